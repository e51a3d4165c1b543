"""The hinge and the fixed joint."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, ClassVar

from atlasphys.engine.joints.kinds.kind import Framed, check_axial, of_type
from atlasphys.engine.joints.part import Elastic, Motor, Part, driven
from atlasphys.engine.state.joints import AXIS, LOCK, POINT, ROTATION


@dataclass(frozen=True, slots=True)
class Hinge(Framed):
    """A hinge: the two bodies share a point and an axis, about which they turn.

    The coordinate is the angle by which b is turned against a about the axis, −π to π [rad].

    Attributes:
        limits: least and greatest angle [rad]; either may be infinite. Default: none.
        spring: a spring on the angle.
        motor: a motor on the angle.
        friction: greatest torque with which the joint resists turning [N m].
    """

    type: ClassVar[str] = "hinge"

    limits: Any = field(default=None, kw_only=True)
    spring: Elastic | None = field(default=None, kw_only=True)
    motor: Motor | None = field(default=None, kw_only=True)
    friction: float = field(default=0.0, kw_only=True)

    def __post_init__(self) -> None:
        Framed.__post_init__(self)
        check_axial(self, -math.pi, math.pi)

    def parts(self) -> list[Part]:
        """A rotation, if anything acts on it; an axis; a point."""
        frames = (self.frame_a, self.frame_b)
        turning = driven(Part(ROTATION, *frames), self.limits, self.spring, self.motor, self.friction)
        return [*turning, Part(AXIS, *frames), Part(POINT)]

    def coordinates(self) -> dict[str, Part]:
        """The angle."""
        return {"angle": Part(ROTATION, self.frame_a, self.frame_b)}


@dataclass(frozen=True, slots=True)
class Fixed(Framed):
    """A fixed joint: the two bodies keep their place and orientation against each other, rigidly or by a spring.

    Attributes:
        spring: a spring that holds them, in place of a rigid joint; its ``rest`` is 0.
    """

    type: ClassVar[str] = "fixed"
    needs_axis: ClassVar[bool] = False

    spring: Elastic | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        Framed.__post_init__(self)
        of_type("spring", self.spring, Elastic)

    def parts(self) -> list[Part]:
        """A rotation lock and a point."""
        return [Part(LOCK, self.frame_a, self.frame_b, elastic=self.spring), Part(POINT, elastic=self.spring)]
