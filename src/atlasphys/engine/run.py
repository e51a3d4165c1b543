"""Steps of the default world from Python's side: what ``fused.steps.run_steps`` is given, and what it asks for."""

from __future__ import annotations

import math
import time
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from atlasphys.engine import ahead
from atlasphys.engine.broadphase import BROADPHASES
from atlasphys.engine.broadphase.fat_boxes import BOUNDING_RADIUS, shape_bounds
from atlasphys.engine.broadphase.filters import without_joined
from atlasphys.engine.broadphase.tree import FatTree
from atlasphys.engine.constants import SLEEP_SPEED
from atlasphys.engine.fused.constants import Constants
from atlasphys.engine.fused.detection import detection_address
from atlasphys.engine.fused.joints import joints_address
from atlasphys.engine.fused.response import response_address, response_address_with_locks
from atlasphys.engine.fused.steps import run_steps
from atlasphys.engine.islands.colour import COLOURS
from atlasphys.engine.islands.split import HUB_COLUMNS, MOST_WHOLE
from atlasphys.engine.joints.layout import Layout, find_code, lay_out, set_numbers
from atlasphys.engine.narrowphase.addresses import ADDRESSES
from atlasphys.engine.narrowphase.batch import GENERIC_KIND, KIND_OF, KINDS
from atlasphys.engine.narrowphase.dispatch import EDGE_LIMITS, KIND_ROUTINES, ROUTINES, with_room
from atlasphys.engine.shapes.bounds import update_bounds
from atlasphys.engine.shapes.table import KIND, PLANE
from atlasphys.engine.simd import LANES
from atlasphys.engine.solvers.bounce_block import FINEST
from atlasphys.engine.solvers.contact_block import (
    Fields,
)
from atlasphys.engine.solvers.rolling_block import ROLLING_FIELDS
from atlasphys.engine.solvers.soft_step import MOST_JOINT_FREQUENCY, SoftStep, softness
from atlasphys.engine.state.arrays import aligned_zeros
from atlasphys.engine.state.blocks import INTEGERS
from atlasphys.engine.state.bodies import CHANGED, DYNAMIC, KINEMATIC, STATIC
from atlasphys.engine.state.joint_work import RATIO
from atlasphys.engine.state.joints import PART_TYPES
from atlasphys.engine.state.manifolds import empty_manifolds, with_rows
from atlasphys.engine.state.pose import ROTATION_LOCKS, refresh
from atlasphys.engine.state.state import Environment, State, tolerances_of
from atlasphys.engine.state.work import (
    BEGAN,
    BLOCKS_MANY,
    BLOCKS_ONE,
    BROADPHASE,
    CALLS,
    CHECKED,
    DETECT,
    DETECTION,
    DIVERGED,
    DONE,
    EDGE_LIMIT,
    ENDED,
    ENTRIES,
    FORCES,
    GENERIC,
    HUBS,
    JOINT_TABLES,
    JOINT_VISITS,
    JOINTS,
    KEEPS,
    KINEMATIC_BODIES,
    NEED_BLOCKS,
    NEED_GENERIC,
    NEED_PAIRS,
    NEED_PARTS,
    OLD_ROWS,
    PAIRS,
    PAIRS_CHANGED,
    PARITY,
    PARTS,
    PHASE,
    RENAME,
    RESPONSE,
    SLEEPERS_CHANGED,
    SLEEPS,
    SLEPT,
    SLOTS,
    STEP,
    WOKEN,
    Work,
    empty_lanes,
)
from atlasphys.engine.step import STAGES, DivergedError, Pipeline, Profile
from atlasphys.engine.team import SYNC_LENGTH
from atlasphys.engine.threads import lend_team

MOST_GROWTH = 4.0
"""By how much last step's impulses may be scaled up for a longer step; see solvers/sequential_impulse.py."""

MOST_FREQUENCY = 0.15
"""Greatest frequency of contacts, as a share of the number of substeps a second. From 0.17 on pyramids jitter (docs/soft_step.md)."""

STATIC_STIFFENING = 1.0
"""Factor on the frequency of contacts with bodies that are not dynamic. With 2, which other engines use, pyramids jitter from two thirds of that
frequency on, and so their other contacts have to be softer."""

LONGEST_CALL = 0.05
"""Time [s] that one compiled call should take at most, so that Ctrl-C is heard."""


