"""A rod on a hinge."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from atlasphys.scene.library.parts import Layout, box, cosine, joint, sine, turned


def pendulum(angle: Annotated[float, Field(ge=-179, le=179)] = 60.0) -> Layout:
    """A rod swings on a hinge, let go at an angle in degrees."""
    rod = box(
        (0.1, 1.0, 0.1), (0.5 * sine(angle), -0.5 * cosine(angle), 0), orientation=turned((0, 0, 1), angle), name="rod"
    )
    return Layout([rod], joints=[joint("hinge", None, "rod", anchor=(0, 0, 0), axis=(0, 0, 1), name="pivot")])
