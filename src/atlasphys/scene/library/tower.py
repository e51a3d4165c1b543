"""A straight stack: the oldest test of a solver."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from atlasphys.scene.library.parts import Layout, box, ground


def tower(height: Annotated[int, Field(ge=1, le=1000)] = 10) -> Layout:
    """Unit cubes stand one on another and should stay so."""
    return Layout([ground(), *(box((1, 1, 1), (0, k + 0.5, 0), name=f"cube {k}") for k in range(height))])
