"""Narrow phase of the pairs that no body over lanes collides: other routines find their contact points, lanes make their manifolds of them.

Compiled apart, once a world has such pairs.
"""

from atlasphys.engine.fused.detection import fill_pair_lane, renew_lanes
from atlasphys.engine.jit import kernel, routine
from atlasphys.engine.manifold.recycle import SWAPPED
from atlasphys.engine.manifold.reduce import reduce_points
from atlasphys.engine.math import vec
from atlasphys.engine.narrowphase.layout import lay_out
from atlasphys.engine.simd import LANES
from atlasphys.engine.simd.address import address_call, call_address
from atlasphys.engine.simd.by_address import part_of
from atlasphys.engine.state.work import EDGE_LIMIT, GENERIC, LAID_OUT, PARITY, ROUTINES, SLOTS
from atlasphys.engine.team import member_of, share

# Tasks of a team (team.py); those of steps.py have other numbers.
LAY_OUT_GENERIC, COLLIDE_GENERIC, TAKE_GENERIC = 6, 7, 8


@routine
def lay_out_generic(colliders, shapes, contacts, work):
    """Sort the pairs that no body over lanes collides by their routines. LAID_OUT says whether there is room for their contacts, and the
    addresses of all routines are known."""
    status, number = work.status, work.status[GENERIC]
    status[SLOTS] = status[LAID_OUT] = 0
    if number > len(contacts.a):
        return
    for i in range(number):
        p = work.generic[i]
        work.generic_pairs[i, 0], work.generic_pairs[i, 1] = work.pairs[p, 0], work.pairs[p, 1]
    status[SLOTS] = lay_out(
        work.generic_pairs[:number], colliders.shape, shapes.layout, work.routines, status[EDGE_LIMIT], contacts,
        work.generic_routine, work.generic_rows, work.generic_starts,
    )  # fmt: skip
    ready = status[SLOTS] <= len(contacts.depth)
    for k in range(ROUTINES):
        ready = ready and (work.calls[k] != 0 or work.generic_starts[k] == work.generic_starts[k + 1])
    status[LAID_OUT] = ready


@routine
def collide_generic(bodies, colliders, shapes, margin, contacts, work, member):
    """Collide a member's share of these pairs."""
    data = address_call(no_call, (work.generic_rows, bodies, colliders, shapes, margin, contacts))[1]
    for k in range(ROUTINES):
        first, stop = share(work.generic_starts[k], work.generic_starts[k + 1], member)
        if first < stop and call_address(work.calls[k], data, first, stop, 0):
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
        renew_lanes(work.generic, start, filled, bodies.geometry, colliders.material, constants, old, new, work, lanes)


@routine
def generic_part(arguments, task, rank, size):
    """Do a thread's share of a task."""
    bodies, colliders, shapes, table_0, table_1, _, _, constants, work, sync, contacts, kept = arguments
    if task == LAY_OUT_GENERIC:
        lay_out_generic(colliders, shapes, contacts, work)
    elif task == COLLIDE_GENERIC:
        collide_generic(bodies, colliders, shapes, constants.margin, contacts, work, member_of(sync, rank, size))
    else:
        old, new = (table_0, table_1) if work.status[PARITY] == 0 else (table_1, table_0)
        take_generic(bodies, colliders, constants, contacts, kept, old, new, work)


@kernel
def generic_address(
    bodies, colliders, shapes, table_0, table_1, remembered, fat, constants, work, sync, contacts, kept
):  # fmt: skip
    """Address of the code of ``generic_part`` for arguments of these types."""
    arguments = (bodies, colliders, shapes, table_0, table_1, remembered, fat, constants, work, sync, contacts, kept)
    return address_call(generic_part, arguments)[0]
