"""The slides of EPA: how deep, and which way out."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from atlasphys.explainer.epa import EpaTrace, Polytope, Step
from atlasphys.explainer.events import length
from atlasphys.explainer.slides.figure import (
    CLOSEST,
    DIFFERENCE,
    DROPPED,
    NEW,
    SIMPLEX,
    A,
    Arrows,
    B,
    Dots,
    Label,
    Lines,
    Mark,
    Marks,
    Solid,
    ring,
    segment,
    square,
)  # fmt: skip
from atlasphys.explainer.slides.gjk import CAPTION, difference_marks
from atlasphys.explainer.slides.mathml import display, formula
from atlasphys.explainer.slides.slide import Slide, coloured, paragraph
from atlasphys.explainer.slides.solids import Hull, Pair


def surface(polytope: Polytope, faces: npt.NDArray[np.intp] | None = None) -> Hull:
    """The surface of a polytope, or some of its faces."""
    corners = (polytope.faces if faces is None else polytope.faces[faces]).astype(np.int64)
    sides = corners[:, [(0, 1), (1, 2), (2, 0)]].reshape(-1, 2)
    return Hull(polytope.vertices.astype(np.float64), corners, np.unique(np.sort(sides, axis=1), axis=0))


def introduction(pair: Pair, trace: EpaTrace) -> Slide:
    """What is asked for."""
    start = trace.steps[0].polytope if trace.steps else None
    marks: list[Mark] = [*difference_marks(pair, 0.1)]
    begins = ""
    if start is not None:
        marks.append(Solid(surface(start), SIMPLEX, 0.3))
        begins = paragraph(
            f"It begins with GJK's last simplex, which holds the origin, made a {coloured('polytope', SIMPLEX)} of {len(start.faces)} faces.",
            "It lies inside A − B. So A − B's surface is at least as far away as the polytope's, and each step makes the polytope larger where it",
            "is nearest to the origin: <b>expanding polytope algorithm</b>.",
        )
    return Slide(
        title="The question",
        text=paragraph(
            f"{coloured('A, ' + pair.names[0], A)} and {coloured('B, ' + pair.names[1], B)} overlap: the origin is inside",
            f"{coloured('A − B', DIFFERENCE)}.",
            "How far, and which way, must B be moved to get out?",
        )
        + paragraph(
            "Moving B by a vector moves A − B by the opposite. They part when the origin reaches the surface of A − B. <b>The",
            "shortest way out is to the",
            "point of the surface nearest to the origin</b>: its distance is the depth, its direction the normal.",
        )
        + begins,
        beside=tuple(marks),
        caption=CAPTION,
    )


def asked(pair: Pair, number_: int, step: Step) -> Slide:
    """The nearest face is asked."""
    n, w = step.normal.astype(np.float64), step.point.astype(np.float64)
    foot = n * step.lower
    gap = step.upper - step.lower
    if step.outcome == "wall":
        text = paragraph("One more direction is tried: that of the curved wall of a round shape.") + display("n =", n)
    else:
        text = paragraph(
            f"Of {len(step.polytope.faces)} faces, the {coloured('nearest', CLOSEST)} to the origin has the distance and the outward normal"
        )
        text += display("l =", step.lower, ",", "n =", n)
        text += paragraph(
            f"The depth is not less than that: {formula('l')} is a bound from below. Is there more of A − B beyond the face? Ask along its normal:"
        )
    text += display("w = s_A(n) − s_B(− n) =", w) + display("u = n · w =", step.upper)
    text += paragraph(
        f"No point of A − B is farther along {formula('n')}. So moving B by {length(step.upper)} along it parts the shapes: a bound from above.",
        f"The least such bound so far is {length(step.best)}.",
    )
    if step.outcome == "grows":
        text += paragraph(
            f"<b>The support point is {length(gap)} beyond the face</b>: the surface of A − B is farther out. The polytope has to grow here."
        )
    elif step.outcome == "known point":
        text += paragraph(
            "<b>That point is a vertex of the polytope already</b>: there is nothing beyond this face, which is part of the surface of A − B."
        )
    elif step.outcome == "converged":
        text += paragraph(
            f"<b>The two bounds meet</b>: {formula('u − l =', gap)} m is no more than round-off. The face lies on the surface",
            "of A − B: this is the depth.",
        )
    reach = 0.5 * pair.size
    marks: list[Mark] = [
        *difference_marks(pair, 0.1),
        Solid(surface(step.polytope), SIMPLEX, 0.22),
        Arrows(segment(foot, foot + reach * n), NEW),
        Dots(w[None], NEW, 1.3),
        Label("w", w, NEW),
        Lines(ring(square(w, n, reach)), NEW, 2.0),
    ]
    if step.outcome != "wall":
        marks += [
            Solid(surface(step.polytope, np.array([step.face])), CLOSEST, 0.75),
            Lines(segment(np.zeros(3), foot), CLOSEST, 3.0),
        ]
    return Slide(
        title=f"Step {number_}: ask the nearest face",
        text=text,
        source=step.source,
        needle="difference_support(",
        beside=tuple(marks),
        caption=CAPTION,
    )


def grown(pair: Pair, number_: int, step: Step) -> Slide:
    """The polytope takes the point in."""
    assert step.grown is not None
    corners = step.polytope.vertices.astype(np.float64)
    horizon = corners[step.horizon]
    text = paragraph(
        f"{coloured('w', NEW)} becomes a vertex. It sees {len(step.removed)} face{'s' if len(step.removed) > 1 else ''} from outside"
        f" ({coloured('grey', DROPPED)}): those would now lie inside, and go."
    )
    text += paragraph(
        f"Their rim is the {coloured('horizon', CLOSEST)}, {len(step.horizon)} edges. Each makes a new face with",
        f"{coloured('w', NEW)}, and the surface is closed again:",
    )
    text += display(f"{len(step.polytope.faces)} − {len(step.removed)} + {len(step.horizon)} = {len(step.grown.faces)}")
    nearest = float(np.min(step.grown.distances))
    text += paragraph(
        f"faces on {len(step.grown.vertices)} vertices. The nearest is now {length(nearest)} from the origin; before, it was {length(step.lower)}."
    )
    marks: Marks = (
        *difference_marks(pair, 0.1),
        Solid(surface(step.grown), SIMPLEX, 0.3),
        Solid(surface(step.polytope, step.removed), DROPPED, 0.5),
        Lines(horizon, CLOSEST, 5.0),
        Dots(step.point[None], NEW, 1.3),
        Label("w", step.point, NEW),
    )
    return Slide(
        title=f"Step {number_}: the polytope grows",
        text=text,
        source=step.source_horizon,
        needle="_take(",
        beside=marks,
        caption=CAPTION,
    )


def verdict(pair: Pair, trace: EpaTrace) -> Slide:
    """Depth, normal, deepest points."""
    assert trace.normal is not None
    assert trace.on_a is not None
    assert trace.on_b is not None
    n = trace.normal.astype(np.float64)
    way = n * trace.depth
    text = paragraph(f"<b>The search ends</b>: {trace.reason}.")
    text += paragraph(f"Depth {length(trace.depth)} along the unit normal from A to B") + display("n =", n)
    text += paragraph(
        "The deepest points, of A in B and of B in A (witness points), follow from the weights of the nearest face:"
    )
    text += (
        display("a =", trace.on_a)
        + display("b =", trace.on_b)
        + display("a − b =", np.subtract(trace.on_a, trace.on_b))
    )
    if any(trace.radii):
        text += paragraph(
            f"With the radii about the cores the surfaces are {length(trace.depth + sum(trace.radii))} deep in each other."
        )
    text += paragraph("On the left B is drawn where it just touches A: moved by the depth along the normal.")
    hull = pair.bodies[1]
    out = sum(trace.radii)
    shapes: list[Mark] = [
        Dots(np.array([trace.on_a, trace.on_b], np.float64), CLOSEST, 1.2),
        Lines(segment(trace.on_a, trace.on_b), CLOSEST, 4.0),
    ]
    shapes.append(Solid(Hull(hull.vertices + way + out * n, hull.faces, hull.edges, hull.is_smooth), B, 0.15))
    beside: list[Mark] = [*difference_marks(pair)]
    if trace.steps:
        beside.append(Solid(surface(trace.steps[-1].polytope), SIMPLEX, 0.2))
    beside += [
        Arrows(segment(np.zeros(3), way), CLOSEST),
        Dots(way[None], CLOSEST, 1.2),
        Label("depth × n", way, CLOSEST),
    ]
    return Slide(
        title=f"Verdict: {length(trace.depth)} deep",
        text=text,
        source=trace.source_end,
        shapes=tuple(shapes),
        beside=tuple(beside),
        caption=CAPTION,
    )


def slides(pair: Pair, trace: EpaTrace) -> list[Slide]:
    """All of them."""
    found = [introduction(pair, trace)]
    for i, step in enumerate(trace.steps, 1):
        found.append(asked(pair, i, step))
        if step.grown is not None:
            found.append(grown(pair, i, step))
    return [*found, verdict(pair, trace)]
