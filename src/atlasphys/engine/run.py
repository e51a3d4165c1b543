"""Steps of the default world from Python's side: what ``fused.steps.run_steps`` is given, and what it asks for."""

from __future__ import annotations

import time

import numpy as np
import numpy.typing as npt

from atlasphys.engine.fused.addresses import find_parts, make_generic_ready, ready_joints, tables
from atlasphys.engine.fused.candidates import look_for_pairs
from atlasphys.engine.fused.constants import constants
from atlasphys.engine.fused.steps import run_steps
from atlasphys.engine.fused.workspace import Workspace, grow_blocks, grow_parts, notes_for, reserve_notes
from atlasphys.engine.jit import call
from atlasphys.engine.narrowphase.batch import KINDS
from atlasphys.engine.solvers.sweep_trace import passes
from atlasphys.engine.state.bodies import DYNAMIC
from atlasphys.engine.state.joint_work import RATIO
from atlasphys.engine.state.pose import refresh
from atlasphys.engine.state.state import NO_PAIRS, NO_ROWS, State
from atlasphys.engine.state.work import (
    BEGAN,
    BROADPHASE,
    CHECKED,
    DETECT,
    DETECTION,
    DIVERGED,
    DONE,
    ENDED,
    FORCES,
    KEEPS,
    NEED_BLOCKS,
    NEED_GENERIC,
    NEED_PAIRS,
    NEED_PARTS,
    NOTED,
    PARITY,
    PHASE,
    ROWS,
    SLEEPERS_CHANGED,
    SLEEPS,
    SLEPT,
    STEP,
    WOKEN,
    empty_lanes,
)
from atlasphys.engine.step import STAGES, DivergedError, Pipeline, Profile
from atlasphys.engine.threads import lend_team

LONGEST_CALL = 0.05
"""Time [s] that one compiled call should take at most, so that Ctrl-C is heard."""


