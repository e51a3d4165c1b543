"""What all kinds of joints have in common."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self

from atlasphys.engine.joints.frames import (
    Pose,
    Quaternion,
    Vector,
    cross,
    dot,
    frame_to_body,
    normalised,
    shortest_turn,
    to_body,
    unit,
)
from atlasphys.engine.joints.part import Elastic, Motor, Part, force
from atlasphys.engine.shapes.arguments import entries, invalid, number, vector
from atlasphys.errors import InvalidArgumentError

FARTHEST = 1e9
"""Greatest coordinate of an anchor [m]."""


def point(name: str, value: object) -> Vector:
    """Three numbers, none of them huge."""
    result = vector(name, value)
    if max(map(abs, result)) > FARTHEST:
        raise invalid(name, f"three numbers between -{FARTHEST:g} and {FARTHEST:g}", value)
    return result


def direction(name: str, value: object) -> Vector:
    """A vector that is not zero, as a unit vector."""
    given = vector(name, value)
    if not any(given):
        raise invalid(name, "a vector that is not zero", value)
    return normalised(given)


def rotation(name: str, value: object) -> Quaternion:
    """A quaternion that is not zero, as a unit quaternion."""
    wanted = "four finite numbers (w, x, y, z), not all zero"
    w, x, y, z = (number(f"{name}[{i}]", entry, wanted) for i, entry in enumerate(entries(name, value, 4, wanted)))
    greatest = max(abs(w), abs(x), abs(y), abs(z))
    if greatest == 0:
        raise invalid(name, wanted, value)
    return unit((w / greatest, x / greatest, y / greatest, z / greatest))


def interval(name: str, value: object, least: float, most: float) -> tuple[float, float] | None:
    """None, or two numbers in order, of which one may be infinite."""
    wanted = f"None or two numbers in order, from {least:g} to {most:g} or infinite"
    if value is None:
        return None
    low, high = (
        float(x) if x in (-math.inf, math.inf) else number(f"{name}[{i}]", x, wanted)
        for i, x in enumerate(entries(name, value, 2, wanted))
    )
    in_range = all(x in (-math.inf, math.inf) or least <= x <= most for x in (low, high))
    if not in_range or not low <= high or low == math.inf or high == -math.inf:
        raise invalid(name, wanted, value)
    return low, high


def of_type(name: str, value: object, kind: type) -> Any:
    """None, or an object of a type."""
    if value is not None and not isinstance(value, kind):
        raise invalid(name, f"None or ap.{kind.__name__}(…)", value)
    return value


@dataclass(frozen=True, slots=True)
class JointKind:
    """What all joints have. Not a joint by itself.

    Attributes:
        a: a body, or None: the world.
        b: another body, or None. One of the two is dynamic.
        collide: whether the two bodies collide with each other. Default: they do not.
        breaking_force: force at which the joint breaks [N]. Default: none.
        breaking_torque: torque at which it breaks [N m]. Default: none.
    """

    type: ClassVar[str] = ""
    """Name of the kind in scene files."""

    a: Any
    b: Any
    collide: bool = field(default=False, kw_only=True)
    breaking_force: float = field(default=math.inf, kw_only=True)
    breaking_torque: float = field(default=math.inf, kw_only=True)

    def __post_init__(self) -> None:
        if type(self.collide) is not bool:
            raise invalid("collide", "True or False", self.collide)
        self._set("breaking_force", force("breaking_force", self.breaking_force))
        self._set("breaking_torque", force("breaking_torque", self.breaking_torque))

    def _set(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, value)

    def placed(self, a: Pose | None, b: Pose | None) -> Self:
        """The same joint with all that it says of the world said in the axes of the bodies, whose poses are given; None: the world."""
        raise NotImplementedError

    def anchors(self) -> tuple[Vector, Vector]:
        """Anchors of a placed joint on a and on b [m]."""
        raise NotImplementedError

    def frames(self) -> tuple[Quaternion, Quaternion]:
        """Axes of a placed joint on a and on b, as quaternions."""
        return (1.0, 0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)

    def parts(self) -> list[Part]:
        """The parts of a placed joint."""
        raise NotImplementedError

    def coordinates(self) -> dict[str, Part]:
        """The joint's coordinates by name, each as the part that measures it."""
        return {}


