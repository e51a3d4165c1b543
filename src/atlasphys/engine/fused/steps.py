"""The step of the default world, its stages fused in one compiled call.

``run_steps`` makes as many steps as it is asked for without returning to Python, unless a stage needs something that only Python can give: other
candidate pairs, routines for pairs of rarer shapes, or more memory. It then says so, and is called again to go on where it stopped.
The stages are those of ``step.py``, in the same order; their algorithms are in the folders that bear their names.
"""

import numpy as np

from atlasphys.engine.broadphase.fat_boxes import has_left
from atlasphys.engine.fused.detection import (
    begin_detection,
    list_generic,
)
from atlasphys.engine.fused.generic import COLLIDE_GENERIC, LAY_OUT_GENERIC, TAKE_GENERIC
from atlasphys.engine.fused.rows import give_back_rows, note_touching
from atlasphys.engine.islands.colour import COLOURS, block_ranges, colour_contacts, fill_blocks, weight_first
from atlasphys.engine.islands.sleep import list_active, list_awake, note_rest, put_to_sleep, wake_touched
from atlasphys.engine.islands.split import MOST_CONTACTS, deal_contacts, find_hubs
from atlasphys.engine.jit import kernel, routine
from atlasphys.engine.narrowphase.apart import add_travel
from atlasphys.engine.simd import LANES
from atlasphys.engine.simd.address import address_call, call_address
from atlasphys.engine.simd.atomic import now
from atlasphys.engine.simd.by_address import part_of
from atlasphys.engine.state.joint_work import KEEP_RESULTS
from atlasphys.engine.state.pose import refresh
from atlasphys.engine.state.work import (
    BLOCKS_MANY,
    BLOCKS_ONE,
    BOUNCES,
    BROADPHASE,
    BROKEN,
    CHECKED,
    COLOURED,
    DETECT,
    DETECT_GENERIC,
    DETECTION,
    DIVERGED,
    DONE,
    FINISH,
    FINISHED,
    FORCES,
    GENERIC,
    GENERIC_PART,
    HUBS,
    ISLANDS,
    JOINT_VISITS,
    KEEPS,
    KINEMATIC_BODIES,
    LAID_OUT,
    LEFT,
    LIVE,
    NARROWPHASE,
    NEED_BLOCKS,
    NEED_GENERIC,
    NEED_PAIRS,
    NEED_PARTS,
    PAIRS,
    PAIRS_CHANGED,
    PARITY,
    PARTS,
    PHASE,
    PLAIN,
    RESPOND,
    RESPONSE,
    SLEEPERS_CHANGED,
    SLEEPS,
    SLEPT,
    SOLVER,
    SPLITS,
    STEP,
    TUMBLING,
    WEIGHT_FIRST,
    WOKEN,
    WRONG,
)
from atlasphys.engine.team import CODE, DATA, do_task, member_of, share

# Tasks of a team (team.py)
LOOK, COLLIDE, ADVANCE, REMEMBER = range(1, 5)

# Least work that a thread is asked to help with: blocks of bodies, pairs, blocks of contacts.
BODIES_EACH, PAIRS_EACH, GENERIC_EACH, CONTACTS_EACH = 64, 256, 8, 64


@routine
def begin_step(bodies, count, work):
    """Bring the lists of bodies up to date, and note which are active, for the events of the step."""
    status = work.status
    if status[SLEEPERS_CHANGED]:
        list_bodies(bodies, count, work)
        status[SLEEPERS_CHANGED] = 0
    elif status[KINEMATIC_BODIES]:  # one that stops or starts disturbs others no more, or again
        list_active(bodies.kind, bodies.island, bodies.rest, bodies.motion, count, work.active)
    if status[SLEEPS]:
        for i in range(count):
            work.before[i] = work.active[i]
    status[SLEPT] = status[WOKEN] = 0


@routine
def list_bodies(bodies, count, work):
    """List the bodies that are to be moved, and those that may disturb others."""
    status = work.status
    list_active(bodies.kind, bodies.island, bodies.rest, bodies.motion, count, work.active)
    status[PLAIN], status[TUMBLING] = list_awake(
        bodies.kind, bodies.island, bodies.frame, count, work.plain, work.tumbling
    )


