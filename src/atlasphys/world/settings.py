"""Settings of worlds: presets, ranges, and what is checked of each."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from atlasphys.engine.solvers import SOLVERS
from atlasphys.errors import InvalidArgumentError
from atlasphys.world.arguments import bounded_vector, choice, in_range

NARROWPHASES = ("auto", "gjk_epa", "sat")

PRESETS: dict[str, dict[str, Any]] = {
    "default": {"broadphase": "tree", "narrowphase": "auto", "solver": "soft_step"},
    "classic": {"broadphase": "sweep", "narrowphase": "gjk_epa", "solver": "sequential_impulse"},
    "xpbd": {"broadphase": "tree", "narrowphase": "sat", "solver": "xpbd"},
    "avbd": {"broadphase": "tree", "narrowphase": "auto", "solver": "avbd"},
}
"""Name → arguments of ``World`` that it stands for."""

DEFAULT_PRESET = "default"

PRECISIONS = {"single": np.float32, "double": np.float64}

SHORTEST_STEP, LONGEST_STEP = 1e-7, 10.0
"""Range of dt [s]. Outside it h² or 1/h² leaves single precision's range in usual scenes."""

MOST_THREADS = 256
"""Limit of the setting."""

LONGEST_RUN = 1e9
"""Most seconds that ``World.run`` simulates: thirty years."""


def solver_of(value: object) -> tuple[str, Any]:
    """Name and settings of a solver given by either."""
    for name, entry in SOLVERS.items():
        if isinstance(value, entry.settings):
            return name, value
    name = choice("solver", value, SOLVERS)
    return name, SOLVERS[name].settings()


def is_fused(solver: str) -> bool:
    """Whether a solver is part of the fused step."""
    return SOLVERS[solver].advance is None


def sleeping_of(solver: str, value: object) -> bool:
    """The setting ``sleeping``; None stands for the solver's default."""
    if value is None:
        return SOLVERS[solver].shares
    if type(value) is not bool:
        raise InvalidArgumentError(f"sleeping must be True or False (got {value!r})")
    if value and not SOLVERS[solver].shares:
        raise InvalidArgumentError(f"sleeping must be False with {solver}: only soft_step lets bodies sleep")
    return value


def threads_of(solver: str, value: object) -> int:
    """The setting ``threads``."""
    if type(value) is not int or not 1 <= value <= MOST_THREADS:
        raise InvalidArgumentError(f"threads must be an integer from 1 to {MOST_THREADS} (got {value!r})")
    if value > 1 and not SOLVERS[solver].shares:
        raise InvalidArgumentError(f"threads must be 1 with {solver}: only soft_step shares its work (got {value})")
    return value


def with_substeps(name: str, settings: Any, substeps: int | None, given: bool) -> Any:
    """The solver's settings with the argument ``substeps``."""
    if substeps is None:
        return settings
    if not hasattr(settings, "substeps"):
        if type(substeps) is int and substeps == 1:
            return settings
        raise InvalidArgumentError(f"substeps must be 1 with {name} (got {substeps!r})")
    if given:
        raise InvalidArgumentError("substeps is given twice: as an argument and in the solver's settings")
    return dataclasses.replace(settings, substeps=substeps)


def gravity_of(value: object) -> tuple[float, float, float]:
    """The setting ``gravity`` [m/s²]."""
    x, y, z = bounded_vector("gravity", value)
    return x, y, z


def threshold_of(value: object) -> float:
    """The setting ``restitution_threshold`` [m/s]."""
    return in_range("restitution_threshold", value, 0, 1e9)
