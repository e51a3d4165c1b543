"""The trace of the separating axis test: each axis, what the two shapes cover of it, and the best so far."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from atlasphys.engine.narrowphase.gjk import difference_support
from atlasphys.engine.narrowphase.pair import place
from atlasphys.explainer.events import Trace, Vector, length, vector
from atlasphys.explainer.moment import Moment
from atlasphys.explainer.plain import Note, plain, recording


@dataclass(frozen=True, eq=False)
class Axis:
    """One axis that was tried."""

    of: str
    """``"face of a"``, ``"face of b"`` or ``"edges"``."""
    a: int
    """Number of the face or edge of the first shape (of a box: of its axis); −1 if it has no part in it."""
    b: int
    """The same of the second shape."""
    axis: Vector
    """Unit vector from A to B."""
    a_to: float
    """How far A reaches along it [m], from A's origin."""
    b_from: float
    """Where B begins along it [m]. B is apart from A by ``b_from − a_to``; negative: they overlap by so much."""
    distance: float
    """What the test found: this, or a part of it that was enough to tell that the axis is worse."""
    best: float
    """The greatest distance of the axes before [m], of the same shape's faces where the two are compared afterwards; −∞ for the first."""
    taken: bool
    """Whether it is the best from here on: it has to be better, an axis of B's faces or of edges by more than the bias in favour of faces of A."""
    source: str
    """The line of the engine."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SatTrace(Trace):
    """What the separating axis test did. Points as in ``GjkTrace``."""

    axes: tuple[Axis, ...] = ()
    parallel: int = 0
    """Pairs of edges that were left out as parallel."""
    distance: float = 0.0
    """Along the best axis [m]; negative where the shapes overlap."""
    normal: Vector | None = None
    """The best axis."""
    on_a: Vector | None = None
    """The point of A in contact or nearest."""
    on_b: Vector | None = None
    """The point of B."""
    limit: float = 0.0
    """Distance from which on a pair has no contact [m]."""
    source_end: str = ""
    """The line of the engine that gave the answer."""

    def lines(self) -> Iterator[str]:
        """The story."""
        yield "SAT: along which axis are the two farthest apart, or do they overlap least?"
        for i, axis in enumerate(self.axes):
            who = {"face of a": f"face {axis.a + 1} of A", "face of b": f"face {axis.b + 1} of B"}.get(
                axis.of, f"edges {axis.a + 1} of A and {axis.b + 1} of B"
            )
            gap = axis.b_from - axis.a_to
            told = f"apart by {length(gap)}" if gap > 0 else f"overlap {length(-gap)}"
            mark = "  best so far" if axis.taken else ""
            yield f"{i + 1}. {who}, {vector(axis.axis)}: A to {length(axis.a_to)}, B from {length(axis.b_from)}: {told}{mark}   [{axis.source}]"
        if self.parallel:
            yield f"{self.parallel} pairs of edges are parallel and left out: faces bound the overlap."
        if not any(axis.of == "edges" for axis in self.axes) and self.distance >= self.limit:
            yield "No edges were tried: the faces have shown that the two are apart by more than the margin."
        word = "apart by" if self.distance > 0 else "overlap"
        yield f"Best: {vector(self.normal)}, {word} {length(abs(self.distance))}, from {vector(self.on_a)} on A to {vector(self.on_b)} on B."


def read(notes: list[Note], moment: Moment, boxes: bool) -> SatTrace:
    """The trace, from the notes of ``box_axes`` (``boxes``) or ``polyhedra_axes``."""
    result = next(note for note in notes if note.kind == "sat.result")
    contacts = moment.one_pair()
    with recording():
        pair, _ = plain(place)(moment.before.bodies, moment.before.colliders, moment.shapes, contacts, 0)
    axes = []
    of, faces = "", ("face of a", "face of b")
    for i, note in enumerate(notes):
        if note.kind == "sat.faces":
            of = note["of"]
        elif note.kind in ("sat.axis", "sat.face"):
            taken = notes[i + 1].kind == "sat.best"
            side = note["of"] if note.kind == "sat.axis" else of
            a = note["face"] if note.kind == "sat.face" and side == faces[0] else note.values.get("a", -1)
            b = note["face"] if note.kind == "sat.face" and side == faces[1] else note.values.get("b", -1)
            backwards = note["axis"] @ np.array(pair[4]) < 0 if boxes else side == faces[1]
            axis = note["axis"] / np.linalg.norm(note["axis"]) * (-1 if backwards else 1)
            with recording():
                w, on_a = plain(difference_support)(moment.shapes, pair, tuple(axis))
            a_to, b_from = float(np.dot(axis, on_a)), float(np.dot(axis, np.subtract(on_a, w)))
            axes.append(Axis(side, a, b, axis, a_to, b_from, note["distance"], note["best"], taken, note.source))
    return SatTrace(
        axes=tuple(axes),
        parallel=sum(note.kind == "sat.parallel" for note in notes),
        distance=result["distance"],
        normal=result["normal"],
        on_a=result["on_a"],
        on_b=result["on_b"],
        limit=result["limit"],
        source_end=result.source,
    )
