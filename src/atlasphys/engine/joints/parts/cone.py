"""Cone: the angle between the x axes n_a and n_b of the two frames. One row, with an upper limit.

    C = θ = 2 atan2(√(y² + z²), √(w² + x²)),   θ̇ = (ω_b − ω_a) · (n_a × n_b) / |n_a × n_b|

with q = (w, x, y, z) = conj(q_a) q_b. Where the axes are parallel the row vanishes, far from any limit. K = turn · (I_a⁻¹ + I_b⁻¹) turn.
"""

from __future__ import annotations

from typing import Any

from atlasphys.engine.joints.ends import Ends, axis, double_angle, reciprocal, relative
from atlasphys.engine.joints.rows import NONE, Row
from atlasphys.engine.simd import sqrt, vec


def measure(ends: Ends) -> list[Any]:
    """C [rad]."""
    w, x, y, z = relative(ends)
    return [double_angle(sqrt(w * w + x * x), sqrt(y * y + z * z))]


def rows(ends: Ends) -> list[Row]:
    """J."""
    across = vec.cross(axis(ends.frame_a, 0), axis(ends.frame_b, 0))
    turn = vec.scale(across, reciprocal(vec.length(across)))
    return [Row(NONE, turn, NONE, turn)]
