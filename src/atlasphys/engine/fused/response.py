"""The solver stage of the fused step: passes over contacts, colour by colour, and over bodies, in substeps. Each member of a team does its share."""

from atlasphys.engine.islands.colour import COLOURS, beside
from atlasphys.engine.jit import kernel, routine
from atlasphys.engine.simd import LANES
from atlasphys.engine.simd.address import address_call, call_address
from atlasphys.engine.simd.bits import fetch
from atlasphys.engine.simd.by_address import part_of
from atlasphys.engine.solvers.body_block import drive, fly, gain_speed, move, settle, tumble
from atlasphys.engine.solvers.locked import follow_turn
from atlasphys.engine.solvers.parts import give_back, hand_out, join_parts, take_bodies
from atlasphys.engine.solvers.rolling_block import prepare_rolling, solve_rolling, start_rolling, store_rolling
from atlasphys.engine.solvers.soft_contact import prepare, solve, store_impulses, warm_start
from atlasphys.engine.solvers.sweep_trace import RELAX, SOLVE, note_pass
from atlasphys.engine.state import joint_work
from atlasphys.engine.state.blocks import COUNT, MANIFOLD, ROLLS
from atlasphys.engine.state.manifolds import RESTITUTION, ROLLING, TORSIONAL
from atlasphys.engine.state.work import (
    BOUNCE,
    BOUNCES,
    BROKEN,
    COLOURED,
    HUBS,
    JOINT_VISITS,
    LIVE,
    PARITY,
    PLAIN,
    TUMBLING,
)
from atlasphys.engine.team import DATA, meet, member_of, share

AHEAD = 2
"""So many blocks before its turn a block's manifolds are fetched: they lie anywhere in the table."""

FEW_BLOCKS = 8
"""Below so many blocks, a colour is done by one thread."""


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
def rows_of(bodies, work):
    """Motion, inverse mass and drives of the bodies, and, while there are hubs, of their parts."""
    if work.status[HUBS] > 0:
        return work.motion, work.inverse_mass, work.drives
    return bodies.motion, bodies.inverse_mass, bodies.drive


@routine
def begin_colour(colour, motion, work, member):
    """Before the last colour, which has hubs as a whole, the leader joins their parts."""
    if colour == COLOURS and member.rank == 0:
        join_parts(work.hubs, work.status[HUBS], motion)


@routine
def meet_after(colour, starts, member):
    """Wait for the others, unless there was nothing to do, or the leader did this colour and does the next. (Where the last colour comes, there
    were parts to be joined.)"""
    if size_of_colour(colour, starts) > 0 or colour == COLOURS:
        goes_on = colour < COLOURS and size_of_colour(colour + 1, starts) > 0 and is_leaders(colour + 1, starts)
        if not (goes_on and is_leaders(colour, starts)):
            meet(member)


@routine
def fetch_ahead(block, stop, integers, manifolds):
    """Have the manifolds of a block that is soon to come brought near."""
    if block < stop:
        for lane in range(LANES):
            row = integers[block, MANIFOLD, lane]
            fetch(manifolds.contact, row, 0)
            fetch(manifolds.points, row, 0)
            fetch(manifolds.points, row, 16)


@routine
def prepare_contacts(locked, inverse_mass, constants, new, work, member):
    """Write the blocks of all contacts. BOUNCES says whether one of them has restitution."""
    ratio, bounces = constants.ratio, False
    first, stop = share(0, work.starts[1, COLOURS + 1], member)
    for block in range(first, stop):
        fetch_ahead(block + AHEAD, stop, work.integers_many, new)
        if prepare(4, locked, block, work.integers_many, work.blocks_many, new, inverse_mass, ratio):
            bounces = note_materials(4, block, work.integers_many, work.rolls_many, new) or bounces
            if work.integers_many[block, ROLLS, 0]:
                prepare_rolling(
                    block, work.integers_many, work.blocks_many, work.rolls_many, new, inverse_mass, ratio
                )  # fmt: skip
    first, stop = share(0, work.starts[0, COLOURS + 1], member)
    for block in range(first, stop):
        fetch_ahead(block + AHEAD, stop, work.integers_one, new)
        if prepare(1, locked, block, work.integers_one, work.blocks_one, new, inverse_mass, ratio):
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
def start_contacts(locked, motion, inverse_mass, work, member):
    """Apply the impulses that the last substep ended with."""
    starts = work.starts
    for colour in range(work.status[COLOURED]):
        begin_colour(colour, motion, work, member)
        first, stop = share_of_colour(1, colour, starts, member)
        block = first
        while block < stop:
            other = beside(block, colour, stop)
            warm_start(4, locked, block, other, work.integers_many, work.blocks_many, motion, inverse_mass)
            block = other + 1
        for block in range(first, stop):
            if work.integers_many[block, ROLLS, 0]:
                start_rolling(
                    4, block, work.integers_many, work.blocks_many, work.rolls_many, motion, inverse_mass
                )  # fmt: skip
        first, stop = share_of_colour(0, colour, starts, member)
        block = first
        while block < stop:
            other = beside(block, colour, stop)
            warm_start(1, locked, block, other, work.integers_one, work.blocks_one, motion, inverse_mass)
            block = other + 1
        for block in range(first, stop):
            if work.integers_one[block, ROLLS, 0]:
                start_rolling(1, block, work.integers_one, work.blocks_one, work.rolls_one, motion, inverse_mass)
        meet_after(colour, starts, member)


