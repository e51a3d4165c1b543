"""Steps that are watched: who watches is shown the state before and after, for explanations."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from atlasphys.engine.solvers.residuals import Sweep
from atlasphys.engine.state.state import State
from atlasphys.engine.step import Pipeline
from atlasphys.world.trace import Records

if TYPE_CHECKING:
    from atlasphys.world.snapshot import Snapshot
    from atlasphys.world.world import World


@dataclass(frozen=True, slots=True)
class SeenStep:
    """A step as those see it who watch it."""

    before: State
    after: State
    """Copies of the state before and after the step."""
    start: Snapshot
    """The same state before the step, with what is known of the bodies beside the physics."""
    pipeline: Pipeline
    h: float
    """Length of the step [s]."""
    solved: list[Records]
    """What ``World.solver_trace`` says of it."""
    sweeps: list[Sweep]
    """What the solver noted of its sweeps."""


Watcher = Callable[[SeenStep], None]


@contextmanager
def watched(world: World, watcher: Watcher) -> Iterator[None]:
    """Show the last step of each call of ``World.step`` or ``World.run`` inside the block to a watcher."""
    world._watchers.append(watcher)
    try:
        yield
    finally:
        world._watchers.remove(watcher)


def advance_watched(world: World, h: float, steps: int) -> None:
    """Take steps and show the last to those who watch. The result is that of any other steps."""
    watchers, world._watchers, tracing = world._watchers, [], world._tracing
    earlier: list[Records] = []
    try:
        if steps > 1:
            world._advance(h, steps - 1)
            earlier = world._trace
        start = world.snapshot()
        world._tracing = True
        world._advance(h, 1)
        seen = SeenStep(start._state, world._state.copy(), start, world._pipeline, h, world._trace, world._sweeps)
    finally:
        world._watchers, world._tracing, world._sweeps = watchers, tracing, []
        world._trace = [*earlier, *world._trace] if tracing else []
    for watcher in watchers:
        watcher(seen)
