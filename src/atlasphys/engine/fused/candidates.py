"""Candidate pairs of the fused step: looked for by a broad phase, and taken over."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from atlasphys.engine.broadphase import BROADPHASES
from atlasphys.engine.broadphase.filters import without_joined
from atlasphys.engine.broadphase.flight import note_flight
from atlasphys.engine.fused.workspace import reserve_rows, with_room_for_pairs
from atlasphys.engine.narrowphase.batch import GENERIC_KIND, KIND_OF
from atlasphys.engine.shapes.bounds import update_bounds
from atlasphys.engine.shapes.table import KIND, PLANE
from atlasphys.engine.simd import LANES
from atlasphys.engine.state.state import State
from atlasphys.engine.state.work import CHECKED, PAIRS, PAIRS_BEFORE, PAIRS_CHANGED, ROWS


def renew_pairs(state: State, pairs: npt.NDArray[np.int32]) -> None:
    """Take over new candidate pairs."""
    pairs = without_joined(pairs, state.joints.apart)
    work, count = state.workspace.work, len(pairs)
    status = work.status
    if not status[PAIRS_CHANGED]:  # else what is known of the last step's pairs has been put aside before
        work = work._replace(
            pairs=work.pairs_before, row=work.row_before, expiry=work.expiry_before,
            pairs_before=work.pairs, row_before=work.row, expiry_before=work.expiry,
        )  # fmt: skip
        status[PAIRS_BEFORE] = status[PAIRS]
    status[PAIRS], status[PAIRS_CHANGED] = count, 1
    state.workspace.work = work = with_room_for_pairs(work, count)
    reserve_rows(state, int(status[ROWS]) + count)
    work.pairs[:count] = pairs
    blocks = -(-count // LANES)
    bodies = np.zeros((blocks * LANES, 2), np.int32)
    bodies[:count] = state.colliders.body[pairs]
    work.pair_bodies[:blocks] = bodies.reshape(blocks, LANES, 2).transpose(0, 2, 1)
    work.copied[:count] = 0
    kinds = state.table.arrays.layout[state.colliders.shape[pairs], KIND]
    work.kinds[:count] = KIND_OF[kinds[:, 0], kinds[:, 1]]
    work.plane_side[:count] = (kinds == PLANE) @ np.array([1, 2], np.int8)
    if state.workspace.narrowphase == "gjk_epa":  # GJK and EPA know no planes
        work.kinds[:count][(kinds != PLANE).all(axis=1)] = GENERIC_KIND


def look_for_pairs(state: State, broadphase: str, h: float) -> None:
    """Bring the candidate pairs up to date."""
    shapes, margin, space = state.table.arrays, state.tolerances.margin, state.workspace
    if broadphase == "tree":
        n, rows, last = state.count, state.manifold_count, state.manifolds
        joints, flying = state.joints, np.empty(n, np.uint8)
        joined = joints.rows.body[: joints.count][joints.active]
        note_flight(last.a[:rows], last.b[:rows], last.count[:rows], state.colliders.body, joined, flying)
        if space.tree.update(state.bodies, state.colliders, shapes, n, h, margin, flying, state.environment.gravity):
            renew_pairs(state, space.tree.pairs)
    else:
        update_bounds(state.bodies, state.colliders, shapes, state.count, margin)
        state.pairs, count = BROADPHASES[broadphase](state.bodies, state.colliders, shapes, state.count, state.pairs)
        renew_pairs(state, state.pairs[:count])
    space.work.status[CHECKED] = 1
