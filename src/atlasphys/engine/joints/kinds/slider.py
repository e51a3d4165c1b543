"""The slider and the wheel."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self

from atlasphys.engine.joints.frames import (
    Pose,
    Quaternion,
    frame_to_body,
    multiply,
    rotate,
    shortest_turn,
    turn,
)
from atlasphys.engine.joints.kinds.kind import (
    FARTHEST,
    Framed,
    check_axial,
    direction,
    interval,
    of_type,
    perpendicular,
)
from atlasphys.engine.joints.part import Elastic, Motor, Part, driven, force, within
from atlasphys.engine.state.joints import AXIS, LINE, LOCK, ROTATION, TRANSLATION
from atlasphys.errors import InvalidArgumentError


@dataclass(frozen=True, slots=True)
class Slider(Framed):
    """A slider: b moves along an axis of a and does not turn against it.

    The coordinate is how far b's anchor has moved from a's along the axis [m].

    Attributes:
        limits: least and greatest translation [m]; either may be infinite. Default: none.
        spring: a spring on the translation.
        motor: a motor on the translation.
        friction: greatest force with which the joint resists sliding [N].
    """

    type: ClassVar[str] = "slider"

    limits: Any = field(default=None, kw_only=True)
    spring: Elastic | None = field(default=None, kw_only=True)
    motor: Motor | None = field(default=None, kw_only=True)
    friction: float = field(default=0.0, kw_only=True)

    def __post_init__(self) -> None:
        Framed.__post_init__(self)
        check_axial(self, -FARTHEST, FARTHEST)

    def parts(self) -> list[Part]:
        """A translation, if anything acts on it; a rotation lock; a line."""
        frames = (self.frame_a, self.frame_b)
        sliding = driven(Part(TRANSLATION, *frames), self.limits, self.spring, self.motor, self.friction)
        return [*sliding, Part(LOCK, *frames), Part(LINE, *frames)]

    def coordinates(self) -> dict[str, Part]:
        """The translation."""
        return {"translation": Part(TRANSLATION, self.frame_a, self.frame_b)}


@dataclass(frozen=True, slots=True)
class Wheel(Framed):
    """A wheel on a suspension: b moves along an axis of a, on a spring, and turns about its axle, which may be steered about the former.

    Attributes:
        axis: direction of the suspension, in a (a chassis).
        axle: axis of the wheel, in the world where the bodies are when they are joined; it need not be at right angles to the suspension, but not
        parallel. limits: least and greatest translation along the suspension [m]. Default: none.
        spring: the suspension's spring.
        motor: a motor on the wheel's rotation against a, to a speed.
        friction: greatest torque with which the axle resists turning [N m]: a brake.
        steering: angle by which the axle is turned about the suspension [rad], −π to π.
    """

    type: ClassVar[str] = "wheel"

    axle: Any = field(default=None, kw_only=True)
    limits: Any = field(default=None, kw_only=True)
    spring: Elastic | None = field(default=None, kw_only=True)
    motor: Motor | None = field(default=None, kw_only=True)
    friction: float = field(default=0.0, kw_only=True)
    steering: float = field(default=0.0, kw_only=True)
    axle_a: Any = field(default=None, kw_only=True)
    axle_b: Any = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        Framed.__post_init__(self)
        self._set("limits", interval("limits", self.limits, -FARTHEST, FARTHEST))
        of_type("spring", self.spring, Elastic)
        motor = of_type("motor", self.motor, Motor)
        if motor is not None and motor.speed is None:
            raise InvalidArgumentError("the motor of a Wheel drives to a speed, not to a position")
        self._set("friction", force("friction", self.friction))
        self._set("steering", within("steering", self.steering, -math.pi, math.pi))
        if self.axle_a is None and self.axis is None:
            raise InvalidArgumentError("a Wheel is given its axis and axle in the world")
        if self.axle_a is None:
            self._set("axle", direction("axle", self.axle))
            perpendicular("axle", self.axis, self.axle)

    def placed(self, a: Pose | None, b: Pose | None) -> Self:
        """See :meth:`JointKind.placed`."""
        if self.axle_a is not None:
            return self
        axle = shortest_turn(self.axle)
        joint = Framed.placed(self._known(frame_to_body(a, axle), frame_to_body(b, axle)), a, b)
        return replace(joint, axle=None)

    def _known(self, in_a: Quaternion, in_b: Quaternion) -> Self:
        return replace(self, axle_a=in_a, axle_b=in_b)

    def _axle_frames(self) -> tuple[Quaternion, Quaternion]:
        suspension = rotate(self.frame_a, (1.0, 0.0, 0.0))
        return multiply(turn(suspension, self.steering), self.axle_a), self.axle_b

    def parts(self) -> list[Part]:
        """A translation along the suspension and a rotation about the axle, if anything acts on them; an axis; a line."""
        frames = (self.frame_a, self.frame_b)
        sliding = driven(Part(TRANSLATION, *frames), self.limits, self.spring, None, 0.0)
        turning = driven(Part(ROTATION, *self._axle_frames()), None, None, self.motor, self.friction)
        return [*turning, *sliding, Part(AXIS, *self._axle_frames()), Part(LINE, *frames)]

    def coordinates(self) -> dict[str, Part]:
        """The translation along the suspension, and the angle about the axle."""
        frames = (self.frame_a, self.frame_b)
        return {"translation": Part(TRANSLATION, *frames), "angle": Part(ROTATION, *self._axle_frames())}
