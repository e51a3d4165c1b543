"""Case 21: towers of cubes stand.

A tower of rigid cubes, put down exactly, is in equilibrium, and stable: its top stays where it is.
"""

from __future__ import annotations

import numpy as np

import atlasphys as ap
from atlasphys.validate.case import Case, G, MakeWorld

HEIGHTS = (10, 20, 50)


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Let each tower stand for ten seconds."""
    errors = {}
    for height in HEIGHTS:
        world = make_world(gravity=(0, -G, 0))
        world.add(ap.Plane(normal=(0, 1, 0)))
        for level in range(height):
            top = world.add(ap.Box(size=(1, 1, 1)), position=(0, 0.5 + level, 0))
        world.run(seconds=10, dt=dt)
        errors[f"drift of the top [m], {height} cubes"] = float(np.linalg.norm(top.position - (0, height - 0.5, 0)))
    return errors


CASE = Case(
    number=21,
    name="towers",
    law="towers of 10, 20 and 50 cubes stand 10 s, the top drifting by less than 1 cm",
    measure=measure,
    tolerances={f"drift of the top [m], {height} cubes": 0.01 for height in HEIGHTS},
)
