"""Joints in the solver stage of the fused step. A kernel of its own, compiled for worlds with joints, which ``response`` calls by address."""

from atlasphys.engine.jit import kernel, routine
from atlasphys.engine.joints.layout import no_visit
from atlasphys.engine.simd.address import address_call, call_address
from atlasphys.engine.state.joint_work import FIRST, KEEP_RESULTS, PREPARE, STOP, TYPE
from atlasphys.engine.state.work import HUBS, JOINT_TABLES, JOINTS
from atlasphys.engine.team import meet, member_of, share

FEW_BLOCKS = 8
"""Below so many blocks, a phase is done by one thread."""


@routine
def joints_part(arguments, mode, rank, size):
    """Do a thread's share of one pass over all joints: PREPARE, START, SOLVE, RELAX or KEEP_RESULTS."""
    bodies, _, _, _, _, _, _, _, work, sync = arguments
    member, phases, calls = member_of(sync, rank, size), work.phases, work.calls
    motion, inverse_mass = bodies.motion, bodies.inverse_mass
    if work.status[HUBS] > 0:
        motion, inverse_mass = work.motion, work.inverse_mass
    data = address_call(no_visit, (motion, bodies.geometry, inverse_mass, bodies.center, work.joints))[1]
    if mode in (PREPARE, KEEP_RESULTS):
        first, stop = share(0, phases[-1, STOP], member)
        call_address(calls[JOINT_TABLES], data, mode, first, stop)
        return
    for p in range(len(phases)):
        first, stop = phases[p, FIRST], phases[p, STOP]
        alone = stop - first < FEW_BLOCKS
        goes_on = alone and p + 1 < len(phases) and phases[p + 1, STOP] - phases[p + 1, FIRST] < FEW_BLOCKS
        if not alone:
            first, stop = share(first, stop, member)
        if not alone or member.rank == 0:
            call_address(calls[JOINTS + phases[p, TYPE]], data, mode, first, stop)
        if not goes_on:
            meet(member)


@kernel
def joints_address(bodies, colliders, shapes, table_0, table_1, remembered, fat, constants, work, sync):
    """Address of the code of ``joints_part`` for arguments of these types."""
    arguments = (bodies, colliders, shapes, table_0, table_1, remembered, fat, constants, work, sync)
    return address_call(joints_part, arguments)[0]
