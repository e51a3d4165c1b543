"""Rotation about an axis: the twist of the frame on b against that on a about their x axes. One row, on which limits, a motor, a spring and
friction act.

With q = (w, x, y, z) = conj(q_a) q_b,

    C = 2 atan2(x, w),   −π … π,

the angle of the part of the turn that is about the x axis (q = swing · twist). From q̇ = ½ (0, ω) q, with s = w² + x²,

    Ċ = 2 (w ẋ − x ẇ) / s = ω_x + ω_y (w z + x y) / s + ω_z (x z − w y) / s

with ω = ω_b − ω_a in the axes of the frame on a: the row's turn. Where the two axes are parallel it is the axis. Not defined where they are
opposite. K = turn · (I_a⁻¹ + I_b⁻¹) turn. Limits of no range forbid twist.
"""

from __future__ import annotations

from typing import Any

from atlasphys.engine.joints.ends import Ends, double_angle, reciprocal, relative, rotate
from atlasphys.engine.joints.rows import NONE, Row
from atlasphys.engine.simd import full


def measure(ends: Ends) -> list[Any]:
    """C [rad]."""
    w, x, _, _ = relative(ends)
    return [double_angle(w, x)]


def rows(ends: Ends) -> list[Row]:
    """J."""
    w, x, y, z = relative(ends)
    inverse = reciprocal(w * w + x * x)
    turn = rotate(ends.frame_a, (full(w, 1), (w * z + x * y) * inverse, (x * z - w * y) * inverse))
    return [Row(NONE, turn, NONE, turn)]
