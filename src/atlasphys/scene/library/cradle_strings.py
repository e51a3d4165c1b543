"""Newton's cradle, hung up."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from atlasphys.scene.library.parts import Layout, cosine, joint, sine, sphere

RADIUS, LENGTH, SPREAD, GAP = 0.25, 2.0, 0.5, 0.03
"""Of a ball; height of its hooks above it; half their distance; distance of neighbours [m]."""


def cradle_strings(
    balls: Annotated[int, Field(ge=2, le=20)] = 5,
    moving: Annotated[int, Field(ge=1, le=19)] = 1,
    angle: Annotated[float, Field(gt=0, le=60)] = 30.0,
) -> Layout:
    """Newton's cradle on strings: as many balls leave as arrive."""
    # As in newtons_cradle the balls hang apart and the step is short, so that each collision happens by itself.
    bodies, joints = [], []
    for k in range(balls):
        x = (2 * RADIUS + GAP) * k
        tilt = -angle if k < min(moving, balls - 1) else 0.0
        place = (x + LENGTH * sine(tilt), -LENGTH * cosine(tilt), 0.0)
        bodies.append(sphere(RADIUS, place, density=7800, friction=0.0, restitution=1.0, name=f"ball {k}"))
        for side, z in (("left", -SPREAD), ("right", SPREAD)):
            joints.append(joint("distance", None, f"ball {k}", anchor_a=(x, 0, z), name=f"{side} string {k}"))
    return Layout(bodies, joints=joints, world={"restitution_threshold": 0.0}, dt=1 / 240)
