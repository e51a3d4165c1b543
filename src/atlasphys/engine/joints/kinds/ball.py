"""The ball joint, and the target by which bodies are dragged."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self

from atlasphys.engine.joints.frames import IDENTITY, Pose, Quaternion, Vector, to_world
from atlasphys.engine.joints.kinds.kind import Framed, JointKind, interval, of_type, point
from atlasphys.engine.joints.part import Elastic, Part, force, within
from atlasphys.engine.state.joints import CONE, LOCK, POINT, ROTATION
from atlasphys.errors import InvalidArgumentError


@dataclass(frozen=True, slots=True)
class Ball(Framed):
    """A ball joint: the two bodies share a point and turn freely about it, within a cone and a range of twist if wanted.

    Attributes:
        axis: middle of the cone, and axis of the twist. Needed with these alone.
        cone: greatest angle between the axis on a and the axis on b [rad], 0.001 to π. Default: any.
        twist: least and greatest angle by which b may be turned against a about the axis [rad], −π to π. Default: any.
        spring: a spring towards the orientation in which the bodies were joined; its ``rest`` is 0.
        friction: greatest torque with which the joint resists turning [N m].
    """

    type: ClassVar[str] = "ball"
    needs_axis: ClassVar[bool] = False

    cone: Any = field(default=None, kw_only=True)
    twist: Any = field(default=None, kw_only=True)
    spring: Elastic | None = field(default=None, kw_only=True)
    friction: float = field(default=0.0, kw_only=True)

    def __post_init__(self) -> None:
        Framed.__post_init__(self)
        if self.cone is not None:
            self._set("cone", within("cone", self.cone, 1e-3, math.pi))
        self._set("twist", interval("twist", self.twist, -math.pi, math.pi))
        if (self.cone is not None or self.twist is not None) and self.axis is None and self.frame_a is None:
            raise InvalidArgumentError("a Ball with a cone or a range of twist needs an axis")
        spring = of_type("spring", self.spring, Elastic)
        if spring is not None and spring.rest != 0:
            raise InvalidArgumentError(f"the spring of a Ball rests at 0 (got {spring.rest:g})")
        self._set("friction", force("friction", self.friction))

    def parts(self) -> list[Part]:
        """A point; a cone, a rotation for the twist; rotation locks as soft as the spring, or no firmer than friction."""
        parts = []
        if self.twist is not None:
            parts.append(Part(ROTATION, self.frame_a, self.frame_b, *self.twist))
        if self.cone is not None:
            parts.append(Part(CONE, self.frame_a, self.frame_b, upper=self.cone))
        if self.spring is not None:
            parts.append(Part(LOCK, self.frame_a, self.frame_b, elastic=self.spring))
        if self.friction > 0:
            parts.append(Part(LOCK, self.frame_a, self.frame_b, friction=self.friction))
        return [*parts, Part(POINT)]

    def coordinates(self) -> dict[str, Part]:
        """The twist, and the angle to the cone's axis, which is called swing."""
        frames = (self.frame_a, self.frame_b)
        return {"twist": Part(ROTATION, *frames), "swing": Part(CONE, *frames)}


@dataclass(frozen=True, slots=True)
class Target(JointKind):
    """A target that a point of a body is pulled towards by a spring: for dragging bodies about. Side a is the world.

    Attributes:
        b: the body. (``a`` is None.)
        target: where the point is pulled to, in the world [m]. Default: where it is at first.
        anchor_b: the point in the axes of b, from its position [m]. Default: its position.
        frequency: of the spring, with the mass of the body [Hz].
        damping: its damping ratio.
        max_force: greatest force [N]. Default: any.
    """

    type: ClassVar[str] = "target"

    a: Any = None
    b: Any = None
    target: Any = field(default=None, kw_only=True)
    anchor_b: Any = field(default=(0.0, 0.0, 0.0), kw_only=True)
    frequency: float = field(default=5.0, kw_only=True)
    damping: float = field(default=1.0, kw_only=True)
    max_force: float = field(default=math.inf, kw_only=True)

    def __post_init__(self) -> None:
        JointKind.__post_init__(self)
        if self.a is not None:
            raise InvalidArgumentError("side a of a Target is the world: give None, and the body as b")
        self._set("anchor_b", point("anchor_b", self.anchor_b))
        if self.target is not None:
            self._set("target", point("target", self.target))
        self.spring  # noqa: B018  # checks its numbers

    @property
    def spring(self) -> Elastic:
        """The spring."""
        return Elastic(frequency=self.frequency, damping=self.damping, max_force=self.max_force)

    def placed(self, a: Pose | None, b: Pose | None) -> Self:
        """See :meth:`JointKind.placed`."""
        return self if self.target is not None else replace(self, target=to_world(b, self.anchor_b))

    def anchors(self) -> tuple[Vector, Vector]:
        """See :meth:`JointKind.anchors`."""
        return self.target, self.anchor_b

    def frames(self) -> tuple[Quaternion, Quaternion]:
        """See :meth:`JointKind.frames`."""
        return IDENTITY, IDENTITY

    def parts(self) -> list[Part]:
        """A soft point."""
        return [Part(POINT, elastic=self.spring)]
