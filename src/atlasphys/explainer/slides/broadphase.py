"""The slides of the broad phase."""

from __future__ import annotations

import numpy as np

from atlasphys.explainer.broadphase import BroadphaseTrace
from atlasphys.explainer.slides.figure import A, B, Colour, Label, Lines, Mark
from atlasphys.explainer.slides.mathml import display
from atlasphys.explainer.slides.slide import Slide, coloured, paragraph
from atlasphys.explainer.slides.solids import Floats, Pair, hull_of

SAID = {
    "may collide": "At least one of the two can move, and each one's mask admits the other's group: they may collide.",
    "filtered": "Neither can move, or a mask does not admit a group: they never collide.",
    "overlap": "The bounds overlap along x, along y and along z: the shapes may touch.",
    "reaches plane": "The lowest point of the bounds is not above the plane: the shape may touch it.",
    "above plane": "Even the lowest point of the bounds is above the plane: the shape cannot touch it.",
}


def slides(pair: Pair, trace: BroadphaseTrace) -> list[Slide]:
    """All of them."""
    assert trace.lower is not None
    assert trace.upper is not None
    marks: list[Mark] = []
    text = paragraph(
        f"A world of {trace.bodies} bodies has {trace.bodies * (trace.bodies - 1) // 2} pairs, and most are far apart. <b>Which",
        "pairs are worth a closer look?</b>",
    )
    text += paragraph(f"Each body is put in a box along the axes, its bounds. The method here is “{trace.method}”.")
    for name, row, low, high in zip(
        trace.names, trace.pair, trace.lower.astype(np.float64), trace.upper.astype(np.float64), strict=True
    ):
        ink: Colour = A if row == pair.rows[0] else B
        if np.isfinite(low).all():
            text += paragraph(f"{coloured(name, ink)}:") + display("from", low, "to", high)
            marks += [
                Lines(box(low - pair.position[0], high - pair.position[0]), ink, 2.5),
                Label(name, high - pair.position[0], ink),
            ]
        else:
            text += paragraph(f"{coloured(name, ink)} is a plane, without bounds.")
    found = [Slide(title="The question", text=text, shapes=tuple(marks))]
    for test in trace.verdict:
        words = SAID.get(
            test.answer, f"The bounds are {test.answer}: one ends before the other begins, and the shapes cannot touch."
        )
        found.append(
            Slide(title=test.answer.capitalize(), text=paragraph(words), source=test.source, shapes=tuple(marks))
        )
    text = paragraph(f"<b>The pair {'goes on to the narrow phase' if trace.survives else 'ends here'}.</b>")
    if trace.survivors is not None:
        text += paragraph(
            f"Of all pairs {len({(t.a, t.b) for t in trace.tests})} were looked at; {len(trace.survivors)} survive."
        )
    source = trace.verdict[-1].source if trace.verdict else ""
    return [*found, Slide(title="Verdict", text=text, source=source, shapes=tuple(marks))]


def box(low: Floats, high: Floats) -> Floats:
    """Edges of a box along the axes."""
    corners = np.array(
        [[(low, high)[i][0], (low, high)[j][1], (low, high)[k][2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    )
    hull = hull_of(corners)
    edges: Floats = hull.vertices[hull.edges]
    return edges
