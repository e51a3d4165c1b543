"""What all shapes have in common."""

from abc import ABC, abstractmethod
from typing import ClassVar

from atlasphys.engine.shapes.polyhedron import Polyhedron

Vector = tuple[float, float, float]
Matrix = tuple[Vector, Vector, Vector]


class Shape(ABC):
    """A solid in its own frame: an immutable value, equal to any other shape of the same kind and sizes.

    The table of shapes reads ``kind``, ``sizes``, ``feature_points`` and ``polyhedron``; the mass properties read
    the rest.
    """

    __slots__ = ()

    kind: ClassVar[int]
    """The kind's number in the table of shapes."""

    @property
    @abstractmethod
    def sizes(self) -> tuple[float, ...]:
        """The size parameters, at most four, as ``Shapes.size`` lists them [m]."""

    @property
    @abstractmethod
    def feature_points(self) -> int:
        """The most points that one supporting feature can have."""

    @property
    def polyhedron(self) -> Polyhedron | None:
        """Vertices, faces and edges; None for shapes that are not polyhedra."""
        return None

    @property
    @abstractmethod
    def volume(self) -> float:
        """Volume [m³]."""

    @property
    def center_of_mass(self) -> Vector:
        """Centre of mass in the shape's own frame, at uniform density [m]."""
        return 0.0, 0.0, 0.0

    @abstractmethod
    def inertia(self, density: float = 1.0) -> Matrix:
        """Inertia tensor about the centre of mass in the axes of the shape's own frame [kg m²].

        Args:
            density: uniform density [kg/m³]. Default: 1.
        """


def diagonal(x: float, y: float, z: float) -> Matrix:
    """The tensor of a shape whose own axes are its principal axes."""
    return (x, 0.0, 0.0), (0.0, y, 0.0), (0.0, 0.0, z)
