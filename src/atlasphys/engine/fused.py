"""The step of the default world, its stages fused in one compiled call.

``run_steps`` makes as many steps as it is asked for without returning to Python, unless a stage needs something that only Python can give: other
candidate pairs, routines for pairs of rarer shapes, or more memory. It then says so, and is called again to go on where it stopped.
The stages are those of ``step.py``, in the same order; their algorithms are in the folders that bear their names.
"""

from typing import NamedTuple

import numpy as np

from atlasphys.engine.broadphase.fat_boxes import has_left, near
from atlasphys.engine.islands.colour import COLOURS, block_ranges, colour_contacts, fill_blocks
from atlasphys.engine.islands.sleep import list_active, list_awake, note_rest, put_to_sleep, wake_touched
from atlasphys.engine.jit import kernel, routine
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
from atlasphys.engine.manifold.reduce import reduce_points
from atlasphys.engine.manifold.renew import renew
from atlasphys.engine.math import vec
from atlasphys.engine.narrowphase.apart import add_travel, carry_expiry
from atlasphys.engine.narrowphase.batch import GENERIC_KIND, KINDS, collide_lanes, place_lane
from atlasphys.engine.narrowphase.layout import lay_out
from atlasphys.engine.simd import LANES
from atlasphys.engine.simd.address import address_call, call_address
from atlasphys.engine.solvers.body_block import drive, gain_speed, move, settle, tumble
from atlasphys.engine.solvers.bounce_block import EASE, EASED, MOST_STRIKES, aim, depart, strike
from atlasphys.engine.solvers.locked import follow_turn
from atlasphys.engine.solvers.rolling_block import prepare_rolling, solve_rolling, start_rolling, store_rolling
from atlasphys.engine.solvers.soft_contact import prepare, solve, store_impulses, warm_start
from atlasphys.engine.state.blocks import COUNT, MANIFOLD, ROLLS
from atlasphys.engine.state.bodies import KINEMATIC
from atlasphys.engine.state.manifolds import DEPTH, POINT_COLUMNS, RESTITUTION, ROLLING, TORSIONAL
from atlasphys.engine.state.pose import refresh
from atlasphys.engine.state.work import (
    BEGAN,
    BLOCKS_MANY,
    BLOCKS_ONE,
    BOUNCES,
    BROKEN,
    CHECKED,
    DETECT,
    DIVERGED,
    DONE,
    EDGE_LIMIT,
    ENDED,
    FINISHED,
    FORCES,
    GENERIC,
    KEEPS,
    KINEMATIC_BODIES,
    LEFT,
    LIVE,
    NEED_BLOCKS,
    NEED_GENERIC,
    NEED_PAIRS,
    OLD_ROWS,
    PAIRS,
    PAIRS_CHANGED,
    PARITY,
    PHASE,
    PLAIN,
    RENAME,
    RESPOND,
    SLEEPERS_CHANGED,
    SLEEPS,
    SLEPT,
    SLOTS,
    STEP,
    TAKE_GENERIC,
    TUMBLING,
    WOKEN,
    WRONG,
    lanes_of,
)
from atlasphys.engine.team import CODE, DATA, do_task, meet, member_of, share

# Tasks of a team (team.py)
LOOK, COLLIDE, COLLIDE_GENERIC, ADVANCE, REMEMBER = range(1, 6)

CHUNK = 128
"""Pairs that a thread collides at a stretch; whole blocks."""

# Least work that a thread is asked to help with: blocks of bodies, pairs, blocks of contacts.
BODIES_EACH, PAIRS_EACH, GENERIC_EACH, CONTACTS_EACH = 64, 256, 8, 64

FEW_BLOCKS = 8
"""Below so many blocks, a colour is done by one thread."""

PLANE_CELL = 64.0
"""Cell size of the lattice on which a plane's centre is taken to be [m]."""


class Constants(NamedTuple):
    """Numbers of a run, in the world's precision."""

    h: float
    """Length of a substep [s]."""
    substeps: int
    slow: float
    """Speed below which a body counts as at rest [m/s]."""
    gravity: tuple[float, float, float]
    ratio: float
    """Factor on last step's impulses."""
    soft: tuple[float, float, float, float, float, float, float, float]
    """See solvers/soft_contact.py."""
    bounce: tuple[float, float, float, float, float]
    """See solvers/bounce_block.py."""
    recycling: tuple[float, float, float, float, float]
    """See manifold/recycle.py."""
    margin: float
    match_distance: float
    friction_rule: int
    restitution_rule: int


@routine
def find_origins(pairs, count, old_a, old_b, old_count, old_touching, old_rows, origin, ended):
    """The row of each pair in last step's table, −1 if it is not there; both are ordered. Returns how many touching pairs are no longer
    candidates."""
    j = lost = 0
    for p in range(count):
        a, b = pairs[p, 0], pairs[p, 1]
        while j < old_rows and (old_a[j] < a or (old_a[j] == a and old_b[j] < b)):
            if old_count[j] > 0 and old_touching[j]:
                ended[lost, 0], ended[lost, 1] = old_a[j], old_b[j]
                lost += 1
            j += 1
        origin[p] = -1
        if j < old_rows and old_a[j] == a and old_b[j] == b:
            origin[p] = j
            j += 1
    while j < old_rows:
        if old_count[j] > 0 and old_touching[j]:
            ended[lost, 0], ended[lost, 1] = old_a[j], old_b[j]
            lost += 1
        j += 1
    return lost


