"""The slides of the separating axis test."""

from __future__ import annotations

import numpy as np

from atlasphys.explainer.events import length
from atlasphys.explainer.sat import Axis, SatTrace
from atlasphys.explainer.slides.figure import (
    CLOSEST,
    NEW,
    A,
    Arrows,
    B,
    Colour,
    Dots,
    Label,
    Lines,
    Mark,
    ring,
    segment,
    square,
)  # fmt: skip
from atlasphys.explainer.slides.gjk import difference_marks
from atlasphys.explainer.slides.mathml import display, formula
from atlasphys.explainer.slides.slide import Slide, coloured, paragraph
from atlasphys.explainer.slides.solids import Floats, Pair

CAPTION = "A − B: none of it lies beyond the plane"
EYE = (0.42, 0.36, 0.83)
"""From where the figure is seen at first: the axis is drawn beside the shapes, not before or behind them."""

SHOWN = 12
"""Axes in the diagram: the newest ones."""


def whose(axis: Axis) -> str:
    """What an axis is made of."""
    names = {"face of a": f"normal of face {axis.a + 1} of A", "face of b": f"normal of face {axis.b + 1} of B"}
    return names.get(axis.of, f"cross product of edge {axis.a + 1} of A and edge {axis.b + 1} of B")


def interval(pair: Pair, which: int, axis: Axis) -> tuple[float, float]:
    """What a shape covers of an axis: the end that the test looked at is the engine's, the other is for the picture."""
    along = pair.core(which) @ axis.axis.astype(np.float64)
    return (float(along.min()), axis.a_to) if which == 0 else (axis.b_from, float(along.max()))


def diagram(pair: Pair, axes: tuple[Axis, ...]) -> str:
    """The newest axes, a row each: what A and B cover of it, and what they share."""
    first = max(0, len(axes) - SHOWN)
    ends = [(interval(pair, 0, axis), interval(pair, 1, axis)) for axis in axes[first:]]
    low, high = min(min(a[0], b[0]) for a, b in ends), max(max(a[1], b[1]) for a, b in ends)
    width, row = 360.0, 22.0
    best = max((i for i, axis in enumerate(axes) if axis.taken), default=-1)

    def x(value: float) -> float:
        return 28 + (width - 36) * (value - low) / (high - low)

    def bar(ends_: tuple[float, float], y: float, colour: Colour) -> str:
        return f'<rect x="{x(ends_[0]):.1f}" y="{y:.1f}" width="{x(ends_[1]) - x(ends_[0]):.1f}" height="7" rx="2" fill="rgb{colour}"/>'

    parts = []
    for k, (a, b) in enumerate(ends):
        i, y = first + k, row * k + 2
        if i == len(axes) - 1:
            parts.append(f'<rect x="0" y="{y - 2}" width="{width}" height="{row}" fill="#eef4ea"/>')
        weight = ' font-weight="bold" fill="rgb(122,62,190)"' if i == best else ' fill="#444"'
        parts.append(f'<text x="2" y="{y + 13}" font-size="11"{weight}>{i + 1}{"★" if i == best else ""}</text>')
        parts += [bar(a, y + 2, A), bar(b, y + 10, B)]
    height = row * len(ends) + 4
    return (
        f'<svg viewBox="0 0 {width:g} {height:g}" style="width:100%;max-width:{width:g}px;font-family:sans-serif" role="img" '
        f'aria-label="intervals of A and B along each axis">{"".join(parts)}</svg>'
    )


def introduction(pair: Pair) -> Slide:
    """What is asked."""
    return Slide(
        title="The question",
        text=paragraph(f"Is there a direction along which {coloured('A', A)} ends before {coloured('B', B)} begins?")
        + paragraph(
            "If two convex shapes are apart, some plane separates them. Seen along that plane's normal, the <b>separating",
            "axis</b>, their shadows do not",
            "overlap. If the shadows overlap along every axis, the shapes do, and the axis where they overlap least is the shortest way out.",
        )
        + paragraph(
            "For polyhedra a few axes are enough: the normals of the faces of A and of B, and the cross products of an edge of A and an edge of B.",
            f"On the right: the same axis asks how far {formula('A − B')} reaches past the origin.",
        ),
        beside=difference_marks(pair),
        caption=CAPTION,
    )


