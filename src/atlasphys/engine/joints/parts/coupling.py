"""Coupling of two motions: gears, rack and pinion. One row.

With n_a and n_b the x axes of the two frames, and for each body either its rotation ω · n or its translation v · n,

    Ċ = ρ_a {ω_a · n_a or v_a · n_a} + ρ_b {ω_b · n_b or v_b · n_b}.

C is the sum of Ċ over time: how far the coupling has slipped, which its impulse brings back to 0. K = ρ_a² {n_a · I_a⁻¹ n_a or 1/m_a} + the same of
b.
"""

from __future__ import annotations

from typing import Any

from atlasphys.engine.joints.ends import Ends, axis
from atlasphys.engine.joints.rows import Row
from atlasphys.engine.simd import vec


def measure(ends: Ends) -> list[Any]:
    """C [rad, m]."""
    return [ends.phase]


def rows(ends: Ends) -> list[Row]:
    """J."""
    sides = []
    for frame, ratio, turns in zip((ends.frame_a, ends.frame_b), ends.ratio, ends.turns, strict=True):
        n = axis(frame, 0)
        sides.append((vec.scale(n, ratio * (1 - turns)), vec.scale(n, ratio * turns)))
    (push_a, turn_a), (push_b, turn_b) = sides
    return [Row(vec.neg(push_a), vec.neg(turn_a), push_b, turn_b)]
