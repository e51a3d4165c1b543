"""Rotation lock: the two frames stay turned alike. Three rows.

With q = (w, v) = conj(q_a) q_b, of the sign that makes w positive,

    C = 2 v,   |C| = 2 sin(θ/2)   for the angle θ of the turn,

and the row of C_k is (see axis.py) purely one of rotation, with w e_k + v × e_k in the axes of the frame on a. K = T (I_a⁻¹ + I_b⁻¹) Tᵀ.
"""

from __future__ import annotations

from typing import Any

from atlasphys.engine.joints.ends import Ends, relative, rotate
from atlasphys.engine.joints.rows import NONE, Row
from atlasphys.engine.simd import select


def measure(ends: Ends) -> list[Any]:
    """C [rad, for small angles]."""
    return [2 * component for component in nearest(ends)[1:4]]


def rows(ends: Ends) -> list[Row]:
    """J."""
    return turns(ends, nearest(ends))


def nearest(ends: Ends) -> Any:
    """The turn between the frames, with w not negative."""
    q = relative(ends)
    return tuple(select(q[0] < 0, -component, component) for component in q)


def turns(ends: Ends, q: Any) -> list[Row]:
    """Rows of 2 v, for the three components of v."""
    w, x, y, z = q
    result = []
    for row in ((w, z, -y), (-z, w, x), (y, -x, w)):
        turn = rotate(ends.frame_a, row)
        result.append(Row(NONE, turn, NONE, turn))
    return result
