"""Gears."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from atlasphys.scene.library.parts import Body, Joint, Layout, Vector, cosine, joint, sine

RADII = (0.5, 1.0, 0.25, 0.75)
"""Of the gears, one after another [m]."""


def _disc(radius: float, corners: int) -> tuple[Vector, ...]:
    """Corners of a flat prism about z."""
    turns = [360.0 * k / corners for k in range(corners)]
    return tuple((radius * cosine(turn), radius * sine(turn), z) for z in (-0.1, 0.1) for turn in turns)


def gear_train(
    speed: Annotated[float, Field(ge=-20, le=20)] = 3.0, torque: Annotated[float, Field(ge=0, le=1e9)] = 1000.0
) -> Layout:
    """A motor drives four gears, each turning the next: speeds go as 1/radius."""
    bodies: list[Body] = []
    joints: list[Joint] = []
    x = 0.0
    for k, radius in enumerate(RADII):
        x += radius + RADII[k - 1] if k else 0.0
        shape = {"type": "convex_hull", "points": _disc(radius, round(24 * radius))}
        # Gears touch by their joints alone.
        bodies.append({"shape": shape, "position": (x, 0.0, 0.0), "mask": 0, "name": f"gear {k}"})
        joints.append(joint("hinge", None, f"gear {k}", anchor=(x, 0, 0), axis=(0, 0, 1), name=f"axle {k}"))
    joints[0]["motor"] = {"speed": speed, "max_force": torque}
    for k in range(1, len(RADII)):
        ratio = RADII[k - 1] / RADII[k]
        axes = {"axis_a": (0, 0, 1), "axis_b": (0, 0, 1)}
        joints.append(joint("gear", f"gear {k - 1}", f"gear {k}", **axes, ratio=ratio, name=f"mesh {k}"))
    return Layout(bodies, joints=joints)