@dataclass(frozen=True, slots=True)
class Anchored(JointKind):
    """A joint at a point.

    Attributes:
        anchor: the point, in the world, where the bodies are when they are joined [m]. Default: the position of b (of a, where b is the world).
        anchor_a: instead of it, the point in the axes of a, from its position [m]; in the world, if a is None.
        anchor_b: the same for b. The two need not be at the same place at first.
    """

    anchor: Any = field(default=None, kw_only=True)
    anchor_a: Any = field(default=None, kw_only=True)
    anchor_b: Any = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        JointKind.__post_init__(self)
        if (self.anchor_a is None) != (self.anchor_b is None):
            raise InvalidArgumentError("anchor_a and anchor_b are given both or neither")
        if self.anchor is not None and self.anchor_a is not None:
            raise InvalidArgumentError("the anchor is given twice: as anchor, and as anchor_a and anchor_b")
        for name in ("anchor", "anchor_a", "anchor_b"):
            if getattr(self, name) is not None:
                self._set(name, point(name, getattr(self, name)))

    def placed(self, a: Pose | None, b: Pose | None) -> Self:
        """See :meth:`JointKind.placed`."""
        if self.anchor_a is not None:
            return self
        pose = b if b is not None else a
        assert pose is not None
        anchor = pose[0] if self.anchor is None else self.anchor
        return replace(self, anchor=None, anchor_a=to_body(a, anchor), anchor_b=to_body(b, anchor))

    def anchors(self) -> tuple[Vector, Vector]:
        """See :meth:`JointKind.anchors`."""
        return self.anchor_a, self.anchor_b


@dataclass(frozen=True, slots=True)
class Framed(Anchored):
    """A joint with an axis.

    Attributes:
        axis: direction of the axis in the world, where the bodies are when they are joined; angles are 0 then.
        frame_a: instead of it, the joint's axes in those of a (in the world's, if a is None), a quaternion (w, x, y, z): it takes x to the axis.
        frame_b: the same for b. Angles are 0 where the two coincide.
    """

    axis: Any = field(default=None, kw_only=True)
    frame_a: Any = field(default=None, kw_only=True)
    frame_b: Any = field(default=None, kw_only=True)

    needs_axis: ClassVar[bool] = True

    def __post_init__(self) -> None:
        Anchored.__post_init__(self)
        if (self.frame_a is None) != (self.frame_b is None):
            raise InvalidArgumentError("frame_a and frame_b are given both or neither")
        if self.axis is not None and self.frame_a is not None:
            raise InvalidArgumentError("the axis is given twice: as axis, and in frame_a and frame_b")
        if self.needs_axis and self.axis is None and self.frame_a is None:
            raise InvalidArgumentError(f"a {type(self).__name__} needs an axis")
        if self.axis is not None:
            self._set("axis", direction("axis", self.axis))
        for name in ("frame_a", "frame_b"):
            if getattr(self, name) is not None:
                self._set(name, rotation(name, getattr(self, name)))

    def placed(self, a: Pose | None, b: Pose | None) -> Self:
        """See :meth:`JointKind.placed`."""
        joint = Anchored.placed(self, a, b)
        if self.frame_a is not None:
            return joint
        in_a, in_b = self.world_frames()
        return replace(joint, axis=None, frame_a=frame_to_body(a, in_a), frame_b=frame_to_body(b, in_b))

    def world_frames(self) -> tuple[Quaternion, Quaternion]:
        """The joint's axes on either body, in the world."""
        frame = (1.0, 0.0, 0.0, 0.0) if self.axis is None else shortest_turn(self.axis)
        return frame, frame

    def frames(self) -> tuple[Quaternion, Quaternion]:
        """See :meth:`JointKind.frames`."""
        return self.frame_a, self.frame_b


def check_axial(joint: Any, least: float, most: float) -> None:
    """Check what acts on the coordinate of a joint with one: limits, spring, motor, friction."""
    joint._set("limits", interval("limits", joint.limits, least, most))
    check_drive(of_type("spring", joint.spring, Elastic), of_type("motor", joint.motor, Motor))
    joint._set("friction", force("friction", joint.friction))


def check_drive(spring: Elastic | None, motor: Motor | None) -> None:
    """Refuse a spring beside a motor that drives to a position."""
    if spring is not None and motor is not None and motor.position is not None:
        raise InvalidArgumentError(
            "a motor that drives to a position takes the place of the spring: give one of the two"
        )


def perpendicular(name: str, u: Vector, v: Vector) -> Vector:
    """The unit vector at right angles to two directions, which must not be parallel."""
    third = cross(u, v)
    if dot(third, third) < 1e-6:
        raise InvalidArgumentError(f"{name} must not be parallel to axis (got {v} and {u})")
    return normalised(third)
