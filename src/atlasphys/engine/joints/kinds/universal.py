"""The universal joint."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self

from atlasphys.engine.joints.frames import TO_Y, TO_Z, Pose, Quaternion, multiply, of_axes
from atlasphys.engine.joints.kinds.kind import (
    Framed,
    check_axial,
    check_drive,
    direction,
    interval,
    of_type,
    perpendicular,
)
from atlasphys.engine.joints.part import Elastic, Motor, Part, driven, force
from atlasphys.engine.state.joints import CROSS, POINT, ROTATION
from atlasphys.errors import InvalidArgumentError


@dataclass(frozen=True, slots=True)
class Universal(Framed):
    """A universal joint (of Cardan or Hooke): the two bodies share a point, and an axis of a stays at right angles to one of b.

    The coordinates are the angle about the axis of a and the angle about that of b [rad]. At ±π/2 of the second the axes of the two shafts are at
    right angles, and it locks.

    Attributes:
        axis: axis of a, in the world where the bodies are when they are joined.
        axis_b: axis of b. The two are to be at right angles; the joint turns the bodies so that they are. They must not be parallel.
        limits, limits_b: least and greatest angle about either axis [rad]. Default: none.
        motor, motor_b: motors on the angles.
        spring, spring_b: springs on the angles.
        friction, friction_b: greatest torque with which the joint resists turning about either axis [N m].
    """

    type: ClassVar[str] = "universal"

    axis_b: Any = field(default=None, kw_only=True)
    limits: Any = field(default=None, kw_only=True)
    spring: Elastic | None = field(default=None, kw_only=True)
    motor: Motor | None = field(default=None, kw_only=True)
    friction: float = field(default=0.0, kw_only=True)
    limits_b: Any = field(default=None, kw_only=True)
    spring_b: Elastic | None = field(default=None, kw_only=True)
    motor_b: Motor | None = field(default=None, kw_only=True)
    friction_b: float = field(default=0.0, kw_only=True)

    def __post_init__(self) -> None:
        Framed.__post_init__(self)
        check_axial(self, -math.pi, math.pi)
        self._set("limits_b", interval("limits_b", self.limits_b, -math.pi, math.pi))
        check_drive(of_type("spring_b", self.spring_b, Elastic), of_type("motor_b", self.motor_b, Motor))
        self._set("friction_b", force("friction_b", self.friction_b))
        if self.axis is not None:
            if self.axis_b is None:
                raise InvalidArgumentError("a Universal needs axis_b beside axis")
            self._set("axis_b", direction("axis_b", self.axis_b))
            perpendicular("axis_b", self.axis, self.axis_b)

    def placed(self, a: Pose | None, b: Pose | None) -> Self:
        """See :meth:`JointKind.placed`."""
        return replace(Framed.placed(self, a, b), axis_b=None)

    def world_frames(self) -> tuple[Quaternion, Quaternion]:
        """Axes of the joint: y is the axis of a, z that of b, x at right angles to both."""
        from_a, from_b = self.axis, self.axis_b
        across = perpendicular("axis_b", from_a, from_b)
        in_b = perpendicular("axis_b", from_b, across)
        return of_axes(across, from_a), of_axes(across, in_b)

    def parts(self) -> list[Part]:
        """Rotations about the two axes, if anything acts on them; a cross; a point."""
        angles = self.coordinates()
        return [
            *driven(angles["angle"], self.limits, self.spring, self.motor, self.friction),
            *driven(angles["angle_b"], self.limits_b, self.spring_b, self.motor_b, self.friction_b),
            Part(CROSS, self.frame_a, self.frame_b, 0.0, 0.0),
            Part(POINT),
        ]

    def coordinates(self) -> dict[str, Part]:
        """The angles about the axis of a and about that of b."""
        a, b = self.frame_a, self.frame_b
        return {
            "angle": Part(ROTATION, multiply(a, TO_Y), multiply(b, TO_Y)),
            "angle_b": Part(ROTATION, multiply(a, TO_Z), multiply(b, TO_Z)),
        }