@lru_cache(maxsize=64)
def constants(precision: str, environment: Environment, settings: SoftStep, h: float, last_h: float) -> Constants:
    """The numbers of a run with steps of length h [s], after substeps of length ``last_h``, or 0; ``precision`` is NumPy's character for the
    world's."""
    real, tolerances = np.dtype(precision).type, tolerances_of(environment, precision)
    sub = h / settings.substeps
    unit = environment.length_unit
    frequency = min(settings.contact_frequency, MOST_FREQUENCY / sub)
    soft = (
        1 / sub,
        *softness(frequency, settings.contact_damping, sub),
        *softness(STATIC_STIFFENING * frequency, settings.contact_damping, sub),
        settings.push_out_speed * unit,
    )
    bounce = (environment.restitution_threshold, h, sub, float(tolerances.slop), FINEST[precision])
    recycling = (
        (settings.recycle_slip * unit) ** 2 if settings.contact_recycling else -1.0,
        (2 * math.sin(settings.recycle_turn / 4)) ** 2,
        (2 * math.sin(settings.recycle_twist / 4)) ** 2,
        float(tolerances.margin),
        settings.recycle_speed * unit * h,
    )
    ratio = min(sub / last_h, MOST_GROWTH) if last_h > 0 else 1.0
    ratio = ratio if settings.warm_starting else 0.0
    return Constants(
        h=real(sub),
        substeps=settings.substeps,
        slow=real(SLEEP_SPEED * unit),
        gravity=tuple(real(g) for g in environment.gravity),
        ratio=real(ratio),
        soft=tuple(real(x) for x in soft),
        bounce=tuple(real(x) for x in bounce),
        recycling=tuple(real(x) for x in recycling),
        margin=tolerances.margin,
        match_distance=real(tolerances.match_distance),
        friction_rule=environment.friction_rule,
        restitution_rule=environment.restitution_rule,
        joint_sweeps=settings.joint_sweeps,
    )


FATTENING = 0.05
"""Room that a fat box leaves all round its body [m], for a length unit of 1 m. Smaller: pairs are looked for more often. Larger: more pairs are
looked at that do not touch."""


NO_SYNC: npt.NDArray[np.int64] = aligned_zeros((SYNC_LENGTH,), np.int64)
"""Stands for the ``sync`` of a team of threads."""

NO_ROWS: npt.NDArray[np.int32] = np.empty(0, np.int32)


class Workspace:
    """What the fused step keeps between steps and can derive from the state at any time."""

    def __init__(self, state: State, narrowphase: str) -> None:
        self.narrowphase = narrowphase
        self.joints = lay_out(state, np.zeros(max(state.count, 1), np.uint8))
        self.work = empty_work(state, self.joints)._replace(routines=KIND_ROUTINES[narrowphase])
        self.work.status[EDGE_LIMIT] = EDGE_LIMITS[narrowphase]
        n = state.count
        bounds = shape_bounds(state.table.arrays, state.colliders.shape[:n], state.bodies.local_center[:n])
        self.work.radius[:n] = bounds[:, BOUNDING_RADIUS]
        self.work.extent[:n] = state.table.arrays.extent[state.colliders.shape[:n]]
        self.work.status[OLD_ROWS] = state.manifold_count
        self.tree = FatTree(state.real, FATTENING * state.environment.length_unit)
        self.kept: npt.NDArray[np.int64] = np.zeros(4, np.int64)
        self.pace = 1
        """Steps that a compiled call may make, for it to return soon enough."""


def locks_of(state: State) -> npt.NDArray[np.integer]:
    """Locks of each body; only those of dynamic ones count."""
    bodies, n = state.bodies, state.count
    return np.where(bodies.kind[:n] == DYNAMIC, bodies.locks[:n], 0)


