"""A lesson in the plane: polygons, as prisms whose ends are out of reach."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from atlasphys.scene.library.parts import Layout, Vector, body, turned

TRIANGLE = ((-0.55, -0.4), (0.65, -0.45), (0.05, 0.7))
PENTAGON = ((0.5, -0.1), (0.2, 0.5), (-0.4, 0.4), (-0.5, -0.2), (0.1, -0.5))
HALF_LENGTH = 2.0
"""Half the length of the prisms along z [m]: more than any depth in the plane."""


def polygons(distance: Annotated[float, Field(ge=0, le=10)] = 1.4) -> Layout:
    """Two polygons in a plane: the first lesson on GJK."""
    return Layout(
        [
            body("convex_hull", (0, 0, 0), {"points": _prism(TRIANGLE)}, name="triangle"),
            body(
                "convex_hull",
                (distance, 0.3, 0),
                {"points": _prism(PENTAGON)},
                orientation=turned((0, 0, 1), 17),
                name="pentagon",
            ),
        ],
        world={"gravity": (0, 0, 0)},
        seconds=1.0,
    )


def _prism(corners: tuple[tuple[float, float], ...]) -> list[Vector]:
    return [(x, y, z) for z in (-HALF_LENGTH, HALF_LENGTH) for x, y in corners]
