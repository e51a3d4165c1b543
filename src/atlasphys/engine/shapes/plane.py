"""The plane: the boundary of a half-space."""

import math
from dataclasses import dataclass
from typing import ClassVar

from atlasphys.engine.shapes.arguments import LARGEST_LENGTH, invalid, number, vector
from atlasphys.engine.shapes.shape import Matrix, Shape, Vector
from atlasphys.engine.shapes.table import PLANE
from atlasphys.errors import InvalidArgumentError


@dataclass(frozen=True, slots=True)
class Plane(Shape):
    """A half-space: all points x with normal · x ≤ offset are solid. It has no finite mass, so its body must be static.

    Args:
        normal: direction out of the solid, of any length but zero; kept as a unit vector. Default: up, (0, 1, 0).
        offset: distance of the surface from the origin along the unit normal [m], −1e6 to 1e6. Default: 0.

    Raises:
        InvalidArgumentError: the normal is not three finite numbers or is zero, or the offset is out of range.
    """

    normal: Vector = (0.0, 1.0, 0.0)
    offset: float = 0.0

    kind: ClassVar[int] = PLANE

    def __post_init__(self) -> None:
        x, y, z = vector("normal", self.normal)
        largest = max(abs(x), abs(y), abs(z))
        if largest == 0.0:
            raise invalid("normal", "a vector that is not zero", self.normal)
        if abs(x * x + y * y + z * z - 1.0) > 4e-16:  # a unit vector is kept to the bit
            x, y, z = x / largest, y / largest, z / largest
            size = math.sqrt(x * x + y * y + z * z)
            x, y, z = x / size, y / size, z / size
        wanted = f"a distance between {-LARGEST_LENGTH:g} and {LARGEST_LENGTH:g} m"
        offset = number("offset", self.offset, wanted)
        if abs(offset) > LARGEST_LENGTH:
            raise invalid("offset", wanted, self.offset)
        object.__setattr__(self, "normal", (x + 0.0, y + 0.0, z + 0.0))  # no negative zeros
        object.__setattr__(self, "offset", offset + 0.0)

    @property
    def sizes(self) -> tuple[float, ...]:
        """Unit normal, offset."""
        return (*self.normal, self.offset)

    @property
    def feature_points(self) -> int:
        """A plane has no features: the other shape's are projected on it."""
        return 0

    @property
    def volume(self) -> float:
        """Infinite."""
        return math.inf

    @property
    def center_of_mass(self) -> Vector:
        """A plane has none."""
        raise InvalidArgumentError("a plane has no finite mass, so no centre of mass: its body must be static")

    def inertia(self, density: float = 1.0) -> Matrix:
        """A plane has none."""
        raise InvalidArgumentError("a plane has no finite mass, so no inertia: its body must be static")
