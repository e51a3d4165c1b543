"""Sliding and rolling down a slope."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from atlasphys.scene.library.parts import Layout, Vector, body, box, cosine, sine, sphere, turned


def incline(
    angle: Annotated[float, Field(ge=0, le=80)] = 25.0, friction: Annotated[float, Field(ge=0, le=10)] = 0.5
) -> Layout:
    """A block that slides if tan(angle) > friction; a ball and a cylinder roll."""
    s, c = sine(angle), cosine(angle)

    def resting(height: float, z: float) -> Vector:
        """A point at that distance from the slope, which falls towards +x."""
        return height * s, height * c, z

    tilt = turned((0, 0, 1), -angle)
    slope = {"shape": {"type": "plane", "normal": (s, c, 0)}, "friction": friction, "name": "slope"}
    # The cylinder lies along z: its own axis, y, is first turned to z, then all is tilted with the slope.
    half = turned((1, 0, 0), 90.0)
    lying = tuple(
        round(value, 12)
        for value in (
            tilt[0] * half[0],
            tilt[0] * half[1],
            tilt[3] * half[1],
            tilt[3] * half[0],
        )
    )
    return Layout(
        [
            slope,
            box((1, 0.5, 1), resting(0.25, 0), orientation=tilt, friction=friction, name="block"),
            sphere(0.5, resting(0.5, 2), friction=friction, name="ball"),
            body(
                "cylinder",
                resting(0.5, -2),
                {"radius": 0.5, "length": 1.0},
                orientation=lying,
                friction=friction,
                name="cylinder",
            ),
        ],
        seconds=5.0,
    )
