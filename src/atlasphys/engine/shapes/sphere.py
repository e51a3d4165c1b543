"""The sphere."""

import math
from dataclasses import dataclass
from typing import ClassVar

from atlasphys.engine.shapes.arguments import length
from atlasphys.engine.shapes.shape import Matrix, Shape, diagonal
from atlasphys.engine.shapes.table import SPHERE


@dataclass(frozen=True, slots=True)
class Sphere(Shape):
    """A ball about the origin.

    Args:
        radius: radius [m], 1e-6 to 1e6.

    Raises:
        InvalidArgumentError: the radius is not such a number.
    """

    radius: float

    kind: ClassVar[int] = SPHERE

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", length("radius", self.radius))

    @property
    def sizes(self) -> tuple[float, ...]:
        """Radius."""
        return (self.radius,)

    @property
    def feature_points(self) -> int:
        """A sphere is felt at one point."""
        return 1

    @property
    def volume(self) -> float:
        """4/3 π r³ [m³]."""
        return 4.0 / 3.0 * math.pi * self.radius**3

    def inertia(self, density: float = 1.0) -> Matrix:
        """2/5 m r² about every axis [kg m²]."""
        moment = 0.4 * density * self.volume * self.radius**2
        return diagonal(moment, moment, moment)
