"""Case 17: Newton's cradle.

Balls of equal mass that collide elastically one after another exchange velocities, so n balls that run into a row at rest send n balls off at the
far end. The gaps are wider than v dt and the contact margin together, so that each impact is between two balls only.
"""

from __future__ import annotations

import numpy as np

import atlasphys as ap
from atlasphys.validate.case import Case, MakeWorld

BALLS, RADIUS, SPEED = 5, 0.25, 2.0


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Send one, two and three of five balls against the others."""
    gap = 0.05 + 2 * SPEED * dt
    errors = {}
    for moving in (1, 2, 3):
        world = make_world(gravity=(0, 0, 0))
        for i in range(BALLS):
            world.add(
                ap.Sphere(radius=RADIUS),
                position=(i * (2 * RADIUS + gap), 0, 0),
                velocity=(SPEED if i < moving else 0, 0, 0),
                mass=1,
                restitution=1,
            )
        world.run(seconds=2 * BALLS * gap / SPEED, dt=dt)
        expected = np.where(np.arange(BALLS) < BALLS - moving, 0, SPEED)
        errors[f"velocities, {moving} in"] = float(np.abs(world.bodies.velocity[:, 0] - expected).max()) / SPEED
    return errors


CASE = Case(
    number=17,
    name="Newton's cradle",
    law="n in, n out at the same speed; the others at rest",
    measure=measure,
    tolerances={f"velocities, {moving} in": 0.01 for moving in (1, 2, 3)},
)
