"""Stage 3, manifold: from all contact points of a pair to at most four, matched with last step's so that impulses carry over."""

import numpy as np

from atlasphys.engine.manifold.build import build_manifolds
from atlasphys.engine.state.state import State


def update_manifolds(state: State, pairs: int) -> None:
    """Build the next manifolds of ``state`` from the contacts of its ``pairs`` pairs."""
    state.reserve_manifolds(pairs)
    rules = (state.environment.friction_rule, state.environment.restitution_rule)
    distance = state.real.type(state.tolerances.match_distance)
    kept, origin = np.zeros((2, 4), np.int64)
    state.next_count = build_manifolds(
        state.contacts, pairs, state.bodies, state.colliders,
        state.manifolds, state.manifold_count, state.next_manifolds, state.manifold_ended, rules, distance, kept, origin,
    )  # fmt: skip
    state.touched_before = state.next_manifolds.touching[: state.next_count].copy()
