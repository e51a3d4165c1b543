"""Case 32: the order of the integrator.

Semi-implicit Euler errs from the parabola y0 + v0 t − ½ g t² by ½ g t h at time t: in proportion to the step. Its error in the period of an
oscillation is of second order (cases 10 and 11 show it for rotation; the pendulum's needs a joint). The order is the slope of the logarithms.
"""

from __future__ import annotations

import math

import numpy as np

import atlasphys as ap
from atlasphys.validate.case import Case, G, MakeWorld

SECONDS = 1.0


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Throw a ball with steps of 4 dt, 2 dt and dt."""
    steps, errors = (4 * dt, 2 * dt, dt), []
    for h in steps:
        world = make_world(gravity=(0, -G, 0))
        ball = world.add(ap.Sphere(radius=0.5), position=(0, 3, 0), velocity=(2, 4, -1))
        world.run(seconds=SECONDS, dt=h)
        t = world.time
        errors.append(abs(float(ball.position[1]) - (3 + 4 * t - 0.5 * G * t * t)))
    if max(errors) < 1e-12:
        return {"order of the trajectory": 0.0}
    slope = float(np.polyfit(np.log(steps), np.log(np.maximum(errors, math.ulp(1.0))), 1)[0])
    return {"order of the trajectory": abs(slope - 1)}


CASE = Case(
    number=32,
    name="order of the integrator",
    law="the trajectory's error falls with dt to the power 1",
    measure=measure,
    tolerances={"order of the trajectory": 0.2},
    precision="double",
)
