"""A suspension bridge of planks."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from atlasphys.scene.library.parts import Body, Joint, Layout, box, cosine, joint, sine, turned

LENGTH, THICKNESS, WIDTH = 1.0, 0.1, 2.0
"""Of a plank, joint to joint [m]."""

SAG = 60.0
"""Angle by which the bridge bends from end to end [degrees]."""


def bridge(planks: Annotated[int, Field(ge=2, le=200)] = 20, boxes: Annotated[int, Field(ge=0, le=50)] = 5) -> Layout:
    """Hinged planks hang between two banks; boxes fall on them."""
    bodies: list[Body] = []
    joints: list[Joint] = []
    x, y = 0.0, 0.0
    heights = []
    for k in range(planks):
        angle = SAG * ((k + 0.5) / planks - 0.5)
        dx, dy = LENGTH * cosine(angle), LENGTH * sine(angle)
        name = f"plank {k}"
        place = (x + 0.5 * dx, y + 0.5 * dy, 0.0)
        size = (0.96 * LENGTH, THICKNESS, WIDTH)
        bodies.append(box(size, place, orientation=turned((0, 0, 1), angle), density=600, name=name))
        before = f"plank {k - 1}" if k else None
        joints.append(joint("hinge", before, name, anchor=(x, y, 0), axis=(0, 0, 1)))
        heights.append(place)
        x, y = x + dx, y + dy
    joints.append(joint("hinge", None, f"plank {planks - 1}", anchor=(x, y, 0), axis=(0, 0, 1)))
    for k in range(boxes):
        place = heights[(k + 1) * planks // (boxes + 1)]
        bodies.append(
            box((0.6, 0.6, 0.6), (place[0], place[1] + 1.0 + 0.5 * k, 0), density=400, friction=0.8, name=f"box {k}")
        )
    return Layout(bodies, joints=joints)