@routine
def far_center(near_center):
    """Where a plane's centre is taken to be, as seen from a body: near it, so that differences are exact enough in single precision, and not moving
    with it. As the body goes from one cell of the lattice to the next, its contact is collided afresh."""
    return PLANE_CELL * np.rint(near_center / PLANE_CELL)


@routine
def fill_pair_lane(lane, p, pairs, plane_side, origin, body, center, old_count, lanes):
    """Put pair p into a lane of the scratch block. Returns the rows of its bodies."""
    a, b = body[pairs[p, 0]], body[pairs[p, 1]]
    lanes.integers[PAIR_A, lane], lanes.integers[PAIR_B, lane] = a, b
    j = origin[p]
    known = j >= 0 and old_count[j] > 0
    lanes.integers[OLD_ROW, lane] = j if known else 0
    lanes.integers[OLD_COUNT, lane] = old_count[j] if known else 0
    lanes.integers[NEW_ROW, lane] = p
    side = plane_side[p]
    for k in range(3):
        center_a = far_center(center[b, k]) if side == 1 else center[a, k]
        center_b = far_center(center[a, k]) if side == 2 else center[b, k]
        lanes.delta[k, lane] = center_b - center_a
    return a, b


@routine
def renew_lanes(step, number, pairs, origin, geometry, material, constants, old, new, lanes):
    """Write the manifolds of the first ``number`` lanes from their contact points."""
    for lane in range(number):
        p = lanes.integers[NEW_ROW, lane]
        combine_materials_lane(
            material, pairs[p, 0], pairs[p, 1], constants.friction_rule, constants.restitution_rule, lanes.materials, lane
        )  # fmt: skip
        j = lanes.integers[OLD_ROW, lane]
        for k in range(4):
            lanes.features[k, lane] = old.feature[j, k]
    for lane in range(number, LANES):  # idle lanes
        lanes.tags[4, lane] = 0
    renew(
        lanes.integers, lanes.delta, geometry, lanes.contact, lanes.tags, lanes.materials, lanes.features, old, new,
        constants.match_distance,
    )  # fmt: skip
    for lane in range(number):
        p, points = lanes.integers[NEW_ROW, lane], lanes.tags[4, lane]
        new.collided[p] = step
        new.count[p] = points
        for k in range(4):
            new.feature[p, k] = lanes.tags[k, lane] if k < points else 0
        known = lanes.integers[OLD_COUNT, lane] > 0
        new.touching[p] = points > 0 and known and old.touching[lanes.integers[OLD_ROW, lane]]


