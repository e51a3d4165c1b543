"""The trace of the solver: impulses of the pair's contact points after each sweep, and what the whole step's contacts lack."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from atlasphys.engine.solvers.residuals import live_points
from atlasphys.engine.state.manifolds import FRICTION
from atlasphys.explainer.events import Trace, number
from atlasphys.explainer.moment import Moment
from atlasphys.world.views import contact_points

AT_THE_CONE = 1e-5
"""A friction impulse counts as held at the cone if it is that near to it, as a part of it."""


@dataclass(frozen=True, eq=False)
class Sweep:
    """The state after a sweep over all contacts, or, in the last entry, at the end of the step."""

    number: int
    """0 for the first record of the step; −1: the end of the step."""
    kind: str
    """What the solver calls it: ``"sweep"`` (number 0: before the first), ``"end"``, or a pass of a substep."""
    substep: int
    """From 0 on, for solvers that have substeps."""
    normal: npt.NDArray[np.float64]
    """(k,) normal impulse of each contact point of the pair [N s]."""
    friction: npt.NDArray[np.float64]
    """(k,) size of its friction impulse [N s]."""
    clamps: tuple[str, ...]
    """For each point ``"pulls"`` (its impulse would pull, and is held at zero), ``"slides"`` (friction is held at the cone) or ``"free"``."""
    complementarity: float
    """Greatest residual |min(w/k, λ)| of all contact points of the world [N s]."""
    cone: float
    """Greatest violation of Coulomb's cone [N s]."""
    energy: float
    """Kinetic energy of all bodies [J]."""

    @property
    def when(self) -> str:
        """In words."""
        if self.kind == "end":
            return "end of the step"
        if self.kind == "sweep":
            return f"sweep {self.number}" if self.number else "before the first sweep"
        return f"substep {self.substep + 1}, {self.kind}"


@dataclass(frozen=True, kw_only=True, eq=False)
class SolverTrace(Trace):
    """How the solver went about the pair's contact points."""

    solver: str = ""
    sweeps: tuple[Sweep, ...] = ()

    def lines(self) -> Iterator[str]:
        """The story."""
        yield f"Solver ({self.solver}): what does each contact point of the pair push with?"
        for sweep in self.sweeps:
            pushed = ", ".join(
                f"{number(normal)} ({'friction ' + number(friction) + ', ' if friction else ''}{clamp})"
                for normal, friction, clamp in zip(sweep.normal, sweep.friction, sweep.clamps, strict=True)
            )
            yield f"{sweep.when}: {pushed} N s"
            yield (
                f"   all contacts: residual {number(sweep.complementarity)} N s, beyond the cone {number(sweep.cone)} N s; "
                f"kinetic energy {number(sweep.energy)} J"
            )


def read(moment: Moment) -> SolverTrace:
    """The trace, from what the solver noted of its sweeps and from the end of the step."""
    solver = moment.pipeline.solver
    if moment.contact is None:
        return SolverTrace(
            instead="The pair has no contact points: the solver had nothing to do with it.", solver=solver
        )
    m = moment.after.manifolds
    rows, _ = live_points(m, moment.after.manifold_count)
    mine = (m.a[rows] == moment.a) & (m.b[rows] == moment.b)
    friction = m.contact[rows[mine], FRICTION].astype(np.float64)
    sweeps = []
    for note, record in zip(moment.sweeps, moment.solved, strict=False):
        if note.impulse is not None:
            impulse = note.impulse[mine]
            sweeps.append(_sweep(impulse[:, 0], np.hypot(impulse[:, 1], impulse[:, 2]), friction, record))
    remark = ""
    if any(sweep.kind != "sweep" for sweep in sweeps):
        remark = "Impulses after a pass are those of its substep, at the end of the step those of the whole step."
    contacts = contact_points(moment.after)
    of_pair = (contacts.body_a == moment.a) & (contacts.body_b == moment.b)
    rubbed = np.linalg.norm(contacts.friction_impulse[of_pair], axis=1)
    sweeps.append(_sweep(contacts.normal_impulse[of_pair], rubbed, friction[: of_pair.sum()], moment.solved[-1]))
    return SolverTrace(remark=remark, solver=solver, sweeps=tuple(sweeps))


def _sweep(
    normal: npt.NDArray[np.float64],
    friction: npt.NDArray[np.float64],
    coefficient: npt.NDArray[np.float64],
    record: np.void,
) -> Sweep:
    clamps = tuple(
        "pulls" if n <= 0 else "slides" if mu > 0 and f >= (1 - AT_THE_CONE) * mu * n else "free"
        for n, f, mu in zip(normal, friction, coefficient, strict=True)
    )
    energy = float(record["translation"] + record["rotation"])
    return Sweep(
        number=int(record["sweep"]),
        kind=str(record["kind"]),
        substep=int(record["substep"]),
        normal=normal,
        friction=friction,
        clamps=clamps,
        complementarity=float(record["complementarity"]),
        cone=float(record["cone"]),
        energy=energy,
    )
