"""A wall that narrows to one box: many contacts, long chains of them."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from atlasphys.scene.library.parts import Layout, box, ground


def pyramid(base: Annotated[int, Field(ge=1, le=200)] = 20, gap: Annotated[float, Field(ge=0, le=0.5)] = 0.1) -> Layout:
    """Rows of unit cubes, each row one shorter than the one below."""
    spacing = 1.0 + gap
    return Layout(
        [
            ground(),
            *(
                box((1, 1, 1), (spacing * (k - 0.5 * (base - row - 1)), row + 0.5, 0), name=f"cube {row}.{k}")
                for row in range(base)
                for k in range(base - row)
            ),
        ]
    )
