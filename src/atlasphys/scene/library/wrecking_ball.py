"""A wrecking ball on a chain."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from atlasphys.scene.library.parts import Body, Joint, Layout, box, capsule, cosine, ground, joint, sine, sphere, turned

HEIGHT, PITCH, LINKS, RADIUS = 9.0, 0.6, 10, 1.0
"""Of the hook, of a link, number of links, radius of the ball [m]."""


def wrecking_ball(
    angle: Annotated[float, Field(ge=0, le=90)] = 60.0, rows: Annotated[int, Field(ge=0, le=20)] = 6
) -> Layout:
    """A heavy ball on a chain swings into a tower of cubes."""
    bodies: list[Body] = [ground()]
    joints: list[Joint] = []
    dx, dy = -sine(angle), -cosine(angle)
    before: str | None = None
    for k in range(LINKS):
        way, name = PITCH * (k + 0.5), f"link {k}"
        place = (way * dx, HEIGHT + way * dy, 0.0)
        settings = {"orientation": turned((0, 0, 1), -angle), "density": 7800, "name": name}
        bodies.append(capsule(0.08, PITCH - 0.16, place, **settings))
        joints.append(joint("ball", before, name, anchor=(PITCH * k * dx, HEIGHT + PITCH * k * dy, 0)))
        before = name
    end = PITCH * LINKS
    bodies.append(sphere(RADIUS, ((end + RADIUS) * dx, HEIGHT + (end + RADIUS) * dy, 0), density=1000, name="ball"))
    joints.append(joint("ball", before, "ball", anchor=(end * dx, HEIGHT + end * dy, 0)))
    for row in range(rows):
        for k in range(9):
            place = (1.6 + k // 3, row + 0.5, k % 3 - 1.0)
            bodies.append(box((1, 1, 1), place, density=200, name=f"cube {row}.{k}"))
    return Layout(bodies, joints=joints)
