"""A wave that runs along a row."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from atlasphys.scene.library.parts import Layout, box, cosine, ground, sine, turned

THICKNESS, HEIGHT, WIDTH = 0.2, 1.0, 0.5
"""Size of a domino [m]."""

LEAN = 14.0
"""Angle of the first domino [degrees]; at 11.3 its centre is above its lower edge."""

SPIN = 1.5
"""Speed at which the first domino turns about that edge at the start [rad/s]. Let go without it, it would lean on the second."""


def dominoes(
    count: Annotated[int, Field(ge=2, le=1000)] = 20, spacing: Annotated[float, Field(ge=0.45, le=1)] = 0.5
) -> Layout:
    """The first domino is pushed beyond its balance and fells the row."""
    size = (THICKNESS, HEIGHT, WIDTH)
    s, c = sine(LEAN), cosine(LEAN)
    # The first one has been turned about its lower edge on the right, which is at x = THICKNESS / 2.
    x = 0.5 * (THICKNESS - THICKNESS * c + HEIGHT * s)
    y = 0.5 * (THICKNESS * s + HEIGHT * c)
    motion = {"velocity": (SPIN * y, SPIN * (0.5 * THICKNESS - x), 0), "angular_velocity": (0, 0, -SPIN)}
    first = box(size, (x, y, 0), orientation=turned((0, 0, 1), -LEAN), **motion, name="domino 0")
    rest = (box(size, (spacing * k, 0.5 * HEIGHT, 0), name=f"domino {k}") for k in range(1, count))
    return Layout([ground(), first, *rest], seconds=max(5.0, 0.2 * count))
