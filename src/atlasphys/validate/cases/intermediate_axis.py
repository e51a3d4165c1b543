"""Case 10: a torque-free box spun about its middle axis, which it leaves again and again (Dzhanibekov's nut).

Euler's equations I1 ω̇1 = (I2 − I3) ω2 ω3 and cyclic keep 2E = Σ I ω² and L² = Σ (I ω)². For I1 < I2 < I3 and L² > 2 E I2 they are
solved by (Landau and Lifshitz, Mechanics, §37)

    ω1 = √((2E I3 − L²)/(I1 (I3 − I1))) cn τ,  ω2 = √((2E I3 − L²)/(I2 (I3 − I2))) sn τ,  ω3 = √((L² − 2E I1)/(I3 (I3 − I1))) dn τ,

τ = rate · t, rate = √((I3 − I2)(L² − 2E I1)/(I1 I2 I3)), with parameter m = (I2 − I1)(2E I3 − L²)/((I3 − I2)(L² − 2E I1)), as SciPy takes
it; the period is 4 K(m)/rate. Time counts from a moment at which ω2 = 0. For L² < 2 E I2 exchange the indices 1 and 3.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

import atlasphys as ap
from atlasphys.validate.case import Case, Curve, MakeWorld, relative
from atlasphys.validate.cases.free_rotation import drift, spin_freely

SIZE = (1.0, 0.4, 0.1)
MOMENTS = (sum(np.square(SIZE)) - np.square(SIZE)) / 12
"""About x, y, z for a mass of 1 kg, ascending: the middle axis is y."""

SPIN = (0.3, 3.0, 0.2)
"""Mostly about y, perturbed by a tenth [rad/s]."""

SECONDS = 60.0


def solution(times: npt.NDArray[np.float64]) -> tuple[npt.NDArray[np.float64], float]:
    """Euler's ω(t) in body axes (n, 3) from SPIN at t = 0, and the period [s]."""
    from scipy.special import ellipj, ellipk, ellipkinc

    axes = [0, 1, 2]
    if MOMENTS[1] * (MOMENTS @ np.square(SPIN)) > (MOMENTS * SPIN) @ (MOMENTS * SPIN):
        axes.reverse()
    (i1, i2, i3), (w1, w2, w3) = MOMENTS[axes], np.array(SPIN)[axes]
    energy, momentum = i1 * w1**2 + i2 * w2**2 + i3 * w3**2, (i1 * w1) ** 2 + (i2 * w2) ** 2 + (i3 * w3) ** 2  # 2E, L²
    low, high = energy * i3 - momentum, momentum - energy * i1
    rate = math.sqrt((i3 - i2) * high / (i1 * i2 * i3))
    m = (i2 - i1) * low / ((i3 - i2) * high)
    size1, size2, size3 = (
        math.sqrt(value) for value in (low / (i1 * (i3 - i1)), low / (i2 * (i3 - i2)), high / (i3 * (i3 - i1)))
    )
    # dn > 0, so ω3 keeps its sign. ω2 shares it by Euler's equation, also with 1 and 3 exchanged, which mirrors the axes. The sign
    # of ω1 is a matter of the phase.
    sign = math.copysign(1, w3)
    phase = ellipkinc(math.atan2(sign * w2 / size2, w1 / size1), m)
    sn, cn, dn, _ = ellipj(phase + rate * times, m)
    spins = np.empty((len(times), 3))
    spins[:, axes] = np.stack([size1 * cn, sign * size2 * sn, sign * size3 * dn], axis=1)
    return spins, 4 * float(ellipk(m)) / rate


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Spin the box for a minute."""
    run = spin_freely(make_world, ap.Box(size=SIZE), MOMENTS, SPIN, SECONDS, dt)
    times, spins = run.times, run.body_spin
    expected, period = solution(times)
    middle = spins[:, 1]
    i = np.flatnonzero((middle[:-1] < 0) & (middle[1:] >= 0))
    crossings = times[i] - middle[i] * (times[i + 1] - times[i]) / (middle[i + 1] - middle[i])
    found = (crossings[-1] - crossings[0]) / (len(crossings) - 1)
    first = times <= period
    off = np.abs(spins - expected).max(axis=1) / np.abs(expected).max()
    return {
        "energy": drift(run.energy),
        "angular momentum": drift(run.world_momentum),
        "period": relative(float(found), period),
        "ω(t), first period": float(off[first].max()),
        "ω(t), 60 s": float(off.max()),
    }


def curve(make_world: MakeWorld, dt: float) -> Curve:
    """Spin about the middle axis for a quarter of a minute."""
    run = spin_freely(make_world, ap.Box(size=SIZE), MOMENTS, SPIN, SECONDS / 4, dt)
    return Curve("ω2 in the body's axes [rad/s]", run.times, run.body_spin[:, 1], solution(run.times)[0][:, 1])


CASE = Case(
    number=10,
    name="spin about the middle axis",
    law="E and L constant; ω(t) by Jacobi's elliptic functions, period 4 K(m)/rate",
    measure=measure,
    tolerances={"energy": 1e-6, "angular momentum": 1e-6, "period": 1e-3, "ω(t), first period": 0.01},
    orders={"period": 2.0, "ω(t), first period": 2.0},
    precision="double",
    curve=curve,
)
