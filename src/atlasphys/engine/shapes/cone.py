"""The cone."""

import math
from dataclasses import dataclass
from typing import ClassVar

from atlasphys.engine.shapes.arguments import length
from atlasphys.engine.shapes.shape import Matrix, Shape, Vector, diagonal
from atlasphys.engine.shapes.table import CONE, RIM_POINTS


@dataclass(frozen=True, slots=True)
class Cone(Shape):
    """A circular cone along y: its base at −height/2, its apex at +height/2.

    The origin is halfway up; the centre of mass is a quarter of the height above the base.

    Args:
        radius: radius of the base [m], 1e-6 to 1e6.
        height: height from base to apex [m], 1e-6 to 1e6.

    Raises:
        InvalidArgumentError: either is not such a number.
    """

    radius: float
    height: float

    kind: ClassVar[int] = CONE

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", length("radius", self.radius))
        object.__setattr__(self, "height", length("height", self.height))

    @property
    def sizes(self) -> tuple[float, ...]:
        """Radius, half height."""
        return self.radius, 0.5 * self.height

    @property
    def feature_points(self) -> int:
        """Its base is felt at points of the rim."""
        return RIM_POINTS

    @property
    def volume(self) -> float:
        """π r² h / 3 [m³]."""
        return math.pi * self.radius**2 * self.height / 3.0

    @property
    def center_of_mass(self) -> Vector:
        """On the axis, a quarter of the height above the base [m]."""
        return 0.0, -0.25 * self.height, 0.0

    def inertia(self, density: float = 1.0) -> Matrix:
        """3/10 m r² about y, 3/80 m (4 r² + h²) across, through the centre of mass [kg m²]."""
        mass, r2 = density * self.volume, self.radius**2
        across = 3.0 / 80.0 * mass * (4.0 * r2 + self.height**2)
        return diagonal(across, 0.3 * mass * r2, across)
