"""The trace of the manifold: which points are kept, which of last step's they go on from, which impulses are carried over."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from atlasphys.engine.manifold.build import build_manifolds
from atlasphys.engine.state.contacts import Contacts
from atlasphys.engine.state.manifolds import NORMAL_IMPULSE, POINT_COLUMNS, Manifolds, empty_manifolds
from atlasphys.explainer.events import Points, Trace, length, number
from atlasphys.explainer.moment import Moment
from atlasphys.explainer.plain import plain, recording

WHY = {
    "deepest": "the deepest, {}",
    "farthest": "the farthest from it, {}",
    "triangle": "makes the largest triangle with the two, twice {}",
    "other side": "adds most area on another side, twice {}",
}


@dataclass(frozen=True, eq=False)
class Kept:
    """A point that reduction keeps."""

    index: int
    """Which of the contact points."""
    why: str
    """``"deepest"``, ``"farthest"``, ``"triangle"`` or ``"other side"``."""
    value: float
    """Its depth [m], squared distance [m²], or twice the area [m²]."""
    source: str
    """The line of the engine."""


@dataclass(frozen=True, eq=False)
class Match:
    """One look for the point of last step from which a new point goes on."""

    point: int
    """The new point."""
    by: str
    """``"feature"``: among those of the same features; ``"place"``: among those left, by distance alone."""
    old: int
    """The old point; −1 if none is near enough."""
    distance: float
    """Its distance as seen from either body, the lesser [m]; NaN if there is none."""
    source: str
    """The line of the engine."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ManifoldTrace(Trace):
    """What became of the pair's contact points."""

    depths: npt.NDArray[np.floating] | None = None
    """(n,) depth of each contact point [m]."""
    from_a: Points | None = None
    """(n, 3) the points as seen from the centre of mass of the body of the lower row."""
    reduction: tuple[Kept, ...] = ()
    """Why points are kept, where there are more than four."""
    kept: tuple[int, ...] = ()
    """The points that the manifold keeps."""
    old_points: int = 0
    """Points that the pair had in the step before."""
    matches: tuple[Match, ...] = ()
    origin: tuple[int, ...] = ()
    """For each point of the manifold the old point that it goes on from, or −1."""
    impulses: npt.NDArray[np.floating] | None = None
    """(k,) normal impulse that each point begins with [N s]."""

    def lines(self) -> Iterator[str]:
        """The story."""
        assert self.depths is not None
        assert self.impulses is not None
        count = len(self.depths)
        yield f"Manifold: {count} contact point{'s' if count > 1 else ''}, depths {', '.join(map(length, self.depths))}."
        if count <= 4:
            yield "Four and less are all kept."
        for entry in self.reduction:
            value = length(entry.value) if entry.why == "deepest" else length(math.sqrt(entry.value))
            if entry.why in ("triangle", "other side"):
                value = f"{number(abs(entry.value))} m²"
            yield f"   point {entry.index + 1}: {WHY[entry.why].format(value)}   [{entry.source}]"
        if not self.old_points:
            yield "The pair had no contact in the step before: all impulses begin at zero."
        for match in self.matches:
            found = (
                f"goes on from old point {match.old + 1}, {length(match.distance)} away"
                if match.old >= 0
                else "none near enough"
            )
            yield f"   point {match.point + 1}, by {match.by}: {found}   [{match.source}]"
        if self.old_points:
            carried = ", ".join(number(float(impulse)) for impulse in self.impulses)
            yield f"Impulses carried over: {carried} N s."


def read(moment: Moment, contacts: Contacts) -> ManifoldTrace:
    """The trace, from the notes of ``build_manifolds`` on the pair's contact points."""
    count = int(contacts.count[0])
    if count == 0:
        return ManifoldTrace(instead="The pair has no contact points, so no manifold.")
    state = moment.before
    old = _old_manifold(moment)
    old_count = len(old.a)
    new = empty_manifolds(1, state.real)
    kept, origin = np.zeros((2, 4), np.int64)
    rules = (state.environment.friction_rule, state.environment.restitution_rule)
    with recording() as notes:
        plain(build_manifolds)(
            contacts, 1, state.bodies, state.colliders, old, old_count, new, np.zeros(1, np.bool_), rules,
            state.real.type(state.tolerances.match_distance), kept, origin,
        )  # fmt: skip
    points = int(new.count[0])
    matches = []
    for note in notes:
        if note.kind == "match.point":
            distance = math.sqrt(note["squared"]) if note["old"] >= 0 else math.nan
            matches.append(Match(note["point"], note["by"], note["old"], distance, note.source))
    return ManifoldTrace(
        depths=contacts.depth[:count].copy(),
        from_a=contacts.anchor_a[:count].copy(),
        reduction=tuple(
            Kept(note["index"], note["why"], note["value"], note.source) for note in notes if note.kind == "reduce.keep"
        ),
        kept=tuple(kept[:points].tolist()),
        old_points=int(old.count[0]) if old_count else 0,
        matches=tuple(matches),
        origin=tuple(origin[:points].tolist()),
        impulses=new.points[0, NORMAL_IMPULSE::POINT_COLUMNS][:points].copy(),
    )


def _old_manifold(moment: Moment) -> Manifolds:
    """The pair's manifold of the step before: a table of one row, or of none."""
    m, n = moment.before.manifolds, moment.before.manifold_count
    rows = np.flatnonzero((m.a[:n] == moment.a) & (m.b[:n] == moment.b) & (m.count[:n] > 0))
    return Manifolds._make(column[rows] for column in m)
