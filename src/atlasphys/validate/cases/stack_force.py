"""Case 19: the forces inside a resting stack.

Each level carries the weight above it: the normal impulses between two bodies of the stack, over dt, add up to the weight of all that lie higher.
"""

from __future__ import annotations

import atlasphys as ap
from atlasphys.validate.case import Case, G, MakeWorld, relative
from atlasphys.world.world import World

LEVELS, MASS = 10, 10.0


def forces(world: World, dt: float) -> list[float]:
    """Normal force [N] under each body of a stack whose bodies were added from the ground up, the ground first."""
    contacts = world.contacts
    return [float(contacts.normal_impulse[contacts.body_b == row].sum()) / dt for row in range(1, len(world.bodies))]


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Stack ten cubes, wait three seconds, and read the forces of the last step."""
    world = make_world(gravity=(0, -G, 0))
    world.add(ap.Plane(normal=(0, 1, 0)))
    for level in range(LEVELS):
        world.add(ap.Box(size=(1, 1, 1)), position=(0, 0.5 + level, 0), mass=MASS)
    world.run(seconds=3, dt=dt)
    weights = [MASS * G * (LEVELS - level) for level in range(LEVELS)]
    return {"force": max(relative(force, weight) for force, weight in zip(forces(world, dt), weights, strict=True))}


CASE = Case(
    number=19,
    name="forces in a stack",
    law="Σ normal impulse / dt under each level = the weight above",
    measure=measure,
    tolerances={"force": 0.01},
)
