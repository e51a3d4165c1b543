"""Case 22: a pyramid of cubes, twenty in the lowest row, stands."""

from __future__ import annotations

import numpy as np

import atlasphys as ap
from atlasphys.validate.case import Case, G, MakeWorld

BASE = 20


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Let the pyramid stand for ten seconds."""
    world = make_world(gravity=(0, -G, 0))
    world.add(ap.Plane(normal=(0, 1, 0)))
    for row in range(BASE):
        for i in range(BASE - row):
            top = world.add(ap.Box(size=(1, 1, 1)), position=(1.1 * (i - 0.5 * (BASE - row - 1)), 0.5 + row, 0))
    start = top.position
    world.run(seconds=10, dt=dt)
    return {
        "drift of the top [m]": float(np.linalg.norm(top.position - start)),
        "kinetic energy [J]": world.energy().kinetic,
    }


CASE = Case(
    number=22,
    name="pyramid",
    law="a pyramid of base 20 stands 10 s, the top drifting by less than 5 cm, kinetic energy below 1 J",
    measure=measure,
    tolerances={"drift of the top [m]": 0.05, "kinetic energy [J]": 1.0},
)
