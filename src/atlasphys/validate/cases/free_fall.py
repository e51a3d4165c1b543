"""Case 1: free fall.

Semi-implicit Euler, v ← v − g h, then y ← y + h v, summed over n steps (an arithmetic series) gives
y = y0 + v0 t − g h² n (n + 1)/2 = y0 + v0 t − ½ g t (t + h) at t = n h, with h the substep: not an approximation but what the scheme must give, to
round-off.
"""

from __future__ import annotations

import atlasphys as ap
from atlasphys.validate.case import Case, G, MakeWorld


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Throw a ball up and sideways and follow it for two seconds."""
    world = make_world(gravity=(0, -G, 0))
    ball = world.add(ap.Sphere(radius=0.5), position=(0, 3, 0), velocity=(2, 4, -1))
    worst_height = worst_side = 0.0
    for n in range(1, round(2 / dt) + 1):
        world.step(dt)
        t = n * dt
        x, y, z = ball.position
        worst_height = max(worst_height, abs(y - (3 + 4 * t - 0.5 * G * t * (t + dt / world.substeps))))
        worst_side = max(worst_side, abs(x - 2 * t), abs(z + t))
    return {"height": worst_height / 3, "sideways": worst_side / 4}


CASE = Case(
    number=1,
    name="free fall",
    law="y = y0 + v0 t − ½ g t (t + h) after every step",
    measure=measure,
    tolerances={"height": 1e-12, "sideways": 1e-12},
    precision="double",
)
