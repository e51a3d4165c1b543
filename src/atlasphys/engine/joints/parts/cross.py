"""Cross: the y axis of the frame on a stays at right angles to the z axis of that on b, as in a universal joint. One row.

    C = y_a · z_b,   Ċ = (ω_b − ω_a) · (z_b × y_a)

K = turn · (I_a⁻¹ + I_b⁻¹) turn.
"""

from __future__ import annotations

from typing import Any

from atlasphys.engine.joints.ends import Ends, axis
from atlasphys.engine.joints.rows import NONE, Row
from atlasphys.engine.simd import vec


def measure(ends: Ends) -> list[Any]:
    """C, the cosine of the angle between the axes."""
    return [vec.dot(axis(ends.frame_a, 1), axis(ends.frame_b, 2))]


def rows(ends: Ends) -> list[Row]:
    """J."""
    turn = vec.cross(axis(ends.frame_b, 2), axis(ends.frame_a, 1))
    return [Row(NONE, turn, NONE, turn)]
