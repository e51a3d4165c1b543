"""Stage 5, solver: impulses and motion. ``SOLVERS`` is the table of choices, one file each."""

from collections.abc import Callable
from typing import Any, NamedTuple

from atlasphys.engine.solvers import avbd, sequential_impulse
from atlasphys.engine.solvers.avbd import AVBD
from atlasphys.engine.solvers.sequential_impulse import SequentialImpulse
from atlasphys.engine.solvers.soft_step import SoftStep
from atlasphys.engine.solvers.xpbd import XPBD
from atlasphys.engine.state.state import State

__all__ = ["AVBD", "SOLVERS", "XPBD", "SequentialImpulse", "SoftStep", "Solver"]


class Solver(NamedTuple):
    """An entry of the table."""

    settings: type
    """Dataclass of the solver's settings; its defaults are the solver's."""
    advance: Callable[[State, Any, float], None] | None
    """Advances a state, whose next manifolds are built, by one step of the given length under the given settings. None: the solver is
    part of the fused step (``engine/run.py``)."""
    shares: bool = False
    """Whether it lets bodies sleep and shares its work among threads."""


SOLVERS: dict[str, Solver] = {
    "soft_step": Solver(SoftStep, None, shares=True),
    "sequential_impulse": Solver(SequentialImpulse, sequential_impulse.advance),
    "xpbd": Solver(XPBD, None),
    "avbd": Solver(AVBD, avbd.advance),
}
