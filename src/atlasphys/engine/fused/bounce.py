"""Impacts of contacts with restitution, before the substeps of the fused step. Each member of a team does its share.

Compiled apart, once a world has bodies with restitution.
"""

from atlasphys.engine.fused.response import begin_colour, meet_after, rows_of, share_of_colour
from atlasphys.engine.islands.colour import COLOURS
from atlasphys.engine.jit import kernel, routine
from atlasphys.engine.simd.address import address_call
from atlasphys.engine.solvers.bounce_block import EASE, EASED, MOST_STRIKES, aim, depart, strike
from atlasphys.engine.solvers.parts import hand_out
from atlasphys.engine.state.work import COLOURED, PARITY, WRONG
from atlasphys.engine.team import meet, member_of, share


@routine
def aim_contacts(locked, motion, inverse_mass, drives, constants, new, work, member):
    """Work out what restitution asks for. WRONG becomes 0 if it acts in this step."""
    acts = False
    first, stop = share(0, work.starts[1, COLOURS + 1], member)
    for block in range(first, stop):
        if aim(
            4, locked, block, work.integers_many, work.blocks_many, motion, inverse_mass, drives, new, constants.bounce
        ):  # fmt: skip
            acts = True
    first, stop = share(0, work.starts[0, COLOURS + 1], member)
    for block in range(first, stop):
        if aim(
            1, locked, block, work.integers_one, work.blocks_one, motion, inverse_mass, drives, new, constants.bounce
        ):  # fmt: skip
            acts = True
    if acts:
        work.status[WRONG] = 0


@routine
def strike_contacts(number, locked, motion, inverse_mass, ease, work, member):
    """Pass ``number`` over all contacts, colour by colour. WRONG becomes that number if a bounce was not solved for yet."""
    starts = work.starts
    for colour in range(work.status[COLOURED]):
        begin_colour(colour, motion, work, member)
        first, stop = share_of_colour(1, colour, starts, member)
        for block in range(first, stop):
            if strike(4, locked, block, work.integers_many, work.blocks_many, motion, inverse_mass, ease):
                work.status[WRONG] = number
        first, stop = share_of_colour(0, colour, starts, member)
        for block in range(first, stop):
            if strike(1, locked, block, work.integers_one, work.blocks_one, motion, inverse_mass, ease):
                work.status[WRONG] = number
        meet_after(colour, starts, member)


@routine
def bounce_contacts(locked, motion, inverse_mass, drives, constants, new, work, member):
    """Resolve the impacts of contacts with restitution."""
    real = motion.dtype.type
    hand_out(motion, inverse_mass, drives, work, member)
    aim_contacts(locked, motion, inverse_mass, drives, constants, new, work, member)
    meet(member)
    for visit in range(MOST_STRIKES):
        if work.status[WRONG] < visit:  # not !=: another member may already be in the next pass
            break
        ease = real(1) if visit < EASED else real(EASE)
        strike_contacts(visit + 1, locked, motion, inverse_mass, ease, work, member)
        hand_out(motion, inverse_mass, drives, work, member)
    first, stop = share(0, work.starts[1, COLOURS + 1], member)
    for block in range(first, stop):
        depart(4, locked, block, work.integers_many, work.blocks_many, motion, inverse_mass, new, constants.ratio)
    first, stop = share(0, work.starts[0, COLOURS + 1], member)
    for block in range(first, stop):
        depart(1, locked, block, work.integers_one, work.blocks_one, motion, inverse_mass, new, constants.ratio)
    meet(member)


@routine
def take_part(arguments, rank, size, locked):
    """Do a thread's share of the bounces. ``locked``: see response.py."""
    bodies, _, _, table_0, table_1, _, _, constants, work, sync, _, _ = arguments
    motion, inverse_mass, drives = rows_of(bodies, work)
    new = table_1 if work.status[PARITY] == 0 else table_0
    bounce_contacts(locked, motion, inverse_mass, drives, constants, new, work, member_of(sync, rank, size))


@routine
def bounce_part(arguments, task, rank, size):
    """The bounces of bodies without locks."""
    take_part(arguments, rank, size, None)


@routine
def bounce_part_with_locks(arguments, task, rank, size):
    """The bounces if some body has locks."""
    take_part(arguments, rank, size, arguments[8].locked)


@kernel
def bounce_address(
    bodies, colliders, shapes, table_0, table_1, remembered, fat, constants, work, sync, contacts, kept
):  # fmt: skip
    """Address of the code of ``bounce_part`` for arguments of these types."""
    arguments = (bodies, colliders, shapes, table_0, table_1, remembered, fat, constants, work, sync, contacts, kept)
    return address_call(bounce_part, arguments)[0]


@kernel
def bounce_address_with_locks(
    bodies, colliders, shapes, table_0, table_1, remembered, fat, constants, work, sync, contacts, kept
):  # fmt: skip
    """Address of the code of ``bounce_part_with_locks``."""
    arguments = (bodies, colliders, shapes, table_0, table_1, remembered, fat, constants, work, sync, contacts, kept)
    return address_call(bounce_part_with_locks, arguments)[0]
