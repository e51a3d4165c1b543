"""Case 23: a chain that hangs at rest.

Each ball joint carries the weight of what is below it.
"""

from __future__ import annotations

import numpy as np

import atlasphys as ap
from atlasphys.validate.case import Case, G, MakeWorld, relative

LINKS, MASS, HALF = 10, 2.0, 0.25


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Hang ten capsules on each other, wait three seconds, and read the joints' forces and gaps."""
    world = make_world(gravity=(0, -G, 0))
    joints, above = [], None
    for k in range(LINKS):
        link = world.add(ap.Capsule(radius=0.1, length=0.3), position=(0, -HALF * (2 * k + 1), 0), mass=MASS)
        joints.append(world.join(ap.Ball(above, link, anchor=(0, -2 * HALF * k, 0))))
        above = link
    world.run(seconds=3, dt=dt)
    tensions = [float(np.sqrt(joint.reaction_force @ joint.reaction_force)) for joint in joints]
    weights = [MASS * G * (LINKS - k) for k in range(LINKS)]
    length = -float(world.bodies.position[-1, 1]) + HALF
    return {
        "tension": max(relative(tension, weight) for tension, weight in zip(tensions, weights, strict=True)),
        "length": relative(length, 2 * HALF * LINKS),
    }


CASE = Case(
    number=23,
    name="hanging chain",
    law="tension of each link = weight below it",
    measure=measure,
    tolerances={"tension": 0.01},
)
