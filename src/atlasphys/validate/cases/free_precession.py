"""Case 11: free precession of a symmetric body.

With I1 = I2, Euler's equations leave ω3 constant and turn (ω1, ω2) in the body's axes at the rate (I3 − I1) ω3/I1: ω̇1 = −rate ω2,
ω̇2 = rate ω1. (The Earth's pole does so, as Euler predicted, in about a year.)
"""

from __future__ import annotations

import numpy as np

import atlasphys as ap
from atlasphys.validate.case import Case, Curve, MakeWorld, relative
from atlasphys.validate.cases.free_rotation import spin_freely

SPIN_3, SPIN_1, SECONDS = 4.0, 0.8, 10.0

BODIES = {"disc": ap.Cylinder(radius=0.5, length=0.2), "rod": ap.Cylinder(radius=0.2, length=1.0)}
"""One with I3 > I1, one with I3 < I1. Their axis is y."""


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Spin a disc and a rod about nearly their axis."""
    errors = {}
    for name, shape in BODIES.items():
        i3 = 0.5 * shape.radius**2
        i1 = 0.5 * i3 + shape.length**2 / 12
        run = spin_freely(make_world, shape, np.array([i1, i3, i1]), (SPIN_1, SPIN_3, 0.0), SECONDS, dt)
        # Axes 1, 2, 3 are z, x, y.
        spins = run.body_spin
        angle = np.unwrap(np.arctan2(spins[:, 0], spins[:, 2]))
        rate = float(angle[-1] - angle[0]) / float(run.times[-1])
        errors[f"precession rate, {name}"] = relative(rate, (i3 - i1) * SPIN_3 / i1)
        errors[f"spin about the axis, {name}"] = float(np.abs(spins[:, 1] / SPIN_3 - 1).max())
    return errors


def curve(make_world: MakeWorld, dt: float) -> Curve:
    """The rod's spin across its axis."""
    rod = BODIES["rod"]
    i3 = 0.5 * rod.radius**2
    i1 = 0.5 * i3 + rod.length**2 / 12
    run = spin_freely(make_world, rod, np.array([i1, i3, i1]), (SPIN_1, SPIN_3, 0.0), SECONDS / 2, dt)
    exact = SPIN_1 * np.cos((i3 - i1) * SPIN_3 / i1 * run.times)
    return Curve("ω1 of the rod in its axes [rad/s]", run.times, run.body_spin[:, 0], exact)


CASE = Case(
    number=11,
    name="free precession",
    law="ω turns about the axis, in body axes, at (I3 − I1) ω3/I1",
    measure=measure,
    tolerances={f"{error}, {name}": 1e-3 for error in ("precession rate", "spin about the axis") for name in BODIES},
    orders={f"precession rate, {name}": 2.0 for name in BODIES},
    curve=curve,
)
