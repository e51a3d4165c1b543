"""Steps of the default world from Python's side: what ``fused.steps.run_steps`` is given, and what it asks for."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
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
from atlasphys.engine.fused.bounce import bounce_address, bounce_address_with_locks
from atlasphys.engine.fused.constants import Constants
from atlasphys.engine.fused.detection import detection_address
from atlasphys.engine.fused.generic import generic_address
from atlasphys.engine.fused.joints import joints_address
from atlasphys.engine.fused.positions import (
    positions_address,
    positions_address_with_locks,
    positions_address_with_notes,
)
from atlasphys.engine.fused.response import (
    response_address,
    response_address_with_locks,
    response_address_with_notes,
)
from atlasphys.engine.fused.steps import run_steps
from atlasphys.engine.islands.colour import COLOURS
from atlasphys.engine.islands.split import HUB_COLUMNS, MOST_WHOLE
from atlasphys.engine.jit import call
from atlasphys.engine.joints.layout import Layout, find_code, lay_out, set_numbers
from atlasphys.engine.narrowphase.addresses import ADDRESSES
from atlasphys.engine.narrowphase.batch import GENERIC_KIND, KIND_OF, KINDS
from atlasphys.engine.narrowphase.dispatch import EDGE_LIMITS, KIND_ROUTINES, ROUTINES, with_room
from atlasphys.engine.shapes.bounds import update_bounds
from atlasphys.engine.shapes.table import KIND, PLANE
from atlasphys.engine.simd import LANES
from atlasphys.engine.solvers.bounce_block import FINEST
from atlasphys.engine.solvers.contact_block import Fields
from atlasphys.engine.solvers.rolling_block import ROLLING_FIELDS
from atlasphys.engine.solvers.soft_step import SoftStep, joint_softness, softness
from atlasphys.engine.solvers.sweep_trace import MOST_TRACED, passes
from atlasphys.engine.solvers.xpbd import XPBD
from atlasphys.engine.solvers.xpbd_contact import XpbdFields
from atlasphys.engine.state.arrays import aligned_zeros, room_for
from atlasphys.engine.state.blocks import INTEGERS
from atlasphys.engine.state.bodies import DYNAMIC, KINEMATIC, STATIC
from atlasphys.engine.state.joint_work import RATIO
from atlasphys.engine.state.joints import PART_TYPES
from atlasphys.engine.state.manifolds import RESTITUTION, empty_manifolds, with_rows
from atlasphys.engine.state.pose import ROTATION_LOCKS, refresh
from atlasphys.engine.state.state import NO_PAIRS, NO_ROWS, Environment, State, tolerances_of
from atlasphys.engine.state.work import (
    BEGAN,
    BLOCKS_MANY,
    BLOCKS_ONE,
    BOUNCE,
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
    GENERIC_PART,
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
    NOTED,
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
    SPLITS,
    STEP,
    WEIGHT_FIRST,
    WOKEN,
    Work,
    empty_lanes,
)
from atlasphys.engine.step import STAGES, DivergedError, Pipeline, Profile
from atlasphys.engine.team import SYNC_LENGTH
from atlasphys.engine.threads import lend_team

MOST_GROWTH = 4.0
"""By how much last step's impulses may be scaled up for a longer step; see solvers/sequential_impulse.py."""

FREQUENCY = 34 / 240
"""Frequency of contacts as a share of the number of substeps a second, if none is asked for: sag falls as the square of a substep."""

MOST_FREQUENCY = 0.15
"""Greatest frequency of contacts, as a share of the number of substeps a second. From 0.17 on pyramids jitter (docs/soft_step.md)."""

STATIC_STIFFENING = 1.0
"""Factor on the frequency of contacts with bodies that are not dynamic. With 2, which other engines use, pyramids jitter from two thirds of that
frequency on, and so their other contacts have to be softer."""

LONGEST_CALL = 0.05
"""Time [s] that one compiled call should take at most, so that Ctrl-C is heard."""

RESPONSES = {
    "soft_step": (response_address, response_address_with_locks, response_address_with_notes),
    "xpbd": (positions_address, positions_address_with_locks, positions_address_with_notes),
}
"""The solver stage of each solver of the fused step: for bodies without locks, with locks, and with notes of the sweeps."""

FIELDS: dict[str, type[Fields]] = {"soft_step": Fields, "xpbd": XpbdFields}
"""What their blocks of contacts hold."""


