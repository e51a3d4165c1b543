"""High mass ratios, which iterative solvers find hard."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from atlasphys.scene.library.parts import Layout, box, ground


def heavy_on_light(ratio: Annotated[float, Field(ge=1, le=1e6)] = 100.0) -> Layout:
    """A cube rests on one that is `ratio` times lighter."""
    return Layout(
        [
            ground(),
            box((1, 1, 1), (0, 0.5, 0), mass=10.0, name="light"),
            box((1, 1, 1), (0, 1.5, 0), mass=10.0 * ratio, name="heavy"),
        ],
        seconds=5.0,
    )
