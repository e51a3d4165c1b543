"""A heavy ball on a light chain."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from atlasphys.scene.library.chain import PITCH, string
from atlasphys.scene.library.parts import Layout, joint, sphere

RADIUS = 0.5


def rope_heavy(
    ratio: Annotated[float, Field(ge=1, le=1e4)] = 100.0, links: Annotated[int, Field(ge=1, le=200)] = 20
) -> Layout:
    """A ball on a chain of links that are lighter by the ratio: the chain holds."""
    bodies, joints = string(links)
    end = PITCH * links
    link_mass = 12.566370614359 * (2 / 3 + 1.5) / 2  # 1000 kg/m³ times π r² (4/3 r + length)
    bodies.append(sphere(RADIUS, (end + RADIUS, 0, 0), mass=ratio * link_mass, name="ball"))
    joints.append(joint("ball", f"link {links - 1}", "ball", anchor=(end, 0, 0)))
    return Layout(bodies, joints=joints)
