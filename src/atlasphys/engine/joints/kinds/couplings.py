"""Joints that couple two motions: gears, rack and pinion, pulley. Each body is held by a joint of its own; these add one row."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self

from atlasphys.engine.joints.frames import (
    IDENTITY,
    Pose,
    Quaternion,
    Vector,
    difference,
    dot,
    frame_to_body,
    shortest_turn,
    to_world,
)
from atlasphys.engine.joints.kinds.kind import JointKind, direction, point, rotation
from atlasphys.engine.joints.part import Part, within
from atlasphys.engine.shapes.arguments import invalid, number
from atlasphys.engine.state.joints import COUPLING, PULLEY
from atlasphys.errors import InvalidArgumentError

LARGEST_RATIO = 1e6


def ratio(name: str, value: object) -> float:
    """A number that is not zero and not extreme."""
    result = number(name, value)
    if not 1 / LARGEST_RATIO <= abs(result) <= LARGEST_RATIO:
        raise invalid(name, f"a number from {1 / LARGEST_RATIO:g} to {LARGEST_RATIO:g}, or its negative", value)
    return result


@dataclass(frozen=True, slots=True)
class _Coupled(JointKind):
    """Two motions along or about axes that are fixed in the bodies."""

    frame_a: Any = field(default=None, kw_only=True)
    frame_b: Any = field(default=None, kw_only=True)

    names: ClassVar[tuple[str, str]] = ("", "")

    def __post_init__(self) -> None:
        JointKind.__post_init__(self)
        for name, frame in zip(self.names, ("frame_a", "frame_b"), strict=True):
            if getattr(self, frame) is not None:
                self._set(frame, rotation(frame, getattr(self, frame)))
            elif getattr(self, name) is None:
                raise InvalidArgumentError(f"a {type(self).__name__} needs {name}")
            else:
                self._set(name, direction(name, getattr(self, name)))

    def placed(self, a: Pose | None, b: Pose | None) -> Self:
        """See :meth:`JointKind.placed`."""
        frames: dict[str, Any] = {}
        for name, frame, pose in zip(self.names, ("frame_a", "frame_b"), (a, b), strict=True):
            if getattr(self, frame) is None:
                frames[frame] = frame_to_body(pose, shortest_turn(getattr(self, name)))
        return replace(self, **frames) if frames else self

    def anchors(self) -> tuple[Vector, Vector]:
        """The bodies' positions: a coupling has none of its own."""
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)

    def frames(self) -> tuple[Quaternion, Quaternion]:
        """See :meth:`JointKind.frames`."""
        return self.frame_a, self.frame_b


@dataclass(frozen=True, slots=True)
class Gear(_Coupled):
    """A pair of gears: when a turns about its axis by an angle, b turns about its own by minus that angle, times the ratio.

    Both rotations are counted in the world, from the moment of joining. The axes are fixed in the bodies; hinges hold them.

    Attributes:
        axis_a, axis_b: axes of rotation, in the world where the bodies are when they are joined.
        ratio: of a's teeth (or radius) to b's: ω_b = −ratio · ω_a. Negative: both turn the same way, as with an inner gear or a belt.
    """

    type: ClassVar[str] = "gear"
    names: ClassVar[tuple[str, str]] = ("axis_a", "axis_b")

    axis_a: Any = field(default=None, kw_only=True)
    axis_b: Any = field(default=None, kw_only=True)
    ratio: float = field(default=1.0, kw_only=True)

    def __post_init__(self) -> None:
        _Coupled.__post_init__(self)
        self._set("ratio", ratio("ratio", self.ratio))

    def parts(self) -> list[Part]:
        """A coupling."""
        held = (0.0, 0.0)
        return [Part(COUPLING, self.frame_a, self.frame_b, *held, ratio=(self.ratio, 1.0), turns=(True, True))]


@dataclass(frozen=True, slots=True)
class RackPinion(_Coupled):
    """A rack and a pinion: when a, the pinion, turns about its axis by an angle, b, the rack, moves in a direction by the radius times that angle.

    Both motions are counted in the world, from the moment of joining.

    Attributes:
        axis: axis of the pinion, in the world where the bodies are when they are joined.
        direction: the way that the rack moves in when the pinion turns in the positive sense.
        radius: of the pinion [m].
    """

    type: ClassVar[str] = "rack_pinion"
    names: ClassVar[tuple[str, str]] = ("axis", "direction")

    axis: Any = field(default=None, kw_only=True)
    direction: Any = field(default=None, kw_only=True)
    radius: float = field(default=1.0, kw_only=True)

    def __post_init__(self) -> None:
        _Coupled.__post_init__(self)
        self._set("radius", within("radius", self.radius, 1e-6, 1e6))

    def parts(self) -> list[Part]:
        """A coupling."""
        return [Part(COUPLING, self.frame_a, self.frame_b, 0.0, 0.0, ratio=(-self.radius, 1.0), turns=(True, False))]


@dataclass(frozen=True, slots=True)
class Pulley(JointKind):
    """A rope over two pulleys: the distance of a's anchor from one point, plus the ratio times that of b's anchor from another, is at most a length.

    Attributes:
        ground_a, ground_b: the points of the world from which the two ends hang [m].
        anchor_a, anchor_b: where they are tied to the bodies, in the bodies' axes, from their positions [m].
        ratio: how much rope b takes for each metre (a block and tackle).
        length: of the rope: length of a's end + ratio · length of b's [m]. Default: the present one.
        taut: whether the rope keeps its length, rather than going slack when it is not pulled.
    """

    type: ClassVar[str] = "pulley"

    ground_a: Any = field(default=None, kw_only=True)
    ground_b: Any = field(default=None, kw_only=True)
    anchor_a: Any = field(default=(0.0, 0.0, 0.0), kw_only=True)
    anchor_b: Any = field(default=(0.0, 0.0, 0.0), kw_only=True)
    ratio: float = field(default=1.0, kw_only=True)
    length: float | None = field(default=None, kw_only=True)
    taut: bool = field(default=False, kw_only=True)

    def __post_init__(self) -> None:
        JointKind.__post_init__(self)
        for name in ("ground_a", "ground_b", "anchor_a", "anchor_b"):
            self._set(name, point(name, getattr(self, name)))
        self._set("ratio", within("ratio", self.ratio, 1 / LARGEST_RATIO, LARGEST_RATIO))
        if self.length is not None:
            self._set("length", within("length", self.length, 1e-6, 1e9))
        if type(self.taut) is not bool:
            raise invalid("taut", "True or False", self.taut)

    def placed(self, a: Pose | None, b: Pose | None) -> Self:
        """See :meth:`JointKind.placed`."""
        ends = []
        for pose, anchor, ground in ((a, self.anchor_a, self.ground_a), (b, self.anchor_b, self.ground_b)):
            rope = difference(to_world(pose, anchor), ground)
            ends.append(math.sqrt(dot(rope, rope)))
        if min(ends) < 1e-6:
            raise InvalidArgumentError("an end of a Pulley's rope has no length: its anchor is where it hangs from")
        return self if self.length is not None else replace(self, length=ends[0] + self.ratio * ends[1])

    def anchors(self) -> tuple[Vector, Vector]:
        """See :meth:`JointKind.anchors`."""
        return self.anchor_a, self.anchor_b

    def parts(self) -> list[Part]:
        """A pulley."""
        assert self.length is not None
        lower = self.length if self.taut else float("-inf")
        return [
            Part(
                PULLEY,
                IDENTITY,
                IDENTITY,
                lower,
                self.length,
                ratio=(1.0, self.ratio),
                hung=(self.ground_a, self.ground_b),
            )
        ]
