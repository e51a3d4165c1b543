"""Line: the anchor of b stays on a line through that of a, along the x axis of the frame on a. Two rows.

With d = p_b − p_a and t one of the other axes of the frame, which turns with a,

    C = t · d,   Ċ = t · (v_b + ω_b × r_b − v_a) − ((r_a + d) × t) · ω_a

so that push = t on both, turn_a = (r_a + d) × t, turn_b = r_b × t. K is 2×2.
"""

from __future__ import annotations

from typing import Any

from atlasphys.engine.joints.ends import Ends, axis
from atlasphys.engine.joints.rows import Row
from atlasphys.engine.simd import vec


def measure(ends: Ends) -> list[Any]:
    """C [m]."""
    return [vec.dot(axis(ends.frame_a, k), ends.apart) for k in (1, 2)]


def rows(ends: Ends) -> list[Row]:
    """J."""
    return [along(ends, axis(ends.frame_a, k)) for k in (1, 2)]


def along(ends: Ends, t: Any) -> Row:
    """The row of the translation along an axis of a."""
    return Row(t, vec.cross(vec.add(ends.arm_a, ends.apart), t), t, vec.cross(ends.arm_b, t))
