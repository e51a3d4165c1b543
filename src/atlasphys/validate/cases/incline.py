"""Case 2: a block on an incline.

Coulomb: along the slope gravity pulls with m g sin θ, and friction can hold at most μ N = μ m g cos θ. So the block holds if
tan θ ≤ μ, and otherwise slides with a = g (sin θ − μ cos θ).
"""

from __future__ import annotations

import math

import numpy as np

import atlasphys as ap
from atlasphys.validate.case import Case, Curve, G, MakeWorld, record, relative, turned_about_z
from atlasphys.world.body import Body
from atlasphys.world.world import World

FRICTIONS = (0.2, 1.0)
SECONDS = 5.0


def block_on_incline(
    make_world: MakeWorld, slope: float, friction: float, size: tuple[float, float, float]
) -> tuple[World, Body]:
    """A world with a plane that falls towards +x at tan θ = ``slope``, and a block that lies flat on it at the origin."""
    angle = math.atan(slope)
    sine, cosine = round(math.sin(angle), 15), round(math.cos(angle), 15)
    world = make_world(gravity=(0, -G, 0))
    world.add(ap.Plane(normal=(sine, cosine, 0)), friction=friction)
    height = 0.5 * size[1]
    block = world.add(
        ap.Box(size=size),
        position=(height * sine, height * cosine, 0),
        orientation=turned_about_z(-angle),
        friction=friction,
    )
    return world, block


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Tilt to 0.99 and to 1.01 of the threshold, for two coefficients of friction."""
    creep = acceleration = path = 0.0
    for friction in FRICTIONS:
        world, block = block_on_incline(make_world, 0.99 * friction, friction, (1, 0.2, 1))
        start = block.position
        world.run(seconds=SECONDS, dt=dt)
        creep = max(creep, float(np.abs(block.position - start).max()))

        slope = 1.01 * friction
        world, block = block_on_incline(make_world, slope, friction, (1, 0.2, 1))
        start = block.position
        world.run(seconds=SECONDS, dt=dt)
        expected = G * (slope - friction) / math.sqrt(1 + slope * slope)
        speed, way = np.linalg.norm(block.velocity), np.linalg.norm(block.position - start)
        acceleration = max(acceleration, relative(float(speed) / SECONDS, expected))
        path = max(path, relative(2 * float(way) / (SECONDS * (SECONDS + dt)), expected))
    return {"creep at 0.99 of the threshold [m]": creep, "acceleration at 1.01": acceleration, "path at 1.01": path}


def curve(make_world: MakeWorld, dt: float) -> Curve:
    """The path down the slope just beyond the threshold."""
    friction, slope = FRICTIONS[0], 1.01 * FRICTIONS[0]
    world, block = block_on_incline(make_world, slope, friction, (1, 0.2, 1))
    start = block.position
    times, paths = record(world, dt, SECONDS, lambda: float(np.linalg.norm(block.position - start)))
    return Curve("path [m]", times, paths, 0.5 * G * (slope - friction) / math.sqrt(1 + slope * slope) * times**2)


CASE = Case(
    number=2,
    name="block on an incline",
    law="holds if tan θ ≤ μ, else a = g (sin θ − μ cos θ)",
    measure=measure,
    tolerances={"creep at 0.99 of the threshold [m]": 1e-3, "acceleration at 1.01": 0.01, "path at 1.01": 0.01},
    curve=curve,
)
