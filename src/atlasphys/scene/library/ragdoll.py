"""A figure of capsules on joints with limits."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field

from atlasphys.engine.joints.frames import multiply, rotate
from atlasphys.scene.library.parts import ALONG_X, Body, Joint, Layout, Vector, body, ground, joint

UPRIGHT = (1.0, 0.0, 0.0, 0.0)

LIMBS: tuple[tuple[str, str, dict[str, Any], Vector, bool], ...] = (
    ("pelvis", "box", {"size": (0.3, 0.16, 0.18)}, (0, 0.98, 0), False),
    ("chest", "box", {"size": (0.32, 0.36, 0.2)}, (0, 1.28, 0), False),
    ("head", "sphere", {"radius": 0.11}, (0, 1.62, 0), False),
    *(
        part
        for side, x in (("left", 1.0), ("right", -1.0))
        for part in (
            (f"{side} upper arm", "capsule", {"radius": 0.045, "length": 0.21}, (0.32 * x, 1.4, 0), True),
            (f"{side} forearm", "capsule", {"radius": 0.04, "length": 0.22}, (0.62 * x, 1.4, 0), True),
            (f"{side} thigh", "capsule", {"radius": 0.07, "length": 0.3}, (0.09 * x, 0.7, 0), False),
            (f"{side} shin", "capsule", {"radius": 0.05, "length": 0.38}, (0.09 * x, 0.24, 0), False),
        )
    ),
)
"""Name, shape, sizes, place and whether it lies along x [m]: a person of 1.73 m and 62 kg, who stands with arms stretched out and looks along z."""

BALL, HINGE = "ball", "hinge"

JOINTS: tuple[tuple[str, str, str, Vector, Vector, dict[str, Any]], ...] = (
    (BALL, "pelvis", "chest", (0, 1.08, 0), (0, 1, 0), {"cone": 0.5, "twist": (-0.5, 0.5), "friction": 5.0}),
    (BALL, "chest", "head", (0, 1.48, 0), (0, 1, 0), {"cone": 0.6, "twist": (-0.9, 0.9), "friction": 1.0}),
    *(
        part
        for side, x in (("left", 1.0), ("right", -1.0))
        for part in (
            (
                BALL,
                "chest",
                f"{side} upper arm",
                (0.18 * x, 1.4, 0),
                (x, 0, 0),
                {"cone": 1.5, "twist": (-0.9, 0.9), "friction": 2.0},
            ),
            (
                HINGE,
                f"{side} upper arm",
                f"{side} forearm",
                (0.47 * x, 1.4, 0),
                (0, -x, 0),
                {"limits": (0.0, 2.4), "friction": 1.0},
            ),
            (
                BALL,
                "pelvis",
                f"{side} thigh",
                (0.09 * x, 0.9, 0),
                (0, -1, 0),
                {"cone": 1.0, "twist": (-0.4, 0.4), "friction": 4.0},
            ),
            (
                HINGE,
                f"{side} thigh",
                f"{side} shin",
                (0.09 * x, 0.48, 0),
                (1, 0, 0),
                {"limits": (0.0, 2.4), "friction": 2.0},
            ),
        )
    ),
)
"""Kind, bodies, place, axis, and limits [rad] and friction [N m]."""


def figure(
    place: Vector, turn: tuple[float, float, float, float] = UPRIGHT, name: str = "", **settings: Any
) -> tuple[list[Body], list[Joint]]:
    """A figure whose feet are at a place, turned about them; names begin with ``name``."""

    def at(point: Vector) -> Vector:
        x, y, z = rotate(turn, point)
        return x + place[0], y + place[1], z + place[2]

    bodies = [
        body(
            shape, at(point), sizes, orientation=multiply(turn, ALONG_X) if lies else turn, name=name + limb, **settings
        )
        for limb, shape, sizes, point, lies in LIMBS
    ]
    joints = [
        joint(kind, name + a, name + b, anchor=at(point), axis=rotate(turn, axis), **limits)
        for kind, a, b, point, axis, limits in JOINTS
    ]
    return bodies, joints


def ragdoll(
    drop: Annotated[float, Field(ge=0, le=20)] = 0.5, push: Annotated[float, Field(ge=-10, le=10)] = 1.5
) -> Layout:
    """A figure with limits and friction in its joints falls over."""
    bodies, joints = figure((0.0, drop, 0.0))
    for limb in bodies:
        if limb["name"] in ("chest", "head", "left upper arm"):
            limb["velocity"] = (0.0, 0.0, -push)
    return Layout([ground(), *bodies], joints=joints)
