"""Case 30: Painlevé's rod.

The lower end of a uniform rod slides along the ground, leading; the rod rises behind it at an angle θ. The end's normal acceleration per unit of
normal force N is (1 + 3 cos² θ − 3 μ sin θ cos θ)/m, which is negative for μ = 1.6 and tan θ from 1.08 to 3.72: N drives the end into the ground,
no finite N holds it there, and rigid bodies with Coulomb friction have no consistent answer (Painlevé 1895; possible from μ = 4/3 on, Génot and
Brogliato 1999). In nature the end jams. An engine must go on with finite numbers and gain no energy.
"""

from __future__ import annotations

import math

import numpy as np

import atlasphys as ap
from atlasphys.validate.case import Case, G, MakeWorld

FRICTION, LENGTH, WIDTH, SPEED, SECONDS = 1.6, 1.0, 0.02, 5.0, 2.0
ANGLES = (0.9, 1.05, 1.2)
"""θ [rad]; tan θ = 1.26, 1.74, 2.57."""


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Let three rods slide, and watch their energy."""
    gained, wrong = 0.0, 0
    for angle in ANGLES:
        sine, cosine = round(math.sin(angle), 15), round(math.cos(angle), 15)
        world = make_world(gravity=(0, -G, 0))
        world.add(ap.Plane(normal=(0, 1, 0)), friction=FRICTION)
        half = round(math.cos(0.5 * angle), 15), 0.0, 0.0, round(math.sin(0.5 * angle), 15)
        lowest = 0.5 * (LENGTH * sine + WIDTH * cosine)
        world.add(
            ap.Box(size=(LENGTH, WIDTH, WIDTH)),
            position=(0, lowest, 0),
            orientation=half,
            velocity=(-SPEED, 0, 0),
            friction=FRICTION,
        )
        first = world.energy()
        for _ in range(round(SECONDS / dt)):
            world.step(dt)
            now = world.energy().total
            gained = max(gained, (now - first.total) / first.kinetic)
        wrong += not np.isfinite(world.bodies.position).all()
    return {"energy gained": gained, "not finite [cases]": float(wrong)}


CASE = Case(
    number=30,
    name="Painlevé's rod",
    law="no consistent rigid answer: finite states, no energy gained",
    measure=measure,
    tolerances={"energy gained": 0.01, "not finite [cases]": 0.0},
)