@lru_cache(maxsize=64)
def constants(
    precision: str, environment: Environment, settings: SoftStep | XPBD, h: float, last_h: float
) -> Constants:
    """The numbers of a run with steps of length h [s], after substeps of length ``last_h``, or 0; ``precision`` is NumPy's character for the
    world's."""
    real, tolerances = np.dtype(precision).type, tolerances_of(environment, precision)
    sub = h / settings.substeps
    unit = environment.length_unit
    threshold, fastest = environment.restitution_threshold, settings.push_out_speed * unit
    soft: tuple[float, ...] = (0.0,) * 6
    positions: tuple[float, ...] = (0.0,) * 3
    recycling = (-1.0, 0.0, 0.0, 0.0, 0.0)
    if isinstance(settings, XPBD):
        positions = (1 / sub, settings.compliance / sub**2, fastest)
        threshold = max(threshold, 2 * math.hypot(*environment.gravity) * sub)
        ratio = last_h / sub if last_h > 0 else 1.0
    else:
        frequency = FREQUENCY / sub
        if settings.contact_frequency > 0:
            frequency = min(settings.contact_frequency, MOST_FREQUENCY / sub)
        soft = (
            1 / sub,
            *softness(frequency, settings.contact_damping, sub),
            *softness(STATIC_STIFFENING * frequency, settings.contact_damping, sub),
            fastest,
        )
        if settings.contact_recycling:
            recycling = (
                (settings.recycle_slip * unit) ** 2,
                (2 * math.sin(settings.recycle_turn / 4)) ** 2,
                (2 * math.sin(settings.recycle_twist / 4)) ** 2,
                float(tolerances.margin),
                settings.recycle_speed * unit * h,
            )
        ratio = min(sub / last_h, MOST_GROWTH) if last_h > 0 else 1.0
        ratio = ratio if settings.warm_starting else 0.0
    bounce = (threshold, h, sub, float(tolerances.slop), FINEST[precision])
    return Constants(
        h=real(sub),
        substeps=settings.substeps,
        slow=real(SLEEP_SPEED * unit),
        gravity=tuple(real(g) for g in environment.gravity),
        ratio=real(ratio),
        soft=tuple(real(x) for x in soft),
        positions=tuple(real(x) for x in positions),
        bounce=tuple(real(x) for x in bounce),
        recycling=tuple(real(x) for x in recycling),
        margin=tolerances.margin,
        match_distance=real(tolerances.match_distance),
        friction_rule=environment.friction_rule,
        restitution_rule=environment.restitution_rule,
        joint_sweeps=settings.joint_sweeps if isinstance(settings, SoftStep) else 0,
    )


FATTENING = 0.05
"""Room that a fat box leaves all round its body [m], for a length unit of 1 m. Smaller: pairs are looked for more often. Larger: more pairs are
looked at that do not touch."""


NO_SYNC: npt.NDArray[np.int64] = aligned_zeros((SYNC_LENGTH,), np.int64)
"""Stands for the ``sync`` of a team of threads."""


class Workspace:
    """What the fused step keeps between steps and can derive from the state at any time."""

    def __init__(self, state: State, narrowphase: str, solver: str) -> None:
        self.narrowphase, self.solver = narrowphase, solver
        self.joints = lay_out(state, np.zeros(max(state.count, 1), np.uint8))
        self.work = empty_work(state, FIELDS[solver], self.joints)._replace(routines=KIND_ROUTINES[narrowphase])
        self.work.status[EDGE_LIMIT] = EDGE_LIMITS[narrowphase]
        self.work.status[SPLITS] = solver == "soft_step"
        self.work.status[WEIGHT_FIRST] = solver == "xpbd"
        n = state.count
        bounds = shape_bounds(state.table.arrays, state.colliders.shape[:n], state.bodies.local_center[:n])
        self.work.radius[:n] = bounds[:, BOUNDING_RADIUS]
        self.work.extent[:n] = state.table.arrays.extent[state.colliders.shape[:n]]
        self.work.status[OLD_ROWS] = state.manifold_count
        self.work.status[KINEMATIC_BODIES] = (state.bodies.kind[:n] == KINEMATIC).any()
        self.tree = FatTree(state.real, FATTENING * state.environment.length_unit)
        self.kept: npt.NDArray[np.int64] = np.zeros(4, np.int64)
        self.takes_notes = False
        """Whether the solver stage that ``work.calls`` has takes notes of its sweeps."""
        self.pace = 1
        """Steps that a compiled call may make, for it to return soon enough."""


def locks_of(state: State) -> npt.NDArray[np.integer]:
    """Locks of each body; only those of dynamic ones count."""
    bodies, n = state.bodies, state.count
    return np.where(bodies.kind[:n] == DYNAMIC, bodies.locks[:n], 0)


def has_restitution(state: State) -> bool:
    """Whether a contact of the next steps may bounce."""
    colliders, manifolds = state.colliders.material[: state.count], state.manifolds.contact[: state.manifold_count]
    return bool((colliders[:, 1] > 0).any() or (manifolds[:, RESTITUTION] > 0).any())


def empty_work(state: State, fields: type[Fields], joints: Layout) -> Work:
    """Working memory for the bodies of a state; nothing in it is known yet. ``fields`` says what blocks of contacts hold."""
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
        blocks_one=aligned_zeros((1, fields(1).number, LANES), real),
        integers_many=aligned_zeros((1, INTEGERS, LANES), np.int32),
        blocks_many=aligned_zeros((1, fields(4).number, LANES), real),
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
        **notes_for(state, 0, 0),
    )


def notes_for(state: State, sweeps: int, points: int) -> dict[str, npt.NDArray[Any]]:
    """Room for notes of so many sweeps over so many contact points."""
    return {
        "notes": np.zeros((sweeps, 2), np.int32),
        "noted_motion": np.zeros((sweeps, state.count, 12), state.real),
        "noted_impulses": np.zeros((sweeps, points, 3), state.real),
    }