def tried(pair: Pair, trace: SatTrace, index: int) -> Slide:
    """One axis."""
    axis = trace.axes[index]
    n = axis.axis.astype(np.float64)
    gap = axis.b_from - axis.a_to
    text = paragraph(f"The {whose(axis)}:") + display("n =", n)
    text += display("max(n · a) =", axis.a_to) + display("min(n · b) =", axis.b_from)
    text += display("min(n · b) − max(n · a) =", gap)
    if gap > 0:
        text += paragraph(
            f"<b>{coloured('A', A)} ends {length(gap)} before {coloured('B', B)} begins: this axis separates them.</b>"
        )
    else:
        text += paragraph(
            f"{coloured('A', A)} ends after {coloured('B', B)} has begun: they overlap by {length(-gap)} along this axis."
        )
    if axis.taken:
        text += paragraph("<b>The best so far</b> (★): no axis before separates them more or has less overlap.")
    else:
        text += paragraph(
            "An axis before is better, or as good and preferred: a face before edges, and A's before B's."
        )
    if abs(axis.distance - gap) > 1e-5 * pair.size:
        text += paragraph("(The test itself stopped as soon as it could tell that this axis is worse.)")
    text += diagram(pair, trace.axes[: index + 1])
    plane = n * -gap
    return Slide(
        title=f"Axis {index + 1} of {len(trace.axes)}",
        text=text,
        source=axis.source,
        shapes=projections(pair, axis),
        beside=(
            *difference_marks(pair),
            Lines(ring(square(plane, n, 0.6 * pair.size)), NEW, 2.0),
            Arrows(segment(plane, plane + 0.5 * pair.size * n), NEW),
            Lines(segment(np.zeros(3), plane), CLOSEST, 3.0),
        ),
        caption=CAPTION,
    )


def projections(pair: Pair, axis: Axis) -> tuple[Mark, ...]:
    """The axis beside the shapes, with what they cover of it."""
    n = axis.axis.astype(np.float64)
    points = np.concatenate([pair.core(0), pair.core(1)])
    across = np.cross(n, EYE if np.linalg.norm(np.cross(n, EYE)) > 0.2 else (1.0, 0.0, 0.0))
    across = across / np.linalg.norm(across)
    across = across if across[1] < 0 or (across[1] == 0 and across[0] > 0) else -across
    middle = points.mean(axis=0)
    middle = middle - n * (n @ middle)
    foot = middle + across * (float((points @ across).max()) - float(middle @ across) + 0.25 * pair.size)
    a, b = interval(pair, 0, axis), interval(pair, 1, axis)
    shift = 0.05 * pair.size * across
    margin = 0.3 * pair.size
    low, high = min(a[0], b[0]) - margin, max(a[1], b[1]) + margin

    def at(value: float) -> Floats:
        place: Floats = foot + n * value
        return place

    ends = [value for which in (0, 1) for value in interval(pair, which, axis)]
    sides = [
        pair.core(which)[(pair.core(which) @ n).argmin() if end == 0 else (pair.core(which) @ n).argmax()]
        for which in (0, 1)
        for end in (0, 1)
    ]
    return (
        Arrows(segment(at(low), at(high)), NEW),
        Lines(np.array([(at(a[0]) - shift, at(a[1]) - shift)]), A, 8.0),
        Lines(np.array([(at(b[0]) + shift, at(b[1]) + shift)]), B, 8.0),
        Lines(np.array([(side, at(value)) for side, value in zip(sides, ends, strict=True)]), (160, 166, 174), 1.2),
    )


def verdict(pair: Pair, trace: SatTrace) -> Slide:
    """The best axis."""
    assert trace.normal is not None
    assert trace.on_a is not None
    assert trace.on_b is not None
    n = trace.normal.astype(np.float64)
    word = "apart" if trace.distance > 0 else "overlapping"
    text = paragraph(
        f"{len(trace.axes)} axes were tried.",
        f"{trace.parallel} pairs of edges were left out as parallel." if trace.parallel else "",
    )
    text += paragraph(f"<b>The two are {word}, by {length(abs(trace.distance))}</b> along the best axis") + display(
        "n =", n
    )
    text += (
        paragraph("Points of contact, or nearest to each other:")
        + display("a =", trace.on_a)
        + display("b =", trace.on_b)
    )
    if trace.axes:
        text += diagram(pair, trace.axes)
    plane = -n * trace.distance
    shapes: list[Mark] = [
        Dots(np.array([trace.on_a, trace.on_b], np.float64), CLOSEST, 1.2),
        Lines(segment(trace.on_a, trace.on_b), CLOSEST, 3.0),
    ]
    taken = [axis for axis in trace.axes if axis.taken]
    if taken and np.abs(taken[-1].axis - n).max() < 1e-5:
        shapes += projections(pair, taken[-1])
    return Slide(
        title=f"Verdict: {word}",
        text=text,
        source=trace.source_end,
        shapes=tuple(shapes),
        beside=(
            *difference_marks(pair),
            Lines(ring(square(plane, n, 0.6 * pair.size)), CLOSEST, 2.5),
            Lines(segment(np.zeros(3), plane), CLOSEST, 4.0),
            Label("best axis", plane, CLOSEST),
        ),
        caption=CAPTION,
    )


def slides(pair: Pair, trace: SatTrace) -> list[Slide]:
    """All of them."""
    return [introduction(pair), *(tried(pair, trace, i) for i in range(len(trace.axes))), verdict(pair, trace)]
