"""The trace of the broad phase: the bounds, which pairs were tested, which survive and why the others do not."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from atlasphys.engine.broadphase import BROADPHASES
from atlasphys.engine.broadphase.filters import bounds_overlap, is_plane, may_collide, reaches_plane
from atlasphys.engine.state.bodies import KINDS
from atlasphys.explainer.events import Points, Trace, vector
from atlasphys.explainer.moment import Moment
from atlasphys.explainer.plain import Note, plain, recording

MOST_WALKED = 200
"""Bodies of a world of which the whole walk is told; plain Python takes a second or two for so many. In larger ones only the pair is tested."""

AXES = "xyz"


@dataclass(frozen=True, eq=False)
class Test:
    """One question that the broad phase asks of a pair of bodies."""

    a: int
    """Row of the body of the lower row."""
    b: int
    """Row of the other."""
    answer: str
    """``"may collide"`` or ``"filtered"`` (neither is dynamic, or a mask does not admit a group); of bounds ``"overlap"`` or ``"apart along x"``
    (y, z); ``"reaches plane"`` or ``"above plane"``; ``"begins later"``: along the axis of the sweep, as do all after it; ``"boxes meet"``: in leaves
    of a tree."""
    source: str
    """The line of the engine."""


@dataclass(frozen=True, eq=False)
class Visit:
    """One block of eight boxes of a tree that is compared with the box around a leaf's eight."""

    leaf: int
    level: int
    """0: leaves."""
    block: int
    hits: int
    """How many of the eight it overlaps."""
    source: str
    """The line of the engine."""


@dataclass(frozen=True, kw_only=True, eq=False)
class BroadphaseTrace(Trace):
    """What the broad phase did with the pair, and, in a world that is not too large, with all others."""

    method: str = ""
    """``"tree"``, ``"sweep"`` or ``"brute"``."""
    names: tuple[str, str] = ("", "")
    pair: tuple[int, int] = (0, 0)
    """Rows of the two bodies."""
    lower: Points | None = None
    """(2, 3) least corner of each one's bounds in world coordinates, margin included [m]; a plane has none (infinite)."""
    upper: Points | None = None
    """(2, 3) greatest corner."""
    verdict: tuple[Test, ...] = ()
    """What was asked of the pair itself."""
    survives: bool = False
    """Whether the narrow phase gets the pair."""
    tests: tuple[Test, ...] = ()
    """All questions of the walk in their order, if it is told."""
    visits: tuple[Visit, ...] = ()
    """Blocks of trees, in their order."""
    survivors: npt.NDArray[np.int32] | None = None
    """(p, 2) all pairs that survive, if the walk is told."""
    bodies: int = 0
    """Bodies in the world."""

    def lines(self) -> Iterator[str]:
        """The story."""
        a, b = self.names
        assert self.lower is not None
        assert self.upper is not None
        yield f"Broad phase ({self.method}): may {a} and {b} touch?"
        for name, low, high in zip(self.names, self.lower, self.upper, strict=True):
            bounds = (
                f"bounds from {vector(low)} to {vector(high)}" if np.isfinite(low).all() else "a plane, without bounds"
            )
            yield f"   {name}: {bounds}"
        for test in self.verdict:
            yield f"   {test.answer}   [{test.source}]"
        yield f"The pair {'goes on to the narrow phase' if self.survives else 'ends here'}."
        if self.survivors is None:
            yield f"With {self.bodies} bodies the walk over all of them is not told (from {MOST_WALKED} on)."
            return
        every = self.bodies * (self.bodies - 1) // 2
        yield f"Of {every} pairs of {self.bodies} bodies {len({(t.a, t.b) for t in self.tests})} were looked at; {len(self.survivors)} survive."
        for visit in self.visits:
            met = f"leaf {visit.leaf + 1} against block {visit.block + 1} of level {visit.level}"
            yield f"   {met}: {visit.hits} of 8 boxes overlap   [{visit.source}]"
        for test in self.tests:
            yield f"   {test.a} and {test.b}: {test.answer}   [{test.source}]"


def read(moment: Moment) -> BroadphaseTrace:
    """The trace, from the notes of the world's broad phase and of its tests of the pair."""
    state, a, b = moment.before, moment.a, moment.b
    bodies, colliders, shapes = state.bodies, state.colliders, moment.shapes
    with recording() as notes:
        survives = bool(plain(may_collide)(bodies, colliders, a, b))
        if survives:
            if moment.has_plane:
                plane, other = (a, b) if plain(is_plane)(colliders, shapes, a) else (b, a)
                bounded = not plain(is_plane)(colliders, shapes, other)
                survives = bounded and bool(plain(reaches_plane)(bodies, colliders, shapes, plane, other))
            else:
                survives = bool(plain(bounds_overlap)(colliders, a, b))
    method = moment.pipeline.broadphase
    remark = ""
    if method == "tree" and moment.is_fused:
        remark = (
            "The step keeps its trees, of boxes with room to move, from step to step, and looks for pairs only when a body leaves its box; "
            "told here are trees of the tight bounds of this moment."
        )
    found = BroadphaseTrace(
        remark=remark,
        method=method,
        names=(moment.name(a), moment.name(b)),
        pair=(a, b),
        lower=colliders.lower[[a, b]],
        upper=colliders.upper[[a, b]],
        verdict=tuple(_tests(notes)),
        survives=survives,
        bodies=state.count,
    )
    if state.count > MOST_WALKED:
        return found
    with recording() as notes:
        pairs, number = plain(BROADPHASES[method])(bodies, colliders, shapes, state.count, np.zeros((64, 2), np.int32))
    visits = tuple(
        Visit(note["leaf"], note["level"], note["block"], int(note["hits"]).bit_count(), note.source)
        for note in notes
        if note.kind == "tree.visit"
    )
    return replace(found, tests=tuple(_tests(notes)), visits=visits, survivors=pairs[:number].copy())


def _tests(notes: list[Note]) -> Iterator[Test]:
    dynamic = KINDS["dynamic"]
    for note in notes:
        if note.kind == "broad.filter":
            admitted = (note["masks"][0] & note["groups"][1]) and (note["masks"][1] & note["groups"][0])
            answer = "may collide" if admitted and dynamic in note["kinds"] else "filtered"
        elif note.kind in ("broad.apart", "broad.overlap"):
            answer = "overlap" if note.kind == "broad.overlap" else f"apart along {AXES[note['axis']]}"
        elif note.kind == "broad.plane":
            answer = "reaches plane" if note["height"] <= note["offset"] else "above plane"
        elif note.kind == "sweep.stop":
            answer = "begins later"
        elif note.kind == "tree.pair":
            answer = "boxes meet"
        else:
            continue
        a, b = note["i"], note.values.get("j", note.values.get("plane"))
        yield Test(min(a, b), max(a, b), answer, note.source)
