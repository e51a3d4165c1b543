"""The scene of the articles' first version."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from atlasphys.scene.library.parts import Body, Layout, box, ground, sphere


def demo(pairs: Annotated[int, Field(ge=1, le=500)] = 4) -> Layout:
    """Cubes and spheres fall one after another on a plane."""
    bodies: list[Body] = [ground()]
    for k in range(pairs):
        bodies.append(box((1, 1, 1), (0.25 * (k % 3), 1.0 + 2.5 * k, 0.0), name=f"cube {k}"))
        bodies.append(
            sphere(
                0.5, (0.1, 2.25 + 2.5 * k, 0.2 * (k % 2)), restitution=0.3, rolling_friction=0.02, name=f"sphere {k}"
            )
        )
    return Layout(bodies)
