"""Joints that keep two points at a distance: rods, ropes, springs."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self

from atlasphys.engine.joints.frames import Pose, Vector, difference, dot, to_world
from atlasphys.engine.joints.kinds.kind import JointKind, point
from atlasphys.engine.joints.part import Elastic, Part, force, within
from atlasphys.engine.shapes.arguments import invalid
from atlasphys.engine.state.joints import DISTANCE
from atlasphys.errors import InvalidArgumentError

LONGEST = 1e9
"""Greatest length [m]."""


@dataclass(frozen=True, slots=True)
class _Between(JointKind):
    """A joint between two points.

    Attributes:
        anchor_a: the point of a, in its axes, from its position [m]; in the world, if a is None.
        anchor_b: the point of b.
    """

    anchor_a: Any = field(default=(0.0, 0.0, 0.0), kw_only=True)
    anchor_b: Any = field(default=(0.0, 0.0, 0.0), kw_only=True)

    def __post_init__(self) -> None:
        JointKind.__post_init__(self)
        for name in ("anchor_a", "anchor_b"):
            self._set(name, point(name, getattr(self, name)))

    def anchors(self) -> tuple[Vector, Vector]:
        """See :meth:`JointKind.anchors`."""
        return self.anchor_a, self.anchor_b

    def present_length(self, a: Pose | None, b: Pose | None) -> float:
        """Distance of the two points [m]."""
        apart = difference(to_world(b, self.anchor_b), to_world(a, self.anchor_a))
        return math.sqrt(dot(apart, apart))

    def coordinates(self) -> dict[str, Part]:
        """The length."""
        return {"length": Part(DISTANCE)}


@dataclass(frozen=True, slots=True)
class Distance(_Between):
    """A rod, which keeps two points at a distance, or a rope, which only keeps them from getting farther apart.

    ``Distance(a, b)`` is a rod of the present length, ``Distance(a, b, length=2)`` one of 2 m, ``Distance(a, b, limits=(0, 2))`` a rope of 2 m.

    Attributes:
        length: of a rod [m]; more than 0. Default: the present one.
        limits: least and greatest distance [m], in place of a length; the greatest may be infinite.
    """

    type: ClassVar[str] = "distance"

    length: float | None = field(default=None, kw_only=True)
    limits: Any = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        _Between.__post_init__(self)
        if self.length is not None:
            if self.limits is not None:
                raise InvalidArgumentError("give a Distance a length or limits, not both")
            self._set("length", within("length", self.length, 1e-6, LONGEST))
        if self.limits is not None:
            wanted = f"two lengths in order, from 0 to {LONGEST:g} m or infinite, the second more than 0"
            try:
                low, high = self.limits
                low, high = float(low), float(high)
            except (TypeError, ValueError):
                raise invalid("limits", wanted, self.limits) from None
            if not (0 <= low <= high and high > 0 and low <= LONGEST and (high <= LONGEST or high == math.inf)):
                raise invalid("limits", wanted, self.limits)
            self._set("limits", (low, high))

    def placed(self, a: Pose | None, b: Pose | None) -> Self:
        """See :meth:`JointKind.placed`."""
        if self.length is not None or self.limits is not None:
            return self
        length = self.present_length(a, b)
        if length < 1e-6:
            raise InvalidArgumentError(
                "the two points of a Distance are at the same place: give its length or limits, or other anchors"
            )
        return replace(self, length=length)

    def parts(self) -> list[Part]:
        """A distance."""
        lower, upper = (self.length, self.length) if self.limits is None else self.limits
        assert lower is not None
        assert upper is not None
        return [Part(DISTANCE, lower=lower, upper=upper)]


@dataclass(frozen=True, slots=True)
class Spring(_Between):
    """A spring with a damper between two points.

    Attributes:
        frequency: of the undamped oscillation of the two bodies along the spring [Hz]: ω² = k (1/m_a + 1/m_b) where it pulls at their centres. At
        most
            0.15 of the number of substeps a second is used.
        damping: damping ratio ζ.
        rest_length: length at which it does not act [m]. Default: the present one.
        max_force: greatest force [N]. Default: any.
        limits: least and greatest length [m]. Default: none.
    """

    type: ClassVar[str] = "spring"

    frequency: float = field(default=1.0, kw_only=True)
    damping: float = field(default=0.0, kw_only=True)
    rest_length: float | None = field(default=None, kw_only=True)
    max_force: float = field(default=math.inf, kw_only=True)
    limits: Any = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        _Between.__post_init__(self)
        if self.rest_length is not None:
            self._set("rest_length", within("rest_length", self.rest_length, 0, LONGEST))
        self._set("max_force", force("max_force", self.max_force))
        self._set("limits", Distance(None, None, limits=self.limits).limits)
        self.spring  # noqa: B018  # checks its numbers

    @property
    def spring(self) -> Elastic:
        """The spring as that of a coordinate."""
        rest = 0.0 if self.rest_length is None else self.rest_length
        return Elastic(frequency=self.frequency, damping=self.damping, rest=rest, max_force=self.max_force)

    def placed(self, a: Pose | None, b: Pose | None) -> Self:
        """See :meth:`JointKind.placed`."""
        return self if self.rest_length is not None else replace(self, rest_length=self.present_length(a, b))

    def parts(self) -> list[Part]:
        """A distance with a spring."""
        lower, upper = (-math.inf, math.inf) if self.limits is None else self.limits
        return [Part(DISTANCE, lower=lower, upper=upper, elastic=self.spring)]
