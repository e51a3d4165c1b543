"""Case 14: a double pendulum of two equal masses on rods of equal length.

For small angles θ1, θ2 from where they hang, 2 θ̈1 + θ̈2 = −2 (g/l) θ1 and θ̈1 + θ̈2 = −(g/l) θ2 (Landau and Lifshitz, Mechanics, §5,
problem 1 with equal masses and lengths). Its modes are θ2 = ±√2 θ1 with ω² = (g/l)(2 ∓ √2).
"""

from __future__ import annotations

import math

import atlasphys as ap
from atlasphys.validate.case import Case, G, MakeWorld, record, relative
from atlasphys.validate.cases.jointed import mean_period

LENGTH, ANGLE = 1.0, 0.02
"""Of each rod [m], and of the upper one at the start [rad]."""

SWINGS = 10

MODES = {"in phase": 1, "in opposition": -1}
"""Sign of θ2/θ1."""


def period_error(make_world: MakeWorld, dt: float, sign: int) -> float:
    """Let go in the shape of a mode and count ten swings; how far the period is off, relatively."""
    world = make_world(gravity=(0, -G, 0))
    place, above = (0.0, 0.0, 0.0), None
    bobs = []
    for angle in (ANGLE, sign * math.sqrt(2) * ANGLE):
        x, y, _ = place
        place = (x + LENGTH * math.sin(angle), y - LENGTH * math.cos(angle), 0.0)
        bob = world.add(ap.Sphere(radius=0.02), position=place, mass=1)
        world.join(ap.Distance(above, bob, length=LENGTH))
        bobs.append(bob)
        above = bob
    period = 2 * math.pi / math.sqrt(G / LENGTH * (2 - sign * math.sqrt(2)))
    times, offsets = record(world, dt, (SWINGS + 1) * period, lambda: bobs[0].position[0])
    return relative(mean_period(times, offsets), period)


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """The errors of both modes' periods."""
    return {f"period {name}": period_error(make_world, dt, sign) for name, sign in MODES.items()}


CASE = Case(
    number=14,
    name="double pendulum",
    law="small swings: ω² = (g/l)(2 ± √2)",
    measure=measure,
    tolerances={f"period {name}": 0.01 for name in MODES},
)
