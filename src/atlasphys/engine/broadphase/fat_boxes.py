"""Fat boxes: bounds of moving bodies with room to move in, so that pairs found once hold for many steps.

A pair of bodies can only come to touch after one of them has left its fat box. So a step asks just that, eight bodies at a time. The boxes of bodies
in flight move with them for a while (``flight.py``).
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from atlasphys.engine.broadphase.bvh import store_interval
from atlasphys.engine.broadphase.flight import FOREVER, time_of_flight
from atlasphys.engine.jit import kernel, routine
from atlasphys.engine.shapes.table import (
    BOX,
    CAPSULE,
    CONE,
    CYLINDER,
    FIRST_VERTEX,
    HULL,
    KIND,
    SPHERE,
    VERTEX_COUNT,
    Shapes,
)
from atlasphys.engine.simd import (
    LANES,
    absolute,
    any_lane,
    full,
    gather,
    load,
    maximum,
    minimum,
    scatter,
    select,
    simd_kernel,
    store,
)
from atlasphys.engine.simd.by_address import by_address
from atlasphys.engine.state.arrays import aligned_zeros
from atlasphys.engine.state.bodies import DYNAMIC, STATIC

STEPS_AHEAD = 8
"""A fat box that stays has room for the motion of so many steps at the present velocity. Fewer: bodies leave their boxes more often.
More: longer boxes, and more pairs that never touch."""

LONGEST_STRETCH = 8.0
"""The room along an axis for a body's motion is at most so many times its bounding radius, so that a very fast body does not meet everything."""

SPEED_SHARE = 0.25
"""Part of the room for the motion that is added all round, because velocities change."""

ROUND_OFF = 1 + 2.0**-20
"""Factor on a tight box's reach, for the rounding of its computation in single precision, seven operations at 2⁻²⁴ each."""

ROOM_OF_LARGE = 2.0**-16
"""Least room in a fat box as a part of the body's size: more than round-off, also for bodies of a hundred kilometres."""

BOUNDING_RADIUS = 7
"""Column of ``FatBoxes.bound``."""


@by_address
class FatBoxes(NamedTuple):
    """The boxes of colliders, a row for each. A collider's row is its body's."""

    bound: npt.NDArray[np.floating]
    """(n, 8) the shape's box in the body's axes: 0–2 its centre relative to the centre of mass, 3–5 half sizes, 6 radius added all round,
    7 bounding radius about the centre of mass [m]."""
    center: npt.NDArray[np.float64]
    """(n, 3) centre of the fat box when the clock was started [m]."""
    half: npt.NDArray[np.floating]
    """(n, 8) 0–2 half sizes of the fat box [m]; 3–5 its velocity [m/s]; 6 the clock's last time for which its sweep holds [s]. Infinitely large for
    planes."""
    clock: npt.NDArray[np.float64]
    """(1,) time since pairs were last looked for [s]."""
    reach: npt.NDArray[np.floating]
    """(n, 8) the tight box as it is now, margin included: 0–2 lower and 3–5 upper corner, rounded outwards [m]. Infinite where it is not worked
    out: planes and static bodies."""
    boxes: npt.NDArray[np.float32]
    """(n + 1, 8) what the fat box sweeps, for the tree: lower and upper corner, rounded outwards. The last row is empty, and so are those of
    planes."""


def empty_fat_boxes(count: int, real: npt.DTypeLike) -> FatBoxes:
    """A table of ``count`` rows."""
    boxes = aligned_zeros((count + 1, 8), np.float32)
    boxes[:, :3], boxes[:, 3:6] = np.inf, -np.inf
    reach = aligned_zeros((count, 8), real)
    reach[:, :3], reach[:, 3:6] = -np.inf, np.inf
    half = aligned_zeros((count, 8), real)
    half[:, :3], half[:, 6] = np.inf, FOREVER
    return FatBoxes(
        bound=aligned_zeros((count, 8), real),
        center=aligned_zeros((count, 3), np.float64),
        half=half,
        clock=np.zeros(1),
        reach=reach,
        boxes=boxes,
    )


def shape_bounds(
    shapes: Shapes, shape: npt.NDArray[np.int32], local_center: npt.NDArray[np.floating]
) -> npt.NDArray[np.floating]:
    """The ``FatBoxes.bound`` of bodies with the rows ``shape`` in the table of shapes and the centres of mass ``local_center``."""
    kind, (s0, s1) = shapes.layout[:, KIND], shapes.size[:, :2].T
    bound = np.zeros((len(kind), 8), shapes.size.dtype)
    round_ended = (kind == SPHERE) | (kind == CAPSULE)
    bound[round_ended, 6] = s0[round_ended]
    bound[kind == CAPSULE, 4] = s1[kind == CAPSULE]
    bound[kind == BOX, 3:6] = shapes.size[kind == BOX, :3]
    disc = (kind == CYLINDER) | (kind == CONE)
    bound[disc, 3:6] = np.stack([s0, s1, s0], axis=1)[disc]
    for row in np.flatnonzero(kind == HULL):
        first, number = shapes.layout[row, [FIRST_VERTEX, VERTEX_COUNT]]
        vertices = shapes.vertices[first : first + number]
        lower, upper = vertices.min(axis=0), vertices.max(axis=0)
        bound[row, :3], bound[row, 3:6] = 0.5 * (lower + upper), 0.5 * (upper - lower)
    bound = bound[shape]
    bound[:, :3] -= local_center
    bound[:, 7] = np.sqrt((bound[:, :3] ** 2).sum(axis=1)) + np.sqrt((bound[:, 3:6] ** 2).sum(axis=1)) + bound[:, 6]
    return bound


