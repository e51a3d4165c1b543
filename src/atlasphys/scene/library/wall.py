"""A brick wall in running bond, hit by a ball."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from atlasphys.scene.library.parts import Body, Layout, box, ground, sphere

LENGTH, HEIGHT, DEPTH = 1.0, 0.5, 0.5
"""Size of a brick [m]."""


def wall(
    bricks: Annotated[int, Field(ge=2, le=200)] = 8,
    rows: Annotated[int, Field(ge=1, le=100)] = 8,
    ball_speed: Annotated[float, Field(ge=0, le=100)] = 15.0,
) -> Layout:
    """A heavy ball hits a brick wall, which stands with ball_speed=0."""
    spacing = LENGTH + 0.02
    bodies: list[Body] = [ground()]
    for row in range(rows):
        y = HEIGHT * (row + 0.5)
        shift = 0.0 if row % 2 == 0 else 0.5
        for k in range(bricks - row % 2):
            x = spacing * (k + shift - 0.5 * (bricks - 1))
            bodies.append(box((LENGTH, HEIGHT, DEPTH), (x, y, 0), name=f"brick {row}.{k}"))
        if row % 2:  # half bricks close the ends
            end = 0.5 * spacing * (bricks - 1) + 0.25 * LENGTH
            for side, x in (("left", -end), ("right", end)):
                bodies.append(box((0.5 * LENGTH, HEIGHT, DEPTH), (x, y, 0), name=f"half brick {row} {side}"))
    if ball_speed > 0:
        middle = 0.5 * rows * HEIGHT
        bodies.append(
            sphere(
                0.6,
                (0, max(middle, 0.6), 8),
                velocity=(0, 0, -ball_speed),
                density=5000,
                rolling_friction=0.05,
                name="ball",
            )
        )
    return Layout(bodies)
