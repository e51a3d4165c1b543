"""Narrow phase and manifolds of the fused step: eight candidate pairs at a time are recycled if they have barely moved, or collided."""

import numpy as np

from atlasphys.engine.broadphase.fat_boxes import near
from atlasphys.engine.fused.rows import carry_over, take_row
from atlasphys.engine.jit import inlined, kernel, routine
from atlasphys.engine.manifold.build import combine_materials_lane
from atlasphys.engine.manifold.recycle import (
    HAS_COPY,
    NEW_ROW,
    OLD_COUNT,
    OLD_ROW,
    PAIR_A,
    PAIR_B,
    RESULT,
    SWAPPED,
    recycle,
)
from atlasphys.engine.manifold.renew import renew
from atlasphys.engine.narrowphase.apart import certain
from atlasphys.engine.narrowphase.batch import GENERIC_KIND, KINDS, collide_lanes, place_lane
from atlasphys.engine.narrowphase.lanes.common import ROOM
from atlasphys.engine.simd import LANES
from atlasphys.engine.simd.address import address_call
from atlasphys.engine.simd.bits import fetch
from atlasphys.engine.simd.by_address import part_of
from atlasphys.engine.state.bodies import KINEMATIC
from atlasphys.engine.state.work import (
    CHUNK,
    GENERIC,
    KEEPS,
    KINEMATIC_BODIES,
    LOOK_NEARER,
    PAIRS,
    PAIRS_CHANGED,
    PARITY,
    RECYCLE_MANY,
    RECYCLE_ONE,
    STEP,
    TASKS,
)
from atlasphys.engine.team import member_of

PLANE_CELL = 64.0
"""Cell size of the lattice on which a plane's centre is taken to be [m]."""


@inlined
def bodies_of(p, pair_bodies):
    """The rows of the two bodies of a pair."""
    block, lane = p // LANES, p % LANES
    return pair_bodies[block, 0, lane], pair_bodies[block, 1, lane]


@routine
def far_center(near_center):
    """Where a plane's centre is taken to be, as seen from a body: near it, so that differences are exact enough in single precision, and not moving
    with it. As the body goes from one cell of the lattice to the next, its contact is collided afresh."""
    return PLANE_CELL * np.rint(near_center / PLANE_CELL)


@inlined
def fill_pair_lane(lane, p, work, center, old_count, lanes):
    """Put pair p into a lane of the scratch block. Returns the rows of its bodies."""
    a, b = bodies_of(p, work.pair_bodies)
    lanes.integers[PAIR_A, lane], lanes.integers[PAIR_B, lane] = a, b
    lanes.integers[OLD_ROW, lane] = work.row[p]
    lanes.integers[OLD_COUNT, lane] = old_count[work.row[p]]
    side = work.plane_side[p]
    if side == 0:
        for k in range(3):
            lanes.delta[k, lane] = center[b, k] - center[a, k]
    else:
        for k in range(3):
            center_a = far_center(center[b, k]) if side == 1 else center[a, k]
            center_b = far_center(center[a, k]) if side == 2 else center[b, k]
            lanes.delta[k, lane] = center_b - center_a
    return a, b


