"""Distance of the two anchors. One row: a rod (limits of no range), a rope (an upper limit), a spring.

    C = |d|,   d = p_b − p_a,   n = d / |d|:   push = n on both, turn_a = r_a × n, turn_b = r_b × n

(d is along n, so that (r_a + d) × n is r_a × n.) Where the anchors coincide n is not defined; the world's x axis is taken.
"""

from __future__ import annotations

from typing import Any

from atlasphys.engine.joints.ends import Ends, reciprocal
from atlasphys.engine.joints.rows import Row
from atlasphys.engine.simd import full, vec


def measure(ends: Ends) -> list[Any]:
    """C [m]."""
    return [vec.length(ends.apart)]


def rows(ends: Ends) -> list[Row]:
    """J."""
    d = ends.apart
    length = vec.length(d)
    zero, one = full(length, 0), full(length, 1)
    n = vec.select_vec(length > 0, vec.scale(d, reciprocal(length)), (one, zero, zero))
    return [Row(n, vec.cross(ends.arm_a, n), n, vec.cross(ends.arm_b, n))]
