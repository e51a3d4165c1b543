"""Narrow phase and manifolds of the fused step: eight candidate pairs at a time are recycled if they have barely moved, or collided."""

import numpy as np

from atlasphys.engine.broadphase.fat_boxes import near
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
from atlasphys.engine.manifold.reduce import reduce_points
from atlasphys.engine.manifold.renew import renew
from atlasphys.engine.math import vec
from atlasphys.engine.narrowphase.apart import carry_expiry
from atlasphys.engine.narrowphase.batch import GENERIC_KIND, KINDS, collide_lanes, place_lane
from atlasphys.engine.narrowphase.layout import lay_out
from atlasphys.engine.simd import LANES
from atlasphys.engine.simd.address import address_call, call_address
from atlasphys.engine.simd.bits import fetch
from atlasphys.engine.simd.by_address import part_of
from atlasphys.engine.state.bodies import KINEMATIC
from atlasphys.engine.state.work import (
    BEGAN,
    CHUNK,
    EDGE_LIMIT,
    ENDED,
    GENERIC,
    GENERIC_DATA,
    KEEPS,
    KINEMATIC_BODIES,
    LOOK_NEARER,
    OLD_ROWS,
    PAIRS,
    PAIRS_CHANGED,
    PARITY,
    RECYCLE_MANY,
    RECYCLE_ONE,
    RENAME,
    SLOTS,
    STEP,
    TASKS,
)
from atlasphys.engine.team import member_of, share

PLANE_CELL = 64.0
"""Cell size of the lattice on which a plane's centre is taken to be [m]."""


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
    j = max(work.origin[p], 0)
    count = old_count[j] if work.origin[p] >= 0 else 0
    lanes.integers[OLD_ROW, lane] = j if count > 0 else 0
    lanes.integers[OLD_COUNT, lane] = count
    lanes.integers[NEW_ROW, lane] = p
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
        a, b = fill_pair_lane(lane, p, work, bodies.center, old.count, lanes)
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
def recycle_waiting(points, first, number, bodies, colliders, shapes, constants, old, new, work, lanes):
    """Recycle up to eight of the pairs of up to so many points that wait for it, or have them collided."""
    waiting = lanes.waiting[RECYCLE_MANY if points > 1 else RECYCLE_ONE]
    for lane in range(LANES):
        p = waiting[first + min(lane, number - 1)]
        fill_pair_lane(lane, p, work, bodies.center, old.count, lanes)
        lanes.integers[HAS_COPY, lane] = 1 if new.collided[p] == old.collided[work.origin[p]] else 0
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
            j = work.origin[p]
            new.count[p], new.touching[p] = old.count[j], old.touching[j]
            if new.collided[p] != old.collided[j]:
                new.collided[p] = old.collided[j]
                for k in range(4):
                    new.feature[p, k] = old.feature[j, k]
        else:
            enqueue(p, bodies, colliders, shapes, constants, old, new, work, lanes)


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
        sort_pairs(first, min(first + CHUNK, count), bodies, constants, old, new, work, lanes)
        work_off(LANES, bodies, colliders, shapes, constants, reach, old, new, work, lanes)
    work_off(1, bodies, colliders, shapes, constants, reach, old, new, work, lanes)
    for kind in range(KINDS):
        if lanes.queued[kind] > 0:
            collide_queue(kind, bodies, colliders, shapes, constants, old, new, work, lanes)


@routine
def leave_distant(first, number, bodies, colliders, shapes, constants, reach, old, new, work, lanes):
    """Have those of up to eight waiting pairs collided whose tight boxes touch; how long the others stay apart is noted."""
    waiting = lanes.waiting[LOOK_NEARER]
    for lane in range(LANES):
        p = waiting[first + min(lane, number - 1)]
        lanes.pairs[0, lane], lanes.pairs[1, lane] = bodies_of(p, work.pair_bodies)
    touching = near(lanes.pairs, reach, lanes.gap) if work.status[KEEPS] else (1 << LANES) - 1
    for lane in range(number):
        if not touching & (1 << lane):
            travel = work.travel[lanes.pairs[0, lane]] + work.travel[lanes.pairs[1, lane]]
            work.expiry[waiting[first + lane]] = travel + lanes.gap[0, lane]
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
        j = work.origin[p]
        if not (work.active[a] | work.active[b]):
            keep_asleep(p, j, old, new, work.copied)
            continue
        points = old.count[max(j, 0)] if j >= 0 and recycling else 0
        if status[KINEMATIC_BODIES] and (is_turntable(bodies, a) or is_turntable(bodies, b)):
            points = 0
        soon = j if points > 0 else 0
        fetch(old.reference, soon, 0)
        fetch(old.local, soon, 0)
        fetch(old.contact, soon, 0)
        fetch(old.points, soon, 0)
        soon = j if points > 1 else 0
        fetch(old.local, soon, 16)
        fetch(old.points, soon, 16)
        lanes.waiting[RECYCLE_MANY, many] = lanes.waiting[RECYCLE_ONE, one] = lanes.waiting[LOOK_NEARER, nearer] = p
        many += 1 if points > 1 else 0
        one += 1 if points == 1 else 0
        expired = (work.travel[a] + work.travel[b] >= work.expiry[p]) | (not keeps)
        nearer += 1 if (points == 0) & expired else 0
        work.copied[p] = 0
        new.count[p] = 0
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
def lay_out_generic(colliders, shapes, contacts, work):
    """Sort the pairs that no body over lanes collides by their routines. Returns whether there is room for their contacts, and the addresses
    of all routines are known."""
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
    for k in range(GENERIC_DATA):
        ready = ready and (work.calls[k] != 0 or work.generic_starts[k] == work.generic_starts[k + 1])
    return ready


@routine
def collide_generic(work, member):
    """Collide a member's share of these pairs."""
    for k in range(GENERIC_DATA):
        first, stop = share(work.generic_starts[k], work.generic_starts[k + 1], member)
        if first < stop and call_address(work.calls[k], work.calls[GENERIC_DATA], first, stop, 0):
            raise MemoryError("no memory for the scratch arrays of a narrow phase")


@routine
def no_call(arguments, first, stop, unused):
    """Stands for the routines, whose arguments it has."""


@routine
def take_generic(bodies, colliders, constants, contacts, kept, old, new, work):
    """Manifolds of the pairs that no body over lanes has collided: contact i belongs to pair ``generic[i]``."""
    lanes, number = part_of(work.lanes, 0), work.status[GENERIC]
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
            fill_pair_lane(lane, p, work, bodies.center, old.count, lanes)
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
def detection_part(arguments, task, rank, size):
    """Do a thread's share of the detection."""
    bodies, colliders, shapes, table_0, table_1, _, fat, constants, work, sync = arguments
    lanes, member = part_of(work.lanes, rank), member_of(sync, rank, size)
    if work.status[PARITY] == 0:
        detect(bodies, colliders, shapes, constants, fat.reach, table_0, table_1, work, lanes, member)
    else:
        detect(bodies, colliders, shapes, constants, fat.reach, table_1, table_0, work, lanes, member)


@kernel
def detection_address(bodies, colliders, shapes, table_0, table_1, remembered, fat, constants, work, sync):
    """Address of the code of ``detection_part`` for arguments of these types."""
    arguments = (bodies, colliders, shapes, table_0, table_1, remembered, fat, constants, work, sync)
    return address_call(detection_part, arguments)[0]
