"""A row of equal balls: as many leave as arrive."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from atlasphys.scene.library.parts import Layout, sphere


def newtons_cradle(
    balls: Annotated[int, Field(ge=2, le=50)] = 5,
    moving: Annotated[int, Field(ge=1, le=49)] = 1,
    speed: Annotated[float, Field(gt=0, le=20)] = 2.0,
) -> Layout:
    """Elastic balls float in a row: as many leave as arrive."""
    # The gaps are wider than the way of a ball in a step plus the margin: each collision happens by itself.
    gap = 0.1 + speed / 60
    arriving = min(moving, balls - 1)
    bodies = [
        sphere(
            0.5,
            ((1 + gap) * k - (2.0 if k < arriving else 0.0), 0, 0),
            velocity=(speed if k < arriving else 0.0, 0, 0),
            restitution=1.0,
            friction=0.0,
            name=f"ball {k}",
        )
        for k in range(balls)
    ]
    return Layout(bodies, world={"gravity": (0, 0, 0), "restitution_threshold": 0.0}, seconds=5.0)
