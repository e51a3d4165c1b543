"""The solver stage of the fused step for ``xpbd``, which one thread does; its parts are those of ``response.py``."""

from atlasphys.engine.fused.response import settle_bodies
from atlasphys.engine.jit import kernel, routine
from atlasphys.engine.simd.address import address_call
from atlasphys.engine.simd.by_address import part_of
from atlasphys.engine.solvers.xpbd import respond
from atlasphys.engine.state.work import PARITY
from atlasphys.engine.team import member_of


@routine
def take_part(arguments, locked, noted):
    """All of the response. ``locked`` and ``noted``: see ``solvers/xpbd.py``."""
    bodies, _, _, table_0, table_1, _, _, constants, work, sync, _, _ = arguments
    respond(bodies, locked, constants, table_1 if work.status[PARITY] == 0 else table_0, work, sync, noted)
    settle_bodies(bodies, work, part_of(work.lanes, 0), member_of(sync, 0, 1))


@routine
def positions_part(arguments, task, rank, size):
    """The response of bodies without locks."""
    take_part(arguments, None, None)


@routine
def positions_part_with_locks(arguments, task, rank, size):
    """The response if some body has locks."""
    take_part(arguments, arguments[8].locked, None)


@routine
def positions_part_with_notes(arguments, task, rank, size):
    """The response if notes are to be taken, with locks or without."""
    take_part(arguments, arguments[8].locked, arguments[8])


@kernel
def positions_address(
    bodies, colliders, shapes, table_0, table_1, remembered, fat, constants, work, sync, contacts, kept
):  # fmt: skip
    """Address of the code of ``positions_part`` for arguments of these types."""
    arguments = (bodies, colliders, shapes, table_0, table_1, remembered, fat, constants, work, sync, contacts, kept)
    return address_call(positions_part, arguments)[0]


@kernel
def positions_address_with_locks(
    bodies, colliders, shapes, table_0, table_1, remembered, fat, constants, work, sync, contacts, kept
):  # fmt: skip
    """Address of the code of ``positions_part_with_locks``."""
    arguments = (bodies, colliders, shapes, table_0, table_1, remembered, fat, constants, work, sync, contacts, kept)
    return address_call(positions_part_with_locks, arguments)[0]


@kernel
def positions_address_with_notes(
    bodies, colliders, shapes, table_0, table_1, remembered, fat, constants, work, sync, contacts, kept
):  # fmt: skip
    """Address of the code of ``positions_part_with_notes``."""
    arguments = (bodies, colliders, shapes, table_0, table_1, remembered, fat, constants, work, sync, contacts, kept)
    return address_call(positions_part_with_notes, arguments)[0]
