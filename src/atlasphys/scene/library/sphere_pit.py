"""A granular pile."""

from __future__ import annotations

import math
import random
from typing import Annotated

from pydantic import Field

from atlasphys.scene.library.parts import Layout, pit, sphere


def sphere_pit(
    count: Annotated[int, Field(ge=1, le=100_000)] = 200, seed: Annotated[int, Field(ge=0, le=2**32)] = 1
) -> Layout:
    """Spheres fall into a pit and come to rest as a pile."""
    number = random.Random(seed).random
    side = max(2, math.ceil(count ** (1 / 3)))
    bodies = pit(float(side), 1.5 * side)
    for k in range(count):
        layer, place = divmod(k, (side - 1) ** 2)
        row, column = divmod(place, side - 1)
        x, z = (n - 0.5 * (side - 2) + 0.1 * (number() - 0.5) for n in (column, row))
        bodies.append(sphere(0.4, (x, 1.0 + layer, z), name=f"sphere {k}"))
    return Layout(bodies)
