"""One step of the engine: the stages in order, nothing else."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from typing import Any

from atlasphys.engine import ahead
from atlasphys.engine.broadphase import BROADPHASES
from atlasphys.engine.broadphase.filters import without_joined
from atlasphys.engine.manifold import update_manifolds
from atlasphys.engine.narrowphase.dispatch import collide
from atlasphys.engine.shapes.bounds import update_bounds
from atlasphys.engine.solvers import SOLVERS, sequential_impulse
from atlasphys.engine.state.pose import refresh
from atlasphys.engine.state.state import State

STAGES = ("broadphase", "narrowphase", "manifold", "islands", "solver", "continuous", "finish")


@dataclass(frozen=True, slots=True)
class Pipeline:
    """Which algorithm does each stage that offers a choice."""

    broadphase: str
    narrowphase: str
    solver: str
    solver_settings: Any
    threads: int = 1
    sleeping: bool = False


class DivergedError(ArithmeticError):
    """A step gave non-finite numbers; ``rows`` says in which bodies."""

    def __init__(self, rows: list[int]) -> None:
        super().__init__(f"rows {rows} became non-finite")
        self.rows = rows


class Profile(dict[str, float]):
    """Seconds spent in each stage of a step."""

    def __init__(self) -> None:
        super().__init__(dict.fromkeys(STAGES, 0.0))

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Add the time of the block to the stage ``name``."""
        start = time.perf_counter()
        yield
        self[name] += time.perf_counter() - start


@cache
def _compile_ahead(precision: str) -> None:
    ahead.start({"classic-solver": sequential_impulse.solve}, {"f": "single", "d": "double"}[precision])


def step(state: State, pipeline: Pipeline, h: float) -> Profile:
    """Advance ``state`` by h seconds, or, if anything goes wrong, leave it as it was and raise."""
    profile = Profile()
    if state.steps == 0:
        _compile_ahead(state.real.char)
    parts = state.joints.parts
    joined = parts.impulse.copy(), parts.total.copy()
    try:
        with profile.stage("broadphase"):
            shapes, margin = state.table.arrays, state.tolerances.margin
            refresh(state.bodies, 0, state.count)
            state.stale = True  # this step ends with derived columns of its beginning
            update_bounds(state.bodies, state.colliders, shapes, state.count, margin)
            find_pairs = BROADPHASES[pipeline.broadphase]
            state.pairs, count = find_pairs(state.bodies, state.colliders, shapes, state.count, state.pairs)
            if state.joints.count:
                kept = without_joined(state.pairs[:count], state.joints.apart)
                count = len(kept)
                state.pairs[:count] = kept
        with profile.stage("narrowphase"):
            pairs = state.pairs[:count]
            state.contacts = collide(
                state.bodies, state.colliders, shapes, pairs, pipeline.narrowphase, margin, state.contacts
            )
        with profile.stage("manifold"):
            update_manifolds(state, count)
        with profile.stage("solver"):
            advance = SOLVERS[pipeline.solver].advance
            assert advance is not None
            advance(state, pipeline.solver_settings, h)
        with profile.stage("finish"):
            if len(rows := state.diverged_rows()):
                raise DivergedError(rows.tolist())
            state.complete_step(h)
    except BaseException:  # an interrupt by the user as well
        state.roll_back()
        parts.impulse[:], parts.total[:] = joined
        raise
    return profile
