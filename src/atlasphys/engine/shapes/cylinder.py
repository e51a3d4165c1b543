"""The cylinder."""

import math
from dataclasses import dataclass
from typing import ClassVar

from atlasphys.engine.shapes import arguments
from atlasphys.engine.shapes.shape import Matrix, Shape, diagonal
from atlasphys.engine.shapes.table import CYLINDER, RIM_POINTS


@dataclass(frozen=True, slots=True)
class Cylinder(Shape):
    """A circular cylinder along y, about the origin.

    Args:
        radius: radius [m], 1e-6 to 1e6.
        length: full length along y [m], 1e-6 to 1e6.

    Raises:
        InvalidArgumentError: either is not such a number.
    """

    radius: float
    length: float

    kind: ClassVar[int] = CYLINDER

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", arguments.length("radius", self.radius))
        object.__setattr__(self, "length", arguments.length("length", self.length))

    @property
    def sizes(self) -> tuple[float, ...]:
        """Radius, half length."""
        return self.radius, 0.5 * self.length

    @property
    def feature_points(self) -> int:
        """Its ends are felt at points of the rim."""
        return RIM_POINTS

    @property
    def volume(self) -> float:
        """π r² l [m³]."""
        return math.pi * self.radius**2 * self.length

    def inertia(self, density: float = 1.0) -> Matrix:
        """m r²/2 about y, m (3 r² + l²)/12 across [kg m²]."""
        mass, r2 = density * self.volume, self.radius**2
        across = mass * (3.0 * r2 + self.length**2) / 12.0
        return diagonal(across, 0.5 * mass * r2, across)
