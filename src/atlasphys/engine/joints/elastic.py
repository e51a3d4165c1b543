"""Springs with dampers whose steps are exact.

In a substep of length h the solver takes v₁ = α v₀ − β C₀ and C₁ = C₀ + h v₁ (semi-implicit Euler). That is a linear map of (C, v); its eigenvalues are
those of the damped oscillator C̈ + 2 ζ ω Ċ + ω² C = 0 over the time h, e^{(−ζ ± √(ζ² − 1)) ω h}, if its determinant and trace are theirs:

    α = e^{−2 ζ ω h},   1 + α − h β = e^{−ζ ω h} 2 cosh(√(ζ² − 1) ω h)   (cos(√(1 − ζ²) ω h), where ζ < 1).

So a spring by itself has the frequency and the decay that were asked for, to round-off, whatever the step (an implicit Euler step of the same spring
loses an energy of ω h / 2 of the damping ratio besides). As an impulse that other constraints take part in, with K the inverse of the mass,

    Δλ = −K⁻¹ ((1 − α) v + β C) − α λ,

of which v₁ above is the fixed point: a soft constraint (E. Catto, "Soft Constraints", GDC 2011) with other coefficients.

Only + − × ÷ √: exponentials of the system's library differ in their last bits between systems.
"""

import numpy as np
import numpy.typing as npt

MOST_FREQUENCY = 0.15
"""Greatest frequency of springs, as a share of the number of substeps a second. Several undamped springs on one body are so stable up to four at
their limit."""

PI = 3.141592653589793

Numbers = npt.NDArray[np.float64]


def exponential(x: Numbers) -> Numbers:
    """e^−x for x ≥ 0, to 1e-13."""
    y = np.minimum(x, 600.0) / 1024
    result = np.ones_like(y)
    for k in range(14, 0, -1):
        result = 1 - result * y / k
    for _ in range(10):
        result = result * result
    return result


def cosine(x: Numbers) -> Numbers:
    """cos x for 0 ≤ x ≤ 1.5, to 1e-16."""
    result = np.ones_like(x)
    for k in range(24, 0, -2):
        result = 1 - result * x * x / (k * (k - 1))
    return result


def coefficients(frequency: Numbers, damping: Numbers, h: float) -> Numbers:
    """1 − α, β [1/s] and α of springs, (3, n), for a substep of h seconds. Where the frequency is negative there is no spring: −1, 0, 0."""
    x = 2 * PI * np.clip(frequency * h, 0, MOST_FREQUENCY)
    z = damping * x
    alpha = exponential(2 * z)
    under = damping < 1
    root = np.sqrt(np.abs(1 - damping * damping)) * x
    slow = exponential(np.where(under, 0, z - root)) + exponential(z + root)
    trace = np.where(under, 2 * exponential(z) * cosine(np.where(under, root, 0)), slow)
    present = frequency >= 0
    beta = np.where(present, (1 + alpha - trace) / h, 0)
    return np.stack([np.where(present, 1 - alpha, -1), beta, np.where(present, alpha, 0)])
