"""The smallest stack."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from atlasphys.scene.library.parts import Layout, box, ground


def two_boxes(drop: Annotated[float, Field(ge=0, le=100)] = 1.0) -> Layout:
    """A cube falls on a cube that rests on a plane."""
    return Layout(
        [ground(), box((1, 1, 1), (0, 0.5, 0), name="lower"), box((1, 1, 1), (0, 1.5 + drop, 0), name="upper")],
        seconds=5.0,
    )
