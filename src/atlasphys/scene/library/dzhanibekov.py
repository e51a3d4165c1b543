"""The theorem of the tennis racket, seen by Vladimir Dzhanibekov on a wing nut in orbit."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from atlasphys.scene.library.parts import Layout, box


def dzhanibekov(
    spin: Annotated[float, Field(gt=0, le=100)] = 6.0, nudge: Annotated[float, Field(ge=0, le=1)] = 0.01
) -> Layout:
    """A box spins about its middle axis and turns over again and again."""
    # Of a box 1 × 0.1 × 0.4 the moments are least about x, greatest about y and between them about z.
    racket = box((1, 0.1, 0.4), (0, 0, 0), angular_velocity=(nudge * spin, 0, spin), name="racket")
    return Layout([racket], world={"gravity": (0, 0, 0)}, seconds=30.0)
