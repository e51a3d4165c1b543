"""The trace of clipping: the features that face each other, what is cut off, which points are kept."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from atlasphys.explainer.events import Points, Trace, Vector, length, vector
from atlasphys.explainer.plain import Note


@dataclass(frozen=True, eq=False)
class Cut:
    """One side plane of the reference face."""

    corner: Vector
    """A point of the plane."""
    outward: Vector
    """Its normal, away from the face."""
    before: Points
    """(n, 3) the incident feature before."""
    after: Points
    """(m, 3) what is left of it."""
    source: str
    """The line of the engine."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ClipTrace(Trace):
    """What clipping did. Points as in ``GjkTrace``."""

    normal: Vector | None = None
    """The unit normal from A to B that the search gave."""
    feature_a: Points | None = None
    """(n, 3) corners of the feature of A that faces B: a face, an edge or a point."""
    feature_b: Points | None = None
    """(n, 3) the same of B."""
    reference: str = ""
    """``"a"`` or ``"b"``: whose face the other feature is cut to; empty: no face stands in for the normal."""
    reference_normal: Vector | None = None
    """The normal of the contact: that of the reference face, or the one that was given."""
    cuts: tuple[Cut, ...] = ()
    clipped: Points | None = None
    """(n, 3) what is left after all cuts."""
    depths: npt.NDArray[np.floating] | None = None
    """(n,) depth of each of them below the reference face [m]."""
    kept: npt.NDArray[np.bool_] | None = None
    """(n,) whether it is nearer than the margin."""
    points: Points | None = None
    """(p, 3) the contact points, midway between the two surfaces."""
    point_depths: npt.NDArray[np.floating] | None = None
    """(p,) their depths [m]."""
    source_features: str = ""
    """The line of the engine that found the features,"""
    source_face: str = ""
    """the one that chose the reference,"""
    source_depth: str = ""
    """the one that measured depths,"""
    source_point: str = ""
    """and the one that wrote the points down; empty where it was not reached."""

    def lines(self) -> Iterator[str]:
        """The story."""
        assert self.feature_a is not None
        assert self.feature_b is not None
        yield f"Clipping: along {vector(self.normal)} face each other {_named(self.feature_a)} of A and {_named(self.feature_b)} of B."
        if self.reference:
            incident = "b" if self.reference == "a" else "a"
            face = f"The face of {self.reference.upper()} is the reference, with its normal {vector(self.reference_normal)}"
            yield f"{face}; what faces it of {incident.upper()} is cut to its outline."
            for i, cut in enumerate(self.cuts):
                plane = f"side plane through {vector(cut.corner)}, outward {vector(cut.outward)}"
                yield f"{i + 1}. {plane}: {_points(len(cut.before))} before, {len(cut.after)} after   [{cut.source}]"
            assert self.clipped is not None
            assert self.depths is not None
            assert self.kept is not None
            for point, depth, kept in zip(self.clipped, self.depths, self.kept, strict=True):
                yield f"   {vector(point)}: {_deep(depth)}: {'kept' if kept else 'dropped, farther than the margin'}"
        else:
            yield "No face parts the two as well as the normal does: contact is where edges run side by side, else at one point."
        assert self.points is not None
        assert self.point_depths is not None
        for point, depth in zip(self.points, self.point_depths, strict=True):
            yield f"Contact point {vector(point)}, {_deep(depth)}."


def _named(feature: Points) -> str:
    return {1: "a point", 2: "an edge"}.get(len(feature), f"a face of {len(feature)} corners")


def _points(count: int) -> str:
    return "1 point" if count == 1 else f"{count} points"


def _deep(depth: float) -> str:
    return f"{length(depth)} deep" if depth >= 0 else f"{length(-depth)} apart"


def _source(notes: list[Note]) -> str:
    return notes[0].source if notes else ""


def read(notes: list[Note], shapes: tuple[str, str], routine: str) -> ClipTrace:
    """The trace, from the notes of ``write_contact``, or why it did not run."""
    points = [note for note in notes if note.kind == "contact.point"]
    found = np.array([note["point"] for note in points]).reshape(-1, 3)
    depths = np.array([note["depth"] for note in points])
    features = next((note for note in notes if note.kind == "clip.features"), None)
    if features is None:
        a, b = shapes
        why = f"{routine} found {a} and {b} apart by more than the margin"
        if points:
            why = f"{routine} gives the points of {a} and {b} without clipping"
        return ClipTrace(
            instead=f"Nothing was clipped: {why}.", points=found, point_depths=depths, source_point=_source(points)
        )
    normal = next(note for note in notes if note.kind == "contact.normal")["normal"]
    faces = [note for note in notes if note.kind == "clip.face" and note["distance"] >= note["allowed"]]
    common = ClipTrace(
        normal=features["normal"],
        feature_a=features["on_a"],
        feature_b=features["on_b"],
        reference_normal=normal,
        points=found,
        point_depths=depths,
        source_features=features.source,
        source_point=_source(points),
    )
    if not faces:
        return common
    cuts = []
    polygon = common.feature_b if faces[0]["side"] == 0 else common.feature_a
    assert polygon is not None
    for note in notes:
        if note.kind == "clip.cut":
            outward = note["outward"] / np.linalg.norm(note["outward"])
            cuts.append(Cut(note["corner"], outward, polygon, note["polygon"], note.source))
            polygon = note["polygon"]
    measured = [note for note in notes if note.kind == "clip.depth"]
    return replace(
        common,
        reference="ab"[faces[0]["side"]],
        cuts=tuple(cuts),
        clipped=np.array([note["point"] for note in measured]).reshape(-1, 3),
        depths=np.array([note["depth"] for note in measured]),
        kept=np.array([note["kept"] for note in measured], np.bool_),
        source_face=faces[0].source,
        source_depth=_source(measured),
    )