@routine
def collide_queue(kind, bodies, colliders, shapes, constants, old, new, work, lanes):
    """Collide the pairs of one kind that wait, up to eight."""
    number = lanes.queued[kind]
    lanes.queued[kind] = 0
    for lane in range(LANES):
        p = lanes.queue[kind, min(lane, number - 1)]
        a, b = fill_pair_lane(
            lane, p, work.pairs, work.plane_side, work.origin, colliders.body, bodies.center, old.count, lanes
        )
        lanes.integers[SWAPPED, lane] = place_lane(
            lane, kind, work.pairs[p, 0], work.pairs[p, 1], a, b, bodies, colliders.shape, shapes, lanes
        )
    collide_lanes(kind, bodies.geometry, constants.margin, lanes)
    renew_lanes(
        work.status[STEP], number, work.pairs, work.origin, bodies.geometry, colliders.material, constants, old, new, lanes
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
def recycle_queue(bodies, colliders, shapes, constants, old, new, work, lanes):
    """Recycle the pairs that wait for it, up to eight, or have them collided."""
    number = lanes.queued[KINDS]
    lanes.queued[KINDS] = 0
    for lane in range(LANES):
        p = lanes.queue[KINDS, min(lane, number - 1)]
        fill_pair_lane(
            lane, p, work.pairs, work.plane_side, work.origin, colliders.body, bodies.center, old.count, lanes
        )
        lanes.integers[HAS_COPY, lane] = 1 if new.collided[p] == old.collided[work.origin[p]] else 0
    recycle(lanes.integers, lanes.delta, bodies.geometry, old, new, constants.recycling)
    recycled = 0
    for lane in range(number):
        if lanes.integers[RESULT, lane]:
            recycled |= 1 << lane
    for lane in range(number):
        p = lanes.queue[KINDS, lane]
        if recycled & (1 << lane):
            j = work.origin[p]
            new.count[p], new.touching[p], new.collided[p] = old.count[j], old.touching[j], old.collided[j]
            for k in range(4):
                new.feature[p, k] = old.feature[j, k]
        else:
            enqueue(p, bodies, colliders, shapes, constants, old, new, work, lanes)


@routine
def list_bodies(bodies, count, work):
    """List the bodies that are to be moved, and those that may disturb others."""
    status = work.status
    list_active(bodies.kind, bodies.island, bodies.motion, count, work.active)
    status[PLAIN], status[TUMBLING] = list_awake(
        bodies.kind, bodies.island, bodies.frame, count, work.plain, work.tumbling
    )


@routine
def keep_asleep(p, j, old, new, copied):
    """The manifold of two bodies that neither move nor are disturbed stays as it is."""
    if copied[p] >= 2:
        return
    copied[p] += 1
    new.count[p] = old.count[j] if j >= 0 else 0
    if new.count[p] > 0:
        new.touching[p], new.collided[p] = old.touching[j], old.collided[j]
        for k in range(4):
            new.feature[p, k] = old.feature[j, k]
        for k in range(16):
            new.contact[p, k], new.reference[p, k] = old.contact[j, k], old.reference[j, k]
        for k in range(32):
            new.points[p, k], new.local[p, k] = old.points[j, k], old.local[j, k]
        for k in range(8):
            new.total[p, k] = old.total[j, k]
        for k in range(12):
            new.friction_impulse[p, k] = old.friction_impulse[j, k]


@routine
def is_turntable(bodies, i):
    """Whether a body is driven round: on it the direction of a frozen arm would lag behind, and what rides on it would creep outwards."""
    motion = bodies.motion
    return bodies.kind[i] == KINEMATIC and (motion[i, 3] != 0 or motion[i, 4] != 0 or motion[i, 5] != 0)


@routine
def begin_detection(old, new, work):
    """Find the pairs' rows in last step's table, name those in the next one, and forget last step's events."""
    status, pairs = work.status, work.pairs
    count = status[PAIRS]
    status[GENERIC] = status[BEGAN] = status[ENDED] = 0
    if status[PAIRS_CHANGED]:
        status[ENDED] = find_origins(
            pairs, count, old.a, old.b, old.count, old.touching, status[OLD_ROWS], work.origin, work.ended
        )
        carry_expiry(work.origin, count, work.expiry_before, work.expiry)
    if status[RENAME] > 0:
        status[RENAME] -= 1
        for p in range(count):
            new.a[p], new.b[p], new.collided[p] = pairs[p, 0], pairs[p, 1], -1


@routine
def detect(bodies, colliders, shapes, constants, reach, old, new, work, lanes, member):
    """Narrow phase and manifolds of a member's share of the candidate pairs, except those left to ``generic``.

    The members take chunks in turn: pairs that are much work are often neighbours.
    """
    lanes.queued[:] = 0
    count = work.status[PAIRS]
    for first in range(CHUNK * member.rank, count, CHUNK * member.size):
        stop = min(first + CHUNK, count)
        detect_range(first, stop, bodies, colliders, shapes, constants, reach, old, new, work, lanes)
    if lanes.queued[KINDS] > 0:
        recycle_queue(bodies, colliders, shapes, constants, old, new, work, lanes)
    for kind in range(KINDS):
        if lanes.queued[kind] > 0:
            collide_queue(kind, bodies, colliders, shapes, constants, old, new, work, lanes)


@routine
def leave_distant(block, asked, reach, work, lanes):
    """Which of the pairs of a block that are asked for have tight boxes that touch, as bits; how long the others stay apart is noted."""
    touching = near(block, work.pair_bodies, reach, lanes.gap)
    for lane in range(LANES):
        if asked & ~touching & (1 << lane):
            a, b = work.pair_bodies[block, 0, lane], work.pair_bodies[block, 1, lane]
            work.expiry[LANES * block + lane] = work.travel[a] + work.travel[b] + lanes.gap[0, lane]
    return asked & touching


@routine
def detect_range(first, stop, bodies, colliders, shapes, constants, reach, old, new, work, lanes):
    """Have a range of whole blocks of pairs recycled or collided, as soon as eight of a kind wait for it."""
    status, origin = work.status, work.origin
    recycling = constants.recycling[0] >= 0
    for start in range(first, stop, LANES):
        block = start // LANES
        number, asked = min(LANES, stop - start), 0
        for lane in range(number):
            p = start + lane
            j = origin[p]
            work.generic[p] = 0
            a, b = work.pair_bodies[block, 0, lane], work.pair_bodies[block, 1, lane]
            if not (work.active[a] or work.active[b]):
                keep_asleep(p, j, old, new, work.copied)
                continue
            work.copied[p] = 0
            new.count[p] = 0
            rides = status[KINEMATIC_BODIES] and (is_turntable(bodies, a) or is_turntable(bodies, b))
            if recycling and j >= 0 and old.count[j] > 0 and not rides:
                lanes.queue[KINDS, lanes.queued[KINDS]] = p
                lanes.queued[KINDS] += 1
                if lanes.queued[KINDS] == LANES:
                    recycle_queue(bodies, colliders, shapes, constants, old, new, work, lanes)
            elif not status[KEEPS] or work.travel[a] + work.travel[b] >= work.expiry[p]:
                asked |= 1 << lane
        if asked and status[KEEPS]:
            asked = leave_distant(block, asked, reach, work, lanes)
        for lane in range(number):
            if asked & (1 << lane):
                enqueue(start + lane, bodies, colliders, shapes, constants, old, new, work, lanes)


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
def lay_out_generic(colliders, shapes, contacts, work):
    """Sort the pairs that no body over lanes collides by their routines. Returns whether there is room for their contacts, and all routines' addresses
    are known."""
    status, number = work.status, work.status[GENERIC]
    status[SLOTS] = 0
    if number > len(contacts.a):
        return False
    for i in range(number):
        p = work.generic[i]
        work.generic_pairs[i, 0], work.generic_pairs[i, 1] = work.pairs[p, 0], work.pairs[p, 1]
    status[SLOTS] = lay_out(
        work.generic_pairs[:number], colliders.shape, shapes.layout, work.routines, status[EDGE_LIMIT], contacts,
        work.generic_routine, work.generic_rows, work.generic_starts,
    )  # fmt: skip
    ready = status[SLOTS] <= len(contacts.depth)
    for k in range(len(work.calls) - 1):
        ready = ready and (work.calls[k] != 0 or work.generic_starts[k] == work.generic_starts[k + 1])
    return ready


@routine
def collide_generic(work, member):
    """Collide a member's share of these pairs."""
    last = len(work.calls) - 1
    for k in range(last):
        first, stop = share(work.generic_starts[k], work.generic_starts[k + 1], member)
        if first < stop and call_address(work.calls[k], work.calls[last], first, stop, 0):
            raise MemoryError("no memory for the scratch arrays of a narrow phase")


@routine
def no_call(arguments, first, stop, unused):
    """Stands for the routines, whose arguments it has."""


@routine
def take_generic(bodies, colliders, constants, contacts, kept, old, new, work):
    """Manifolds of the pairs that no body over lanes has collided: contact i belongs to pair ``generic[i]``."""
    lanes, number = lanes_of(work.lanes, 0), work.status[GENERIC]
    for i in range(number):
        if contacts.gap[i] > 0:
            p = work.generic[i]
            a, b = work.pair_bodies[p // LANES, 0, p % LANES], work.pair_bodies[p // LANES, 1, p % LANES]
            work.expiry[p] = work.travel[a] + work.travel[b] + contacts.gap[i]
    for start in range(0, number, LANES):
        filled = min(LANES, number - start)
        for lane in range(LANES):
            i = start + min(lane, filled - 1)
            p = work.generic[i]
            fill_pair_lane(
                lane, p, work.pairs, work.plane_side, work.origin, colliders.body, bodies.center, old.count, lanes
            )
            # Points are taken as seen from the body that cannot be a plane with a far-off origin.
            from_b = work.plane_side[p] == 1
            lanes.integers[SWAPPED, lane] = from_b
            normal = vec.load(contacts.normal, i)
            if from_b:
                normal = vec.neg(normal)
            points = 0
            if contacts.count[i] > 0:
                points = reduce_points(
                    normal, contacts.anchor_b, contacts.depth, contacts.first[i], contacts.count[i], kept
                )
            lanes.tags[4, lane] = points
            for k in range(3):
                lanes.contact[k, lane] = normal[k]
            for k in range(points):
                for c in range(3):
                    lanes.contact[4 + 4 * k + c, lane] = (
                        contacts.anchor_b[kept[k], c] if from_b else contacts.anchor_a[kept[k], c]
                    )
                lanes.contact[7 + 4 * k, lane] = contacts.depth[kept[k]]
                lanes.tags[k, lane] = contacts.feature[kept[k]]
        renew_lanes(
            work.status[STEP], filled, work.pairs, work.origin, bodies.geometry, colliders.material, constants, old, new, lanes
        )  # fmt: skip


@routine
def list_live(count, rows, pair_bodies, active, live):
    """List the manifolds that have points and an active body; return how many."""
    number = 0
    for i in range(rows):
        if count[i] > 0:
            block, lane = i // LANES, i % LANES
            if active[pair_bodies[block, 0, lane]] or active[pair_bodies[block, 1, lane]]:
                live[number] = i
                number += 1
    return number


@routine
def size_of_colour(colour, starts):
    """Blocks of a colour, of both classes."""
    return starts[0, colour + 1] - starts[0, colour] + starts[1, colour + 1] - starts[1, colour]


@routine
def is_leaders(colour, starts):
    """Whether all blocks of a colour are the leader's: few are not worth a meeting, and those of the last colour have bodies in common."""
    return colour == COLOURS or size_of_colour(colour, starts) < FEW_BLOCKS


@routine
def share_of_colour(points, colour, starts, member):
    """A member's blocks of a class and colour: the first and the one past the last."""
    first, stop = starts[points, colour], starts[points, colour + 1]
    if is_leaders(colour, starts):
        return first, stop if member.rank == 0 else first
    return share(first, stop, member)


@routine
def meet_after(colour, starts, member):
    """Wait for the others, unless there was nothing to do, or the leader did this colour and does the next."""
    if size_of_colour(colour, starts) > 0:
        goes_on = colour < COLOURS and size_of_colour(colour + 1, starts) > 0 and is_leaders(colour + 1, starts)
        if not (goes_on and is_leaders(colour, starts)):
            meet(member)


@routine
def prepare_contacts(bodies, constants, new, work, member):
    """Write the blocks of all contacts. BOUNCES says whether one of them has restitution."""
    inverse_mass, ratio, bounces = bodies.inverse_mass, constants.ratio, False
    first, stop = share(0, work.starts[1, COLOURS + 1], member)
    for block in range(first, stop):
        if prepare(4, work.locked, block, work.integers_many, work.blocks_many, new, inverse_mass, ratio):
            bounces = note_materials(4, block, work.integers_many, work.rolls_many, new) or bounces
            if work.integers_many[block, ROLLS, 0]:
                prepare_rolling(
                    block, work.integers_many, work.blocks_many, work.rolls_many, new, inverse_mass, ratio
                )  # fmt: skip
    first, stop = share(0, work.starts[0, COLOURS + 1], member)
    for block in range(first, stop):
        if prepare(1, work.locked, block, work.integers_one, work.blocks_one, new, inverse_mass, ratio):
            bounces = note_materials(1, block, work.integers_one, work.rolls_one, new) or bounces
            if work.integers_one[block, ROLLS, 0]:
                prepare_rolling(block, work.integers_one, work.blocks_one, work.rolls_one, new, inverse_mass, ratio)
    if bounces:
        work.status[BOUNCES] = 1


@routine
def note_materials(points, block, integers, rolls, new):
    """Note in a block whether it has rolling friction. Returns whether it has restitution."""
    bounces = False
    for lane in range(LANES):
        if integers[block, COUNT, lane] > 0:
            i = integers[block, MANIFOLD, lane]
            bounces = bounces or new.contact[i, RESTITUTION] > 0
            if new.contact[i, ROLLING] > 0 or (points == 1 and new.contact[i, TORSIONAL] > 0):
                integers[block, ROLLS, 0] = 1 if block < len(rolls) else 0
    return bounces


@routine
def aim_contacts(bodies, constants, new, work, member):
    """Work out what restitution asks for. WRONG becomes 0 if it acts in this step."""
    motion, inverse_mass, drives, acts = bodies.motion, bodies.inverse_mass, bodies.drive, False
    first, stop = share(0, work.starts[1, COLOURS + 1], member)
    for block in range(first, stop):
        if aim(
            4,
            work.locked,
            block,
            work.integers_many,
            work.blocks_many,
            motion,
            inverse_mass,
            drives,
            new,
            constants.bounce,
        ):
            acts = True
    first, stop = share(0, work.starts[0, COLOURS + 1], member)
    for block in range(first, stop):
        if aim(
            1,
            work.locked,
            block,
            work.integers_one,
            work.blocks_one,
            motion,
            inverse_mass,
            drives,
            new,
            constants.bounce,
        ):
            acts = True
    if acts:
        work.status[WRONG] = 0


@routine
def strike_contacts(number, motion, inverse_mass, ease, work, member):
    """Pass ``number`` over all contacts, colour by colour. WRONG becomes that number if a bounce was not solved for yet."""
    starts = work.starts
    for colour in range(COLOURS + 1):
        first, stop = share_of_colour(1, colour, starts, member)
        for block in range(first, stop):
            if strike(4, work.locked, block, work.integers_many, work.blocks_many, motion, inverse_mass, ease):
                work.status[WRONG] = number
        first, stop = share_of_colour(0, colour, starts, member)
        for block in range(first, stop):
            if strike(1, work.locked, block, work.integers_one, work.blocks_one, motion, inverse_mass, ease):
                work.status[WRONG] = number
        meet_after(colour, starts, member)


@routine
def bounce_contacts(bodies, constants, new, work, member):
    """Resolve the impacts of contacts with restitution."""
    motion, inverse_mass = bodies.motion, bodies.inverse_mass
    real = motion.dtype.type
    aim_contacts(bodies, constants, new, work, member)
    meet(member)
    for visit in range(MOST_STRIKES):
        if work.status[WRONG] < visit:  # not !=: another member may already be in the next pass
            break
        ease = real(1) if visit < EASED else real(EASE)
        strike_contacts(visit + 1, motion, inverse_mass, ease, work, member)
    first, stop = share(0, work.starts[1, COLOURS + 1], member)
    for block in range(first, stop):
        depart(4, work.locked, block, work.integers_many, work.blocks_many, motion, inverse_mass, new, constants.ratio)
    first, stop = share(0, work.starts[0, COLOURS + 1], member)
    for block in range(first, stop):
        depart(1, work.locked, block, work.integers_one, work.blocks_one, motion, inverse_mass, new, constants.ratio)
    meet(member)


@routine
def start_contacts(motion, inverse_mass, work, member):
    """Apply the impulses that the last substep ended with."""
    starts = work.starts
    for colour in range(COLOURS + 1):
        first, stop = share_of_colour(1, colour, starts, member)
        for block in range(first, stop):
            warm_start(4, work.locked, block, work.integers_many, work.blocks_many, motion, inverse_mass)
            if work.integers_many[block, ROLLS, 0]:
                start_rolling(
                    4, block, work.integers_many, work.blocks_many, work.rolls_many, motion, inverse_mass
                )  # fmt: skip
        first, stop = share_of_colour(0, colour, starts, member)
        for block in range(first, stop):
            warm_start(1, work.locked, block, work.integers_one, work.blocks_one, motion, inverse_mass)
            if work.integers_one[block, ROLLS, 0]:
                start_rolling(1, block, work.integers_one, work.blocks_one, work.rolls_one, motion, inverse_mass)
        meet_after(colour, starts, member)


@routine
def solve_contacts(relax, motion, inverse_mass, soft, work, member):
    """One pass over all contacts, colour by colour."""
    starts = work.starts
    counts = soft[0] - soft[0] + (1 if relax else 0)
    for colour in range(COLOURS + 1):
        first, stop = share_of_colour(1, colour, starts, member)
        for block in range(first, stop):
            if relax:
                solve(4, work.locked, 1, block, work.integers_many, work.blocks_many, motion, inverse_mass, soft)
            else:
                solve(4, work.locked, 0, block, work.integers_many, work.blocks_many, motion, inverse_mass, soft)
            if work.integers_many[block, ROLLS, 0]:
                solve_rolling(
                    4, block, work.integers_many, work.blocks_many, work.rolls_many, motion, inverse_mass, counts
                )  # fmt: skip
        first, stop = share_of_colour(0, colour, starts, member)
        for block in range(first, stop):
            if relax:
                solve(1, work.locked, 1, block, work.integers_one, work.blocks_one, motion, inverse_mass, soft)
            else:
                solve(1, work.locked, 0, block, work.integers_one, work.blocks_one, motion, inverse_mass, soft)
            if work.integers_one[block, ROLLS, 0]:
                solve_rolling(
                    1, block, work.integers_one, work.blocks_one, work.rolls_one, motion, inverse_mass, counts
                )  # fmt: skip
        meet_after(colour, starts, member)


@routine
def store_contacts(new, work, member):
    """Write the impulses to the manifolds."""
    first, stop = share(0, work.starts[1, COLOURS + 1], member)
    for block in range(first, stop):
        store_impulses(4, block, work.integers_many, work.blocks_many, new)
        if work.integers_many[block, ROLLS, 0]:
            store_rolling(block, work.integers_many, work.blocks_many, work.rolls_many, new)
    first, stop = share(0, work.starts[0, COLOURS + 1], member)
    for block in range(first, stop):
        store_impulses(1, block, work.integers_one, work.blocks_one, new)
        if work.integers_one[block, ROLLS, 0]:
            store_rolling(block, work.integers_one, work.blocks_one, work.rolls_one, new)


@routine
def respond(bodies, constants, new, work, member):
    """The solver stage: impulses and motion in all substeps. Each member does its share of every loop."""
    motion, geometry, inverse_mass, h = bodies.motion, bodies.geometry, bodies.inverse_mass, constants.h
    status = work.status
    plain, tumbling = work.plain, work.tumbling
    for rows, blocks in ((plain, status[PLAIN]), (tumbling, status[TUMBLING])):
        first, stop = share(0, blocks, member)
        for block in range(first, stop):
            drive(
                work.locked, block, rows, motion, bodies.force, bodies.response, inverse_mass, bodies.mass, bodies.drive,
                constants.gravity, h,
            )  # fmt: skip
    prepare_contacts(bodies, constants, new, work, member)
    meet(member)
    if status[BOUNCES]:
        bounce_contacts(bodies, constants, new, work, member)
    for _ in range(constants.substeps):
        for rows, blocks in ((plain, status[PLAIN]), (tumbling, status[TUMBLING])):
            first, stop = share(0, blocks, member)
            for block in range(first, stop):
                gain_speed(block, rows, motion, bodies.drive)
        meet(member)
        start_contacts(motion, inverse_mass, work, member)
        solve_contacts(False, motion, inverse_mass, constants.soft, work, member)
        first, stop = share(0, status[PLAIN], member)
        for block in range(first, stop):
            move(block, plain, motion, geometry, h)
        first, stop = share(0, status[TUMBLING], member)
        for block in range(first, stop):
            tumble(block, tumbling, motion, geometry, bodies.mass, bodies.frame, inverse_mass, h)
        meet(member)
        if work.locked is not None:
            if member.rank == 0:
                follow_turn(work.locked, bodies.locks, motion, geometry, inverse_mass, bodies.mass, bodies.frame, h)
            meet(member)
        solve_contacts(True, motion, inverse_mass, constants.soft, work, member)
    store_contacts(new, work, member)


@routine
def settle_bodies(bodies, work, lanes, member):
    """Poses at the end of the step. BROKEN says whether one is not finite."""
    status = work.status
    moved = lanes.moved
    finite = True
    for rows, blocks in ((work.plain, status[PLAIN]), (work.tumbling, status[TUMBLING])):
        first, stop = share(0, blocks, member)
        for block in range(first, stop):
            finite = settle(block, rows, bodies.motion, bodies.geometry, bodies.frame, moved) and finite
            for lane in range(LANES):
                i = rows[block, lane]
                if lane > 0 and i == rows[block, lane - 1]:
                    break
                for k in range(3):
                    bodies.position[i, k] = bodies.center[i, k] + moved[k, lane] - moved[3 + k, lane]
                    bodies.center[i, k] = bodies.position[i, k] + moved[3 + k, lane]  # as ``refresh`` computes it
                for k in range(4):
                    bodies.orientation[i, k] = bodies.geometry[i, 12 + k]
    if not finite:
        status[BROKEN] = 1


@routine
def rest(bodies, colliders, count, constants, new, work):
    """Which bodies are at rest, and which of them fall asleep."""
    status = work.status
    if status[SLEEPS]:
        for rows, blocks in ((work.plain, status[PLAIN]), (work.tumbling, status[TUMBLING])):
            note_rest(
                rows, blocks, bodies.kind, bodies.motion, bodies.response, work.radius, constants.slow,
                constants.h * constants.substeps, bodies.rest,
            )  # fmt: skip
        status[SLEPT] = put_to_sleep(
            new.a, new.b, work.live, status[LIVE], colliders.body, bodies.kind, bodies.island, bodies.rest, bodies.motion,
            work.active, count, work.parent, work.ready,
        )  # fmt: skip
        if status[SLEPT]:
            status[SLEEPERS_CHANGED] = 1


@routine
def remember(bodies, remembered, work, member):
    """What follows from the new poses; and the state to which a later step that fails goes back."""
    status = work.status
    # What follows from the pose is worked out in one way only, so that working it out again changes nothing.
    first, stop = share(0, status[TUMBLING], member)
    for block in range(first, stop):
        for lane in range(LANES):
            i = work.tumbling[block, lane]
            if lane == 0 or i != work.tumbling[block, lane - 1]:
                refresh(bodies, i, i + 1)
    for rows, blocks in ((work.plain, status[PLAIN]), (work.tumbling, status[TUMBLING])):
        first, stop = share(0, blocks, member)
        for block in range(first, stop):
            for lane in range(LANES):
                i = rows[block, lane]
                add_travel(i, bodies, remembered, work.extent, work.travel)
                for k in range(3):
                    remembered.position[i, k] = bodies.position[i, k]
                for k in range(4):
                    remembered.orientation[i, k] = bodies.orientation[i, k]
                for k in range(16):
                    remembered.motion[i, k] = bodies.motion[i, k]


@routine
def note_events(new, old, work):
    """Which pairs touch now, and which began or ceased to in this step."""
    status, pairs = work.status, work.pairs
    for p in range(status[PAIRS]):
        j = work.origin[p]
        touched = j >= 0 and old.count[j] > 0 and old.touching[j]
        touches = new.count[p] > 0 and new.touching[p]
        if new.count[p] > 0 and not touches:
            for k in range(new.count[p]):
                column = POINT_COLUMNS * k
                touches = touches or new.total[p, k] > 0 or new.points[p, column + DEPTH] >= 0
            new.touching[p] = touches
        if touches and not touched:
            work.began[status[BEGAN], 0], work.began[status[BEGAN], 1] = pairs[p, 0], pairs[p, 1]
            status[BEGAN] += 1
        if touched and new.count[p] == 0:
            work.ended[status[ENDED], 0], work.ended[status[ENDED], 1] = pairs[p, 0], pairs[p, 1]
            status[ENDED] += 1


@routine
def take_part(arguments, task, rank, size):
    """Do a thread's share of a task."""
    bodies, colliders, shapes, table_0, table_1, remembered, fat, constants, work, sync = arguments
    status, lanes, member = work.status, lanes_of(work.lanes, rank), member_of(sync, rank, size)
    if status[PARITY] == 0:
        old, new = table_0, table_1
    else:
        old, new = table_1, table_0
    if task == LOOK:
        for rows, blocks in ((work.plain, status[PLAIN]), (work.tumbling, status[TUMBLING])):
            first, stop = share(0, blocks, member)
            if has_left(
                first, stop, rows, bodies.center, bodies.geometry, fat, constants.margin, lanes.delta, work.room
            ):  # fmt: skip
                status[LEFT] = 1
    elif task == COLLIDE:
        detect(bodies, colliders, shapes, constants, fat.reach, old, new, work, lanes, member)
    elif task == COLLIDE_GENERIC:
        collide_generic(work, member)
    elif task == ADVANCE:
        respond(bodies, constants, new, work, member)
        settle_bodies(bodies, work, lanes, member)
    elif task == REMEMBER:
        remember(bodies, remembered, work, member)


@kernel
def run_steps(
    bodies, colliders, shapes, table_0, table_1, remembered, contacts, kept, count, fat, constants, work, steps, sync
):  # fmt: skip
    """Make steps until ``status[DONE]`` is ``steps``, or until something is needed; the answer says what.

    ``count`` is the number of bodies, ``fat`` the boxes of the tree broad phase. The present manifolds are in ``table_0`` if PARITY is 0;
    each step builds
    the next ones in the other table. ``sync`` is that of the team of threads (team.py) that share the work; ``work.lanes`` has scratch for each.
    """
    status = work.status
    arguments = (bodies, colliders, shapes, table_0, table_1, remembered, fat, constants, work, sync)
    sync[CODE], sync[DATA] = address_call(take_part, arguments)
    generic_arguments = (work.generic_rows, bodies, colliders, shapes, constants.margin, contacts)
    work.calls[len(work.calls) - 1] = address_call(no_call, generic_arguments)[1]
    while status[DONE] < steps:
        if status[PARITY] == 0:
            old, new = table_0, table_1
        else:
            old, new = table_1, table_0
        if status[PHASE] == DETECT:
            if status[SLEEPERS_CHANGED]:
                list_bodies(bodies, count, work)
                status[SLEEPERS_CHANGED] = 0
            elif status[KINEMATIC_BODIES]:
                list_active(bodies.kind, bodies.island, bodies.motion, count, work.active)
            if status[SLEEPS]:
                for i in range(count):
                    work.before[i] = work.active[i]
            status[SLEPT] = status[WOKEN] = 0
            if status[KEEPS]:
                status[LEFT] = 0
                do_task(sync, LOOK, (status[PLAIN] + status[TUMBLING]) // BODIES_EACH)
                if status[LEFT] and not status[CHECKED]:
                    return NEED_PAIRS
            elif not status[CHECKED]:
                return NEED_PAIRS
            status[CHECKED] = 0
            begin_detection(old, new, work)
            do_task(sync, COLLIDE, status[PAIRS] // PAIRS_EACH)
            status[PHASE] = RESPOND
            if status[GENERIC] > 0:
                list_generic(work)
                status[PHASE] = TAKE_GENERIC
        if status[PHASE] == TAKE_GENERIC:
            if not lay_out_generic(colliders, shapes, contacts, work):
                return NEED_GENERIC
            do_task(sync, COLLIDE_GENERIC, status[GENERIC] // GENERIC_EACH)
            take_generic(bodies, colliders, constants, contacts, kept, old, new, work)
            status[PHASE] = RESPOND
        live = list_live(new.count, status[PAIRS], work.pair_bodies, work.active, work.live)
        if status[SLEEPS]:
            status[WOKEN] += wake_touched(
                new.a, new.b, work.live, live, colliders.body, bodies.kind, bodies.island, bodies.rest, work.active, count,
                work.ready,
            )  # fmt: skip
            if status[WOKEN]:
                list_bodies(bodies, count, work)
                live = list_live(new.count, status[PAIRS], work.pair_bodies, work.active, work.live)
        status[LIVE] = live
        colour_contacts(
            new.a, new.b, new.count, work.live, live, colliders.body, work.moves, work.used, work.colours, work.sizes
        )
        block_ranges(work.sizes, work.starts)
        status[BLOCKS_ONE], status[BLOCKS_MANY] = work.starts[0, COLOURS + 1], work.starts[1, COLOURS + 1]
        if len(work.blocks_one) < status[BLOCKS_ONE] or len(work.blocks_many) < status[BLOCKS_MANY]:
            return NEED_BLOCKS
        fill_blocks(
            new.a, new.b, new.count, work.live, live, colliders.body, work.moves, work.colours, work.starts, work.cursor,
            work.integers_one, work.integers_many,
        )  # fmt: skip
        status[BOUNCES] = status[BROKEN] = 0
        status[WRONG] = -1
        body_work = (status[PLAIN] + status[TUMBLING]) // BODIES_EACH
        do_task(sync, ADVANCE, (status[BLOCKS_ONE] + status[BLOCKS_MANY]) // CONTACTS_EACH + body_work)
        if status[BROKEN]:
            return DIVERGED
        rest(bodies, colliders, count, constants, new, work)
        do_task(sync, REMEMBER, body_work)
        note_events(new, old, work)
        if status[FORCES]:
            bodies.force[:] = 0
            status[FORCES] = 0
        if status[PAIRS_CHANGED]:
            for p in range(status[PAIRS]):
                work.origin[p] = p
            status[PAIRS_CHANGED] = 0
        status[OLD_ROWS] = status[PAIRS]
        status[STEP] += 1
        status[PARITY] = 1 - status[PARITY]
        status[PHASE] = DETECT
        status[DONE] += 1
    return FINISHED
