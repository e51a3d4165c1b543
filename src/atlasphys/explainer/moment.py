"""The step that is explained: the state before it, the state after it, and the pair in question."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from atlasphys.engine.broadphase.brute import find_pairs
from atlasphys.engine.narrowphase.batch import GENERIC_KIND, KIND_OF
from atlasphys.engine.narrowphase.dispatch import EDGE_LIMITS, KIND_ROUTINES, ROUTINES, PairKernel
from atlasphys.engine.narrowphase.layout import CONVEX_CONVEX, POLYHEDRA, most_points
from atlasphys.engine.shapes.bounds import update_bounds
from atlasphys.engine.shapes.table import EDGE_COUNT, KIND, PLANE, Shapes
from atlasphys.engine.solvers import SOLVERS
from atlasphys.engine.state.contacts import Contacts, empty_contacts
from atlasphys.engine.state.manifolds import DEPTH, NORMAL, POINT_COLUMNS
from atlasphys.engine.state.pose import refresh
from atlasphys.explainer.plain import plain
from atlasphys.world.trace import trace_records
from atlasphys.world.watch import SeenStep

SHAPE_NAMES = ("sphere", "capsule", "box", "cylinder", "cone", "hull", "plane")
LANE_BODIES = "engine/narrowphase/lanes"


@dataclass(frozen=True)
class Contact:
    """What the step itself made of the pair: its manifold at the end."""

    normal: npt.NDArray[np.float64]
    depth: npt.NDArray[np.float64]
    """(points,) [m]"""
    collided: bool
    """Whether the pair was collided in this step; else its points moved with the bodies (recycled), or both sleep."""


class Moment:
    """A step of a world, for one pair of its bodies.

    Args:
        seen: the step.
        names: a name for each body.
        pair: rows of the two bodies, in any order. Default: the pair whose contact is deepest, planes last; without contact, the nearest.
    """

    def __init__(self, seen: SeenStep, names: list[str], pair: tuple[int, int] | None) -> None:
        self.before, self.after, self.pipeline, self.h = seen.before, seen.after, seen.pipeline, seen.h
        self.solved, self.sweeps, self.names = trace_records(seen.solved), seen.sweeps, names
        before = self.before
        shapes, margin = before.table.arrays, before.tolerances.margin
        refresh(before.bodies, 0, before.count)
        update_bounds(before.bodies, before.colliders, shapes, before.count, margin)
        self.a, self.b = sorted(pair) if pair is not None else self._likely_pair()

    @property
    def step(self) -> int:
        """Number of the step, from 1 on."""
        return self.after.steps

    @property
    def shapes(self) -> Shapes:
        """The table of shapes."""
        return self.before.table.arrays

    @property
    def kinds(self) -> tuple[int, int]:
        """Kinds of the two shapes, in the order of the two bodies."""
        a, b = self.before.colliders.shape[[self.a, self.b]]
        return int(self.shapes.layout[a, KIND]), int(self.shapes.layout[b, KIND])

    @property
    def first_and_second(self) -> tuple[int, int]:
        """The two bodies in the order in which the narrow phase takes them: of the lower kind of shape first."""
        return (self.b, self.a) if self.kinds[0] > self.kinds[1] else (self.a, self.b)

    @property
    def has_plane(self) -> bool:
        """Whether one of the two is a plane."""
        return PLANE in self.kinds

    def name(self, body: int) -> str:
        """Name of a body."""
        return self.names[body]

    def shape_name(self, body: int) -> str:
        """Kind of a body's shape, in a word."""
        return SHAPE_NAMES[int(self.shapes.layout[self.before.colliders.shape[body], KIND])]

    @cached_property
    def routine(self) -> PairKernel:
        """The narrow phase's routine for the pair, of those for one pair at a time."""
        a, b = self.before.colliders.shape[[self.a, self.b]]
        layout, method = self.shapes.layout, self.pipeline.narrowphase
        number = int(KIND_ROUTINES[method][layout[a, KIND], layout[b, KIND]])
        if number == POLYHEDRA and layout[a, EDGE_COUNT] * layout[b, EDGE_COUNT] > EDGE_LIMITS[method]:
            number = CONVEX_CONVEX
        return ROUTINES[number]

    def one_pair(self) -> Contacts:
        """Room for the contact points of the pair alone."""
        shape_a, shape_b = self.before.colliders.shape[[self.a, self.b]]
        slots = int(plain(most_points)(self.shapes.layout, shape_a, shape_b))
        contacts = empty_contacts(1, slots, self.before.real)
        contacts.a[0], contacts.b[0], contacts.first[1] = self.a, self.b, slots
        return contacts

    @property
    def is_fused(self) -> bool:
        """Whether the step was that of ``engine/fused``."""
        return SOLVERS[self.pipeline.solver].advance is None

    @property
    def by_lanes(self) -> bool:
        """Whether the step collides the pair eight at a time, by a body over lanes that does what ``routine`` does."""
        if not self.is_fused or KIND_OF[self.kinds] == GENERIC_KIND:
            return False
        return self.has_plane or self.pipeline.narrowphase != "gjk_epa"

    @cached_property
    def contact(self) -> Contact | None:
        """The pair's contact at the end of the step; None if it has no points."""
        m, n = self.after.manifolds, self.after.manifold_count
        rows = np.flatnonzero((m.a[:n] == self.a) & (m.b[:n] == self.b) & (m.count[:n] > 0))
        if len(rows) == 0:
            return None
        i = rows[0]
        depth = m.points[i, DEPTH::POINT_COLUMNS][: m.count[i]].astype(np.float64)
        fresh = not self.is_fused or int(m.collided[i]) == self.after.steps
        return Contact(m.contact[i, NORMAL : NORMAL + 3].astype(np.float64), depth, fresh)

    def _likely_pair(self) -> tuple[int, int]:
        m, n = self.after.manifolds, self.after.manifold_count
        live = np.flatnonzero(m.count[:n] > 0)
        kind = self.shapes.layout[self.before.colliders.shape[: self.before.count], KIND]
        if len(live):
            used = np.arange(4) < m.count[live, None]
            depth = np.where(used, m.points[live, DEPTH::POINT_COLUMNS], -np.inf).max(axis=1)
            plane = (kind[m.a[live]] == PLANE) | (kind[m.b[live]] == PLANE)
            row = live[np.lexsort((-depth, plane))[0]]
            return int(m.a[row]), int(m.b[row])
        before = self.before
        pairs, found = find_pairs(before.bodies, before.colliders, self.shapes, before.count, before.pairs)
        if found:
            return int(pairs[0, 0]), int(pairs[0, 1])
        bounded = np.flatnonzero(kind != PLANE)
        if len(bounded) < 2:
            return 0, 1
        lower, upper = before.colliders.lower[bounded], before.colliders.upper[bounded]
        apart = np.maximum(lower[:, None] - upper[None], lower[None] - upper[:, None]).max(axis=2)
        np.fill_diagonal(apart, np.inf)
        i, j = np.unravel_index(np.argmin(apart), apart.shape)
        return int(min(bounded[i], bounded[j])), int(max(bounded[i], bounded[j]))
