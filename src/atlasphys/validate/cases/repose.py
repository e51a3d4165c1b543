"""Case 31: the angle of repose.

A heap of grains is the steeper the rougher they are: its angle rises with μ and with rolling friction. There is no closed form for it, but the
trend is found in every experiment (Zhou et al. 1999). A column of balls collapses on ground of the same material; the angle of the heap follows
from means that a cone of height h and base R has, h/4 for the height and R/2 for the distance from the axis.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import atlasphys as ap
from atlasphys.validate.case import Case, G, MakeWorld

RADIUS, SIDE, LAYERS, SECONDS = 0.2, 4, 9, 4.0

MATERIALS = ((0.1, 0.1), (0.5, 0.1), (0.5, 0.4))
"""μ and rolling friction over R, each a step rougher than the one before."""


def angle(make_world: MakeWorld, friction: float, rolling: float, dt: float) -> float:
    """Angle of the heap [degrees]."""
    world = make_world(gravity=(0, -G, 0))
    material: dict[str, Any] = {"friction": friction, "rolling_friction": rolling * RADIUS}
    world.add(ap.Plane(normal=(0, 1, 0)), **material)
    random = np.random.default_rng(31)
    for layer in range(LAYERS):
        for i in range(SIDE):
            for k in range(SIDE):
                aside = 2.05 * RADIUS * (np.array([i, k]) - 0.5 * (SIDE - 1)) + random.uniform(-0.01, 0.01, 2)
                place = (aside[0], RADIUS * (1 + 2.02 * layer), aside[1])
                world.add(ap.Sphere(radius=RADIUS), position=place, **material)
    world.run(seconds=SECONDS, dt=dt)
    position = world.bodies.position[1:]
    away = np.hypot(position[:, 0], position[:, 2])
    return math.degrees(math.atan(2 * float((position[:, 1] - RADIUS).mean()) / float(away.mean())))


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Heap three materials."""
    angles = [angle(make_world, friction, rolling, dt) for friction, rolling in MATERIALS]
    errors = {
        f"{what} does not raise the angle [cases]": float(not above > 1.05 * below)
        for what, below, above in zip(("friction", "rolling friction"), angles, angles[1:], strict=False)
    }
    shown = {f"angle [°], μ = {m:g}, rolling {r:g} R": value for (m, r), value in zip(MATERIALS, angles, strict=True)}
    return errors | shown


CASE = Case(
    number=31,
    name="angle of repose",
    law="rises with μ and with rolling friction",
    measure=measure,
    tolerances={f"{what} does not raise the angle [cases]": 0.0 for what in ("friction", "rolling friction")},
)
