"""Case 25: blocks stacked over the edge of a table.

The blocks above level n, counted from the top, have their common centre of mass over the edge of the one below if each overhangs by L/(2n): the
whole stack then reaches ½ L Σ 1/n beyond the table (the harmonic stack), and every joint of it is on the verge of tipping. With all overhangs scaled
by f it stands iff f ≤ 1.
"""

from __future__ import annotations

import numpy as np

import atlasphys as ap
from atlasphys.validate.case import Case, G, MakeWorld

LENGTH, HEIGHT, BLOCKS, SECONDS = 1.0, 0.2, 4, 3.0
MOVED = 0.02
"""A stack any block of which has moved this far has fallen [m]."""


def falls(make_world: MakeWorld, factor: float, dt: float) -> bool:
    """Whether a stack whose overhangs are ``factor`` of the greatest falls."""
    world = make_world(gravity=(0, -G, 0))
    world.add(ap.Box(size=(4, 1, 1)), position=(-2, -0.5, 0), kind="static")
    edge = 0.0
    for level in range(BLOCKS):
        edge += factor * LENGTH / (2 * (BLOCKS - level))
        world.add(
            ap.Box(size=(LENGTH, HEIGHT, 0.6)), position=(edge - 0.5 * LENGTH, (level + 0.5) * HEIGHT, 0), density=100
        )
    start = world.bodies.position.copy()
    world.run(seconds=SECONDS, dt=dt)
    return float(np.abs(world.bodies.position - start).max()) > MOVED


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Find by bisection, to 0.1 %, how far the stack can reach."""
    low, high = 0.9, 1.1
    while high - low > 1e-3:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if falls(make_world, middle, dt) else (middle, high)
    return {"greatest overhang": abs(0.5 * (low + high) - 1)}


CASE = Case(
    number=25,
    name="block overhang",
    law="stands iff the stack reaches less than ½ L Σ 1/n beyond the table",
    measure=measure,
    tolerances={"greatest overhang": 0.02},
)
