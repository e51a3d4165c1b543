"""A net of balls."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from atlasphys.scene.library.parts import Body, Joint, Layout, joint, sphere

HELD = 3
"""Balls to either side of the middle that the net hangs by."""


def joint_grid(side: Annotated[int, Field(ge=2, le=300)] = 40) -> Layout:
    """A square net of balls on ball joints hangs by its edge (Box3D: side=100)."""
    bodies: list[Body] = []
    joints: list[Joint] = []
    for column in range(side):
        for row in range(side):
            here, x, y = f"ball {column}.{row}", float(column), float(-row)
            bodies.append(sphere(0.4, (x, y, 0), mask=0, name=here))  # its balls do not collide
            if row > 0:
                joints.append(joint("ball", f"ball {column}.{row - 1}", here, anchor=(x, y + 0.5, 0)))
            elif abs(column - side // 2) <= HELD:
                joints.append(joint("ball", None, here, anchor=(x, 0.5, 0)))
            if column > 0:
                joints.append(joint("ball", f"ball {column - 1}.{row}", here, anchor=(x - 0.5, y, 0)))
    return Layout(bodies, joints=joints)
