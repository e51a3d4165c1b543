"""The slides of GJK: what the simplex is for."""

from __future__ import annotations

import numpy as np

from atlasphys.explainer.events import Vector, length, number
from atlasphys.explainer.gjk import REASONS, GjkTrace, Step
from atlasphys.explainer.gjk import SIMPLEX as NAMES
from atlasphys.explainer.slides.figure import (
    CLOSEST,
    DIFFERENCE,
    DROPPED,
    NEW,
    ORIGIN,
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
from atlasphys.explainer.slides.mathml import Markup, display, formula, fraction, norm
from atlasphys.explainer.slides.slide import Slide, coloured, paragraph
from atlasphys.explainer.slides.solids import Pair, hull_of

CAPTION = "A − B, all differences of a point of A and a point of B"


def difference_marks(pair: Pair, opacity: float = 0.18) -> Marks:
    """A − B and the origin."""
    marks: list[Mark] = [Dots(np.zeros((1, 3)), ORIGIN, 1.2), Label("origin", np.zeros(3), below=True)]
    if pair.difference is not None:
        marks.insert(0, Solid(pair.difference, DIFFERENCE, opacity, hollow=True))
    return tuple(marks)


def simplex_marks(points: Vector, *, numbered: bool = True) -> Marks:
    """A simplex: its points, edges and faces."""
    if len(points) == 0:
        return ()
    marks: list[Mark] = [Dots(points, SIMPLEX)]
    if len(points) > 1:
        pairs = [(points[i], points[j]) for i in range(len(points)) for j in range(i)]
        marks.append(Lines(np.array(pairs, np.float64), SIMPLEX, 3.5))
    if len(points) > 2:
        marks.append(Solid(hull_of(points), SIMPLEX, 0.3, outlined=False))
    if numbered:
        marks += [Label(f"w{i}", point, SIMPLEX) for i, point in enumerate(points, 1)]
    return tuple(marks)


def introduction(pair: Pair, trace: GjkTrace) -> Slide:
    """What the question is, and what the simplex is for."""
    a, b = coloured(f"A, {pair.names[0]}", A), coloured(f"B, {pair.names[1]}", B)
    cores = ""
    if any(pair.radii):
        cores = paragraph(
            "Round shapes are handled as a core, a point or a segment, and a radius about it:",
            f"{length(pair.radii[0])} and {length(pair.radii[1])}. GJK works on the cores, and so does the picture on the right.",
        )
    plane = ""
    if pair.is_flat:
        plane = paragraph(
            "These two are prisms whose ends nobody reaches, so all that happens lies in the plane of their outlines:",
            "this is GJK for polygons, run by the engine's code for space. (Points of A and of B have a third coordinate, that of the end of the",
            "prism on which they lie; in their difference it cancels.)",
        )
    return Slide(
        title="The question",
        text=paragraph(f"Do {a} and {b} touch?")
        + paragraph(
            "They do if a point <i>a</i> of A and a point <i>b</i> of B are the same point:", formula("a − b = 0"), "."
        )
        + paragraph(
            f"So collect the differences {formula('a − b')} of <i>all</i> points: the {coloured('Minkowski difference A − B', DIFFERENCE)}, on the",
            "right. <b>A and B touch exactly if A − B contains the origin</b>, the black dot. If it does not, the point of A −",
            "B nearest to the origin",
            "tells how far apart the two are. Drag a shape, and A − B slides over the origin.",
        )
        + paragraph(
            "The page has drawn A − B for you. The engine never does: that would be too many points. It may ask one thing only:",
            f"<i>which point of A − B is farthest in a direction</i> {formula('d')}? The answer is a {coloured('support point', NEW)}.",
        )
        + paragraph(
            f"What it remembers of the answers is the {coloured('simplex', SIMPLEX)}: one point, or two (a line), three (a triangle) or four (a",
            "tetrahedron). Why so few? Whatever lies between points of A − B belongs to A − B. So a simplex around the origin is proof that",
            "A and B overlap, and in space four points are enough to go around it. As long as the simplex misses the origin, its nearest point",
            "says in which direction to ask next.",
        )
        + plane
        + cores,
        beside=difference_marks(pair),
        caption=CAPTION,
    )


def asked(pair: Pair, trace: GjkTrace, number_: int, step: Step) -> Slide:
    """A support point is asked for."""
    d = step.direction.astype(np.float64)
    size = float(np.linalg.norm(d))
    unit = d / size if size > 0 else d
    reach = 0.5 * pair.size
    along = float(step.point @ unit)
    from_where = -d
    if number_ == 1:
        why = paragraph(
            "Nothing is known yet. Begin with some direction, here from A towards B:", formula("d =", d), "."
        )
    else:
        why = paragraph(
            f"The {NAMES[len(step.before)]} comes nearest to the origin at {coloured('c', CLOSEST)}. Look from there towards the origin:"
        ) + display("d = − c =", d)
    answer = paragraph(
        f"The farthest point of {coloured('A', A)} along {formula('d')}, minus the farthest point of {coloured('B', B)} the other way, is the",
        f"farthest point of A − B along {formula('d')}, a {coloured('support point', NEW)}:",
    )
    answer += display("s_A(d) =", step.support_a) + display("s_B(− d) =", step.support_b)
    answer += display("w = s_A(d) − s_B(− d) =", step.point)
    border = "line" if pair.is_flat else "square"
    if size > 0:
        answer += paragraph(f"All of A − B lies on this side of the green {border} through it.")
    ratio = formula(fraction("w · d", norm("d")), "=", along)
    if size == 0:
        answer += paragraph("The direction is zero, as the two have one middle: any point will do to begin with.")
    elif along < 0:
        answer += paragraph(
            f"The origin lies beyond: {ratio}. So <b>A − B cannot contain it</b>, and A and B are at least {length(-along)} apart."
        )
    else:
        answer += paragraph(f"It reaches past the origin: {ratio}. Nothing is ruled out yet.")
    if not step.source_weights:
        answer += paragraph(f"The search ends here: {trace.reason}.")
    marks: list[Mark] = [
        *difference_marks(pair),
        *simplex_marks(step.before),
        Dots(step.point[None], NEW, 1.3),
        Label("w", step.point, NEW),
    ]
    shapes: list[Mark] = [
        Dots(step.support_a[None], NEW, 1.3),
        Dots(step.support_b[None], NEW, 1.3),
        Label("on A", step.support_a, NEW),
        Label("on B", step.support_b, NEW),
    ]
    if size > 0:
        marks.append(Lines(ring(square(step.point, d, reach)), NEW, 2.0))
        marks.append(Arrows(segment(from_where, from_where + unit * max(min(size, 2 * reach), 0.5 * reach)), NEW))
        shapes.append(Arrows(segment(step.support_a, step.support_a + reach * unit), NEW))
        shapes.append(Arrows(segment(step.support_b, step.support_b - reach * unit), NEW))
    if number_ > 1:
        marks.append(Dots(from_where[None], CLOSEST))
        marks += [Label("c", from_where, CLOSEST)] if len(step.before) > 1 else []
    return Slide(
        title=f"Step {number_}: ask for a support point",
        text=why + answer,
        source=step.source,
        needle="difference_support(",
        shapes=tuple(shapes),
        beside=tuple(marks),
        caption=CAPTION,
    )


def taken_in(pair: Pair, number_: int, step: Step) -> Slide:
    """The simplex takes the point in, and drops what does not help."""
    assert step.closest is not None
    tried = np.vstack([step.before, step.point])
    dropped = tried[~(step.weights > 0)]
    weights = step.weights[step.weights > 0]
    total: list[object] = []
    for i, weight in enumerate(weights, 1):
        total += ["+" if total else "", float(weight), f"w_{i}"]
    text = paragraph(
        f"The {coloured('simplex', SIMPLEX)} takes {coloured('w', NEW)} in: {len(tried)} point{'s' if len(tried) > 1 else ''}.",
        "Which part of it is nearest to the origin?",
    )
    text += paragraph(f"<b>{step.case[0].upper()}{step.case[1:]}</b>.")
    if len(dropped):
        text += paragraph(
            f"What is {coloured('dropped', DROPPED)} has no part in the nearest point; were it needed again, it would be found again."
        )
    text += paragraph(
        f"Nearest to the origin is {coloured('c', CLOSEST)}, the points weighed by numbers that are positive and add up to one:"
    )
    text += display("c =", *total) + display("c =", step.closest)
    text += display(norm("c"), "=", Markup(f"<mtext>{length(step.distance)}</mtext>"))
    if len(step.simplex) == 4:
        text += paragraph("<b>The origin is inside the tetrahedron, and so inside A − B: A and B overlap.</b>")
    elif step.distance == 0 or (len(step.simplex) == 3 and pair.is_flat and step.distance < 1e-6 * pair.size):
        text += paragraph("<b>The simplex contains the origin, and so does A − B: A and B touch or overlap.</b>")
    else:
        text += paragraph(
            f"It does not contain the origin yet. So A and B are at most {length(step.distance)} apart. Next, ask towards the origin."
        )
    c = step.closest.astype(np.float64)
    return Slide(
        title=f"Step {number_}: the simplex is a {NAMES[len(step.simplex)]}",
        text=text,
        source=step.source_weights,
        needle="_set_weights(",
        beside=(
            *difference_marks(pair),
            *simplex_marks(step.simplex),
            Dots(dropped, DROPPED),
            Lines(segment(c, np.zeros(3)), CLOSEST, 2.0),
            Dots(c[None], CLOSEST),
            *(() if len(step.simplex) == 1 else (Label("c", c, CLOSEST),)),
        ),
        caption=CAPTION,
    )


def verdict(pair: Pair, trace: GjkTrace) -> Slide:
    """What GJK found."""
    last = trace.steps[-1]
    what = "cores" if any(trace.radii) else "shapes"
    answer = "touching or overlapping" if pair.is_flat and trace.normal is None else trace.verdict
    text = paragraph(f"<b>The {what} are {answer}</b>: {trace.reason}.")
    shapes: tuple[Mark, ...] = ()
    beside = [*difference_marks(pair), *simplex_marks(last.simplex)]
    if trace.normal is not None and trace.on_a is not None and trace.on_b is not None:
        is_bound = trace.reason == REASONS["beyond limit"]
        text += paragraph(
            f"Distance {'at least ' if is_bound else ''}{length(trace.distance)}, along the unit normal from A to B"
        )
        text += display("n =", trace.normal)
        if is_bound:
            text += paragraph(
                "That is more than a contact needs, so the engine looks no further. The nearest points that it had by then:"
            )
        else:
            text += paragraph("between the two points that are nearest to each other,")
        text += display("a =", trace.on_a) + display("b =", trace.on_b)
        if any(trace.radii):
            gap = trace.distance - sum(trace.radii)
            word = "apart" if gap > 0 else "deep in each other"
            text += paragraph(f"Less the two radii, the surfaces are {length(abs(gap))} {word}:")
            text += display(number(trace.distance), "−", trace.radii[0], "−", trace.radii[1], "=", gap)
        nearest = (trace.on_a - trace.on_b).astype(np.float64)
        shapes = (
            Lines(segment(trace.on_a, trace.on_b), CLOSEST, 3.0),
            Dots(np.array([trace.on_a, trace.on_b], np.float64), CLOSEST, 1.2),
        )
        beside += [Lines(segment(nearest, np.zeros(3)), CLOSEST, 3.0), Dots(nearest[None], CLOSEST, 1.2)]
        text += paragraph("A − B never held the origin: no simplex could be closed around it.")
    else:
        text += paragraph(
            "The simplex holds the origin, so A − B does: some point of A is also one of B. How deep they are in each other GJK cannot tell; EPA can."
        )
        if pair.is_flat:
            text += paragraph(
                "In the plane three points are enough to go around the origin: the triangle is the proof. The engine's code for",
                "space calls the origin",
                "“on the simplex”, which is flat there, and would ask for a fourth point off the plane to measure depth.",
            )
    text += paragraph(f"It took {len(trace.steps)} support point{'s' if len(trace.steps) > 1 else ''}.")
    return Slide(
        title=f"Verdict: {answer}",
        text=text,
        source=trace.source_end or last.source,
        shapes=shapes,
        beside=tuple(beside),
        caption=CAPTION,
    )


def slides(pair: Pair, trace: GjkTrace) -> list[Slide]:
    """All of them: the question, two for each step, the verdict."""
    found = [introduction(pair, trace)]
    for i, step in enumerate(trace.steps, 1):
        found.append(asked(pair, trace, i, step))
        if step.closest is not None:
            found.append(taken_in(pair, i, step))
    return [*found, verdict(pair, trace)]
