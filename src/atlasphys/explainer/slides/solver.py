"""The slides of the solver: impulses and residual, sweep by sweep."""

from __future__ import annotations

import inspect
import math
from pathlib import Path

import numpy as np

from atlasphys.engine.run import run
from atlasphys.engine.solvers import SOLVERS
from atlasphys.explainer.events import number
from atlasphys.explainer.slides.figure import SIMPLEX as INK
from atlasphys.explainer.slides.figure import Dots, Label, Mark
from atlasphys.explainer.slides.manifold import impulse_arrows
from atlasphys.explainer.slides.mathml import display, formula
from atlasphys.explainer.slides.slide import PACKAGE, Chart, Slide, paragraph, source_lines
from atlasphys.explainer.slides.solids import Pair
from atlasphys.explainer.solver import SolverTrace, Sweep
from atlasphys.world.views import contact_points

LEAST = 1e-9
"""What is less is drawn as this [N s]."""

CLAMPS = {
    "pulls": "it would have to pull: its impulse is held at zero",
    "slides": "it slides: friction is held at the cone",
    "free": "",
}


def slides(pair: Pair, trace: SolverTrace) -> list[Slide]:
    """All of them."""
    moment = pair.moment
    contacts = contact_points(moment.after)
    mine = (contacts.body_a == moment.a) & (contacts.body_b == moment.b)
    points = contacts.point[mine] - pair.position[0]
    normal = contacts.normal[mine][0] if mine.any() else np.array((0.0, 1.0, 0.0))
    source = place(trace.solver)
    places: list[Mark] = [Dots(points, INK)]
    places += [Label(str(i), point, INK) for i, point in enumerate(points, 1)]
    found = [
        Slide(
            title="The question",
            text=paragraph(
                f"What must each of the {len(points)} contact point{'s' if len(points) != 1 else ''} of the pair push with, so",
                "that nothing goes deeper and nothing sticks?",
            )
            + paragraph("For each point, an impulse and the speed along the normal after it obey")
            + display("λ ≥ 0 , v ≥ 0 , λ v = 0")
            + paragraph(
                f"it pushes, or it parts, not both; and friction stays in Coulomb's cone, {formula('|λ_t| ≤ μ λ')}. All points",
                "depend on each other, so",
                "a solver goes over them again and again. How far it is from these laws is the residual.",
            )
            + (paragraph(trace.remark) if trace.remark else ""),
            source=source,
            shapes=tuple(places),
            opacity=0.25,
        )
    ]
    for i, sweep in enumerate(trace.sweeps):
        arrows = impulse_arrows(pair, points, normal, sweep.normal) if len(points) == len(sweep.normal) else ()
        found.append(
            Slide(
                title={-1: "The end of the step", 0: "Before the first sweep"}.get(
                    sweep.number, f"Sweep {sweep.number}"
                ),
                text=said(sweep),
                source=place(trace.solver, sweep.number),
                shapes=(*places, *arrows),
                opacity=0.25,
                charts=charts(trace.sweeps[: i + 1]),
            )
        )
    return found


def said(sweep: Sweep) -> str:
    """What is known after a sweep."""
    text = ""
    if sweep.number == 0:
        text = paragraph("The impulses that last step's contacts left are applied first: the warm start.")
    elif sweep.number == -1:
        text = paragraph("After all sweeps: the impulses of the whole step, and what is left of the residual.")
    for i, (normal, friction, clamp) in enumerate(zip(sweep.normal, sweep.friction, sweep.clamps, strict=True), 1):
        rubbed = formula(f"|λ_t{i}| =", float(friction)) + " N s" if friction else ""
        said_ = f"({CLAMPS[clamp]})" if CLAMPS[clamp] else ""
        text += paragraph(f"point {i}:", formula(f"λ_{i} =", float(normal)), "N s", rubbed, said_)
    text += paragraph(
        "All contacts of the world:",
        formula("max |min(w / k, λ)| =", sweep.complementarity),
        "N s is lacking,",
        f"{number(sweep.cone)} N s beyond the cone; kinetic energy {number(sweep.energy)} J.",
    )
    return text


def charts(sweeps: tuple[Sweep, ...]) -> tuple[Chart, ...]:
    """Impulses, residual and energy up to a sweep; the end of the step counts as one more."""
    across = tuple(float(sweep.number if sweep.number >= 0 else len(sweeps) - 1) for sweep in sweeps)
    count = len(sweeps[0].normal)
    return (
        Chart(
            title="normal impulse [N s] by sweep",
            across=across,
            curves={f"point {k + 1}": tuple(float(sweep.normal[k]) for sweep in sweeps) for k in range(count)},
        ),
        Chart(
            title="what is lacking, log10 of [N s], by sweep",
            across=across,
            curves={
                "residual": tuple(_logarithm(sweep.complementarity) for sweep in sweeps),
                "beyond the cone": tuple(_logarithm(sweep.cone) for sweep in sweeps),
            },
        ),
    )


def _logarithm(value: float) -> float:
    return math.log10(max(value, LEAST))


def place(solver: str, sweep: int = -1) -> str:
    """The line of a solver that makes a sweep (0: that starts warm), where it notes its sweeps; else where its step begins."""
    advance = SOLVERS[solver].advance or run
    file = inspect.getsourcefile(advance)
    assert file is not None
    name = Path(file).relative_to(PACKAGE).as_posix()
    call = {-1: "", 0: "    warm_start("}.get(sweep, "= sweep(")
    lines = (i for i, text in enumerate(source_lines(name), 1) if call and call in text)
    return f"{name}:{next(lines, advance.__code__.co_firstlineno)}"
