"""The two shapes of a pair as convex hulls, and their Minkowski difference.

For pictures only: no algorithm of the engine builds a hull. Points of curved shapes come from the engine's own support function.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
import numpy.typing as npt
from scipy.spatial import ConvexHull

from atlasphys.engine.shapes.support import rounding, support
from atlasphys.engine.shapes.table import BOX, FIRST_VERTEX, HULL, KIND, PLANE, VERTEX_COUNT
from atlasphys.explainer.moment import Moment
from atlasphys.explainer.plain import plain, recording

AROUND = 24
"""Directions about the axis of a curved shape, for its points."""

MOST_DIFFERENCES = 20_000
"""Up to so many differences of points the hull is taken of all; of more, of those of the most distant directions."""

FLAT = 1e-6
"""A set of points is flat if it is thinner than this part of its size."""

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Hull:
    """The hull of points: a solid, or, of flat sets, a polygon, a segment or a point."""

    vertices: Floats
    """(v, 3)"""
    faces: npt.NDArray[np.int64]
    """(f, 3) triangles, counter-clockwise as seen from outside; of a polygon both sides."""
    edges: npt.NDArray[np.int64]
    """(e, 2) where faces meet at an angle, or the outline."""
    is_smooth: bool = False
    """Whether the edges are only those of the drawing."""

    def placed(self, rotation: Floats, position: Floats) -> Hull:
        """The hull, turned and moved."""
        return Hull(self.vertices @ rotation.T + position, self.faces, self.edges, self.is_smooth)


def hull_of(points: npt.ArrayLike, *, is_smooth: bool = False) -> Hull:
    """The hull of points, (n, 3)."""
    points = np.unique(np.asarray(points, np.float64).reshape(-1, 3), axis=0)
    middle = points.mean(axis=0)
    _, sizes, axes = np.linalg.svd(points - middle, full_matrices=True)
    rank = int((sizes > FLAT * max(float(np.abs(points).max()), sizes[0], 1e-300)).sum()) if len(points) > 1 else 0
    none = np.empty((0, 3), np.int64), np.empty((0, 2), np.int64)
    if rank == 0:
        return Hull(points[:1], *none)
    flat = (points - middle) @ axes.T
    if rank == 1:
        ends = points[[int(flat[:, 0].argmin()), int(flat[:, 0].argmax())]]
        return Hull(ends, none[0], np.array([(0, 1)]))
    if rank == 2:
        around = ConvexHull(flat[:, :2]).vertices
        corners, count = points[around], len(around)
        fan = np.array([(0, k, k + 1) for k in range(1, count - 1)])
        outline = np.array([(k, (k + 1) % count) for k in range(count)])
        return Hull(corners, np.concatenate([fan, fan[:, ::-1]]), outline)
    found = ConvexHull(points)
    kept = np.unique(found.simplices)
    number = np.zeros(len(points), np.int64)
    number[kept] = np.arange(len(kept))
    faces = found.simplices.astype(np.int64)
    a, b, c = (points[faces[:, k]] for k in range(3))
    inward = np.einsum("fk,fk->f", np.cross(b - a, c - a), found.equations[:, :3]) < 0
    faces[inward] = faces[inward][:, ::-1]
    edges = []
    for face, others in enumerate(found.neighbors):
        for k, other in enumerate(others):
            bent = found.equations[face, :3] @ found.equations[other, :3] < 1 - 1e-9
            if other > face and bent:
                edges.append([corner for m, corner in enumerate(found.simplices[face]) if m != k])
    return Hull(points[kept], number[faces], number[np.array(edges)].reshape(-1, 2), is_smooth)


class Pair:
    """The two shapes of a story, as the narrow phase takes them: A of the lower kind. Points are along the world's axes from A's origin."""

    def __init__(self, moment: Moment) -> None:
        self.moment = moment
        state = moment.before
        self.rows = moment.first_and_second
        self.shape_rows = [int(state.colliders.shape[row]) for row in self.rows]
        self.position = state.bodies.position[list(self.rows)].astype(np.float64)
        self.rotation = state.bodies.geometry[list(self.rows), :9].astype(np.float64).reshape(2, 3, 3)
        self.kinds = [int(moment.shapes.layout[row, KIND]) for row in self.shape_rows]
        self.names = [moment.name(row) for row in self.rows]
        self.shape_names = [moment.shape_name(row) for row in self.rows]

    @property
    def offsets(self) -> Floats:
        """(2, 3) origins of the two shapes."""
        offsets: Floats = self.position - self.position[0]
        return offsets

    @cached_property
    def _cores(self) -> list[Floats]:
        return [core_points(self.moment, row) for row in self.shape_rows]

    def core(self, which: int) -> Floats:
        """(n, 3) points of a shape's core."""
        placed: Floats = self._cores[which] @ self.rotation[which].T + self.offsets[which]
        return placed

    @cached_property
    def local_bodies(self) -> tuple[Hull, Hull]:
        """The shapes with what is round about their cores, in their own frames; of a plane the part below the other shape."""
        first, second = (
            self._part_of_plane(k) if self.kinds[k] == PLANE else body_hull(self.moment, self.shape_rows[k])
            for k in range(2)
        )
        return first, second

    def _part_of_plane(self, which: int) -> Hull:
        plane = self.moment.shapes.size[self.shape_rows[which]].astype(np.float64)
        other = (self.position[1 - which] - self.position[which]) @ self.rotation[which]
        reach = 1.5 * float(self.moment.shapes.extent[self.shape_rows[1 - which]]) or 1.0
        foot = other + (plane[3] - plane[:3] @ other) * plane[:3]
        u = np.cross(plane[:3], np.eye(3)[np.abs(plane[:3]).argmin()])
        u /= np.linalg.norm(u)
        v = np.cross(plane[:3], u)
        return hull_of(foot + reach * np.array([u + v, v - u, -u - v, u - v]))

    @cached_property
    def bodies(self) -> tuple[Hull, Hull]:
        """The shapes, placed."""
        first, second = (hull.placed(self.rotation[k], self.offsets[k]) for k, hull in enumerate(self.local_bodies))
        return first, second

    @cached_property
    def radii(self) -> tuple[float, float]:
        """Radii about the cores [m]."""
        first, second = (float(plain(rounding)(self.moment.shapes, row)) for row in self.shape_rows)
        return first, second

    @cached_property
    def difference(self) -> Hull | None:
        """The Minkowski difference of the cores, A − B; None if one of the two is a plane."""
        if PLANE in self.kinds:
            return None
        a, b = self.core(0), self.core(1)
        if len(a) * len(b) > MOST_DIFFERENCES:
            ways = directions(40, 80)
            points = a[(ways @ a.T).argmax(axis=1)] - b[(-ways @ b.T).argmax(axis=1)]
        else:
            points = (a[:, None] - b[None]).reshape(-1, 3)
        return hull_of(points, is_smooth=not set(self.kinds) <= {BOX, HULL})

    @cached_property
    def size(self) -> float:
        """Size of the smaller shape [m], by which marks are drawn; of flat prisms, in the plane."""
        axes = 2 if self.is_flat else 3
        return min(float(np.ptp(hull.vertices[:, :axes], axis=0).max()) for hull in self.local_bodies)

    @cached_property
    def is_flat(self) -> bool:
        """Whether both are prisms along z about one plane z = 0, between which nothing happens across it: a lesson in the plane."""
        if not set(self.kinds) <= {BOX, HULL}:
            return False
        tolerance = 1e-6 * float(np.abs(self.core(0)).max())
        for which in range(2):
            points = self.core(which)
            heights = points[:, 2]
            if np.abs(np.abs(heights) - heights.max()).max() > tolerance:
                return False
            ends = [points[np.sign(heights) == side][:, :2] for side in (1, -1)]
            if (
                len(ends[0]) != len(ends[1])
                or np.abs(ends[0][:, None] - ends[1]).max(axis=2).min(axis=1).max() > tolerance
            ):
                return False
        return True


