"""All shapes together."""

from __future__ import annotations

import random
from typing import Annotated, Any

from pydantic import Field

from atlasphys.scene.library.parts import Layout, body, pit

SHAPES: list[tuple[str, dict[str, Any]]] = [
    ("sphere", {"radius": 0.4}),
    ("box", {"size": (0.8, 0.6, 0.7)}),
    ("capsule", {"radius": 0.3, "length": 0.6}),
    ("cylinder", {"radius": 0.4, "length": 0.7}),
    ("cone", {"radius": 0.45, "height": 0.8}),
    ("octahedron", {"radius": 0.5}),
]


def mixed_shapes(
    count: Annotated[int, Field(ge=1, le=5000)] = 36, seed: Annotated[int, Field(ge=0, le=2**32)] = 1
) -> Layout:
    """Shapes of all kinds, turned at random, fall into a pit."""
    number = random.Random(seed).random
    bodies = pit(4.0, 3.0)
    for k in range(count):
        kind, sizes = SHAPES[k % len(SHAPES)]
        layer, place = divmod(k, 9)
        row, column = divmod(place, 3)
        position = (
            1.25 * (column - 1) + 0.1 * (number() - 0.5),
            1.0 + 1.3 * layer,
            1.25 * (row - 1) + 0.1 * (number() - 0.5),
        )
        orientation = tuple(2 * number() - 1 for _ in range(4))
        bodies.append(body(kind, position, sizes, orientation=orientation, name=f"{kind} {k}"))
    return Layout(bodies)