def empty_work(state: State, joints: Layout) -> Work:
    """Working memory for the bodies of a state; nothing in it is known yet."""
    n = state.count
    moving = np.flatnonzero(state.bodies.kind[:n] != STATIC)
    tumbles = state.bodies.frame[moving, 3] > 0
    locks = locks_of(state)
    real = state.real
    one = np.zeros(1, np.int32)
    return Work(
        status=np.zeros(ENTRIES, np.int64),
        pairs=np.zeros((1, 2), np.int32),
        kinds=np.zeros(1, np.int8),
        pair_bodies=np.zeros((1, 2, LANES), np.int32),
        copied=np.zeros(1, np.uint8),
        live=one.copy(),
        active=joints.work.active,
        before=np.zeros(max(n, 1), np.uint8),
        radius=np.zeros(max(n, 1), real),
        parent=np.zeros(max(n, 1), np.int32),
        ready=np.zeros(max(n, 1), np.uint8),
        island_before=np.zeros(max(n, 1), np.int32),
        rest_before=np.zeros(max(n, 1), real),
        moves=np.zeros(max(n, 1), np.uint8) | (state.bodies.kind[: max(n, 1)] == DYNAMIC),
        plane_side=np.zeros(1, np.int8),
        travel=np.zeros(max(n, 1)),
        extent=np.zeros(max(n, 1)),
        expiry=np.full(1, -np.inf),
        expiry_before=np.full(1, -np.inf),
        origin=one,
        generic=one.copy(),
        generic_pairs=np.zeros((1, 2), np.int32),
        generic_routine=np.zeros(1, np.int8),
        generic_rows=np.zeros(1, np.intp),
        generic_starts=np.zeros(len(ROUTINES) + 1, np.int64),
        routines=KIND_ROUTINES["auto"],
        calls=np.zeros(CALLS, np.int64),
        phases=joints.phases,
        joints=joints.work,
        linked=joints.linked,
        times=np.zeros(len(STAGES), np.int64),
        began=np.zeros((1, 2), np.int32),
        ended=np.zeros((1, 2), np.int32),
        colours=np.zeros(1, np.int8),
        used=np.zeros(max(n, 1), np.uint64),
        sizes=np.zeros((2, COLOURS + 1), np.int64),
        starts=np.zeros((2, COLOURS + 2), np.int64),
        cursor=np.zeros((2, COLOURS + 1), np.int64),
        integers_one=aligned_zeros((1, INTEGERS, LANES), np.int32),
        blocks_one=aligned_zeros((1, Fields(1).number, LANES), real),
        integers_many=aligned_zeros((1, INTEGERS, LANES), np.int32),
        blocks_many=aligned_zeros((1, Fields(4).number, LANES), real),
        rolls_one=aligned_zeros((1, ROLLING_FIELDS, LANES), real),
        rolls_many=aligned_zeros((1, ROLLING_FIELDS, LANES), real),
        hubs=np.zeros((0, HUB_COLUMNS), np.int32),
        heaviest=aligned_zeros((0, MOST_WHOLE + 1), real),
        ends=np.zeros((0, 2, LANES), np.int32),
        motion=aligned_zeros((0, 16), real),
        inverse_mass=aligned_zeros((0, 16), real),
        drives=aligned_zeros((0, 8), real),
        locked=np.flatnonzero(locks & ROTATION_LOCKS).astype(np.int32),
        plain=np.zeros((-(-int((~tumbles).sum()) // LANES), LANES), np.int32),
        tumbling=np.zeros((-(-int(tumbles.sum()) // LANES), LANES), np.int32),
        room=np.zeros((max(-(-len(moving) // LANES), 1), LANES), real),
        lanes=empty_lanes(1, KINDS, real),
    )


def renew_pairs(state: State, pairs: npt.NDArray[np.int32]) -> None:
    """Take over new candidate pairs."""
    pairs = without_joined(pairs, state.joints.apart)
    work, count = state.workspace.work, len(pairs)
    status = work.status
    rows = int(status[OLD_ROWS])
    if not status[PAIRS_CHANGED]:  # else what is known of the old pairs has been put aside before
        work = work._replace(expiry=work.expiry_before, expiry_before=work.expiry)
    if len(work.expiry_before) < rows:
        work = work._replace(expiry_before=np.full(rows, -np.inf))
    status[PAIRS], status[PAIRS_CHANGED] = count, 1
    if len(work.expiry) < count:
        work = work._replace(expiry=np.full(2 * count + 8, -np.inf))
    if len(work.pairs) < count or len(work.ended) < count + rows:
        capacity = 2 * count + 8
        work = work._replace(
            pairs=np.zeros((capacity, 2), np.int32),
            kinds=np.zeros(capacity, np.int8),
            pair_bodies=np.zeros((-(-capacity // LANES), 2, LANES), np.int32),
            live=np.zeros(capacity, np.int32),
            copied=np.zeros(capacity, np.uint8),
            plane_side=np.zeros(capacity, np.int8),
            origin=np.zeros(capacity, np.int32),
            generic=np.zeros(capacity, np.int32),
            generic_pairs=np.zeros((capacity, 2), np.int32),
            generic_routine=np.zeros(capacity, np.int8),
            generic_rows=np.zeros(capacity, np.intp),
            began=np.zeros((capacity, 2), np.int32),
            ended=np.zeros((capacity + rows, 2), np.int32),
            colours=np.zeros(capacity, np.int8),
        )
    work.pairs[:count] = pairs
    blocks = -(-count // LANES)
    bodies = np.zeros((blocks * LANES, 2), np.int32)
    bodies[:count] = state.colliders.body[pairs]
    work.pair_bodies[:blocks] = bodies.reshape(blocks, LANES, 2).transpose(0, 2, 1)
    status[RENAME] = 2
    work.copied[:count] = 0
    kinds = state.table.arrays.layout[state.colliders.shape[pairs], KIND]
    work.kinds[:count] = KIND_OF[kinds[:, 0], kinds[:, 1]]
    work.plane_side[:count] = (kinds == PLANE) @ np.array([1, 2], np.int8)
    if state.workspace.narrowphase == "gjk_epa":  # GJK and EPA know no planes
        work.kinds[:count][(kinds != PLANE).all(axis=1)] = GENERIC_KIND
    state.workspace.work = work
    if len(state.manifolds.a) < count:
        state.manifolds = with_rows(state.manifolds, 2 * count + 8)
    if len(state.next_manifolds.a) < count:
        state.next_manifolds = empty_manifolds(2 * count + 8, state.real)


def look_for_pairs(state: State, broadphase: str, h: float) -> None:
    """Bring the candidate pairs up to date."""
    shapes, margin, space = state.table.arrays, state.tolerances.margin, state.workspace
    if broadphase == "tree":
        if space.tree.update(state.bodies, state.colliders, shapes, state.count, h, margin):
            renew_pairs(state, space.tree.pairs)
    else:
        update_bounds(state.bodies, state.colliders, shapes, state.count, margin)
        state.pairs, count = BROADPHASES[broadphase](state.bodies, state.colliders, shapes, state.count, state.pairs)
        renew_pairs(state, state.pairs[:count])
    space.work.status[CHECKED] = 1


def grow_blocks(state: State) -> None:
    """Room for the blocks that the step needs."""
    work = state.workspace.work
    rolls = bool((state.colliders.material[: state.count, 2:4] > 0).any())
    for name, entry in (("one", BLOCKS_ONE), ("many", BLOCKS_MANY)):
        needed = int(work.status[entry])
        blocks = getattr(work, "blocks_" + name)
        if len(blocks) < needed:
            capacity = needed + needed // 4 + 4
            work = work._replace(
                **{
                    "blocks_" + name: aligned_zeros((capacity, *blocks.shape[1:]), state.real),
                    "rolls_" + name: aligned_zeros((capacity if rolls else 1, ROLLING_FIELDS, LANES), state.real),
                    "integers_" + name: aligned_zeros((capacity, INTEGERS, LANES), np.int32),
                }
            )
    state.workspace.work = work


def grow_parts(state: State) -> None:
    """Room for the parts of the bodies that are split in the step."""
    work, n = state.workspace.work, state.count
    hubs, parts = 2 * int(work.status[HUBS]), 2 * int(work.status[PARTS])
    moves = np.ones(n + parts, np.uint8)
    moves[:n] = work.moves[:n]
    state.workspace.work = work._replace(
        hubs=np.zeros((hubs, HUB_COLUMNS), np.int32),
        heaviest=aligned_zeros((hubs, MOST_WHOLE + 1), state.real),
        ends=np.zeros_like(work.pair_bodies),
        motion=aligned_zeros((n + parts, 16), state.real),
        inverse_mass=aligned_zeros((n + parts, 16), state.real),
        drives=aligned_zeros((n + parts, 8), state.real),
        moves=moves,
        used=np.zeros(n + parts, np.uint64),
    )


def make_generic_ready(state: State, margin: float) -> None:
    """Room for the contacts of the pairs that no body over lanes collides, and the addresses of the routines that do, compiled if need be."""
    work = state.workspace.work
    state.contacts = with_room(state.contacts, int(work.status[GENERIC]), int(work.status[SLOTS]))
    for k, address_of in enumerate(ADDRESSES):
        if work.calls[k] == 0 and work.status[SLOTS] > 0 and work.generic_starts[k] < work.generic_starts[k + 1]:
            work.calls[k] = address_of(
                work.generic_rows, state.bodies, state.colliders, state.table.arrays, margin, state.contacts
            )


def tables(state: State) -> tuple[Any, Any, Any, Any, Any, Any]:
    """The tables of the state with which the arguments of the step's kernels begin."""
    return (
        state.bodies, state.colliders, state.table.arrays, state.manifolds, state.next_manifolds, state.remembered,
    )  # fmt: skip


def find_parts(state: State, values: Constants) -> None:
    """Addresses of the parts of the step that are compiled apart. The first time of all another process compiles one of them in the meantime."""
    space, before = state.workspace, tables(state)
    work, fat = space.work, space.tree.fat
    response = response_address_with_locks if locks_of(state).any() else response_address
    precision = {"f": "single", "d": "double"}[state.real.char]
    ahead.start({"response": response, "detection": detection_address}, precision)
    run_steps(*before, state.contacts, space.kept, state.count, fat, values, work, 0, NO_SYNC)
    ahead.wait()
    work.calls[DETECTION] = detection_address(*before, fat, values, work, NO_SYNC)
    work.calls[RESPONSE] = response(*before, fat, values, work, NO_SYNC)


def ready_joints(state: State, settings: SoftStep, values: Constants) -> None:
    """Numbers and code for the joints of a run."""
    space = state.workspace
    if len(space.joints.phases) == 0:
        return
    h, unit = float(values.h), state.environment.length_unit
    frequency = min(settings.joint_frequency, MOST_JOINT_FREQUENCY / h)
    soft = softness(frequency, settings.joint_damping, h)
    set_numbers(state, space.joints, h, float(values.ratio), soft, settings.joint_push_out_speed * unit)
    find_code(state, space.joints)
    space.work.calls[JOINTS : JOINTS + PART_TYPES] = space.joints.calls[:PART_TYPES]
    space.work.calls[JOINT_TABLES] = space.joints.calls[PART_TYPES]
    if space.work.calls[JOINT_VISITS] == 0:
        space.work.calls[JOINT_VISITS] = joints_address(*tables(state), space.tree.fat, values, space.work, NO_SYNC)


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
    if state.workspace is not None and state.workspace.narrowphase != pipeline.narrowphase:
        state.workspace = None
    if state.workspace is None:
        state.workspace = Workspace(state, pipeline.narrowphase)
    space = state.workspace
    status = space.work.status
    space.work.times[:] = 0
    status[KEEPS], status[DONE], status[FORCES] = keeps, 0, state.forced
    state.forced = False
    status[CHECKED], status[PHASE], status[STEP] = 0, DETECT, state.steps + 1
    status[SLEEPS], status[SLEEPERS_CHANGED] = pipeline.sleeping, 1
    status[KINEMATIC_BODIES] = (state.bodies.kind[: state.count] == KINEMATIC).any()
    if keeps and (written or len(space.tree.fat.center) != state.count):
        look_for_pairs(state, pipeline.broadphase, h)
    if len(space.work.lanes.queue) < pipeline.threads:
        space.work = space.work._replace(lanes=empty_lanes(pipeline.threads, KINDS, state.real))
    changed = bool((state.bodies.rest[: state.count] == CHANGED).any())
    wanted = 1 if changed or values.ratio != 1 else min(steps, space.pace)
    completed = 0
    if space.work.calls[DETECTION] == 0:
        find_parts(state, values)
    ready_joints(state, settings, values)
    try:
        while True:
            start = time.perf_counter()
            try:
                with lend_team(pipeline.threads) as sync:
                    answer = run_steps(
                        *tables(state), state.contacts, space.kept, state.count, space.tree.fat, values, space.work, wanted, sync,
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
                make_generic_ready(state, values.margin)
            elif answer == DIVERGED:
                raise DivergedError(state.diverged_rows().tolist())
            elif wanted < steps:
                taken = time.perf_counter() - start
                if taken < LONGEST_CALL / 2:
                    space.pace *= 2
                elif taken > LONGEST_CALL:
                    space.pace = max(space.pace // 2, 1)
                wanted = min(steps, wanted + space.pace)
                if settings.warm_starting:
                    values = values._replace(ratio=type(values.ratio)(1))
                    space.joints.work.numbers[RATIO] = 1
            else:
                break
    except BaseException:
        abandon_step(state, completed)
        raise
    for stage, nanoseconds in zip(STAGES, space.work.times.tolist(), strict=True):
        profile[stage] = 1e-9 * nanoseconds / max(steps, 1)
    state.began = space.work.began[: status[BEGAN]].copy()
    state.ended = space.work.ended[: status[ENDED]].copy()
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
        state.last_h, state.manifold_count = h / substeps, int(status[OLD_ROWS])
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
        state.began = state.ended = np.empty((0, 2), np.int32)
        state.slept = state.woke = NO_ROWS
    state.forced = bool(work.status[FORCES])
    state.workspace = None


def changed_activity(state: State) -> npt.NDArray[np.int8]:
    """1 for dynamic bodies that have become active in the present step, −1 for those that have ceased to be, else 0."""
    work, n = state.workspace.work, state.count
    change = work.active[:n].astype(np.int8) - work.before[:n].astype(np.int8)
    return np.where(state.bodies.kind[:n] == DYNAMIC, change, np.int8(0))


def _rows(mask: npt.NDArray[np.bool_]) -> npt.NDArray[np.int32]:
    """Rows of which a mask is true."""
    return np.flatnonzero(mask).astype(np.int32)
