"""The table of shapes that kernels read: each distinct shape once, however many colliders use it.

A polyhedron (box or hull) lists its vertices, faces and edges; every shape has four size parameters.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from atlasphys.engine.shapes.polyhedron import bluntness
from atlasphys.engine.simd.by_address import by_address

if TYPE_CHECKING:
    from atlasphys.engine.shapes.polyhedron import Polyhedron
    from atlasphys.engine.shapes.shape import Shape

SPHERE, CAPSULE, BOX, CYLINDER, CONE, HULL, PLANE = range(7)
"""Values of the column KIND. The order is that of the roles in a pair: sphere before capsule before box …; planes
come last."""

KIND, FIRST_VERTEX, VERTEX_COUNT, FIRST_FACE, FACE_COUNT, FIRST_EDGE, EDGE_COUNT, FEATURE_POINTS = range(8)
"""Columns of ``Shapes.layout``. FEATURE_POINTS is the most points that one supporting feature (face, edge or vertex)
can have."""

RIM_POINTS = 8
"""Points by which the rim of a cylinder or cone is represented where a whole disc rests on something.
Fewer: a disc tips over its octagon's sides earlier than over its rim. More: more points to clip and reduce."""


@by_address
class Shapes(NamedTuple):
    """The shapes of a world. All coordinates are in the shape's own frame."""

    layout: npt.NDArray[np.int32]
    """(s, 8) the columns KIND to FEATURE_POINTS."""
    size: npt.NDArray[np.floating]
    """(s, 4) sphere: radius. Capsule: radius, half length (along y). Box: half sizes x, y, z. Cylinder: radius, half
    length (along y). Cone: radius, half height (along y; the apex at +half height). Plane: unit normal, offset. Hull:
    none. Unused ones are 0."""
    vertices: npt.NDArray[np.floating]
    """(v, 3) vertices of the polyhedra [m]."""
    faces: npt.NDArray[np.floating]
    """(f, 4) outward unit normal n and offset d of each face's plane n · x = d."""
    face_range: npt.NDArray[np.int32]
    """(f, 2) first entry in ``face_vertices`` and number of entries of each face."""
    face_vertices: npt.NDArray[np.int32]
    """(k,) vertex rows of the faces, counter-clockwise as seen from outside."""
    extent: npt.NDArray[np.floating]
    """(s,) at least the greatest distance of a point of the shape from its origin [m]; planes: 0."""
    bluntness: npt.NDArray[np.floating]
    """(s,) polyhedra: cosine of the greatest angle between a face's normal and the middle of the normals at one of its vertices; others: 0."""
    edges: npt.NDArray[np.int32]
    """(e, 4) two vertex rows and the rows of the faces to the left and right of the edge (as seen from outside, from
    the first vertex to the second)."""


class ShapeTable:
    """Collects distinct shapes and turns them into arrays.

    Args:
        real: the world's precision, float32 or float64.
        shapes: shapes to begin with; their rows are in that order.
    """

    def __init__(self, real: npt.DTypeLike, shapes: Iterable[Shape] = ()) -> None:
        self._real = np.dtype(real)
        self._rows: dict[Shape, int] = {}
        self._polyhedra: list[Polyhedron | None] = []
        self._arrays: Shapes | None = None
        for shape in shapes:
            self.row_of(shape)

    def __len__(self) -> int:
        return len(self._rows)

    @property
    def shapes(self) -> list[Shape]:
        """The distinct shapes, in the order of their rows."""
        return list(self._rows)

    def row_of(self, shape: Shape) -> int:
        """The shape's row; equal shapes share one. Rows never change."""
        row = self._rows.get(shape)
        if row is None:
            self._polyhedra.append(shape.polyhedron)
            row = self._rows[shape] = len(self._rows)
            self._arrays = None
        return row

    def copy(self) -> ShapeTable:
        """An independent table of the same shapes in the same rows."""
        other = ShapeTable(self._real)
        other._rows, other._polyhedra, other._arrays = dict(self._rows), list(self._polyhedra), self._arrays
        return other

    @property
    def arrays(self) -> Shapes:
        """The arrays for the kernels; made anew when shapes were added since they were last asked for."""
        if self._arrays is None:
            self._arrays = self._build()
        return self._arrays

    def _build(self) -> Shapes:
        layout = np.zeros((len(self), 8), np.int32)
        size = np.zeros((len(self), 4), self._real)
        for row, shape in enumerate(self._rows):
            layout[row, KIND], layout[row, FEATURE_POINTS] = shape.kind, shape.feature_points
            sizes = shape.sizes
            size[row, : len(sizes)] = sizes

        extent = np.where(layout[:, KIND] == PLANE, 0, size[:, 0] + size[:, 1])
        owners = [row for row, polyhedron in enumerate(self._polyhedra) if polyhedron is not None]
        polyhedra = [polyhedron for polyhedron in self._polyhedra if polyhedron is not None]
        counts = np.array([(len(p.vertices), len(p.planes), len(p.edges)) for p in polyhedra], np.int32).reshape(-1, 3)
        starts = np.cumsum(counts, axis=0, dtype=np.int32) - counts
        layout[np.ix_(owners, [VERTEX_COUNT, FACE_COUNT, EDGE_COUNT])] = counts
        layout[np.ix_(owners, [FIRST_VERTEX, FIRST_FACE, FIRST_EDGE])] = starts

        extent[owners] = [np.sqrt((p.vertices**2).sum(axis=1).max()) for p in polyhedra]

        face_sizes = _joined([p.face_sizes for p in polyhedra], np.int32, ())
        face_vertices = _joined([p.face_vertices for p in polyhedra], np.int32, ())
        edges = _joined([p.edges for p in polyhedra], np.int32, (4,))
        # Vertex and face numbers become rows of the whole table.
        face_vertices += np.repeat(starts[:, 0], np.array([len(p.face_vertices) for p in polyhedra], np.int64))
        edges[:, :2] += np.repeat(starts[:, :1], counts[:, 2], axis=0)
        edges[:, 2:] += np.repeat(starts[:, 1:2], counts[:, 2], axis=0)
        first = np.cumsum(face_sizes, dtype=np.int32) - face_sizes
        return Shapes(
            layout=layout,
            size=size,
            vertices=_joined([p.vertices for p in polyhedra], self._real, (3,)),
            faces=_joined([p.planes for p in polyhedra], self._real, (4,)),
            face_range=np.stack([first, face_sizes], axis=1),
            face_vertices=face_vertices,
            extent=extent,
            bluntness=np.array([0.0 if p is None else bluntness(p) for p in self._polyhedra], self._real),
            edges=edges,
        )


def _joined(parts: list[npt.NDArray[Any]], dtype: npt.DTypeLike, row: tuple[int, ...]) -> npt.NDArray[Any]:
    """The rows of all parts, or none if there are no parts."""
    return np.concatenate([np.empty((0, *row), dtype), *parts], dtype=dtype, casting="same_kind")