def run(state: State, pipeline: Pipeline, h: float, steps: int) -> Profile:
    """Advance ``state`` by ``steps`` steps of h seconds. If one of them goes wrong, the state is that before it, and an error is raised."""
    settings = pipeline.solver_settings
    values = constants(state.real.char, state.environment, settings, h, state.last_h)
    keeps = pipeline.broadphase == "tree"
    profile = Profile()
    written = state.stale
    if written:
        refresh(state.bodies, 0, state.count)
        state.stale = False
        if state.workspace is not None:
            state.workspace.work.expiry[:] = state.workspace.work.expiry_before[:] = -np.inf
    space = state.workspace
    if space is None or (space.narrowphase, space.solver) != (pipeline.narrowphase, pipeline.solver):
        space = state.workspace = Workspace(state, pipeline.narrowphase, pipeline.solver)
    status = space.work.status
    space.work.times[:] = 0
    status[KEEPS], status[DONE], status[FORCES] = keeps, 0, state.forced
    state.forced = False
    status[CHECKED], status[PHASE], status[STEP] = 0, DETECT, state.steps + 1
    status[SLEEPS], status[SLEEPERS_CHANGED] = pipeline.sleeping, 1
    if keeps and (written or len(space.tree.fat.center) != state.count):
        look_for_pairs(state, pipeline.broadphase, h)
    if len(space.work.lanes.queue) < pipeline.threads:
        space.work = space.work._replace(lanes=empty_lanes(pipeline.threads, KINDS, state.real))
    changed = state.changed
    wanted = 1 if changed or values.ratio != 1 else min(steps, space.pace)
    completed = 0
    if space.work.calls[DETECTION] == 0 or space.takes_notes != (state.trace is not None):
        find_parts(state, values)
    ready_joints(state, settings, values)
    status[NOTED] = 0
    try:
        while True:
            if space.takes_notes:
                reserve_notes(state, 2 * settings.substeps)
            start = time.perf_counter()
            try:
                with lend_team(1 if space.takes_notes else pipeline.threads) as sync:
                    answer = call(
                        run_steps, state.real.char, *tables(state), state.contacts, space.kept, state.count,
                        space.tree.fat, values, space.work, wanted, sync,
                    )  # fmt: skip
            finally:  # Ctrl-C is heard as soon as the call has returned
                completed += note_completed(state, completed, h, settings.substeps)
            if changed and completed:  # the first call makes one step at most
                state.changes_noticed()
                status[SLEEPERS_CHANGED], changed = 1, False
            if answer == NEED_PAIRS:
                looked = time.perf_counter_ns()
                look_for_pairs(state, pipeline.broadphase, h)
                space.work.times[BROADPHASE] += time.perf_counter_ns() - looked
            elif answer == NEED_BLOCKS:
                grow_blocks(state)
            elif answer == NEED_PARTS:
                grow_parts(state)
            elif answer == NEED_GENERIC:
                make_generic_ready(state, values)
            elif answer == DIVERGED:
                raise DivergedError(state.diverged_rows().tolist())
            elif wanted < steps:
                taken = time.perf_counter() - start
                if taken < LONGEST_CALL / 2:
                    space.pace *= 2
                elif taken > LONGEST_CALL:
                    space.pace = max(space.pace // 2, 1)
                wanted = min(steps, wanted + space.pace)
                if values.ratio != 0:
                    values = values._replace(ratio=type(values.ratio)(1))
                    space.joints.work.numbers[RATIO] = 1
            else:
                break
    except BaseException:
        abandon_step(state, completed)
        raise
    scale = 1e-9 / max(steps, 1)
    for stage, nanoseconds in zip(STAGES, space.work.times.tolist(), strict=True):
        profile[stage] = nanoseconds * scale
    if state.trace is not None:
        state.trace += passes(state, pipeline.solver, h / settings.substeps)
        space.work = space.work._replace(**notes_for(state, 0, 0))
    state.began, state.ended = (
        in_order(pairs) for pairs in (space.work.began[: status[BEGAN]], space.work.ended[: status[ENDED]])
    )
    state.slept = _rows(changed_activity(state) < 0) if status[SLEPT] else NO_ROWS
    state.woke = _rows(changed_activity(state) > 0) if status[WOKEN] else NO_ROWS
    return profile


def note_completed(state: State, completed: int, h: float, substeps: int) -> int:
    """Take over the steps that a compiled call has completed beyond the first ``completed``. Returns how many they are."""
    status = state.workspace.work.status
    if status[PARITY]:
        state.manifolds, state.next_manifolds = state.next_manifolds, state.manifolds
        status[PARITY] = 0
    more = int(status[DONE]) - completed
    for _ in range(more):
        state.time += h
    if more:
        state.steps += more
        state.last_h, state.manifold_count = h / substeps, int(status[ROWS])
        state.joints.elapsed = h
    return more


def abandon_step(state: State, completed: int) -> None:
    """Return to the end of the last completed step of this run, the number of which was ``completed``."""
    work, bodies = state.workspace.work, state.bodies
    state.roll_back()
    if work.status[WOKEN]:
        woken = changed_activity(state) > 0
        bodies.island[: state.count][woken] = work.island_before[: state.count][woken]
        bodies.rest[: state.count][woken] = work.rest_before[: state.count][woken]
    if completed:  # the events of that step have been overwritten
        state.began = state.ended = NO_PAIRS
        state.slept = state.woke = NO_ROWS
    state.forced = bool(work.status[FORCES])
    state.workspace = None


def changed_activity(state: State) -> npt.NDArray[np.int8]:
    """1 for dynamic bodies that have become active in the present step, −1 for those that have ceased to be, else 0."""
    work, n = state.workspace.work, state.count
    change = work.active[:n].astype(np.int8) - work.before[:n].astype(np.int8)
    return np.where(state.bodies.kind[:n] == DYNAMIC, change, np.int8(0))


def in_order(pairs: npt.NDArray[np.int32]) -> npt.NDArray[np.int32]:
    """A copy of a list of pairs, ordered."""
    return pairs[np.lexsort(pairs.T[::-1])] if len(pairs) else NO_PAIRS


def _rows(mask: npt.NDArray[np.bool_]) -> npt.NDArray[np.int32]:
    """Rows of which a mask is true."""
    return np.flatnonzero(mask).astype(np.int32)
