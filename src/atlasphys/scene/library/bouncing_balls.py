"""Restitution from none to all."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from atlasphys.scene.library.parts import Layout, ground, sphere


def bouncing_balls(
    count: Annotated[int, Field(ge=2, le=100)] = 6, height: Annotated[float, Field(ge=0, le=1000)] = 4.0
) -> Layout:
    """Balls of restitution from 0 to 1 fall side by side."""
    balls = (
        sphere(0.5, (1.5 * (k - 0.5 * (count - 1)), height + 0.5, 0), restitution=k / (count - 1), name=f"ball {k}")
        for k in range(count)
    )
    return Layout([ground(), *balls], world={"restitution_threshold": 0.1})