@routine
def renew_lanes(listed, first, number, geometry, material, constants, old, new, work, lanes):
    """Write the manifolds of the ``number`` pairs from ``listed[first]`` on, which fill as many lanes, from their contact points."""
    pairs = work.pairs
    for lane in range(number):
        p = listed[first + lane]
        combine_materials_lane(
            material, pairs[p, 0], pairs[p, 1], constants.friction_rule, constants.restitution_rule, lanes.materials, lane
        )  # fmt: skip
        if lanes.tags[4, lane] > 0 and work.row[p] == 0:
            work.row[p] = take_row(work)
        lanes.integers[NEW_ROW, lane] = work.row[p]
        for k in range(4):
            lanes.features[k, lane] = old.feature[lanes.integers[OLD_ROW, lane], k]
    for lane in range(number, LANES):  # idle lanes
        lanes.tags[4, lane] = 0
    renew(
        lanes.integers, lanes.delta, geometry, lanes.contact, lanes.tags, lanes.materials, lanes.features, old, new,
        constants.match_distance,
    )  # fmt: skip
    for lane in range(number):
        row, points = lanes.integers[NEW_ROW, lane], lanes.tags[4, lane]
        if row == 0:
            continue
        new.count[row] = points
        if points > 0:
            p = listed[first + lane]
            new.a[row], new.b[row], new.collided[row] = pairs[p, 0], pairs[p, 1], work.status[STEP]
            new.touching[row] = lanes.integers[OLD_COUNT, lane] > 0 and old.touching[row]
            for k in range(4):
                new.feature[row, k] = lanes.tags[k, lane] if k < points else 0


@routine
def collide_queue(kind, bodies, colliders, shapes, constants, old, new, work, lanes):
    """Collide the pairs of one kind that wait, up to eight."""
    number = lanes.queued[kind]
    lanes.queued[kind] = 0
    for lane in range(LANES):
        p = lanes.queue[kind, min(lane, number - 1)]
        a, b = fill_pair_lane(lane, p, work, bodies.center, old.count, lanes)
        lanes.integers[SWAPPED, lane] = place_lane(
            lane, kind, work.pairs[p, 0], work.pairs[p, 1], a, b, bodies, colliders.shape, shapes, lanes
        )
    collide_lanes(kind, bodies.geometry, constants.margin, lanes)
    for lane in range(number):
        a, b = lanes.integers[PAIR_A, lane], lanes.integers[PAIR_B, lane]
        room = certain(float(lanes.contact[ROOM, lane]), work.extent[a] + work.extent[b])
        work.expiry[lanes.queue[kind, lane]] = work.travel[a] + work.travel[b] + room
    renew_lanes(
        lanes.queue[kind], 0, number, bodies.geometry, colliders.material, constants, old, new, work, lanes
    )  # fmt: skip


@routine
def enqueue(p, bodies, colliders, shapes, constants, old, new, work, lanes):
    """Have a pair collided: once eight of its kind wait, or later by another routine."""
    kind = work.kinds[p]
    if kind == GENERIC_KIND:
        work.generic[p] = 1
        work.status[GENERIC] = 1
        return
    lanes.queue[kind, lanes.queued[kind]] = p
    lanes.queued[kind] += 1
    if lanes.queued[kind] == LANES:
        collide_queue(kind, bodies, colliders, shapes, constants, old, new, work, lanes)


@routine
def recycle_waiting(points, first, number, bodies, colliders, shapes, constants, old, new, work, lanes):
    """Recycle up to eight of the pairs of up to so many points that wait for it, or have them collided."""
    waiting = lanes.waiting[RECYCLE_MANY if points > 1 else RECYCLE_ONE]
    for lane in range(LANES):
        p = waiting[first + min(lane, number - 1)]
        fill_pair_lane(lane, p, work, bodies.center, old.count, lanes)
        row = lanes.integers[OLD_ROW, lane]
        lanes.integers[HAS_COPY, lane] = 1 if new.collided[row] == old.collided[row] else 0
    if points > 1:
        recycle(4, lanes.integers, lanes.delta, bodies.geometry, old, new, constants.recycling)
    else:
        recycle(1, lanes.integers, lanes.delta, bodies.geometry, old, new, constants.recycling)
    recycled = 0
    for lane in range(number):
        recycled |= lanes.integers[RESULT, lane] << lane
    for lane in range(number):
        p = waiting[first + lane]
        if recycled & (1 << lane):
            row = work.row[p]
            new.count[row], new.touching[row] = old.count[row], old.touching[row]
            if new.collided[row] != old.collided[row]:
                new.a[row], new.b[row], new.collided[row] = old.a[row], old.b[row], old.collided[row]
                for k in range(4):
                    new.feature[row, k] = old.feature[row, k]
        else:
            enqueue(p, bodies, colliders, shapes, constants, old, new, work, lanes)


