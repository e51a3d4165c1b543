"""Case 12: a heavy symmetric top on a ball joint.

With moments I1 about the pivot across and I3 along its axis, spin ω3 along it, centre of mass at distance l: at a constant angle θ from the
vertical it precesses at a rate Ω with I1 cos θ Ω² − I3 ω3 Ω + m g l = 0. Upright it is stable if and only if ω3² > 4 I1 m g l/I3². With r times
that ω3² and let go at an angle ε without precession it nutates: u̇², u = cos θ, is proportional to (u0 − u)((1 − u²) − 2 r (u0 − u)), u0 = cos ε, and
has the roots u0 and r − √(r² − 2 r u0 + 1) (Goldstein, Classical Mechanics, §5.7). For r < 1 it falls to about cos θ = 2 r − 1, for r > 1 it stays
within about ε √(r/(r − 1)).
"""

from __future__ import annotations

import math

import numpy as np

import atlasphys as ap
from atlasphys.validate.case import Case, Doubles, G, MakeWorld, relative, turned_about_z

SIZE, MASS, ARM = (0.4, 0.1, 0.4), 2.0, 0.25
ALONG = MASS * (SIZE[0] ** 2 + SIZE[2] ** 2) / 12
ACROSS = MASS * ((SIZE[0] ** 2 + SIZE[1] ** 2) / 12 + ARM**2)
"""I3, and I1 about the pivot [kg m²]."""

WEIGHT = MASS * G * ARM
"""m g l [N m]."""

TILT, SPIN = math.radians(40), 60.0
"""θ and ω3 of steady precession [rad, rad/s]."""

THRESHOLD = 4 * ACROSS * WEIGHT / ALONG**2
"""ω3² above which it stands upright [rad²/s²]."""

START, SHARES = 0.01, (0.9, 1.1)
"""Angle from the vertical at the start [rad]; shares of the threshold."""


def spin(make_world: MakeWorld, tilt: float, along: float, precession: float, seconds: float, dt: float) -> Doubles:
    """Direction of the top's axis after each step, (n, 3)."""
    world = make_world(gravity=(0, -G, 0))
    axis = np.array([-math.sin(tilt), math.cos(tilt), 0.0])
    omega = precession * np.array([0.0, 1.0, 0.0]) + (along - precession * math.cos(tilt)) * axis
    top = world.add(
        ap.Box(size=SIZE),
        position=ARM * axis,
        orientation=turned_about_z(tilt),
        velocity=np.cross(omega, ARM * axis),
        angular_velocity=omega,
        mass=MASS,
    )
    world.join(ap.Ball(None, top, anchor=(0, 0, 0)))
    axes = []
    for _ in range(round(seconds / dt)):
        world.step(dt)
        w, x, y, z = top.orientation
        axes.append((2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)))
    return np.array(axes)


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Precess steadily for two turns; stand nearly upright for six seconds below and above the threshold."""
    root = (ALONG * SPIN) ** 2 - 4 * ACROSS * math.cos(TILT) * WEIGHT
    rate = (ALONG * SPIN - math.sqrt(root)) / (2 * ACROSS * math.cos(TILT))
    axes = spin(make_world, TILT, SPIN, rate, 4 * math.pi / rate, dt)
    turned = np.unwrap(np.arctan2(-axes[:, 2], axes[:, 0]))
    steps = len(axes) - 1
    errors = {
        "precession": relative(float(turned[-1] - turned[0]) / (steps * dt), rate),
        "steady tilt": float(np.abs(np.arccos(axes[:, 1]) - TILT).max()) / TILT,
    }
    for share in SHARES:
        axes = spin(make_world, START, math.sqrt(share * THRESHOLD), 0.0, 6.0, dt)
        greatest = float(np.arccos(np.clip(axes[:, 1], -1, 1)).max())
        lowest = share - math.sqrt(share * share - 2 * share * math.cos(START) + 1)
        errors[f"greatest tilt at {share:g} of the threshold"] = relative(greatest, math.acos(lowest))
    return errors


CASE = Case(
    number=12,
    name="heavy symmetric top",
    law="I1 cos θ Ω² − I3 ω3 Ω + m g l = 0; upright stable iff ω3² > 4 I1 m g l/I3²",
    measure=measure,
    tolerances={
        "precession": 0.01,
        "steady tilt": 0.01,
        # So near the threshold the tilt changes five times as much as ω3².
        **{f"greatest tilt at {share:g} of the threshold": 0.05 for share in SHARES},
    },
    precision="double",
)