@routine
def solve_contacts(relax, locked, motion, inverse_mass, soft, work, member):
    """One pass over all contacts, colour by colour."""
    starts = work.starts
    counts = soft[0] - soft[0] + (1 if relax else 0)
    for colour in range(work.status[COLOURED]):
        begin_colour(colour, motion, work, member)
        first, stop = share_of_colour(1, colour, starts, member)
        block = first
        while block < stop:
            other = beside(block, colour, stop)
            if relax:
                solve(4, locked, 1, block, other, work.integers_many, work.blocks_many, motion, inverse_mass, soft)
            else:
                solve(4, locked, 0, block, other, work.integers_many, work.blocks_many, motion, inverse_mass, soft)
            block = other + 1
        for block in range(first, stop):
            if work.integers_many[block, ROLLS, 0]:
                solve_rolling(
                    4, block, work.integers_many, work.blocks_many, work.rolls_many, motion, inverse_mass, counts
                )  # fmt: skip
        first, stop = share_of_colour(0, colour, starts, member)
        block = first
        while block < stop:
            other = beside(block, colour, stop)
            if relax:
                solve(1, locked, 1, block, other, work.integers_one, work.blocks_one, motion, inverse_mass, soft)
            else:
                solve(1, locked, 0, block, other, work.integers_one, work.blocks_one, motion, inverse_mass, soft)
            block = other + 1
        for block in range(first, stop):
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
        fetch_ahead(block + AHEAD, stop, work.integers_many, new)
        store_impulses(4, block, work.integers_many, work.blocks_many, new)
        if work.integers_many[block, ROLLS, 0]:
            store_rolling(block, work.integers_many, work.blocks_many, work.rolls_many, new)
    first, stop = share(0, work.starts[0, COLOURS + 1], member)
    for block in range(first, stop):
        fetch_ahead(block + AHEAD, stop, work.integers_one, new)
        store_impulses(1, block, work.integers_one, work.blocks_one, new)
        if work.integers_one[block, ROLLS, 0]:
            store_rolling(block, work.integers_one, work.blocks_one, work.rolls_one, new)


@routine
def visit_joints(mode, work, member):
    """One pass over all joints (fused/joints.py)."""
    if len(work.phases) > 0:
        call_address(work.calls[JOINT_VISITS], member.sync[DATA], mode, member.rank, member.size)


@routine
def fly_all(bodies, drives, constants, work, member):
    """Motion in all substeps if nothing touches or is joined: each block of bodies takes them one after the other."""
    status, motion, geometry, h = work.status, bodies.motion, bodies.geometry, constants.h
    first, stop = share(0, status[PLAIN], member)
    for block in range(first, stop):
        for _ in range(constants.substeps):
            fly(block, work.plain, motion, geometry, drives, h)
    first, stop = share(0, status[TUMBLING], member)
    for block in range(first, stop):
        for _ in range(constants.substeps):
            gain_speed(block, work.tumbling, motion, drives)
            tumble(block, work.tumbling, motion, geometry, bodies.mass, bodies.frame, bodies.inverse_mass, h)