@routine
def keep_asleep(row, old, new):
    """The manifold of two bodies that neither move nor are disturbed stays as it is: it is copied once."""
    new.a[row], new.b[row], new.count[row] = old.a[row], old.b[row], old.count[row]
    new.touching[row], new.collided[row] = old.touching[row], old.collided[row]
    for k in range(4):
        new.feature[row, k] = old.feature[row, k]
    for k in range(16):
        new.contact[row, k], new.reference[row, k] = old.contact[row, k], old.reference[row, k]
    for k in range(32):
        new.points[row, k], new.local[row, k] = old.points[row, k], old.local[row, k]
    for k in range(8):
        new.total[row, k] = old.total[row, k]
    for k in range(12):
        new.friction_impulse[row, k] = old.friction_impulse[row, k]


@routine
def is_turntable(bodies, i):
    """Whether a body is driven round: on it the direction of a frozen arm would lag behind, and what rides on it would creep outwards."""
    motion = bodies.motion
    return bodies.kind[i] == KINEMATIC and (motion[i, 3] != 0 or motion[i, 4] != 0 or motion[i, 5] != 0)


@routine
def begin_detection(new, work):
    """Take over what is known of the pairs that have been candidates before."""
    work.status[GENERIC] = 0
    if work.status[PAIRS_CHANGED]:
        carry_over(new, work)


@routine
def detect(bodies, colliders, shapes, constants, reach, old, new, work, lanes, member):
    """Narrow phase and manifolds of a member's share of the candidate pairs, except those left to ``generic``.

    The members take chunks in turn: pairs that are much work are often neighbours.
    """
    lanes.queued[:] = 0
    count = work.status[PAIRS]
    for first in range(CHUNK * member.rank, count, CHUNK * member.size):
        sort_pairs(first, min(first + CHUNK, count), bodies, constants, old, new, work, lanes)
        work_off(LANES, bodies, colliders, shapes, constants, reach, old, new, work, lanes)
    work_off(1, bodies, colliders, shapes, constants, reach, old, new, work, lanes)
    for kind in range(KINDS):
        if lanes.queued[kind] > 0:
            collide_queue(kind, bodies, colliders, shapes, constants, old, new, work, lanes)


@routine
def leave_distant(first, number, bodies, colliders, shapes, constants, reach, old, new, work, lanes):
    """Have those of up to eight waiting pairs collided whose tight boxes touch; the others have no points, and how long they stay apart is noted."""
    waiting = lanes.waiting[LOOK_NEARER]
    for lane in range(LANES):
        p = waiting[first + min(lane, number - 1)]
        lanes.pairs[0, lane], lanes.pairs[1, lane] = bodies_of(p, work.pair_bodies)
    touching = near(lanes.pairs, reach, lanes.gap) if work.status[KEEPS] else (1 << LANES) - 1
    for lane in range(number):
        if not touching & (1 << lane):
            p, travel = waiting[first + lane], work.travel[lanes.pairs[0, lane]] + work.travel[lanes.pairs[1, lane]]
            work.expiry[p] = travel + lanes.gap[0, lane]
            if work.row[p] > 0:
                new.count[work.row[p]] = 0
    for lane in range(number):
        if touching & (1 << lane):
            enqueue(waiting[first + lane], bodies, colliders, shapes, constants, old, new, work, lanes)