@simd_kernel
def room_left(block, rows, geometry, bound, half, offset, clock, margin, room, reach) -> bool:
    """Store the tight boxes in ``reach``, and how far the tight boxes of eight bodies, ``margin`` included, are from the nearest side of their fat
    boxes, −1 for NaN; return whether any is outside, or its fat box no longer good. ``offset`` (6, 8) has the centres of mass relative to the fat
    boxes' centres at the start of the clock, and as they are."""
    index = load(rows, block)
    m = gather(geometry, index, 16)
    x, y, z, h0, h1, h2, radius, _ = gather(bound, index)
    halves = gather(half, index)
    left, lower, upper = [], [], []
    for k in range(3):
        a, b, c = m[3 * k], m[3 * k + 1], m[3 * k + 2]
        shift = a * x + b * y + c * z
        extent = (absolute(a) * h0 + absolute(b) * h1 + absolute(c) * h2 + (radius + margin)) * ROUND_OFF
        come, gone = load(offset, k), clock * halves[3 + k]
        away = absolute(come + shift - gone) * ROUND_OFF + (ROUND_OFF - 1) * (absolute(come) + absolute(gone))
        left.append(halves[k] - (away + extent))
        middle = load(offset, 3 + k) + shift
        extent = extent + 2 * (ROUND_OFF - 1) * (absolute(middle) + absolute(shift))
        lower.append(middle - extent)
        upper.append(middle + extent)
    least = minimum(minimum(left[0], left[1]), left[2])
    outside = ~((left[0] >= 0.0) & (left[1] >= 0.0) & (left[2] >= 0.0))  # NaN also
    outside = outside | (clock > halves[6])
    store(room, block, select(outside & ~(least < 0.0), -1.0, least))
    scatter(reach, index, (*lower, *upper, h0, h1))
    return any_lane(outside)


@routine
def load_offsets(block, rows, center, fat_center, offset):
    """The centres of mass of a block's bodies relative to their fat boxes, subtracted in double precision."""
    real = offset.dtype.type
    for lane in range(LANES):
        row = rows[block, lane]
        for k in range(3):
            offset[k, lane] = real(center[row, k] - fat_center[row, k])
            offset[3 + k, lane] = real(center[row, k])


@routine
def has_left(first, stop, rows, center, geometry, fat, margin, offset, room):
    """Whether any of the bodies named in the blocks ``first`` … ``stop`` − 1 of ``rows`` (blocks, 8) has left its fat box, ``margin`` [m]
    included. Works
    out ``fat.reach`` of them all.

    ``center`` and ``geometry`` are the bodies' columns; ``offset`` (6, 8) and ``room`` (at least blocks, 8) are scratch of the bodies' precision.
    """
    left, clock = False, offset.dtype.type(fat.clock[0])
    for block in range(first, stop):
        load_offsets(block, rows, center, fat.center, offset)
        if room_left(block, rows, geometry, fat.bound, fat.half, offset, clock, margin, room, fat.reach):
            left = True
    return left


@simd_kernel
def near(pairs, reach, gap) -> int:
    """Which of eight pairs of bodies have tight boxes that touch: a bit for each. In ``gap`` (1, 8) the others have how far apart the boxes are
    along the axis that parts them farthest [m], less the rounding of their computation."""
    a, b = load(pairs, 0), load(pairs, 1)
    box_a, box_b = gather(reach, a), gather(reach, b)
    touch = a == a
    apart = size = full(box_a[0], 0)
    for k in range(3):
        touch = touch & (box_a[k] <= box_b[3 + k]) & (box_b[k] <= box_a[3 + k])
        apart = maximum(apart, maximum(box_a[k] - box_b[3 + k], box_b[k] - box_a[3 + k]))
        size = size + absolute(box_a[k]) + absolute(box_a[3 + k]) + absolute(box_b[k]) + absolute(box_b[3 + k])
    store(gap, 0, apart - 4 * (ROUND_OFF - 1) * size)
    return touch


