"""Stage 5, solver: impulses and motion. ``SOLVERS`` is the table of choices, one file each."""

from collections.abc import Callable
from typing import Any, NamedTuple

from atlasphys.engine.solvers import sequential_impulse
from atlasphys.engine.solvers.sequential_impulse import SequentialImpulse
from atlasphys.engine.state.state import State

__all__ = ["SOLVERS", "SequentialImpulse", "Solver"]


class Solver(NamedTuple):
    """An entry of the table."""

    settings: type
    """Dataclass of the solver's settings; its defaults are the solver's."""
    advance: Callable[[State, Any, float], None]
    """Advances a state, whose next manifolds are built, by one step of the given length under the given settings."""


SOLVERS: dict[str, Solver] = {
    "sequential_impulse": Solver(SequentialImpulse, sequential_impulse.advance),
}
