"""The trace of a solver as the user reads it: a record a sweep."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from atlasphys.engine.solvers.residuals import Residuals, Sweep, contact_residuals
from atlasphys.engine.state.state import State
from atlasphys.world import totals

TRACE = np.dtype(
    [
        ("step", np.int64),
        ("sweep", np.int32),
        ("colour", np.int32),
        ("substep", np.int32),
        ("kind", "U10"),
        ("complementarity", np.float64),
        ("cone", np.float64),
        ("work", np.float64),
        ("translation", np.float64),
        ("rotation", np.float64),
        ("potential", np.float64),
        ("depth", np.float64),
    ]
)

END = -1
"""Value of the column ``sweep`` at the end of a step."""


Records = npt.NDArray[np.void]


def trace_of(state: State) -> Records:
    """The records of the step that a state has just completed, from the notes in ``state.trace`` and from its end."""
    end = Sweep(END, -1, contact_residuals(state), state.bodies.motion[: state.count, 0:6], kind="end")
    notes: list[Sweep] = [*(state.trace or ()), end]
    records = np.zeros(len(notes), TRACE)
    for record, note in zip(records, notes, strict=True):
        record["step"], record["sweep"], record["colour"] = state.steps, note.sweep, note.colour
        record["substep"], record["kind"] = note.substep, note.kind
        record["complementarity"], record["cone"], record["work"], record["depth"] = _worst(note.residuals)
        record["translation"], record["rotation"] = totals.kinetic(state, note.motion)
    records["potential"] = totals.energy(state).potential
    return records


def _worst(residuals: Residuals) -> tuple[float, float, float, float]:
    if len(residuals.depth) == 0:
        return 0.0, 0.0, 0.0, 0.0
    complementarity, cone, work, depth = residuals
    return float(complementarity.max()), float(cone.max()), float(work.sum()), max(float(depth.max()), 0.0)


def trace_records(trace: list[Records]) -> np.recarray[Any, Any]:
    """The records of a number of steps, in one array."""
    records = np.concatenate([np.zeros(0, TRACE), *trace])
    records.flags.writeable = False
    return records.view(np.recarray)
