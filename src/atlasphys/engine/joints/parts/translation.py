"""Translation along the x axis of the frame on a. One row, on which limits, a motor, a spring and friction act.

    C = n · d,   d = p_b − p_a,   push = n on both, turn_a = (r_a + d) × n, turn_b = r_b × n

as for the line. K = n · (M_a⁻¹ + M_b⁻¹) n + turn_a · I_a⁻¹ turn_a + turn_b · I_b⁻¹ turn_b. Limits of no range make it a plane.
"""

from __future__ import annotations

from typing import Any

from atlasphys.engine.joints.ends import Ends, axis
from atlasphys.engine.joints.parts.line import along
from atlasphys.engine.joints.rows import Row
from atlasphys.engine.simd import vec


def measure(ends: Ends) -> list[Any]:
    """C [m]."""
    return [vec.dot(axis(ends.frame_a, 0), ends.apart)]


def rows(ends: Ends) -> list[Row]:
    """J."""
    return [along(ends, axis(ends.frame_a, 0))]