@kernel
def flag_leavers(rows, count, center, geometry, motion, fat, near, soon, margin, offset, room, changed):
    """Flag in ``changed`` the bodies that have left their fat box, and if there are any, those that are about to. Return how many left and
    how many are flagged. ``count`` is the number of bodies in ``rows``, ``near`` a distance [m], ``soon`` a time [s].

    About to leave are bodies that have moved, in the direction in which they still move, farther than ``near`` from the box's centre, or if the box
    moves, nearer than that to its side; and those whose box is good for less than ``soon``.
    """
    left, flagged, clock = 0, 0, offset.dtype.type(fat.clock[0])
    for block in range(len(rows)):
        load_offsets(block, rows, center, fat.center, offset)
        if room_left(block, rows, geometry, fat.bound, fat.half, offset, clock, margin, room, fat.reach):
            left += 1
    if left == 0:
        return 0, 0
    left = 0
    for s in range(count):
        block, lane = s // LANES, s % LANES
        row = rows[block, lane]
        gone = not room[block, lane] >= 0
        leaves = gone or fat.half[row, 6] < fat.clock[0] + soon
        if not leaves:
            along, distance, moves = 0.0, 0.0, False
            for k in range(3):
                shift = 0.0
                for j in range(3):
                    shift += np.float64(geometry[row, 3 * k + j]) * fat.bound[row, j]
                velocity = np.float64(fat.half[row, 3 + k])
                moved = center[row, k] + shift - (fat.center[row, k] + velocity * fat.clock[0])
                along += moved * (motion[row, k] - velocity)
                distance = max(distance, abs(moved))
                moves = moves or velocity != 0
            leaves = along > 0 and (room[block, lane] < near if moves else distance > near)
        left += 1 if gone else 0
        flagged += 1 if leaves else 0
        changed[row] = 1 if leaves else 0
    return left, flagged


@kernel
def fatten(rows, changed, flying, longest, bodies, gravity, h, margin, fattening, fat):
    """Take all boxes of bodies in the list ``rows`` to the start of a new clock, and give new ones to those that are flagged in ``changed``: the
    tight box, ``margin`` [m] included, and ``fattening`` [m] all round, grown by what the body may turn during the next steps of ``h`` seconds.
    Returns how many of the boxes move.

    If the body is fast and flagged in ``flying``, its box moves, for about ``longest`` seconds at most; else it is stretched along the body's way.
    What falls moves along a parabola and its box along the chord, from which it is at most a quarter of the fall away.
    """
    bound, motion, geometry, clock, moving = fat.bound, bodies.motion, bodies.geometry, fat.clock[0], 0
    for s in range(len(rows)):
        i = rows[s]
        if not changed[i]:
            if fat.half[i, 6] < FOREVER:
                for k in range(3):
                    fat.center[i, k] += np.float64(fat.half[i, 3 + k]) * clock
                fat.half[i, 6] -= clock
                moving += 1
            continue
        # No point of the shape's box comes farther than ``reach`` from the centre of mass, however it turns.
        reach, spin, speed = np.float64(bound[i, 7]), 0.0, 0.0
        for k in range(3):
            spin += np.float64(motion[i, 3 + k]) ** 2
            speed = max(speed, abs(np.float64(motion[i, k])))
        flight = 0.0
        if (
            flying[i] and bodies.kind[i] != STATIC and not bodies.rest[i] > 0
        ):  # what may soon sleep keeps its box where it is
            flight = time_of_flight(speed, reach, longest, h, fattening)
        ahead = flight if flight > 0 else 0.0 if bodies.kind[i] == STATIC else STEPS_AHEAD * h
        scale = np.float64(bodies.response[i, 0]) if bodies.kind[i] == DYNAMIC else 0.0
        moving += 1 if flight > 0 else 0
        turn = math.sqrt(spin) * ahead
        fat.half[i, 6] = flight if flight > 0 else FOREVER
        for k in range(3):
            shift, extent = 0.0, np.float64(bound[i, 6])
            for j in range(3):
                shift += np.float64(geometry[i, 3 * k + j]) * bound[i, j]
                extent += abs(np.float64(geometry[i, 3 * k + j])) * bound[i, 3 + j]
            room = max(fattening, ROOM_OF_LARGE * extent) + min(turn * reach, reach + abs(shift) - extent)
            stretch = velocity = 0.0
            if flight > 0:
                fall = 0.5 * scale * gravity[k] * flight * flight
                velocity = motion[i, k] + fall / flight
                room += 0.25 * abs(fall)
            else:
                stretch = min(max(motion[i, k] * ahead, -LONGEST_STRETCH * reach), LONGEST_STRETCH * reach)
                room += SPEED_SHARE * abs(stretch)
            middle = bodies.center[i, k] + shift + 0.5 * stretch
            fat.center[i, k] = middle
            fat.half[i, k], fat.half[i, 3 + k] = extent + margin + room + 0.5 * abs(stretch), velocity
            half, sweep = np.float64(fat.half[i, k]), np.float64(fat.half[i, 3 + k]) * flight
            store_interval(fat.boxes, i, k, middle + min(sweep, 0.0) - half, middle + max(sweep, 0.0) + half)
    return moving
