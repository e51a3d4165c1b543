"""Point: the anchors of the two bodies stay together. Three rows.

    C = p_b − p_a,   Ċ = v_b + ω_b × r_b − v_a − ω_a × r_a

so that along the world's axis e_k: push = e_k on both, turn_a = r_a × e_k, turn_b = r_b × e_k, and
K = (1/m_a + 1/m_b) 1 − r̂_a I_a⁻¹ r̂_a − r̂_b I_b⁻¹ r̂_b.
"""

from __future__ import annotations

from typing import Any

from atlasphys.engine.joints.ends import Ends
from atlasphys.engine.joints.rows import Row, cross


def measure(ends: Ends) -> list[Any]:
    """C [m]."""
    return list(ends.apart)


def rows(ends: Ends) -> list[Row]:
    """J."""
    axes = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    return [Row(e, cross(ends.arm_a, e), e, cross(ends.arm_b, e)) for e in axes]
