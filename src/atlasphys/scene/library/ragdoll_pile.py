"""Many ragdolls."""

from __future__ import annotations

import math
import random
from typing import Annotated

from pydantic import Field

from atlasphys.scene.library.parts import Joint, Layout, pit, turned
from atlasphys.scene.library.ragdoll import figure

CELL, STOREY, LAYERS = 1.75, 1.9, 5
"""Space for a figure, sideways and in height [m]; layers, one above the other."""


def ragdoll_pile(
    count: Annotated[int, Field(ge=1, le=1000)] = 20, seed: Annotated[int, Field(ge=0, le=2**32)] = 1
) -> Layout:
    """Ragdolls fall into a pit and come to rest as a pile."""
    number = random.Random(seed).random
    side = math.ceil(math.sqrt(count / LAYERS))
    bodies, joints = pit(CELL * side, 1.0), list[Joint]()
    for k in range(count):
        layer, place = divmod(k, side * side)
        row, column = divmod(place, side)
        where = (CELL * (column - 0.5 * (side - 1)), 0.1 + STOREY * layer, CELL * (row - 0.5 * (side - 1)))
        added = figure(where, turned((0, 1, 0), 360 * number()), f"{k} ")
        bodies += added[0]
        joints += added[1]
    return Layout(bodies, joints=joints)
