"""The trace of EPA: a polytope inside A − B that grows to the boundary where the boundary is nearest."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from atlasphys.explainer.events import Points, Trace, Vector, length, vector
from atlasphys.explainer.plain import Note

REASONS = {
    "flat": "A − B is flat: it can be left at right angles, and the depth is zero",
    "no closer face": "no face that is left is nearer than the least depth found",
    "converged": "the face lies on the boundary of A − B, up to round-off",
    "": "all vertices that there is room for were spent; the least depth found is returned",
}


@dataclass(frozen=True, eq=False)
class Polytope:
    """A closed surface of triangles about the origin, inside A − B."""

    vertices: Points
    """(v, 3) points of A − B."""
    faces: npt.NDArray[np.integer]
    """(f, 3) corners, counter-clockwise as seen from outside."""
    normals: Points
    """(f, 3) outward unit normals."""
    distances: npt.NDArray[np.floating]
    """(f,) distance of each face's plane from the origin [m]; infinite for one that is too narrow for a normal."""


@dataclass(frozen=True, eq=False)
class Step:
    """One iteration: the face nearest to the origin is asked for the support point along its normal."""

    polytope: Polytope
    """The polytope before."""
    face: int
    """The face that is asked; for a step that tries the wall of a round shape the one that was asked last."""
    normal: Vector
    """Its outward unit normal: the direction in which the support point is looked for."""
    lower: float
    """Its distance from the origin: the depth is not less [m]."""
    point: Vector
    """The support point of A − B."""
    upper: float
    """How far it is along the normal: moving B so far parts the shapes, so the depth is not more [m]."""
    best: float
    """The least such bound so far [m]."""
    outcome: str
    """``"grows"``, ``"known point"`` (the vertex is there already: the face is on the boundary), ``"converged"`` or ``"wall"`` (another direction is
    tried)."""
    removed: npt.NDArray[np.intp]
    """Faces that the new vertex sees, which give way."""
    horizon: npt.NDArray[np.integer]
    """(e, 2) edges between these and the rest, as vertices: each makes a new face with the new vertex."""
    grown: Polytope | None
    """The polytope after, if it grew."""
    source: str
    """The line of the engine that asked."""
    source_horizon: str
    """The line that found the horizon, if the polytope grew."""


@dataclass(frozen=True, kw_only=True, eq=False)
class EpaTrace(Trace):
    """What EPA did. Points as in ``GjkTrace``."""

    steps: tuple[Step, ...] = ()
    reason: str = ""
    """What ended the search, in words."""
    depth: float = 0.0
    """Overlap of the cores along the normal [m]."""
    normal: Vector | None = None
    """Unit normal from A to B: moving B so far along it parts the cores."""
    on_a: Vector | None = None
    """The deepest point of A."""
    on_b: Vector | None = None
    """The deepest point of B."""
    radii: tuple[float, float] = (0.0, 0.0)
    """Radii about the cores [m]."""
    source_end: str = ""
    """The line of the engine that ended the search."""

    def lines(self) -> Iterator[str]:
        """The story."""
        yield "EPA: the simplex of GJK grows into a polytope, until its nearest face lies on the boundary of A − B."
        for i, step in enumerate(self.steps):
            polytope = step.polytope
            yield f"{i + 1}. {len(polytope.faces)} faces on {len(polytope.vertices)} vertices   [{step.source}]"
            asked = f"the nearest, face {step.face + 1}, {length(step.lower)} from the origin"
            if step.outcome == "wall":
                asked = "the wall of a round shape"
            yield f"   asked is {asked}, along {vector(step.normal)}"
            yield f"   support: {vector(step.point)}, {length(step.upper)} along it; the depth is at most {length(step.best)}"
            if step.grown is not None:
                yield (
                    f"   {length(step.upper - step.lower)} beyond the face: the new vertex sees {len(step.removed)} faces; "
                    f"{len(step.horizon)} new ones over their horizon"
                )
            elif step.outcome == "known point":
                yield "   the vertex is there already: there is nothing beyond this face"
        yield f"End: {self.reason}."
        yield f"Depth {length(self.depth)} along {vector(self.normal)}, from {vector(self.on_a)} on A to {vector(self.on_b)} on B."


def read(notes: list[Note], radii: tuple[float, float]) -> EpaTrace:
    """The trace, from the notes of ``epa`` and ``core_contact``; only where it ran."""
    steps: list[Step] = []
    polytope, end, source_end = None, "", ""
    found = [note for note in notes if note.kind.startswith("epa.")]
    for i, note in enumerate(found):
        if note.kind == "epa.polytope":
            polytope = _polytope(note)
        elif note.kind == "epa.end":
            end, source_end = note["reason"], note.source
        elif note.kind == "epa.probe":
            after = found[i + 1]
            grown = _polytope(found[i + 2]) if after.kind == "epa.horizon" else None
            outcome = {"epa.horizon": "grows", "epa.known": "known point", "epa.end": "converged"}.get(
                after.kind, "wall"
            )
            assert polytope is not None
            step = Step(
                polytope, note["face"], note["normal"], note["lower"], note["point"], note["upper"], note["best"],
                "wall" if note["wall"] else outcome,
                np.flatnonzero(after["removed"]) if grown else np.empty(0, np.intp),
                after["edges"] if grown else np.empty((0, 2), np.int32),
                grown, note.source, after.source if grown else "",
            )  # fmt: skip
            steps.append(step)
    result = next(note for note in found if note.kind == "epa.result")
    answer = next(note for note in notes if note.kind == "core.result")
    return EpaTrace(
        steps=tuple(steps),
        reason=REASONS[end],
        depth=result["depth"],
        normal=result["normal"],
        on_a=result["on_a"],
        on_b=answer["on_b"],
        radii=radii,
        source_end=source_end,
    )


def _polytope(note: Note) -> Polytope:
    return Polytope(note["vertices"][:, :3], note["corners"], note["planes"][:, :3], note["planes"][:, 3])