def core_points(moment: Moment, row: int) -> Floats:
    """(n, 3) points of the core of a shape in its own frame, the corners of a polyhedron; none of a plane."""
    shapes = moment.shapes
    kind = int(shapes.layout[row, KIND])
    if kind == PLANE:
        return np.empty((0, 3))
    if kind == BOX:
        half = shapes.size[row, :3].astype(np.float64)
        return np.array(list(product(*((-x, x) for x in half))))
    if kind == HULL:
        first, count = shapes.layout[row, FIRST_VERTEX], shapes.layout[row, VERTEX_COUNT]
        corners: Floats = shapes.vertices[first : first + count].astype(np.float64)
        return corners
    real = shapes.size.dtype.type
    with recording():
        found = [plain(support)(shapes, row, tuple(real(x) for x in way)) for way in directions(4, AROUND)]
    points: Floats = np.unique(np.array(found, np.float64), axis=0)
    return points


def body_hull(moment: Moment, row: int) -> Hull:
    """A bounded shape in its own frame."""
    points = core_points(moment, row)
    radius = float(plain(rounding)(moment.shapes, row))
    if radius == 0:
        return hull_of(points, is_smooth=int(moment.shapes.layout[row, KIND]) not in (BOX, HULL))
    around = radius * directions(AROUND // 2, AROUND)
    return hull_of((points[:, None] + around[None]).reshape(-1, 3), is_smooth=True)


def directions(levels: int, around: int) -> Floats:
    """Unit vectors in circles about y, and the two poles."""
    polar = np.linspace(0, math.pi, levels + 1)[1:-1]
    azimuth = np.arange(around) * (2 * math.pi / around)
    theta, phi = (angle.ravel() for angle in np.meshgrid(polar, azimuth, indexing="ij"))
    sheet = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)], axis=1)
    return np.concatenate([[(0.0, 1.0, 0.0), (0.0, -1.0, 0.0)], sheet])
