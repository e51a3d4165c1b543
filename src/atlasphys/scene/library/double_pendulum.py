"""Two rods on hinges."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from atlasphys.scene.library.parts import Layout, box, cosine, joint, sine, turned


def double_pendulum(
    upper: Annotated[float, Field(ge=-180, le=180)] = 120.0, lower: Annotated[float, Field(ge=-180, le=180)] = 120.0
) -> Layout:
    """Two rods, one hinged to the other, swing chaotically."""
    bodies, joints = [], []
    above, x, y = None, 0.0, 0.0
    for name, angle in (("upper", upper), ("lower", lower)):
        dx, dy = sine(angle), -cosine(angle)
        place = (x + 0.5 * dx, y + 0.5 * dy, 0.0)
        bodies.append(box((0.1, 1.0, 0.1), place, orientation=turned((0, 0, 1), angle), name=name))
        joints.append(joint("hinge", above, name, anchor=(x, y, 0), axis=(0, 0, 1)))
        above, x, y = name, x + dx, y + dy
    return Layout(bodies, joints=joints)
