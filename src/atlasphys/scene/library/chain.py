"""A chain of capsules."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from atlasphys.scene.library.parts import ALONG_X, Body, Joint, Layout, capsule, joint

RADIUS, PITCH = 0.1, 0.5
"""Of a link, and distance from joint to joint [m]."""


def string(count: int, density: float = 1000.0) -> tuple[list[Body], list[Joint]]:
    """Capsules in a row along x from the origin, each joined with the one before and the first with the world."""
    bodies = [
        capsule(
            RADIUS,
            PITCH - 2 * RADIUS,
            (PITCH * (k + 0.5), 0, 0),
            orientation=ALONG_X,
            density=density,
            name=f"link {k}",
        )
        for k in range(count)
    ]
    joints = [
        joint("ball", f"link {k - 1}" if k else None, f"link {k}", anchor=(PITCH * k, 0, 0)) for k in range(count)
    ]
    return bodies, joints


def chain(links: Annotated[int, Field(ge=1, le=1000)] = 20) -> Layout:
    """A chain of capsules on ball joints, stretched out sideways, is let go."""
    bodies, joints = string(links)
    return Layout(bodies, joints=joints)
