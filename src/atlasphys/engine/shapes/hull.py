"""The convex hull of a set of points, and the solids made with it.

Qhull (Barber, Dobkin and Huhdanpaa, "The Quickhull Algorithm for Convex Hulls", ACM TOMS 22(4), 1996) gives triangles.
Those that lie in one plane are merged into polygons, and vertices, faces and edges are put in an order of our own, so
that the result does not depend on the order of the points, nor on how Qhull cut the faces.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from numbers import Integral
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from atlasphys.engine.shapes.arguments import LARGEST_LENGTH, SMALLEST_LENGTH, invalid, length
from atlasphys.engine.shapes.polyhedron import Polyhedron, edges_of
from atlasphys.engine.shapes.shape import Matrix, Shape, Vector
from atlasphys.engine.shapes.table import HULL
from atlasphys.errors import InvalidArgumentError

COPLANAR = 1e-7
"""Points this near to one plane, as a part of the hull's extent, lie in one face; points this near to each other are
one. About what single precision can tell apart. Smaller: round-off splits flat faces. Larger: fine features are
lost."""

FLAT = 4e-7
"""A set of points thinner than this part of its extent has no inside. Above COPLANAR, or opposite faces would merge."""

_UNCLEAR = "points are too nearly flat or too near to each other for a hull: spread or thin them out"

Faces = list[tuple[int, ...]]
Points = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, init=False, repr=False)
class ConvexHull(Shape):
    """The smallest convex solid that holds all given points, which stay where they are in the shape's own frame.

    Points inside it, on its faces or edges, or given twice make no difference: hulls of equal vertices are equal.

    Args:
        points: (n, 3) at least four points, not all in one plane [m]. Coordinates from −1e6 to 1e6, extent at least
            1e-6.

    Attributes:
        vertices: the corners, sorted by x, then y, then z [m].
        faces: the vertex numbers of each face, counter-clockwise as seen from outside, the lowest first; sorted.
        planes: outward unit normal and offset (nx, ny, nz, d) of each face's plane n · x = d.

    Raises:
        InvalidArgumentError: the points are not such an array, or have no inside.
    """

    vertices: tuple[Vector, ...]
    faces: tuple[tuple[int, ...], ...] = field(compare=False)
    planes: tuple[tuple[float, float, float, float], ...] = field(compare=False)
    _volume: float = field(compare=False)
    _center: Vector = field(compare=False)
    _inertia: Matrix = field(compare=False)

    kind: ClassVar[int] = HULL

    def __init__(self, points: npt.ArrayLike) -> None:
        vertices, faces = _hull(_checked(points))
        planes = _planes(vertices, faces)
        volume, center, inertia = _integrals(vertices, faces)
        values = {
            "vertices": tuple((x, y, z) for x, y, z in vertices.tolist()),
            "faces": tuple(faces),
            "planes": tuple((x, y, z, d) for x, y, z, d in planes.tolist()),
            "_volume": volume,
            "_center": center,
            "_inertia": inertia,
        }
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def __repr__(self) -> str:
        extent = np.ptp(np.array(self.vertices), axis=0)
        size = " × ".join(f"{edge:.4g}" for edge in extent)
        return f"ConvexHull({len(self.vertices)} vertices, {len(self.faces)} faces, {size} m)"

    @property
    def sizes(self) -> tuple[float, ...]:
        """None."""
        return ()

    @property
    def feature_points(self) -> int:
        """Vertices of the face that has most."""
        return max(len(face) for face in self.faces)

    @property
    def polyhedron(self) -> Polyhedron:
        """Vertices, faces and edges as arrays."""
        return Polyhedron(
            vertices=np.array(self.vertices),
            planes=np.array(self.planes),
            face_sizes=np.array([len(face) for face in self.faces], np.int32),
            face_vertices=np.array([vertex for face in self.faces for vertex in face], np.int32),
            edges=np.array(edges_of(self.faces), np.int32),
        )

    @property
    def volume(self) -> float:
        """Volume [m³]."""
        return self._volume

    @property
    def center_of_mass(self) -> Vector:
        """Centroid [m]."""
        return self._center

    def inertia(self, density: float = 1.0) -> Matrix:
        """Inertia tensor about the centroid [kg m²]."""
        a, b, c = (tuple(density * entry for entry in row) for row in self._inertia)
        return (a[0], a[1], a[2]), (b[0], b[1], b[2]), (c[0], c[1], c[2])


def tetrahedron(radius: float) -> ConvexHull:
    """A regular tetrahedron: base level, apex up (+y), centroid at the origin.

    Args:
        radius: distance of the corners from the centroid [m].
    """
    r = length("radius", radius)
    rim, level = r * math.sqrt(8.0) / 3.0, -r / 3.0
    side = rim * math.sqrt(3.0) / 2.0
    return ConvexHull([(0.0, r, 0.0), (rim, level, 0.0), (-0.5 * rim, level, side), (-0.5 * rim, level, -side)])


def octahedron(radius: float) -> ConvexHull:
    """A regular octahedron about the origin, its corners on the axes.

    Args:
        radius: distance of the corners from the centre [m].
    """
    r = length("radius", radius)
    return ConvexHull([(r, 0, 0), (-r, 0, 0), (0, r, 0), (0, -r, 0), (0, 0, r), (0, 0, -r)])


def pyramid(sides: int, radius: float, height: float) -> ConvexHull:
    """A right pyramid along y on a regular polygon: base at −height/2, apex at +height/2.

    The origin is halfway up the axis; the centre of mass is a quarter of the height above the base.

    Args:
        sides: number of sides of the base, 3 to 1000. A corner of the base lies on +x.
        radius: distance of the base's corners from the axis [m].
        height: height from base to apex [m].
    """
    if not isinstance(sides, Integral) or isinstance(sides, bool) or not 3 <= sides <= 1000:
        raise invalid("sides", "a whole number from 3 to 1000", sides)
    r, half = length("radius", radius), 0.5 * length("height", height)
    turns = [2.0 * math.pi * k / int(sides) for k in range(int(sides))]
    # Sine and cosine differ in the last bit between systems, so they are rounded.
    base = [(r * round(math.cos(turn), 12), -half, r * round(math.sin(turn), 12)) for turn in turns]
    return ConvexHull([*base, (0.0, half, 0.0)])


def _checked(points: npt.ArrayLike) -> Points:
    """The points as an array, in lexicographic order, each once."""
    wanted = "an (n, 3) array of finite coordinates in metres, n ≥ 4"
    try:
        raw = np.asarray(points)
        if raw.dtype.kind not in "iuf":
            raise invalid("points", wanted, points)
        array = raw.astype(np.float64)
    except (TypeError, ValueError, OverflowError):
        raise invalid("points", wanted, points) from None
    if array.ndim != 2 or array.shape[1] != 3:
        raise InvalidArgumentError(f"points must be {wanted} (got an array of shape {array.shape})")
    if len(array) < 4:
        raise InvalidArgumentError(f"points must be at least 4, for fewer have no inside (got {len(array)})")
    bad = np.flatnonzero(~np.all(np.abs(array) <= LARGEST_LENGTH, axis=1))
    if len(bad):
        row = int(bad[0])
        wanted = f"finite coordinates between {-LARGEST_LENGTH:g} and {LARGEST_LENGTH:g} m"
        raise invalid(f"points[{row}]", wanted, tuple(array[row].tolist()))
    array = np.unique(array + 0.0, axis=0)
    extent = _extent(array)
    if extent < SMALLEST_LENGTH:
        raise InvalidArgumentError(
            f"points must extend over at least {SMALLEST_LENGTH:g} m along some axis: "
            f"they coincide or nearly do (got {extent:g} m)"
        )
    _refuse_flat(array, FLAT * extent)
    return array


def _extent(points: Points) -> float:
    """The longest edge of the box about the points."""
    return float(np.max(np.ptp(points, axis=0)))


def _refuse_flat(points: Points, tolerance: float) -> None:
    """Raise unless four of the points span a solid thicker than the tolerance."""
    arms = points - points[0]
    axis = arms[np.argmax(_lengths(arms))]
    axis = axis / _lengths(axis[None])[0]
    across = arms - _dots(arms, axis)[:, None] * axis
    distance = _lengths(across)
    far = np.argmax(distance)
    if distance[far] <= tolerance:
        raise InvalidArgumentError(f"points must not lie on one line (the farthest is {distance[far]:.3g} m off)")
    height = np.abs(_dots(arms, np.cross(axis, across[far] / distance[far])))
    if np.max(height) <= tolerance:
        raise InvalidArgumentError(f"points must not lie in one plane (the farthest is {np.max(height):.3g} m off)")


def _dots(rows: Points, vector: Points) -> Points:
    """Dot products of each row with a vector, without BLAS, whose rounding differs between CPUs."""
    return rows[:, 0] * vector[..., 0] + rows[:, 1] * vector[..., 1] + rows[:, 2] * vector[..., 2]


def _lengths(rows: Points) -> Points:
    return np.sqrt(_dots(rows, rows))


def _hull(points: Points) -> tuple[Points, Faces]:
    """Vertices in lexicographic order and faces in order of their vertices, each face from its lowest vertex on.

    Merging may leave vertices that are no corners (on an edge, or on a face within the tolerance). They are dropped and
    the hull is built again, until all are corners.
    """
    extent = _extent(points)
    # Qhull gets coordinates of about one: its tolerances are made for them.
    scaled = (points - 0.5 * (np.min(points, axis=0) + np.max(points, axis=0))) / extent
    while True:
        triangles = _triangles(scaled)
        kept = _distinct(scaled, np.unique(triangles))
        if len(kept) == len(scaled):
            loops = _merged(scaled, triangles)
            kept = _corners(loops)
            if len(kept) == len(scaled):
                break
        if len(kept) < 4:
            raise InvalidArgumentError(_UNCLEAR)
        points, scaled = points[kept], scaled[kept]
    _refuse_flat(points, FLAT * extent)  # what was dropped may have been all that was thick
    faces = [loop[loop.index(min(loop)) :] + loop[: loop.index(min(loop))] for loop in loops]
    return points, sorted(tuple(face) for face in faces)


def _triangles(points: Points) -> npt.NDArray[np.intp]:
    """(t, 3) triangles of the hull, counter-clockwise as seen from outside, in a fixed order."""
    from scipy.spatial import ConvexHull as Qhull  # costs 0.4 s, so not before it is needed
    from scipy.spatial import QhullError

    try:
        qhull = Qhull(points)
    except QhullError as error:
        reason = str(error).strip().splitlines()[0]
        raise InvalidArgumentError(f"points have no convex hull: {reason}") from None
    triangles = np.array(qhull.simplices, np.intp)
    a, b, c = (points[triangles[:, k]] for k in range(3))
    inward = _dots(np.cross(b - a, c - a), qhull.equations[:, :3]) < 0
    triangles[inward] = triangles[inward][:, ::-1]
    return triangles


def _distinct(points: Points, candidates: npt.NDArray[np.intp]) -> npt.NDArray[np.intp]:
    """The candidates without those that lie within the tolerance of an earlier one."""
    from scipy.spatial import cKDTree

    pairs = cKDTree(points[candidates]).query_pairs(COPLANAR)
    dropped = {max(pair) for pair in pairs}
    return np.array([candidate for k, candidate in enumerate(candidates) if k not in dropped], np.intp)


def _merged(points: Points, triangles: npt.NDArray[np.intp]) -> list[list[int]]:
    """The boundary of each region of adjacent triangles that lie in one plane, counter-clockwise.

    Regions grow from the largest triangle left, whose plane is the best known.
    """
    a, b, c = (points[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    areas = _lengths(normals)
    sides = [[(int(t[k - 1]), int(t[k])) for k in range(3)] for t in triangles]
    owner = {side: triangle for triangle, three in enumerate(sides) for side in three}
    visited = [False] * len(triangles)
    loops = []
    for seed in np.lexsort((*np.sort(triangles, axis=1).T, -areas)).tolist():
        if visited[seed]:
            continue
        if areas[seed] == 0.0:
            raise InvalidArgumentError(_UNCLEAR)
        normal, origin = normals[seed] / areas[seed], a[seed]
        region = [seed]
        visited[seed] = True
        for triangle in region:  # grows as it is walked
            for start, end in sides[triangle]:
                other = owner[end, start]
                if visited[other]:
                    continue
                height = np.abs(_dots(points[triangles[other]] - origin, normal))
                if np.max(height) <= COPLANAR and _dots(normals[other : other + 1], normal)[0] >= 0.0:
                    visited[other] = True
                    region.append(other)
        inside = {side for triangle in region for side in sides[triangle]}
        boundary = {start: end for start, end in inside if (end, start) not in inside}
        loop = [min(boundary)]
        while (vertex := boundary.pop(loop[-1], None)) is not None and vertex != loop[0]:
            loop.append(vertex)
        if vertex is None or boundary:  # not one simple loop
            raise InvalidArgumentError(_UNCLEAR)
        loops.append(loop)
    return loops


def _corners(loops: list[list[int]]) -> npt.NDArray[np.intp]:
    """The vertices at which at least three faces meet."""
    vertices, faces = np.unique(np.array([vertex for loop in loops for vertex in loop]), return_counts=True)
    return np.asarray(vertices[faces >= 3], np.intp)


def _planes(vertices: Points, faces: Sequence[Sequence[int]]) -> Points:
    """(f, 4) outward unit normal and offset of each face.

    Newell's method: the normal is the sum of the cross products of the fan from one corner; the offset is that of the
    farthest corner, so that no corner lies outside.
    """
    planes = np.empty((len(faces), 4))
    for row, face in enumerate(faces):
        corners = vertices[list(face)]
        arms = corners[1:] - corners[0]
        nx, ny, nz = (math.fsum(column) for column in np.cross(arms[:-1], arms[1:]).T.tolist())
        size = math.sqrt(nx * nx + ny * ny + nz * nz)
        normal = np.array((nx / size, ny / size, nz / size)) + 0.0
        planes[row, :3] = normal
        planes[row, 3] = np.max(_dots(corners, normal))
    return planes


def _integrals(vertices: Points, faces: Sequence[Sequence[int]]) -> tuple[float, Vector, Matrix]:
    """Volume, centroid, and inertia tensor about the centroid at unit density.

    The solid is cut into tetrahedra from an inner point to the triangles of its faces. In a tetrahedron of volume V
    with corners 0, a, b, c, ∫ x = V s/4 and ∫ x xᵀ = V (a aᵀ + b bᵀ + c cᵀ + s sᵀ)/20, with s = a + b + c (Tonon,
    "Explicit Exact Formulas for the 3-D Tetrahedron Inertia Tensor", J. Math. Stat. 1(1), 2004). Sums are exactly
    rounded.
    """
    origin = 0.5 * (np.min(vertices, axis=0) + np.max(vertices, axis=0))
    fans = [(face[0], face[k], face[k + 1]) for face in faces for k in range(1, len(face) - 1)]
    a, b, c = (vertices[[fan[k] for fan in fans]] - origin for k in range(3))
    parts = _dots(np.cross(a, b), c) / 6.0
    s = a + b + c
    volume = math.fsum(parts.tolist())
    m = [math.fsum((parts * s[:, i] / 4.0).tolist()) / volume for i in range(3)]

    def second(i: int, j: int) -> float:
        """∫ (x − m)_i (x − m)_j."""
        products = a[:, i] * a[:, j] + b[:, i] * b[:, j] + c[:, i] * c[:, j] + s[:, i] * s[:, j]
        return math.fsum((parts * products / 20.0).tolist()) - volume * m[i] * m[j]

    xx, yy, zz, xy, xz, yz = (second(i, j) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
    xy, xz, yz = 0.0 - xy, 0.0 - xz, 0.0 - yz
    inertia = (yy + zz, xy, xz), (xy, zz + xx, yz), (xz, yz, xx + yy)
    x, y, z = (float(origin[i]) + m[i] for i in range(3))
    return volume, (x, y, z), inertia
