"""The slides of the manifold: reduction to four points, matching, impulses carried over."""

from __future__ import annotations

import math

import numpy as np

from atlasphys.explainer.events import Points, length, number
from atlasphys.explainer.manifold import ManifoldTrace
from atlasphys.explainer.slides.clip import Flat
from atlasphys.explainer.slides.figure import CLOSEST, DROPPED, NEW, Arrows, Dots, Label, Lines, Mark, Marks, ring
from atlasphys.explainer.slides.mathml import display, formula
from atlasphys.explainer.slides.slide import Slide, coloured, paragraph
from atlasphys.explainer.slides.solids import Pair

CAPTION = "the contact points, seen along the normal and enlarged"

WHY = {
    "deepest": "It is the <b>deepest</b>: the one that must not be missed.",
    "farthest": "It is the <b>farthest</b> from the first: a lever against tipping about one axis.",
    "triangle": "It makes the <b>largest triangle</b> with the two.",
    "other side": "It adds the <b>most area on another side</b> of the triangle.",
}


def slides(pair: Pair, trace: ManifoldTrace) -> list[Slide]:
    """All of them."""
    assert trace.depths is not None
    assert trace.from_a is not None
    assert trace.impulses is not None
    moment = pair.moment
    centre = moment.before.bodies.geometry[moment.a, 9:12].astype(np.float64)
    points = trace.from_a.astype(np.float64) + centre + moment.before.bodies.position[moment.a] - pair.position[0]
    normal = moment.contact.normal if moment.contact is not None else np.array((0.0, 1.0, 0.0))
    flat = Flat(pair, normal, points)
    count = len(points)

    def marks(kept: list[int], newest: int | None) -> tuple[Marks, Marks]:
        """The points, beside the shapes and flat."""
        both = []
        for place in (points, flat(points)):
            found: list[Mark] = [Dots(place, DROPPED)]
            if kept:
                found.append(Dots(place[kept], CLOSEST, 1.2))
                found += [Lines(ring(place[_around(flat(points), kept)]), CLOSEST, 2.5)] if len(kept) > 1 else []
            if newest is not None:
                found.append(Dots(place[[newest]], NEW, 1.6))
            both.append((*found, *(Label(str(i), at) for i, at in enumerate(place, 1))))
        return both[0], both[1]

    def slide(title: str, text: str, source: str, kept: list[int], newest: int | None = None) -> Slide:
        shapes, beside = marks(kept, newest)
        return Slide(
            title=title,
            text=text,
            source=source,
            shapes=shapes,
            beside=beside,
            caption=CAPTION,
            faces_viewer=True,
            opacity=0.25,
        )

    depths = ", ".join(length(depth) for depth in trace.depths)
    text = paragraph(f"The pair has {count} contact point{'s' if count > 1 else ''}, depths {depths}.")
    text += paragraph(
        "The solver's work grows with their number, and four well spread ones hold a body as firmly as many. And a point that was there in the last",
        "step should go on from last step's impulse, so that the solver need not begin from nothing: <b>warm starting</b>.",
    )
    text += paragraph("Four and less are all kept." if count <= 4 else "Four are chosen.")
    found = [slide("The question", text, "", list(range(count)) if count <= 4 else [])]
    kept: list[int] = []
    for entry in trace.reduction:
        value = (
            entry.value
            if entry.why == "deepest"
            else math.sqrt(entry.value)
            if entry.why == "farthest"
            else abs(entry.value)
        )
        words = paragraph(f"{coloured(f'Point {entry.index + 1}', NEW)} is kept. {WHY[entry.why]}")
        words += display({"deepest": "depth =", "farthest": "distance ="}.get(entry.why, "2 · area ="), float(value))
        kept.append(entry.index)
        found.append(slide(f"Keep point {entry.index + 1}: {entry.why}", words, entry.source, list(kept), entry.index))
    final = list(trace.kept)
    for match in trace.matches:
        number_ = final[match.point] + 1
        if match.old >= 0:
            words = paragraph(
                f"{coloured(f'Point {number_}', NEW)} is old point {match.old + 1}, found by {match.by}: as seen from one of the two bodies",
                f"it has moved by {length(match.distance)} only.",
            )
        else:
            words = paragraph(f"{coloured(f'Point {number_}', NEW)}: no old point by {match.by} is near enough.")
        found.append(slide(f"Match point {number_} by {match.by}", words, match.source, final, number_ - 1))
    if not trace.old_points:
        words = paragraph("The pair had no contact in the step before: all impulses begin at zero.")
    else:
        words = paragraph(
            f"The pair had {trace.old_points} points. Each point goes on from the normal impulse of the one that it is:"
        )
        for index, old, impulse in zip(final, trace.origin, trace.impulses, strict=True):
            came = f"old point {old + 1}" if old >= 0 else "new"
            words += paragraph(f"point {index + 1}: {came},", formula(f"λ_{index + 1} =", float(impulse)), "N s")
    end = slide(
        f"Verdict: {len(final)} point{'s' if len(final) > 1 else ''}",
        words,
        trace.matches[-1].source if trace.matches else "",
        final,
    )
    arrows = impulse_arrows(pair, points[final], normal, trace.impulses)
    return [*found, Slide(**{**vars(end), "shapes": (*end.shapes, *arrows)})]


def _around(flat: Points, kept: list[int]) -> list[int]:
    """The kept points in their order around their middle."""
    middle = flat[kept].mean(axis=0)
    return sorted(kept, key=lambda i: math.atan2(flat[i, 1] - middle[1], flat[i, 0] - middle[0]))


def impulse_arrows(pair: Pair, points: Points, normal: Points, impulses: Points) -> Marks:
    """Normal impulses as arrows, the largest as long as the smaller shape is wide."""
    largest = float(np.max(impulses, initial=0.0))
    if largest <= 0:
        return ()
    shown = np.asarray(impulses) > 0
    tips = points + normal * (0.8 * pair.size / largest * np.asarray(impulses))[:, None]
    return (
        Arrows(np.stack([points, tips], axis=1)[shown], NEW),
        *(Label(f"{number(float(i))} N s", tip, NEW) for i, tip in zip(impulses[shown], tips[shown], strict=True)),
    )
