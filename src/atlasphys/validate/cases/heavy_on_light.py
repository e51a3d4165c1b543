"""Case 20: a heavy cube on a light one.

At rest the lower contact carries both weights and the upper one the heavy one's, whatever the ratio of masses; nothing moves.
Iterative solvers need a number of sweeps that grows with the ratio, which shows as sinking.
"""

from __future__ import annotations

import numpy as np

import atlasphys as ap
from atlasphys.validate.case import Case, G, MakeWorld, relative
from atlasphys.validate.cases.stack_force import forces

RATIOS = (10, 100, 1000)
SLOP = 0.005
"""Overlap that the engine leaves uncorrected [m]."""


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Let each pair of cubes stand for five seconds."""
    errors = {}
    for ratio in RATIOS:
        world = make_world(gravity=(0, -G, 0))
        world.add(ap.Plane(normal=(0, 1, 0)))
        world.add(ap.Box(size=(1, 1, 1)), position=(0, 0.5, 0), mass=1)
        world.add(ap.Box(size=(1, 1, 1)), position=(0, 1.5, 0), mass=ratio)
        start = world.bodies.position.copy()
        world.run(seconds=5, dt=dt)
        weights = (G * (1 + ratio), G * ratio)
        errors[f"force, {ratio} : 1"] = max(relative(f, w) for f, w in zip(forces(world, dt), weights, strict=True))
        errors[f"overlap over slop, {ratio} : 1"] = max(float(world.contacts.depth.max()) / SLOP, 0.0)
        errors[f"motion [m], {ratio} : 1"] = float(np.abs(world.bodies.position - start).max())
    return errors


CASE = Case(
    number=20,
    name="heavy on light",
    law="forces as in case 19; overlap below the slop; moves less than 1 mm in 5 s",
    measure=measure,
    tolerances={
        f"{error}, {ratio} : 1": limit
        for ratio in RATIOS
        for error, limit in (("force", 0.01), ("overlap over slop", 1.0), ("motion [m]", 1e-3))
    },
)
