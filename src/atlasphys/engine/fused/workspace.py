"""Working memory of the fused step: how it begins, and how it grows."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from atlasphys.engine.broadphase.fat_boxes import BOUNDING_RADIUS, shape_bounds
from atlasphys.engine.broadphase.tree import FatTree
from atlasphys.engine.islands.colour import COLOURS
from atlasphys.engine.islands.split import HUB_COLUMNS, MOST_WHOLE
from atlasphys.engine.joints.layout import Layout, lay_out
from atlasphys.engine.narrowphase.batch import KINDS
from atlasphys.engine.narrowphase.dispatch import EDGE_LIMITS, KIND_ROUTINES, ROUTINES
from atlasphys.engine.simd import LANES
from atlasphys.engine.solvers.contact_block import Fields
from atlasphys.engine.solvers.rolling_block import ROLLING_FIELDS
from atlasphys.engine.solvers.sweep_trace import MOST_TRACED
from atlasphys.engine.solvers.xpbd_contact import XpbdFields
from atlasphys.engine.state.arrays import aligned_zeros, room_for
from atlasphys.engine.state.blocks import INTEGERS
from atlasphys.engine.state.bodies import DYNAMIC, KINEMATIC, STATIC
from atlasphys.engine.state.manifolds import arranged, empty_manifolds, live_rows, with_rows
from atlasphys.engine.state.pose import ROTATION_LOCKS
from atlasphys.engine.state.state import State
from atlasphys.engine.state.work import (
    BLOCKS_MANY,
    BLOCKS_ONE,
    CALLS,
    EDGE_LIMIT,
    ENTRIES,
    FREE,
    HUBS,
    KINEMATIC_BODIES,
    PAIRS_BEFORE,
    PAIRS_CHANGED,
    PARTS,
    ROWS,
    SPLITS,
    WEIGHT_FIRST,
    Work,
    empty_lanes,
)
from atlasphys.engine.step import STAGES

Arrays = dict[str, Any]
"""Fields of ``Work`` by their names."""

FIELDS: dict[str, type[Fields]] = {"soft_step": Fields, "xpbd": XpbdFields}
"""What their blocks of contacts hold."""


FATTENING = 0.05
"""Room that a fat box leaves all round its body [m], for a length unit of 1 m. Smaller: pairs are looked for more often. Larger: more pairs are
looked at that do not touch."""


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
        self._take_up_manifolds(state)
        self.work.status[KINEMATIC_BODIES] = (state.bodies.kind[:n] == KINEMATIC).any()
        self.tree = FatTree(state.real, FATTENING * state.environment.length_unit)
        self.kept: npt.NDArray[np.int64] = np.zeros(4, np.int64)
        self.takes_notes = False
        """Whether the solver stage that ``work.calls`` has takes notes of its sweeps."""
        self.pace = 1
        """Steps that a compiled call may make, for it to return soon enough."""

    def _take_up_manifolds(self, state: State) -> None:
        """Lay the tables of manifolds out as the fused step needs them, which is how it leaves them: row 0 is nobody's."""
        rows = live_rows(state.manifolds, state.manifold_count)
        if state.manifold_count == 0 or state.manifolds.count[0] > 0:
            state.manifolds = arranged(state.manifolds, rows, first=1)
            state.manifold_count = 1 + len(rows)
            rows = np.arange(1, 1 + len(rows))
        table, count = state.manifolds, state.manifold_count
        if len(state.next_manifolds.a) != len(table.a):  # they grow together
            state.next_manifolds = empty_manifolds(len(table.a), state.real)
        state.next_manifolds.count[:count], state.next_manifolds.collided[:count] = 0, -1  # it holds no copies
        free = 1 + np.flatnonzero(table.count[1:count] == 0)
        self.work = self.work._replace(
            pairs_before=np.stack([table.a[rows], table.b[rows]], axis=1),
            row_before=rows.astype(np.int32),
            expiry_before=np.full(len(rows), -np.inf),
            **lists_of_rows(len(table.a)),
        )
        self.work.free[: len(free)] = free
        status = self.work.status
        status[ROWS], status[FREE], status[PAIRS_BEFORE], status[PAIRS_CHANGED] = count, len(free), len(rows), 1


def locks_of(state: State) -> npt.NDArray[np.integer]:
    """Locks of each body; only those of dynamic ones count."""
    bodies, n = state.bodies, state.count
    return np.where(bodies.kind[:n] == DYNAMIC, bodies.locks[:n], 0)