@routine
def list_live(count, work):
    """List the pairs that have points, so many as ``count`` says of their rows, and an active body."""
    number, active, live = 0, work.active, work.live
    for i in range(work.status[PAIRS]):
        block, lane = i // LANES, i % LANES
        moves = active[work.pair_bodies[block, 0, lane]] | active[work.pair_bodies[block, 1, lane]]
        live[number] = i  # no branch: a processor would guess wrong half the time
        number += 1 if (count[work.row[i]] > 0) & (moves != 0) else 0
    work.status[LIVE] = number


@routine
def wake(bodies, colliders, count, new, work):
    """Wake the islands that an active body touches; their contacts are live then too."""
    status = work.status
    status[WOKEN] += wake_touched(
        work.pairs, work.live, status[LIVE], colliders.body, work.linked, bodies.kind, bodies.island, bodies.rest, work.active, count,
        work.ready, work.island_before, work.rest_before,
    )  # fmt: skip
    if status[WOKEN]:
        list_bodies(bodies, count, work)
        list_live(new.count, work)


@routine
def arrange_contacts(bodies, count, new, work):
    """Give the contacts their places in blocks: colours, and before these parts of the bodies that have many. Returns what there is no room for, or
    FINISHED."""
    status, live, ends = work.status, work.status[LIVE], work.pair_bodies
    status[HUBS] = status[PARTS] = 0
    work.used[:] = np.uint64(0)
    colour_contacts(ends, work.row, new.count, work.live, live, work.moves, work.used, work.colours, work.sizes)
    status[COLOURED] = block_ranges(work.sizes, work.starts)
    if status[SPLITS] and status[COLOURED] > MOST_CONTACTS:
        status[HUBS], status[PARTS] = find_hubs(ends, work.live, live, work.moves, count, work.parent, work.hubs)
    if status[HUBS] > 0:
        if (
            len(work.hubs) < status[HUBS]
            or len(work.motion) < count + status[PARTS]
            or len(work.ends) < len(work.pair_bodies)
        ):
            return NEED_PARTS
        deal_contacts(
            ends, work.live, live, bodies.inverse_mass, work.parent, work.hubs, status[HUBS], work.heaviest, work.ends,
            work.used,
        )  # fmt: skip
        ends = work.ends
        colour_contacts(ends, work.row, new.count, work.live, live, work.moves, work.used, work.colours, work.sizes)
        block_ranges(work.sizes, work.starts)
        status[COLOURED] = COLOURS + 1
    status[BLOCKS_ONE], status[BLOCKS_MANY] = work.starts[0, COLOURS + 1], work.starts[1, COLOURS + 1]
    if len(work.blocks_one) < status[BLOCKS_ONE] or len(work.blocks_many) < status[BLOCKS_MANY]:
        return NEED_BLOCKS
    fill_blocks(
        ends, work.row, new.count, work.live, live, work.moves, work.colours, work.starts, work.cursor,
        work.integers_one, work.integers_many,
    )  # fmt: skip
    return FINISHED


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
            work.pairs, work.live, status[LIVE], colliders.body, work.linked, bodies.kind, bodies.island, bodies.rest,
            bodies.motion, work.active, count, work.parent, work.ready,
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
def end_step(bodies, constants, fat, work):
    """What was to last for one step ends, the tables of manifolds change their parts, and the clocks go on."""
    status = work.status
    if status[FORCES]:
        bodies.force[:] = 0
        status[FORCES] = 0
    status[PAIRS_CHANGED] = 0
    fat.clock[0] += constants.substeps * np.float64(constants.h)
    status[PARITY] = 1 - status[PARITY]
    status[STEP] += 1
    status[PHASE] = DETECT
    status[DONE] += 1


@routine
def take_part(arguments, task, rank, size):
    """Do a thread's share of the tasks that are not compiled apart, as ``detection`` and ``response`` are."""
    bodies, _, _, _, _, remembered, fat, constants, work, sync, _, _ = arguments
    status, lanes, member = work.status, part_of(work.lanes, rank), member_of(sync, rank, size)
    if task == LOOK:
        for rows, blocks in ((work.plain, status[PLAIN]), (work.tumbling, status[TUMBLING])):
            first, stop = share(0, blocks, member)
            if has_left(
                first, stop, rows, bodies.center, bodies.geometry, fat, constants.margin, lanes.delta, work.room
            ):  # fmt: skip
                status[LEFT] = 1
    elif task == REMEMBER:
        remember(bodies, remembered, work, member)


