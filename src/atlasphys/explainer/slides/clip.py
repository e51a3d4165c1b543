"""The slides of clipping."""

from __future__ import annotations

import numpy as np

from atlasphys.explainer.clip import ClipTrace
from atlasphys.explainer.events import Points, length
from atlasphys.explainer.slides.figure import (
    CLOSEST,
    DROPPED,
    NEW,
    SIMPLEX,
    A,
    Arrows,
    B,
    Colour,
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
from atlasphys.explainer.slides.mathml import display, formula
from atlasphys.explainer.slides.slide import Slide, coloured, paragraph
from atlasphys.explainer.slides.solids import Pair, hull_of

CAPTION = "the features alone, seen along the normal and enlarged"


KEPT = {True: "kept", False: "dropped: farther than the margin"}


class Flat:
    """Draws what lies about the plane of contact a second time, seen along the normal and enlarged: in the x-y plane, normal towards +z."""

    def __init__(self, pair: Pair, normal: Points, about: Points) -> None:
        n = normal.astype(np.float64)
        u = np.array((-n[1], n[0], 0.0)) if abs(n[2]) < 0.999 else np.array((1.0, 0.0, 0.0))
        if abs(n[1]) > 0.7:
            u = np.cross((0.0, 0.0, 1.0), n)
        u = u / np.linalg.norm(u)
        self.axes = np.array([u, np.cross(n, u), n])
        self.middle = about.mean(axis=0).astype(np.float64)
        spread = float(np.linalg.norm(about - self.middle, axis=1).max())
        self.scale = pair.size / max(spread, 0.2 * pair.size)

    def __call__(self, points: Points) -> Points:
        """Places in the picture of points."""
        flat: Points = (np.asarray(points, np.float64).reshape(-1, 3) - self.middle) @ self.axes.T * self.scale
        return flat


def polygon(points: Points, colour: Colour, opacity: float = 0.3, width: float = 3.0) -> Marks:
    """A feature: a face, an edge or a point."""
    if len(points) == 0:
        return ()
    marks: list[Mark] = [Dots(points, colour, 0.8)]
    if len(points) > 1:
        marks.append(Lines(ring(points), colour, width))
    if len(points) > 2:
        marks.append(Solid(hull_of(points), colour, opacity, outlined=False))
    return tuple(marks)


def named(points: Points) -> str:
    """What a feature is."""
    return {1: "a corner", 2: "an edge"}.get(len(points), f"a face of {len(points)} corners")


def slides(pair: Pair, trace: ClipTrace) -> list[Slide]:
    """All of them."""
    assert trace.feature_a is not None
    assert trace.feature_b is not None
    assert trace.normal is not None
    assert trace.reference_normal is not None
    a, b = trace.feature_a.astype(np.float64), trace.feature_b.astype(np.float64)
    flat = Flat(pair, trace.reference_normal, np.concatenate([a, b]))
    both = (*polygon(a, A), *polygon(b, B))
    flat_both = (*polygon(flat(a), A, 0.15), *polygon(flat(b), B, 0.15))
    found = [
        Slide(
            title="The question",
            text=paragraph(
                "The shapes touch along a normal. A box that rests on a box needs more than one point of contact, or it would",
                "tip. <b>Where do the two",
                "surfaces face each other?</b>",
            )
            + display("n =", trace.normal)
            + paragraph(
                f"Along it, {coloured(named(a) + ' of A', A)} and {coloured(named(b) + ' of B', B)} face each other."
            ),
            source=trace.source_features,
            shapes=(*both, Arrows(segment(a.mean(axis=0), a.mean(axis=0) + 0.5 * pair.size * trace.normal), NEW)),
            beside=flat_both,
            caption=CAPTION,
            faces_viewer=True,
            opacity=0.25,
        )
    ]
    if trace.reference:
        reference, incident, ink, other_ink = (a, b, A, B) if trace.reference == "a" else (b, a, B, A)
        other = "B" if trace.reference == "a" else "A"
        found.append(
            Slide(
                title="Reference and incident",
                text=paragraph(
                    f"The face of {coloured(trace.reference.upper(), ink)} is the more nearly at right angles to the normal: it",
                    "is the <b>reference face</b>.",
                    f"What faces it of {coloured(other, other_ink)} is <b>incident</b>, and is cut to the outline of the",
                    "reference, one side after the other.",
                )
                + paragraph("The normal of the contact is that of the reference face:")
                + display("n =", trace.reference_normal),
                source=trace.source_face,
                shapes=(*polygon(reference, ink, 0.7, 5.0), *polygon(incident, other_ink)),
                beside=(*polygon(flat(reference), ink, 0.4, 5.0), *polygon(flat(incident), other_ink, 0.15)),
                caption=CAPTION,
                faces_viewer=True,
                opacity=0.25,
            )
        )
        found += _cuts(pair, trace, flat, reference, ink, other_ink)
    return [*found, _points(trace, flat, both, flat_both)]


def _cuts(pair: Pair, trace: ClipTrace, flat: Flat, reference: Points, ink: Colour, other_ink: Colour) -> list[Slide]:
    found = []
    for i, cut in enumerate(trace.cuts, 1):
        outward = cut.outward.astype(np.float64)
        height = (cut.before.astype(np.float64) - cut.corner) @ outward
        beyond = int((height > 0).sum())
        text = paragraph(
            f"Side {i} of the reference face is a plane, {formula('p')} a point of it and {formula('m')} its normal, away from the face:"
        )
        text += display("p =", cut.corner) + display("m =", outward)
        text += paragraph(f"Points beyond it, {formula('(x − p) · m > 0')}: {beyond} of {len(cut.before)}.")
        if beyond:
            text += paragraph(
                f"What lies beyond is {coloured('cut off', DROPPED)}; where an edge crosses the plane there is a new corner.",
                f"{len(cut.after)} points are left.",
            )
        else:
            text += paragraph("Nothing is cut off.")
        start, end = (corner.astype(np.float64) for corner in (cut.corner, trace.cuts[i % len(trace.cuts)].corner))
        wall = square((start + end) / 2, outward, max(0.5 * float(np.linalg.norm(end - start)), 0.2 * pair.size))
        side = np.array([start - 0.12 * (end - start), end + 0.12 * (end - start)])
        gone = cut.before[height > 0]
        found.append(
            Slide(
                title=f"Cut {i} of {len(trace.cuts)}",
                text=text,
                source=cut.source,
                needle="_cut(",
                shapes=(
                    *polygon(reference, ink, 0.2, 2.0),
                    *polygon(cut.after, SIMPLEX, 0.6, 4.0),
                    Dots(gone, DROPPED),
                    Lines(ring(wall), NEW, 2.0),
                ),
                beside=(
                    *polygon(flat(reference), ink, 0.1, 2.0),
                    Lines(ring(flat(cut.before)), other_ink, 1.5),
                    *polygon(flat(cut.after), SIMPLEX, 0.35, 4.0),
                    Dots(flat(gone), DROPPED),
                    Lines(flat(side)[None], NEW, 3.0),
                ),
                caption=CAPTION,
                faces_viewer=True,
                opacity=0.25,
            )
        )
    if trace.clipped is not None and trace.depths is not None and trace.kept is not None:
        rows = "".join(
            f"<tr><td>{i}</td><td>{length(abs(depth))} {'deep' if depth >= 0 else 'apart'}</td><td>{KEPT[bool(kept)]}</td></tr>"
            for i, (depth, kept) in enumerate(zip(trace.depths, trace.kept, strict=True), 1)
        )
        kept, dropped = trace.clipped[trace.kept].astype(np.float64), trace.clipped[~trace.kept].astype(np.float64)
        found.append(
            Slide(
                title="How deep is what is left?",
                text=paragraph(
                    "Each corner that is left is measured against the plane of the reference face. Those below it, or hardly above, touch:"
                )
                + f'<table style="width:100%"><tbody>{rows}</tbody></table>',
                source=trace.source_depth,
                shapes=(*polygon(reference, ink, 0.2, 2.0), Dots(kept, NEW, 1.3), Dots(dropped, DROPPED)),
                beside=(
                    *polygon(flat(reference), ink, 0.15, 2.0),
                    Dots(flat(kept), NEW, 1.3),
                    Dots(flat(dropped), DROPPED),
                    *(Label(str(i), place) for i, place in enumerate(flat(trace.clipped), 1)),
                ),
                caption=CAPTION,
                faces_viewer=True,
                opacity=0.25,
            )
        )
    return found


def _points(trace: ClipTrace, flat: Flat, both: Marks, flat_both: Marks) -> Slide:
    assert trace.points is not None
    assert trace.point_depths is not None
    points = trace.points.astype(np.float64)
    text = (
        ""
        if trace.reference
        else paragraph(
            "No face parts the two as well as the normal does: contact is where edges run side by side, else at one point."
        )
    )
    text += paragraph(
        f"<b>{len(points)} contact point{'s' if len(points) != 1 else ''}</b>, midway between the two surfaces:"
    )
    for point, depth in zip(points, trace.point_depths, strict=True):
        text += display("x =", point, ", depth", float(depth))
    return Slide(
        title=f"Verdict: {len(points)} contact point{'s' if len(points) != 1 else ''}",
        text=text,
        source=trace.source_point,
        shapes=(*both, Dots(points, CLOSEST, 1.4)),
        beside=(*flat_both, Dots(flat(points), CLOSEST, 1.4)),
        caption=CAPTION,
        faces_viewer=True,
        opacity=0.25,
    )
