"""Springs with dampers whose steps are exact.

In a substep of length h a spring changes the rate v of its coordinate C from v₀ to v₁ = α v₀ − β C₀, and then C₁ = C₀ + h v₁ (semi-implicit Euler).
That is a linear map of (C, v). Its eigenvalues are those of the damped oscillator C̈ + 2 ζ ω Ċ + ω² C = 0 over the time h, e^{(−ζ ± √(ζ² − 1)) ω
h}, if its
determinant and trace are theirs:

    α = e^{−2 ζ ω h},   h β = 1 + α − e^{−ζ ω h} 2 cosh(√(ζ² − 1) ω h)     (cos(√(1 − ζ²) ω h), where ζ < 1).

So a spring by itself has the frequency and the decay that were asked for, to round-off, whatever the step. (An implicit Euler step of it would add
ω h / 2 to ζ.) Under a constant acceleration a it is to stretch by a / ω². The velocity a h that this gives in a substep is damped too, as far as the
damper sees v₁ rather than v₀; so the damper acts on both: v₁ = u − p v₀ − q u − β C₀, where u is the velocity without the spring, p + q = 1 − α,
and q = 1 − β / (ω² h).

As an impulse that other constraints take part in, with K the inverse of the mass and v the velocity that the present impulse λ is part of,

    λ ← −K⁻¹ (p v₀ + q v + β C) + q λ,

a soft constraint (E. Catto, "Soft Constraints", GDC 2011) with other coefficients. Springs on vectors (soft points and locks) take p = 0, q = 1 − α.

Only + − × ÷ √: exponentials of the system's library differ in their last bits between systems.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

MOST_FREQUENCY = 0.15
"""Greatest frequency of springs, as a share of the number of substeps a second. Several undamped springs on one body are so stable up to four at
their limit."""

PI = 3.141592653589793

Numbers = npt.NDArray[np.float64]


class Coefficients(NamedTuple):
    """Of springs, (n,) each."""

    alpha: Numbers
    beta: Numbers
    """[1/s]"""
    p: Numbers
    q: Numbers


def decay(x: Numbers) -> Numbers:
    """1 − e^−x for x ≥ 0, with a relative error below 1e-13: its series at x / 1024, then 1 − e^−2y from 1 − e^−y."""
    y = np.minimum(x, 600.0) / 1024
    series = np.ones_like(y)
    for k in range(14, 1, -1):
        series = 1 - series * y / k
    result = series * y
    for _ in range(10):
        result = result * (2 - result)
    return result


def versine(x: Numbers) -> Numbers:
    """1 − cos x for 0 ≤ x ≤ 1.5, with a relative error below 1e-15."""
    series = np.ones_like(x)
    for k in range(24, 2, -2):
        series = 1 - series * x * x / (k * (k - 1))
    return 0.5 * x * x * series


def coefficients(frequency: Numbers, damping: Numbers, h: float) -> Coefficients:
    """Coefficients of springs for a substep of h seconds. ``frequency`` [Hz] is more than 0."""
    x = 2 * PI * np.minimum(frequency * h, MOST_FREQUENCY)
    z = damping * x
    under = damping < 1
    root = np.sqrt(np.abs(1 - damping * damping))
    slow = x / (damping + root)  # ζ − √(ζ² − 1) without cancellation
    lost = decay(z)
    swinging = lost * lost + 2 * (1 - lost) * versine(np.where(under, root * x, 0))
    creeping = decay(np.where(under, 0, slow)) * decay(np.where(under, 0, z + root * x))
    pull = np.where(under, swinging, creeping)
    total = decay(2 * z)
    q = 1 - pull / (x * x)
    return Coefficients(1 - total, pull / h, total - q, q)
