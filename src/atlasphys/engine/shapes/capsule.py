"""The capsule."""

import math
from dataclasses import dataclass
from typing import ClassVar

from atlasphys.engine.shapes import arguments
from atlasphys.engine.shapes.shape import Matrix, Shape, diagonal
from atlasphys.engine.shapes.table import CAPSULE


@dataclass(frozen=True, slots=True)
class Capsule(Shape):
    """A cylinder along y with a half ball on each end: all points within ``radius`` of a segment about the origin.

    Args:
        radius: radius [m], 1e-6 to 1e6.
        length: length of the segment, that is, between the centres of the caps [m], 1e-6 to 1e6.

    Raises:
        InvalidArgumentError: either is not such a number.
    """

    radius: float
    length: float

    kind: ClassVar[int] = CAPSULE

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", arguments.length("radius", self.radius))
        object.__setattr__(self, "length", arguments.length("length", self.length))

    @property
    def sizes(self) -> tuple[float, ...]:
        """Radius, half length."""
        return self.radius, 0.5 * self.length

    @property
    def feature_points(self) -> int:
        """The two ends of its side."""
        return 2

    @property
    def volume(self) -> float:
        """π r² l + 4/3 π r³ [m³]."""
        return math.pi * self.radius**2 * (self.length + 4.0 / 3.0 * self.radius)

    def inertia(self, density: float = 1.0) -> Matrix:
        """A cylinder, and two half balls moved out by the parallel-axis theorem [kg m²].

        A half ball of mass m has its centroid 3/8 r above its flat side and 83/320 m r² about axes through the centroid
        and along that side, so two of mass m in all, with flat sides l apart, have m (2/5 r² + l²/4 + 3/8 l r)
        together.
        """
        r, l = self.radius, self.length  # noqa: E741
        cylinder = density * math.pi * r * r * l
        caps = density * 4.0 / 3.0 * math.pi * r**3
        across = cylinder * (r * r / 4.0 + l * l / 12.0) + caps * (0.4 * r * r + l * l / 4.0 + 0.375 * l * r)
        along = cylinder * r * r / 2.0 + caps * 0.4 * r * r
        return diagonal(across, along, across)
