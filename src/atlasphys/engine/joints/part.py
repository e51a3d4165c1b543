"""What a kind of joint says of the parts that it is made of."""

import math
from dataclasses import dataclass
from typing import NamedTuple

from atlasphys.engine.joints.frames import IDENTITY, Quaternion, Vector
from atlasphys.engine.shapes.arguments import invalid, number

LARGEST_FORCE = 1e15
"""Greatest finite force or torque [N, N m] of a motor, spring or friction; beyond it there is only infinity."""


def force(name: str, value: object) -> float:
    """A force or torque: a number that is not negative, or infinity."""
    if value == math.inf:
        return math.inf
    wanted = f"a number from 0 to {LARGEST_FORCE:g}, or infinity"
    result = number(name, value, wanted)
    if not 0 <= result <= LARGEST_FORCE:
        raise invalid(name, wanted, value)
    return result


def within(name: str, value: object, least: float, most: float) -> float:
    """A number in a range."""
    wanted = f"a number from {least:g} to {most:g}"
    result = number(name, value, wanted)
    if not least <= result <= most:
        raise invalid(name, wanted, value)
    return result


@dataclass(frozen=True, slots=True, kw_only=True)
class Elastic:
    """A spring with a damper that acts on a coordinate of a joint: an angle [rad] or a length [m].

    Args:
        frequency: of the undamped oscillation of the two bodies along the coordinate, with the mass that the joint feels there [Hz]. At most 0.15
            of the number of substeps a second is used. Larger: stiffer.
        damping: damping ratio ζ. 0: it swings for ever; 1: it comes to rest soonest without overshoot.
        rest: coordinate at which it does not act [rad, m].
        max_force: greatest force or torque [N, N m]. Default: any.

    Raises:
        InvalidArgumentError: a value is not of the right kind or out of range.
    """

    frequency: float
    damping: float = 0.0
    rest: float = 0.0
    max_force: float = math.inf

    def __post_init__(self) -> None:
        within("frequency", self.frequency, 1e-4, 1e5)
        within("damping", self.damping, 0, 1e3)
        within("rest", self.rest, -1e9, 1e9)
        force("max_force", self.max_force)


@dataclass(frozen=True, slots=True, kw_only=True)
class Motor:
    """A motor that drives a coordinate of a joint: an angle [rad] or a length [m].

    Either to a speed, with whatever force up to ``max_force`` it takes; or to a position, by a spring with a damper whose force is at most that.

    Args:
        speed: rate of the coordinate to be reached [rad/s, m/s].
        position: coordinate to be reached [rad, m]; instead of a speed.
        max_force: greatest force or torque [N, N m]. Default: any.
        frequency: of that spring [Hz]. Larger: it holds the position more stiffly. Without effect on a speed.
        damping: its damping ratio.

    Raises:
        InvalidArgumentError: a value is not of the right kind or out of range, or both or neither of speed and position are given.
    """

    speed: float | None = None
    position: float | None = None
    max_force: float = math.inf
    frequency: float = 5.0
    damping: float = 1.0

    def __post_init__(self) -> None:
        if (self.speed is None) == (self.position is None):
            raise invalid("motor", "given either a speed or a position", (self.speed, self.position))
        for name in ("speed", "position"):
            if getattr(self, name) is not None:
                within(name, getattr(self, name), -1e9, 1e9)
        force("max_force", self.max_force)
        within("frequency", self.frequency, 1e-4, 1e5)
        within("damping", self.damping, 0, 1e3)

    @property
    def elastic(self) -> Elastic | None:
        """The spring of a motor that drives to a position."""
        if self.position is None:
            return None
        return Elastic(frequency=self.frequency, damping=self.damping, rest=self.position, max_force=self.max_force)


class Part(NamedTuple):
    """A part of a joint, in the axes of the two bodies; see ``state/joints.py`` for what its numbers mean."""

    type: int
    frame_a: Quaternion = IDENTITY
    frame_b: Quaternion = IDENTITY
    lower: float = -math.inf
    upper: float = math.inf
    elastic: Elastic | None = None
    motor: Motor | None = None
    friction: float = 0.0
    ratio: tuple[float, float] = (0.0, 0.0)
    turns: tuple[bool, bool] = (False, False)
    hung: tuple[Vector, Vector] | None = None
    """Points of the world from which the ropes of a pulley hang."""

    @property
    def acts(self) -> bool:
        """Whether anything acts on the coordinate of an axial part."""
        limited = self.lower > -math.inf or self.upper < math.inf
        return limited or self.elastic is not None or self.motor is not None or self.friction > 0


def driven(
    part: Part, limits: tuple[float, float] | None, spring: Elastic | None, motor: Motor | None, friction: float
) -> list[Part]:
    """An axial part with limits, a spring, a motor and friction; none if there is nothing of all this."""
    elastic = spring if motor is None or motor.elastic is None else motor.elastic
    speed = motor if motor is not None and motor.speed is not None else None
    lower, upper = (-math.inf, math.inf) if limits is None else limits
    part = part._replace(lower=lower, upper=upper, elastic=elastic, motor=speed, friction=friction)
    return [part] if part.acts else []
