"""The joint with six degrees of freedom, each free, limited or locked."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

from atlasphys.engine.joints.frames import IDENTITY, TO_Y, TO_Z, Quaternion, multiply
from atlasphys.engine.joints.kinds.kind import FARTHEST, Framed, check_drive, interval, of_type
from atlasphys.engine.joints.part import Elastic, Motor, Part, driven, force
from atlasphys.engine.shapes.arguments import invalid
from atlasphys.engine.state.joints import AXIS, LINE, LOCK, POINT, ROTATION, TRANSLATION

TRANSLATIONS, ROTATIONS = ("x", "y", "z"), ("rx", "ry", "rz")
TURNS = (IDENTITY, TO_Y, TO_Z)


@dataclass(frozen=True, slots=True)
class SixDof(Framed):
    """A joint whose six degrees of freedom are each free, limited or locked: translation along its three axes, rotation about them.

    The axes are those of the joint: x is ``axis`` (default: that of the world), and the others are at right angles to it; ``frame_a`` and
    ``frame_b`` choose all three. Translations are those of b's anchor along the axes on a; the rotation about an axis is the twist about it,
    which is exact where b is turned about that axis alone.

    Attributes:
        x, y, z: ``"free"``, ``"locked"``, or least and greatest translation along that axis [m]. Default: locked.
        rx, ry, rz: the same for the rotation about it [rad], −π to π. Default: locked.
        springs: springs by the name of their degree of freedom, ``{"x": ap.Elastic(frequency=2)}``.
        motors: motors by name.
        friction: greatest force or torque of friction by name [N, N m].
    """

    type: ClassVar[str] = "six_dof"
    needs_axis: ClassVar[bool] = False

    x: Any = field(default="locked", kw_only=True)
    y: Any = field(default="locked", kw_only=True)
    z: Any = field(default="locked", kw_only=True)
    rx: Any = field(default="locked", kw_only=True)
    ry: Any = field(default="locked", kw_only=True)
    rz: Any = field(default="locked", kw_only=True)
    springs: Mapping[str, Elastic] = field(default_factory=dict, kw_only=True)
    motors: Mapping[str, Motor] = field(default_factory=dict, kw_only=True)
    friction: Mapping[str, float] = field(default_factory=dict, kw_only=True)

    def __post_init__(self) -> None:
        Framed.__post_init__(self)
        for name in (*TRANSLATIONS, *ROTATIONS):
            value = getattr(self, name)
            if isinstance(value, str):
                if value not in ("free", "locked"):
                    raise invalid(name, "'free', 'locked' or two numbers", value)
            elif value is None:
                raise invalid(name, "'free', 'locked' or two numbers", value)
            else:
                most = FARTHEST if name in TRANSLATIONS else math.pi
                self._set(name, interval(name, value, -most, most))
        for title in ("springs", "motors", "friction"):
            drives = getattr(self, title)
            if not isinstance(drives, Mapping):
                raise invalid(title, "a mapping from names of degrees of freedom", drives)
            for name in drives:
                if name not in (*TRANSLATIONS, *ROTATIONS) or getattr(self, name) == "locked":
                    raise invalid(title, "about degrees of freedom that are not locked", name)
            self._set(title, dict(drives))
        for name, value in self.friction.items():
            force(f"friction[{name!r}]", value)
        for name in (*TRANSLATIONS, *ROTATIONS):
            spring = of_type(f"springs[{name!r}]", self.springs.get(name), Elastic)
            check_drive(spring, of_type(f"motors[{name!r}]", self.motors.get(name), Motor))

    def parts(self) -> list[Part]:
        """What is locked together is a point, a line or a translation of no range; likewise a lock, an axis, or a rotation of no range."""
        parts: list[Part] = []
        held: list[Part] = []
        for names, axial, pair, all_three in (
            (ROTATIONS, ROTATION, AXIS, LOCK),
            (TRANSLATIONS, TRANSLATION, LINE, POINT),
        ):
            locked = [k for k, name in enumerate(names) if getattr(self, name) == "locked"]
            for k, name in enumerate(names):
                if k not in locked:
                    value = getattr(self, name)
                    limits = None if isinstance(value, str) else value
                    drives = (self.springs.get(name), self.motors.get(name), self.friction.get(name, 0.0))
                    parts += driven(Part(axial, *self._turned(k)), limits, *drives)
            if len(locked) == 1:
                held.append(Part(axial, *self._turned(locked[0]), 0.0, 0.0))
            elif len(locked) == 2:
                held.append(Part(pair, *self._turned(3 - sum(locked))))
            elif locked:
                held.append(Part(all_three, *self._turned(0)))
        return parts + held

    def coordinates(self) -> dict[str, Part]:
        """The six degrees of freedom by name."""
        return {
            name: Part(kind, *self._turned(k))
            for names, kind in ((TRANSLATIONS, TRANSLATION), (ROTATIONS, ROTATION))
            for k, name in enumerate(names)
        }

    def _turned(self, k: int) -> tuple[Quaternion, Quaternion]:
        """The joint's frames with axis k in the place of x."""
        return multiply(self.frame_a, TURNS[k]), multiply(self.frame_b, TURNS[k])
