"""Case 15: a mass on a spring with a damper.

It swings with ω = ω0 √(1 − ζ²): from one passage through 0 to the next but one it takes 2π/ω, and each peak is smaller than the last by the factor
e^(−δ), δ = 2πζ/√(1 − ζ²), the logarithmic decrement (Rao, Mechanical Vibrations, §2.6).
"""

from __future__ import annotations

import math

import numpy as np

import atlasphys as ap
from atlasphys.validate.case import Case, Curve, Doubles, MakeWorld, record, relative
from atlasphys.validate.cases.jointed import mean_period

FREQUENCY, LENGTH, START = 2.0, 1.0, 0.4
"""Of the spring [Hz], its length at rest and its first elongation [m]."""

RATIOS = (0.0, 0.05, 0.2)
"""Damping ratios ζ."""


def oscillate(make_world: MakeWorld, zeta: float, seconds: float, dt: float) -> tuple[Doubles, Doubles]:
    """Times and elongations [m]."""
    world = make_world(gravity=(0, 0, 0))
    mass = world.add(ap.Sphere(radius=0.1), position=(LENGTH + START, 0, 0), mass=3)
    world.join(ap.Spring(None, mass, rest_length=LENGTH, frequency=FREQUENCY, damping=zeta))
    return record(world, dt, seconds, lambda: mass.position[0] - LENGTH)


def peaks(values: Doubles) -> Doubles:
    """Heights of the greatest values between two lower ones, by a parabola through the three."""
    before, here, after = values[:-2], values[1:-1], values[2:]
    at = (here > before) & (here >= after) & (here > 0)
    before, here, after = before[at], here[at], after[at]
    found: Doubles = here + (after - before) ** 2 / (8 * (2 * here - before - after))
    return found


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Let go for five periods at each damping ratio."""
    errors = {}
    for zeta in RATIOS:
        damped = math.sqrt(1 - zeta * zeta)
        times, found = oscillate(make_world, zeta, 5.5 / FREQUENCY, dt)
        errors[f"period, ζ = {zeta:g}"] = relative(mean_period(times, found), 1 / (FREQUENCY * damped))
        tops = peaks(found)
        decrement = float(np.log(tops[0] / tops[-1])) / (len(tops) - 1)
        if zeta:
            errors[f"decrement, ζ = {zeta:g}"] = relative(decrement, 2 * math.pi * zeta / damped)
        else:
            errors["decrement without damping"] = abs(decrement)
    return errors


def curve(make_world: MakeWorld, dt: float) -> Curve:
    """The middle damping ratio."""
    zeta, omega = RATIOS[1], 2 * math.pi * FREQUENCY
    damped = omega * math.sqrt(1 - zeta * zeta)
    times, found = oscillate(make_world, zeta, 5 / FREQUENCY, dt)
    shape = np.cos(damped * times) + zeta * omega / damped * np.sin(damped * times)
    return Curve("elongation [m]", times, found, START * np.exp(-zeta * omega * times) * shape)


CASE = Case(
    number=15,
    name="spring and damper",
    law="ω = ω0 √(1 − ζ²), logarithmic decrement 2πζ/√(1 − ζ²)",
    measure=measure,
    tolerances={f"period, ζ = {zeta:g}": 0.01 for zeta in RATIOS}
    | {f"decrement, ζ = {zeta:g}": 0.01 for zeta in RATIOS if zeta}
    | {"decrement without damping": 0.01},
    curve=curve,
)
