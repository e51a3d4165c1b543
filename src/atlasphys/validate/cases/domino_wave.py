"""Case 27: a wave of falling dominoes.

Its speed depends on the dominoes' length l, on g and on numbers without a unit (shape, spacing, friction, restitution). The only speed that l and
g make is √(g l), so with all lengths scaled by s, or g by s, the wave is √s times as fast (dimensional analysis; Efthimiou and Johnson 2007). The
step, the engine's tolerances and the size for which they are meant stay the same, so that only the physics scales.
"""

from __future__ import annotations

import math

import numpy as np

import atlasphys as ap
from atlasphys.validate.case import Case, G, MakeWorld

DOMINOES, SCALE = 20, 4.0
TIPPED = 0.15
"""Tilt at which a domino counts as reached [rad]; 0.2 of what it takes to touch the next one and more than it sways before."""


def speed(make_world: MakeWorld, length: float, gravity: float, dt: float) -> float:
    """Speed of the wave [m/s] from the fifth domino on, of dominoes of a given height [m]."""
    world = make_world(gravity=(0, -gravity, 0))
    world.add(ap.Plane(normal=(0, 1, 0)), friction=0.5)
    spacing, push = 0.4 * length, 1.5 * math.sqrt(gravity / length)
    for i in range(DOMINOES):
        world.add(
            ap.Box(size=(0.1 * length, length, 0.5 * length)),
            position=(i * spacing, 0.5 * length, 0),
            velocity=(0.5 * length * push if i == 0 else 0, 0, 0),
            angular_velocity=(0, 0, -push if i == 0 else 0),
            friction=0.5,
        )
    reached = np.full(DOMINOES, np.nan)
    before = np.zeros(DOMINOES)
    while np.isnan(reached[-2]) and world.time < 10 * DOMINOES * spacing / math.sqrt(gravity * length):
        world.step(dt)
        tilt = 2 * np.abs(world.bodies.orientation[1:, 3])
        now = np.isnan(reached) & (tilt >= TIPPED)
        reached[now] = world.time - dt * ((tilt - TIPPED) / np.maximum(tilt - before, 1e-12))[now]
        before = tilt
    return float((DOMINOES - 7) * spacing / (reached[-2] - reached[5]))


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Compare with dominoes four times as large, and with four times the gravity."""
    base = speed(make_world, 1.0, G, dt)
    found = {
        "lengths scaled": speed(make_world, SCALE, G, dt),
        "gravity scaled": speed(make_world, 1.0, SCALE * G, dt),
    }
    errors = {f"speed, {name}": abs(value / (base * math.sqrt(SCALE)) - 1) for name, value in found.items()}
    return errors | {"speed / √(g l) (no error)": base / math.sqrt(G)}


CASE = Case(
    number=27,
    name="domino wave",
    law="the speed of the wave scales with √(g l)",
    measure=measure,
    tolerances={"speed, lengths scaled": 0.05, "speed, gravity scaled": 0.05},
)