def reserve_notes(state: State, sweeps: int) -> None:
    """Room for the notes of a step."""
    work = state.workspace.work
    rows, points = min(sweeps, MOST_TRACED), 4 * int(work.status[PAIRS])
    if len(work.notes) != rows or work.noted_impulses.shape[1] < points:
        state.workspace.work = work._replace(**notes_for(state, rows, points))


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
        work = work._replace(expiry=np.full(room_for(count), -np.inf))
    if len(work.pairs) < count or len(work.ended) < count + rows:
        capacity = room_for(count)
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
        state.manifolds = with_rows(state.manifolds, room_for(count), rows)
    if len(state.next_manifolds.a) < count:
        state.next_manifolds = empty_manifolds(room_for(count), state.real)


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


def make_generic_ready(state: State, values: Constants) -> None:
    """Room for the contacts of the pairs that no body over lanes collides, and the addresses of the routines that do, compiled if need be."""
    work = state.workspace.work
    state.contacts = with_room(state.contacts, int(work.status[GENERIC]), int(work.status[SLOTS]))
    if work.calls[GENERIC_PART] == 0:
        work.calls[GENERIC_PART] = call(generic_address, state.real.char, *part_arguments(state, values))
    for k, address_of in enumerate(ADDRESSES):
        if work.calls[k] == 0 and work.status[SLOTS] > 0 and work.generic_starts[k] < work.generic_starts[k + 1]:
            work.calls[k] = address_of(
                work.generic_rows, state.bodies, state.colliders, state.table.arrays, values.margin, state.contacts
            )


def tables(state: State) -> tuple[Any, Any, Any, Any, Any, Any]:
    """The tables of the state with which the arguments of the step's kernels begin."""
    return (
        state.bodies, state.colliders, state.table.arrays, state.manifolds, state.next_manifolds, state.remembered,
    )  # fmt: skip


def part_arguments(state: State, values: Constants) -> tuple[Any, ...]:
    """Arguments of the kernels that give the addresses of the parts of the step that are compiled apart."""
    space = state.workspace
    return (*tables(state), space.tree.fat, values, space.work, NO_SYNC, state.contacts, space.kept)


PRECISIONS = {"f": "single", "d": "double"}


def job_of(address: Callable[..., Any]) -> str:
    """Name of the job that compiles a part of the step (``atlasphys.warmup``)."""
    return address.__name__.replace("_address", "").replace("_", "-")


def compile_ahead(state: State, response: Callable[..., Any] = response_address) -> None:
    """The first time of all, have another process begin to compile parts of the step."""
    kernels = (response, detection_address)
    ahead.start({job_of(kernel): kernel for kernel in kernels}, PRECISIONS[state.real.char])


def find_parts(state: State, values: Constants) -> None:
    """Addresses of the parts of the step that are compiled apart. The first time of all another process compiles one of them in the meantime."""
    space, before = state.workspace, tables(state)
    work, fat = space.work, space.tree.fat
    locked, real = locks_of(state).any(), state.real.char
    plain, with_locks, with_notes = RESPONSES[space.solver]
    response = with_notes if state.trace is not None else with_locks if locked else plain
    compile_ahead(state, response)
    call(run_steps, real, *before, state.contacts, space.kept, state.count, fat, values, work, 0, NO_SYNC)
    ahead.wait()
    work.calls[DETECTION] = call(detection_address, real, *part_arguments(state, values))
    work.calls[RESPONSE] = call(response, real, *part_arguments(state, values))
    if space.solver == "soft_step" and has_restitution(state):
        bounce = bounce_address_with_locks if locked else bounce_address
        work.calls[BOUNCE] = call(bounce, real, *part_arguments(state, values))
    space.takes_notes = state.trace is not None


def ready_joints(state: State, settings: SoftStep | XPBD, values: Constants) -> None:
    """Numbers and code for the joints of a run."""
    space = state.workspace
    if len(space.joints.phases) == 0:
        return
    h, unit = float(values.h), state.environment.length_unit
    if isinstance(settings, XPBD):
        soft, fastest = (1 / h, 1.0), settings.push_out_speed  # all of an error, in each substep
    else:
        soft, fastest = joint_softness(settings, h), settings.joint_push_out_speed
    set_numbers(state, space.joints, h, float(values.ratio), soft, fastest * unit)
    find_code(state, space.joints)
    space.work.calls[JOINTS : JOINTS + PART_TYPES] = space.joints.calls[:PART_TYPES]
    space.work.calls[JOINT_TABLES] = space.joints.calls[PART_TYPES]
    if space.work.calls[JOINT_VISITS] == 0:
        space.work.calls[JOINT_VISITS] = call(joints_address, state.real.char, *part_arguments(state, values))


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
    began = space.work.began[: status[BEGAN]]
    state.began = began[np.lexsort(began.T[::-1])] if len(began) else NO_PAIRS  # contacts may have another order
    state.ended = space.work.ended[: status[ENDED]].copy() if status[ENDED] else NO_PAIRS
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
        state.began = state.ended = NO_PAIRS
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