@routine
def respond(bodies, locked, constants, new, work, member, noted):
    """The solver stage: impulses and motion in all substeps. Each member does its share of every loop.

    ``noted`` is ``work`` if notes are to be taken of the passes, which one member then does alone, else None."""
    status, geometry, h = work.status, bodies.geometry, constants.h
    if status[HUBS] > 0:
        take_bodies(bodies, work, member)
    motion, inverse_mass, drives = rows_of(bodies, work)
    plain, tumbling = work.plain, work.tumbling
    for rows, blocks in ((plain, status[PLAIN]), (tumbling, status[TUMBLING])):
        first, stop = share(0, blocks, member)
        for block in range(first, stop):
            drive(
                locked, block, rows, motion, bodies.force, bodies.response, inverse_mass, bodies.mass, drives,
                constants.gravity, h,
            )  # fmt: skip
    if status[LIVE] == 0 and len(work.phases) == 0 and locked is None and noted is None:
        fly_all(bodies, drives, constants, work, member)
        return
    prepare_contacts(locked, inverse_mass, constants, new, work, member)
    visit_joints(joint_work.PREPARE, work, member)
    meet(member)
    if status[BOUNCES] and call_address(work.calls[BOUNCE], member.sync[DATA], 0, member.rank, member.size) != 0:
        raise RuntimeError("the bounces failed")
    for substep in range(constants.substeps):
        for rows, blocks in ((plain, status[PLAIN]), (tumbling, status[TUMBLING])):
            first, stop = share(0, blocks, member)
            for block in range(first, stop):
                gain_speed(block, rows, motion, drives)
        meet(member)
        visit_joints(joint_work.START, work, member)
        hand_out(motion, inverse_mass, drives, work, member)
        start_contacts(locked, motion, inverse_mass, work, member)
        for _ in range(constants.joint_sweeps):
            visit_joints(joint_work.SOLVE, work, member)
        hand_out(motion, inverse_mass, drives, work, member)
        solve_contacts(False, locked, motion, inverse_mass, constants.soft, work, member)
        if noted is not None:
            note_pass(SOLVE, substep, motion, noted)
        first, stop = share(0, status[PLAIN], member)
        for block in range(first, stop):
            move(block, plain, motion, geometry, h)
        first, stop = share(0, status[TUMBLING], member)
        for block in range(first, stop):
            tumble(block, tumbling, motion, geometry, bodies.mass, bodies.frame, inverse_mass, h)
        meet(member)
        if locked is not None:
            if member.rank == 0:
                follow_turn(locked, bodies.locks, motion, geometry, inverse_mass, bodies.mass, bodies.frame, h)
            meet(member)
        visit_joints(joint_work.RELAX, work, member)
        hand_out(motion, inverse_mass, drives, work, member)
        solve_contacts(True, locked, motion, inverse_mass, constants.soft, work, member)
        if noted is not None:
            note_pass(RELAX, substep, motion, noted)
    store_contacts(new, work, member)
    give_back(bodies, work, member)


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
def take_part(arguments, rank, size, locked, noted):
    """Do a thread's share of the response. ``locked`` are the rows of the bodies whose rotation is locked about some axis; None if no body
    has any locks, not even of its translation."""
    bodies, _, _, table_0, table_1, _, _, constants, work, sync, _, _ = arguments
    lanes, member = part_of(work.lanes, rank), member_of(sync, rank, size)
    respond(bodies, locked, constants, table_1 if work.status[PARITY] == 0 else table_0, work, member, noted)
    settle_bodies(bodies, work, lanes, member)


@routine
def response_part(arguments, task, rank, size):
    """The response of bodies without locks."""
    take_part(arguments, rank, size, None, None)


@routine
def response_part_with_locks(arguments, task, rank, size):
    """The response if some body has locks."""
    take_part(arguments, rank, size, arguments[8].locked, None)


@routine
def response_part_with_notes(arguments, task, rank, size):
    """The response if notes are to be taken, with locks or without."""
    take_part(arguments, rank, size, arguments[8].locked, arguments[8])


@kernel
def response_address(
    bodies, colliders, shapes, table_0, table_1, remembered, fat, constants, work, sync, contacts, kept
):  # fmt: skip
    """Address of the code of ``response_part`` for arguments of these types."""
    arguments = (bodies, colliders, shapes, table_0, table_1, remembered, fat, constants, work, sync, contacts, kept)
    return address_call(response_part, arguments)[0]


@kernel
def response_address_with_locks(
    bodies, colliders, shapes, table_0, table_1, remembered, fat, constants, work, sync, contacts, kept
):  # fmt: skip
    """Address of the code of ``response_part_with_locks``."""
    arguments = (bodies, colliders, shapes, table_0, table_1, remembered, fat, constants, work, sync, contacts, kept)
    return address_call(response_part_with_locks, arguments)[0]


@kernel
def response_address_with_notes(
    bodies, colliders, shapes, table_0, table_1, remembered, fat, constants, work, sync, contacts, kept
):  # fmt: skip
    """Address of the code of ``response_part_with_notes``."""
    arguments = (bodies, colliders, shapes, table_0, table_1, remembered, fat, constants, work, sync, contacts, kept)
    return address_call(response_part_with_notes, arguments)[0]
