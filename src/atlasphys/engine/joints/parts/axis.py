"""Axis: the x axes of the two frames stay parallel; b turns freely about them. Two rows.

With q = (w, x, y, z) = conj(q_a) q_b, the turn from the frame on a to that on b,

    C = 2 (y, z),   |C| = 2 sin(θ/2)   for the angle θ between the two axes,

which grows up to θ = π, so that the joint is pulled back from any error. From q̇ = ½ (0, ω) q, with ω = ω_b − ω_a in the axes of the frame on a, the
vector part v of q changes by v̇ = ½ (w ω + ω × v). So the row of C_k is purely one of rotation, with w e_k + v × e_k in those axes; the rows are
two of those of the lock. K = T (I_a⁻¹ + I_b⁻¹) Tᵀ.
"""

from __future__ import annotations

from typing import Any

from atlasphys.engine.joints.ends import Ends, relative
from atlasphys.engine.joints.parts.lock import turns
from atlasphys.engine.joints.rows import Row


def measure(ends: Ends) -> list[Any]:
    """C [rad, for small angles]."""
    return [2 * component for component in relative(ends)[2:4]]


def rows(ends: Ends) -> list[Row]:
    """J."""
    return turns(ends, relative(ends))[1:3]
