"""The box."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from atlasphys.engine.shapes.arguments import entries, length
from atlasphys.engine.shapes.polyhedron import Polyhedron, edges_of
from atlasphys.engine.shapes.shape import Matrix, Shape, Vector, diagonal
from atlasphys.engine.shapes.table import BOX

# Vertex 4 i + 2 j + k lies on the positive side of x, y, z where i, j, k is 1; faces are −x, +x, −y, +y, −z, +z.
_CORNERS = np.array([(x, y, z) for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
_FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
_NORMALS = np.array([(-1.0, 0, 0), (1, 0, 0), (0, -1, 0), (0, 1, 0), (0, 0, -1), (0, 0, 1)])
_FACE_SIZES = np.full(6, 4, np.int32)
_FACE_VERTICES = np.array(_FACES, np.int32).ravel()
_EDGES = np.array(edges_of(_FACES), np.int32)


@dataclass(frozen=True, slots=True)
class Box(Shape):
    """A rectangular box about the origin.

    Args:
        size: full edge lengths along x, y and z [m], each 1e-6 to 1e6.

    Raises:
        InvalidArgumentError: the size is not three such numbers.
    """

    size: Vector

    kind: ClassVar[int] = BOX

    def __post_init__(self) -> None:
        edges = entries("size", self.size, 3, "three lengths (x, y, z) in metres")
        object.__setattr__(self, "size", tuple(length(f"size[{i}]", edge) for i, edge in enumerate(edges)))

    @property
    def sizes(self) -> tuple[float, ...]:
        """Half sizes."""
        x, y, z = self.size
        return 0.5 * x, 0.5 * y, 0.5 * z

    @property
    def feature_points(self) -> int:
        """A face has four corners."""
        return 4

    @property
    def polyhedron(self) -> Polyhedron:
        """Eight vertices, six faces, twelve edges."""
        half = np.array(self.sizes)
        planes = np.empty((6, 4))
        planes[:, :3] = _NORMALS
        planes[:, 3] = np.repeat(half, 2)
        return Polyhedron(_CORNERS * half, planes, _FACE_SIZES, _FACE_VERTICES, _EDGES)

    @property
    def volume(self) -> float:
        """The product of the edges [m³]."""
        x, y, z = self.size
        return x * y * z

    def inertia(self, density: float = 1.0) -> Matrix:
        """m (y² + z²) / 12 about x, and so on [kg m²]."""
        x, y, z = (edge * edge for edge in self.size)
        twelfth = density * self.volume / 12.0
        return diagonal(twelfth * (y + z), twelfth * (z + x), twelfth * (x + y))
