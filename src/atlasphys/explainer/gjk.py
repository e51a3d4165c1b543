"""The trace of GJK: from one support point of A − B to the next, until the verdict."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from atlasphys.engine.narrowphase.gjk import WEIGHT
from atlasphys.explainer.events import Points, Trace, Vector, length, listed, number, vector
from atlasphys.explainer.plain import Note

SIMPLEX = ("nothing", "point", "line", "triangle", "tetrahedron")
VERDICTS = ("separated", "touching", "overlapping")

REASONS = {
    "beyond limit": "A − B lies beyond the plane through the support point by more than is asked for: how far exactly does not matter",
    "converged": "the support point is no nearer to the origin than the simplex, up to round-off: the simplex holds the closest point of A − B",
    "known point": "the support point is one of the simplex already: there is no point farther against the origin",
    "inside": "the origin lies inside the tetrahedron, and so inside A − B",
    "on the boundary": "the origin lies on the simplex, up to round-off",
    "round-off": "the simplex came no nearer to the origin: round-off has stopped the descent",
    "": "the greatest number of iterations was reached",
}


@dataclass(frozen=True, eq=False)
class Step:
    """One iteration: a direction, the support point there, and what becomes of the simplex."""

    direction: Vector
    """Where the support point is looked for: from the closest point of the simplex to the origin; any length."""
    support_a: Vector
    """The point of A farthest along it."""
    support_b: Vector
    """The point of B farthest against it."""
    point: Vector
    """The support point of A − B: their difference."""
    before: Points
    """(0 to 3, 3) the simplex before."""
    simplex: Points
    """(1 to 4, 3) the simplex after."""
    weights: npt.NDArray[np.floating]
    """Barycentric weights of the closest point, for each point of ``before`` and the new one. Those of no weight are dropped; empty in a step in
    which the search ends before the point is taken in."""
    case: str
    """Which feature of the line, triangle or tetrahedron is closest to the origin, and what is dropped."""
    closest: Vector | None
    """The point of the simplex closest to the origin."""
    distance: float
    """Its distance [m]: not less than that of the cores. Where the simplex did not change, that of the step before."""
    source: str
    """The line of the engine that asked for the support point."""
    source_weights: str
    """The line that weighed the points and dropped some; empty where the search ended before."""


@dataclass(frozen=True, kw_only=True, eq=False)
class GjkTrace(Trace):
    """What GJK did. Points are along the world's axes, from the origin of the first shape; round shapes are their cores."""

    shapes: tuple[str, str] = ("", "")
    """The first and the second shape, A and B."""
    steps: tuple[Step, ...] = ()
    verdict: str = ""
    """``"separated"``, ``"touching"`` or ``"overlapping"``, of the cores."""
    reason: str = ""
    """What ended the search, in words."""
    distance: float = 0.0
    """Distance of the cores [m]; 0 unless they are separated. Where the search ended beyond its limit: a lower bound."""
    normal: Vector | None = None
    """Unit normal from A to B, of separated cores."""
    on_a: Vector | None = None
    """The point of A closest to B, of separated cores."""
    on_b: Vector | None = None
    """The point of B closest to A, of separated cores."""
    radii: tuple[float, float] = (0.0, 0.0)
    """Radii about the cores [m]."""
    source_end: str = ""
    """The line of the engine that ended the search."""

    def lines(self) -> Iterator[str]:
        """The story."""
        a, b = self.shapes
        yield f"GJK: A is {a}, B is {b}. Does A − B contain the origin, and if not, how far is it?"
        for i, step in enumerate(self.steps):
            yield f"{i + 1}. look along {vector(step.direction)}   [{step.source}]"
            yield f"   support: A {vector(step.support_a)} − B {vector(step.support_b)} = {vector(step.point)}"
            if step.case:
                yield f"   {step.case}"
            if step.closest is not None:
                yield f"   closest to the origin: {vector(step.closest)}, {length(step.distance)} away"
        yield f"Verdict: the {'cores' if any(self.radii) else 'shapes'} are {self.verdict}: {self.reason}."
        if self.normal is not None:
            yield f"Distance {length(self.distance)} along {vector(self.normal)}, from {vector(self.on_a)} on A to {vector(self.on_b)} on B."
        if any(self.radii):
            yield f"Radii about the cores: {length(self.radii[0])} and {length(self.radii[1])}."


def read(notes: list[Note], shapes: tuple[str, str], radii: tuple[float, float]) -> GjkTrace:
    """The trace, from the notes of ``gjk`` and ``core_contact``."""
    steps: list[Step] = []
    simplex: Points = np.empty((0, 3))
    distance, end, source_end, result = float("inf"), "", "", None
    found = [note for note in notes if note.kind.startswith(("gjk.", "core."))]
    for i, note in enumerate(found):
        if note.kind == "gjk.support":
            tried = found[i + 1] if found[i + 1].kind == "gjk.weights" else None
            closest = None
            before = simplex
            weights = np.empty(0)
            case = f"the simplex stays a {SIMPLEX[len(before)]}"
            if tried is not None:
                weights = tried["simplex"][:, WEIGHT]
                simplex = tried["simplex"][weights > 0, :3]
                case = _case(weights)
                closest = found[i + 2]["point"]
                distance = float(np.linalg.norm(closest))
            step = Step(
                note["direction"], note["on_a"], note["on_a"] - note["point"], note["point"], before, simplex, weights, case,
                closest, distance, note.source, tried.source if tried is not None else "",
            )  # fmt: skip
            steps.append(step)
        elif note.kind == "gjk.end":
            end, source_end = note["reason"], note.source
        elif note.kind == "gjk.result":
            result = note
    assert result is not None
    verdict = VERDICTS[result["status"]]
    common = GjkTrace(
        shapes=shapes, steps=tuple(steps), verdict=verdict, reason=REASONS[end], radii=radii, source_end=source_end
    )
    if verdict != "separated":
        return common
    answer = next(note for note in found if note.kind == "core.result")
    return replace(
        common, distance=answer["distance"], normal=answer["normal"], on_a=answer["on_a"], on_b=answer["on_b"]
    )


def _case(weights: npt.NDArray[np.floating]) -> str:
    count = len(weights)
    names = ["a new point" if i == count - 1 else f"point {i + 1}" for i in range(count)]
    kept = [names[i].replace("a new", "the new") for i in range(count) if weights[i] > 0]
    dropped = [names[i].replace("a new", "the new") for i in range(count) if not weights[i] > 0]
    shown = ", ".join(number(float(weight)) for weight in weights)
    if count == 1:
        return "point: the simplex begins with it"
    if not dropped:
        place = {2: "between its ends", 3: "over its inside", 4: "inside it"}[count]
        return f"{SIMPLEX[count]}: the origin is {place} (weights {shown} are all positive): all points stay"
    feature = {1: "vertex", 2: "edge", 3: "face"}[len(kept)]
    return f"{SIMPLEX[count]}: closest to the origin is the {feature} of {listed(kept)} (weights {shown}); {listed(dropped)} is dropped".replace(
        " and the new point is dropped", " and the new point are dropped"
    )