@routine
def note_time(times, stage, since):
    """Add the time since a moment to that of a stage; returns the present moment."""
    time = now()
    times[stage] += time - since
    return time


@kernel
def run_steps(
    bodies, colliders, shapes, table_0, table_1, remembered, contacts, kept, count, fat, constants, work, steps, sync
):  # fmt: skip
    """Make steps until ``status[DONE]`` is ``steps``, or until something is needed; the answer says what.

    ``count`` is the number of bodies, ``fat`` the boxes of the tree broad phase. The present manifolds are in ``table_0`` if PARITY is 0; each step
    builds the next ones in the other table. ``sync`` is that of the team of threads (team.py) that share the work; ``work.lanes`` has scratch for
    each. PHASE says with which stage a step goes on once what it needed has been given.
    """
    status = work.status
    arguments = (bodies, colliders, shapes, table_0, table_1, remembered, fat, constants, work, sync, contacts, kept)
    code, sync[DATA] = address_call(take_part, arguments)
    sync[CODE + LOOK] = sync[CODE + REMEMBER] = code
    sync[CODE + COLLIDE], sync[CODE + ADVANCE] = work.calls[DETECTION], work.calls[RESPONSE]
    sync[CODE + LAY_OUT_GENERIC] = sync[CODE + COLLIDE_GENERIC] = sync[CODE + TAKE_GENERIC] = work.calls[GENERIC_PART]
    time = now()
    while status[DONE] < steps:
        if status[PARITY] == 0:
            old, new = table_0, table_1
        else:
            old, new = table_1, table_0
        if status[PHASE] == DETECT:
            # Broad phase: the candidate pairs of last step hold, unless they were found for this step only or a body has left its fat box.
            begin_step(bodies, count, work)
            if status[KEEPS]:
                status[LEFT] = 0
                do_task(sync, LOOK, (status[PLAIN] + status[TUMBLING]) // BODIES_EACH)
                if status[LEFT] and not status[CHECKED]:
                    return NEED_PAIRS
            elif not status[CHECKED]:
                return NEED_PAIRS
            status[CHECKED] = 0
            time = note_time(work.times, BROADPHASE, time)

            # Narrow phase and manifolds; pairs of rarer shapes are left to routines of their own.
            begin_detection(new, work)
            do_task(sync, COLLIDE, status[PAIRS] // PAIRS_EACH)
            status[PHASE] = RESPOND
            if status[GENERIC] > 0:
                list_generic(work)
                status[PHASE] = DETECT_GENERIC
        if status[PHASE] == DETECT_GENERIC:
            if work.calls[GENERIC_PART] == 0:
                return NEED_GENERIC
            do_task(sync, LAY_OUT_GENERIC, 1)
            if not status[LAID_OUT]:
                return NEED_GENERIC
            do_task(sync, COLLIDE_GENERIC, status[GENERIC] // GENERIC_EACH)
            do_task(sync, TAKE_GENERIC, 1)
            status[PHASE] = RESPOND
        time = note_time(work.times, NARROWPHASE, time)

        # Islands: what wakes, and which contacts are solved at the same time.
        list_live(new.count, work)
        if status[SLEEPS]:
            wake(bodies, colliders, count, new, work)
        if status[WEIGHT_FIRST]:
            weight_first(new.contact, work.row, constants.gravity, work.live, status[LIVE], work.generic)
        missing = arrange_contacts(bodies, count, new, work)
        if missing != FINISHED:
            return missing
        time = note_time(work.times, ISLANDS, time)

        # Solver
        status[BOUNCES] = status[BROKEN] = 0
        status[WRONG] = -1
        body_work = (status[PLAIN] + status[TUMBLING]) // BODIES_EACH
        contact_work = (status[BLOCKS_ONE] + status[BLOCKS_MANY] + len(work.joints.blocks)) // CONTACTS_EACH
        do_task(sync, ADVANCE, contact_work + body_work)
        if status[BROKEN]:
            return DIVERGED
        if len(work.phases) > 0:
            call_address(work.calls[JOINT_VISITS], sync[DATA], KEEP_RESULTS, 0, 1)
        time = note_time(work.times, SOLVER, time)

        # Finish
        rest(bodies, colliders, count, constants, new, work)
        do_task(sync, REMEMBER, body_work)
        note_touching(new, work)
        give_back_rows(old, new, work)
        end_step(bodies, constants, fat, work)
        time = note_time(work.times, FINISH, time)
    return FINISHED