def empty_work(state: State, fields: type[Fields], joints: Layout) -> Work:
    """Working memory for the bodies of a state; nothing in it is known yet. ``fields`` says what blocks of contacts hold."""
    n = state.count
    moving = np.flatnonzero(state.bodies.kind[:n] != STATIC)
    tumbles = state.bodies.frame[moving, 3] > 0
    locks = locks_of(state)
    real = state.real
    return Work(
        status=np.zeros(ENTRIES, np.int64),
        active=joints.work.active,
        before=np.zeros(max(n, 1), np.uint8),
        radius=np.zeros(max(n, 1), real),
        parent=np.zeros(max(n, 1), np.int32),
        ready=np.zeros(max(n, 1), np.uint8),
        island_before=np.zeros(max(n, 1), np.int32),
        rest_before=np.zeros(max(n, 1), real),
        moves=np.zeros(max(n, 1), np.uint8) | (state.bodies.kind[: max(n, 1)] == DYNAMIC),
        travel=np.zeros(max(n, 1)),
        extent=np.zeros(max(n, 1)),
        **known_pairs(1),
        pairs_before=np.zeros((1, 2), np.int32),
        row_before=np.zeros(1, np.int32),
        expiry_before=np.zeros(1),
        **lists_of_pairs(1),
        **lists_of_rows(1),
        generic_starts=np.zeros(len(ROUTINES) + 1, np.int64),
        routines=KIND_ROUTINES["auto"],
        calls=np.zeros(CALLS, np.int64),
        phases=joints.phases,
        joints=joints.work,
        linked=joints.linked,
        times=np.zeros(len(STAGES), np.int64),
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


def known_pairs(capacity: int) -> Arrays:
    """Room for so many candidate pairs, and what is known of them from step to step."""
    return {
        "pairs": aligned_zeros((capacity, 2), np.int32),
        "row": aligned_zeros((capacity,), np.int32),
        "expiry": aligned_zeros((capacity,), np.float64),
    }


def lists_of_pairs(capacity: int) -> Arrays:
    """Room for what follows from so many candidate pairs, and for lists of them."""
    return {
        "kinds": aligned_zeros((capacity,), np.int8),
        "pair_bodies": aligned_zeros((-(-capacity // LANES), 2, LANES), np.int32),
        "live": aligned_zeros((capacity,), np.int32),
        "copied": aligned_zeros((capacity,), np.uint8),
        "plane_side": aligned_zeros((capacity,), np.int8),
        "generic": aligned_zeros((capacity,), np.int32),
        "generic_pairs": aligned_zeros((capacity, 2), np.int32),
        "generic_routine": aligned_zeros((capacity,), np.int8),
        "generic_rows": aligned_zeros((capacity,), np.intp),
        "began": aligned_zeros((capacity, 2), np.int32),
        "colours": aligned_zeros((capacity,), np.int8),
    }


def lists_of_rows(capacity: int) -> Arrays:
    """Room for lists of rows of so long tables of manifolds."""
    return {"free": aligned_zeros((capacity,), np.int32), "ended": aligned_zeros((capacity, 2), np.int32)}


def with_room_for_pairs(work: Work, count: int) -> Work:
    """The same with room for so many candidate pairs; nothing is known of them."""
    if len(work.pairs) < count:
        work = work._replace(**known_pairs(room_for(count)))
    if len(work.kinds) < count:
        work = work._replace(**lists_of_pairs(room_for(count)))
    return work


def reserve_rows(state: State, rows: int) -> None:
    """Room in the tables of manifolds for so many rows. Those that are never taken need no memory (arrays.MAPPED)."""
    used, work = int(state.workspace.work.status[ROWS]), state.workspace.work
    if len(state.manifolds.a) < rows:
        capacity = room_for(rows)
        state.manifolds = with_rows(state.manifolds, capacity, used)
        state.next_manifolds = with_rows(state.next_manifolds, capacity, used)
        lists, free = lists_of_rows(capacity), int(work.status[FREE])
        lists["free"][:free] = work.free[:free]
        state.workspace.work = work._replace(**lists)


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
    rows, points = min(sweeps, MOST_TRACED), 4 * len(state.manifolds.a)
    if len(work.notes) != rows or work.noted_impulses.shape[1] < points:
        state.workspace.work = work._replace(**notes_for(state, rows, points))


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
