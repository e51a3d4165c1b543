"""Pulley: a rope from a over two points of the world to b. One row.

With d_a and d_b from those points to the two anchors, n = d / |d|,

    C = ρ_a |d_a| + ρ_b |d_b|,   Ċ = ρ_a n_a · (v_a + ω_a × r_a) + ρ_b n_b · (v_b + ω_b × r_b)

K = ρ_a² (n_a · M_a⁻¹ n_a + (r_a × n_a) · I_a⁻¹ (r_a × n_a)) + the same of b. An end of no length does not pull.
"""

from __future__ import annotations

from typing import Any

from atlasphys.engine.joints.ends import Ends, reciprocal
from atlasphys.engine.joints.rows import Row
from atlasphys.engine.simd import vec


def measure(ends: Ends) -> list[Any]:
    """C [m]."""
    return [ends.ratio[0] * vec.length(ends.ropes[0]) + ends.ratio[1] * vec.length(ends.ropes[1])]


def rows(ends: Ends) -> list[Row]:
    """J."""
    n_a, n_b = (
        vec.scale(rope, ratio * reciprocal(vec.length(rope)))
        for rope, ratio in zip(ends.ropes, ends.ratio, strict=True)
    )
    return [Row(vec.neg(n_a), vec.neg(vec.cross(ends.arm_a, n_a)), n_b, vec.cross(ends.arm_b, n_b))]