@routine
def sort_pairs(first, stop, bodies, constants, old, new, work, lanes):
    """List the pairs of a chunk by what is to be done with them. Whether a pair has points is as good as random, and a wrong guess of the processor
    costs more than the rest: so each pair is written to the end of all lists, and those that it belongs to grow."""
    status, queued = work.status, lanes.queued
    recycling, keeps = constants.recycling[0] >= 0, status[KEEPS] != 0
    many, one, nearer = queued[KINDS + RECYCLE_MANY], queued[KINDS + RECYCLE_ONE], queued[KINDS + LOOK_NEARER]
    work.generic[first:stop] = 0
    for p in range(first, stop):
        a, b = bodies_of(p, work.pair_bodies)
        asleep = not (work.active[a] | work.active[b])
        if asleep and work.copied[p]:
            continue
        known = old.count[work.row[p]]
        row = work.row[p] if known > 0 else 0  # it may have lost its points in the last step
        work.row[p] = row
        if asleep:
            if row > 0:
                keep_asleep(row, old, new)
            work.copied[p] = 1
            continue
        points = known if recycling else 0
        if status[KINEMATIC_BODIES] and (is_turntable(bodies, a) or is_turntable(bodies, b)):
            points = 0
        soon = row if points > 0 else 0
        fetch(old.reference, soon, 0)
        fetch(old.local, soon, 0)
        fetch(old.contact, soon, 0)
        fetch(old.points, soon, 0)
        soon = row if points > 1 else 0
        fetch(old.local, soon, 16)
        fetch(old.points, soon, 16)
        lanes.waiting[RECYCLE_MANY, many] = lanes.waiting[RECYCLE_ONE, one] = lanes.waiting[LOOK_NEARER, nearer] = p
        many += 1 if points > 1 else 0
        one += 1 if points == 1 else 0
        expired = (work.travel[a] + work.travel[b] >= work.expiry[p]) | (not keeps)
        nearer += 1 if (points == 0) & (expired | (known > 0)) else 0
        work.copied[p] = 0
    queued[KINDS + RECYCLE_MANY], queued[KINDS + RECYCLE_ONE], queued[KINDS + LOOK_NEARER] = many, one, nearer


@routine
def work_off(least, bodies, colliders, shapes, constants, reach, old, new, work, lanes):
    """Do what pairs wait for, eight at a time, until fewer than ``least`` wait."""
    for task in range(TASKS):
        waiting, number, first = lanes.waiting[task], lanes.queued[KINDS + task], 0
        while number - first >= least:
            now = min(LANES, number - first)
            if task == LOOK_NEARER:
                leave_distant(first, now, bodies, colliders, shapes, constants, reach, old, new, work, lanes)
            else:
                points = 4 if task == RECYCLE_MANY else 1
                recycle_waiting(points, first, now, bodies, colliders, shapes, constants, old, new, work, lanes)
            first += now
        for k in range(number - first):
            waiting[k] = waiting[first + k]
        lanes.queued[KINDS + task] = number - first


@routine
def list_generic(work):
    """Turn ``generic`` from marks at pairs into a list of them."""
    number = 0
    for p in range(work.status[PAIRS]):
        if work.generic[p]:
            work.generic[number] = p
            number += 1
    work.status[GENERIC] = number


@routine
def detection_part(arguments, task, rank, size):
    """Do a thread's share of the detection."""
    bodies, colliders, shapes, table_0, table_1, _, fat, constants, work, sync, _, _ = arguments
    lanes, member = part_of(work.lanes, rank), member_of(sync, rank, size)
    if work.status[PARITY] == 0:
        detect(bodies, colliders, shapes, constants, fat.reach, table_0, table_1, work, lanes, member)
    else:
        detect(bodies, colliders, shapes, constants, fat.reach, table_1, table_0, work, lanes, member)


@kernel
def detection_address(
    bodies, colliders, shapes, table_0, table_1, remembered, fat, constants, work, sync, contacts, kept
):  # fmt: skip
    """Address of the code of ``detection_part`` for arguments of these types."""
    arguments = (bodies, colliders, shapes, table_0, table_1, remembered, fat, constants, work, sync, contacts, kept)
    return address_call(detection_part, arguments)[0]
