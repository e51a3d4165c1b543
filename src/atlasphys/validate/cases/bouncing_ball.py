"""Case 5: a bouncing ball.

Newton's law of restitution leaves e of the speed, so e² of the height, after each bounce: apex n is e^(2n) H. The fall takes √(2H/g), and the
n-th flight 2 eⁿ √(2H/g); the geometric series adds up to √(2H/g) (1 + e)/(1 − e), when the ball lies still after infinitely many bounces.
"""

from __future__ import annotations

import math

import numpy as np

import atlasphys as ap
from atlasphys.validate.case import Case, Curve, G, MakeWorld, record, relative
from atlasphys.world.body import Body
from atlasphys.world.world import World

DROP, RADIUS = 1.0, 0.25
RESTITUTIONS = (0.5, 0.8, 1.0)
LOWEST_APEX = 0.02
"""Apexes are compared down to this height [m]."""


def dropped(make_world: MakeWorld, restitution: float) -> tuple[World, Body]:
    """A ball at a height of DROP above the ground."""
    world = make_world(gravity=(0, -G, 0))
    world.add(ap.Plane(normal=(0, 1, 0)))
    return world, world.add(ap.Sphere(radius=RADIUS), position=(0, RADIUS + DROP, 0), restitution=restitution)


def bounce(make_world: MakeWorld, restitution: float, seconds: float, dt: float) -> tuple[list[float], float]:
    """Heights of the apexes, and the time of the last motion."""
    world, ball = dropped(make_world, restitution)
    apexes, before, stopped = [], 0.0, 0.0
    while world.time < seconds:
        height = float(ball.position[1]) - RADIUS
        world.step(dt)
        speed = float(ball.velocity[1])
        if before > 0 >= speed:
            apexes.append(height)
        if abs(speed) > 1e-3:
            stopped = world.time
        before = speed
    return apexes, stopped


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Drop three balls of different restitution."""
    fall = math.sqrt(2 * DROP / G)
    errors = {"apexes": 0.0, "total time": 0.0}
    for e in RESTITUTIONS:
        total = fall * (1 + e) / (1 - e) if e < 1 else 9 * fall
        apexes, stopped = bounce(make_world, e, total + 0.5, dt)
        number = math.floor(math.log(LOWEST_APEX / DROP) / (2 * math.log(e))) if e < 1 else 4
        found = [relative(apex, e ** (2 * n) * DROP) for n, apex in enumerate(apexes[:number], 1)]
        errors["apexes"] = max(errors["apexes"], *found, 0.0 if len(found) == number else math.inf)
        if e < 1:
            errors["total time"] = max(errors["total time"], relative(stopped, total))
    return errors


def curve(make_world: MakeWorld, dt: float) -> Curve:
    """Height of the ball that keeps 0.8 of its speed, for five bounces."""
    e, fall = 0.8, math.sqrt(2 * DROP / G)
    bounces = fall + 2 * fall * np.cumsum([0, *(e**n for n in range(1, 6))])
    world, ball = dropped(make_world, e)
    times, heights = record(world, dt, bounces[-1], lambda: ball.position[1] - RADIUS)
    flight = np.searchsorted(bounces, times, side="right")  # 0 is the fall
    since = np.where(flight > 0, times - bounces[flight - 1], times + fall)
    exact = since * (G * fall * e ** np.maximum(flight, 0) - 0.5 * G * since)
    return Curve("height, e = 0.8 [m]", times, heights, exact)


CASE = Case(
    number=5,
    name="bouncing ball",
    law="n-th apex e^(2n) H, total time √(2H/g) (1 + e)/(1 − e)",
    measure=measure,
    tolerances={"apexes": 0.01, "total time": 0.01},
    dt=1 / 1000,
    curve=curve,
)
