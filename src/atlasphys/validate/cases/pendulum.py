"""Case 13: a physical pendulum on a hinge.

A rod of mass M on a hinge at distance d from its centre of mass, with moment of inertia I about the hinge, let go at rest at the angle θ0 from
where it hangs, has the period T = 4 √(I/(M g d)) K(m) with the complete elliptic integral of the first kind, parameter m = sin²(θ0/2) as SciPy
takes it (Landau and Lifshitz, Mechanics, §11).
"""

from __future__ import annotations

import math

import numpy as np

import atlasphys as ap
from atlasphys.validate.case import Case, Curve, Doubles, G, MakeWorld, record, relative, turned_about_z
from atlasphys.validate.cases.jointed import mean_period

SIZE = (0.1, 1.0, 0.1)
MASS, ARM = 2.0, 0.5
INERTIA = MASS * ((SIZE[0] ** 2 + SIZE[1] ** 2) / 12 + ARM**2)
"""About the hinge [kg m²]."""

SMALL = math.sqrt(INERTIA / (MASS * G * ARM))
"""1/ω of small swings [s]."""

AMPLITUDES = (10, 60, 120)
"""Angles at which it is let go [degrees]."""

SWINGS = 10


def swing(make_world: MakeWorld, degrees: float, seconds: float, dt: float) -> tuple[Doubles, Doubles, float]:
    """Times, angles from where it hangs, and energy lost as a share of that of the first swing."""
    world = make_world(gravity=(0, -G, 0))
    angle = math.radians(degrees)
    rod = world.add(
        ap.Box(size=SIZE),
        position=(ARM * math.sin(angle), -ARM * math.cos(angle), 0),
        orientation=turned_about_z(angle),
        mass=MASS,
    )
    world.join(ap.Hinge(None, rod, anchor=(0, 0, 0), axis=(0, 0, 1)))
    start = world.energy().total
    times, angles = record(world, dt, seconds, lambda: _angle(rod))
    lost = (start - world.energy().total) / (MASS * G * ARM * (1 - math.cos(angle)))
    return times, angles, lost


def _angle(rod: ap.Body) -> float:
    w, _, _, z = rod.orientation
    return 2 * math.atan2(z, w)


def period(degrees: float) -> float:
    """The exact period [s]."""
    from scipy.special import ellipk

    return 4 * SMALL * float(ellipk(math.sin(0.5 * math.radians(degrees)) ** 2))


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Count ten swings from each angle."""
    errors = {}
    for degrees in AMPLITUDES:
        exact = period(degrees)
        times, angles, lost = swing(make_world, degrees, (SWINGS + 1) * exact, dt)
        errors[f"period from {degrees}°"] = relative(mean_period(times, angles), exact)
        errors[f"energy after {SWINGS} swings from {degrees}°"] = abs(lost)
    return errors


def curve(make_world: MakeWorld, dt: float) -> Curve:
    """Three swings from the middle angle."""
    from scipy.special import ellipj, ellipk

    degrees = AMPLITUDES[1]
    times, angles, _ = swing(make_world, degrees, 3 * period(degrees), dt)
    k = math.sin(0.5 * math.radians(degrees))
    sn = ellipj(float(ellipk(k * k)) - times / SMALL, k * k)[0]
    return Curve("angle [rad]", times, angles, 2 * np.arcsin(k * sn))


CASE = Case(
    number=13,
    name="physical pendulum",
    law="T = 4 √(I/(M g d)) K(m), m = sin²(θ0/2)",
    measure=measure,
    tolerances={f"period from {degrees}°": 1e-3 for degrees in AMPLITUDES},
    orders={f"period from {degrees}°": 2.0 for degrees in AMPLITUDES},
    precision="double",
    curve=curve,
)
