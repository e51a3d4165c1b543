"""The two ends of a part, as its coordinate and Jacobian see them. Over lanes."""

from __future__ import annotations

from typing import Any, NamedTuple

from atlasphys.engine.simd import full, select, sqrt, vec


class Ends(NamedTuple):
    """Where the two anchors are and how the two frames are turned, in world axes."""

    arm_a: Any
    """Anchor of a, from its centre of mass [m]."""
    arm_b: Any
    apart: Any
    """Anchor of b − anchor of a [m]."""
    frame_a: Any
    """Unit quaternion: the part's frame on a."""
    frame_b: Any
    ropes: Any
    """Of a pulley: from where it hangs to the anchor of a, and the same for b [m]."""
    ratio: Any
    """How the motions of a and of b count, for couplings and pulleys."""
    turns: Any
    """Of a coupling: 1 where the rotation of a, of b counts, 0 where the translation does."""
    phase: Any
    """Of a coupling: its coordinate, which is summed up from substep to substep."""


def rotate(q: Any, v: Any) -> Any:
    """q v q* for a unit quaternion: v + 2 w u × v + 2 u × (u × v)."""
    u = q[1:4]
    t = vec.scale(vec.cross(u, v), 2)
    return vec.add(vec.add_scaled(v, t, q[0]), vec.cross(u, t))


def axis(q: Any, k: int) -> Any:
    """Where the unit quaternion q takes axis k: a column of its matrix."""
    w, x, y, z = q
    if k == 0:
        return 1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)
    if k == 1:
        return 2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)
    return 2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)


def multiply(p: Any, q: Any) -> Any:
    """p q: first the turn q, then p."""
    return (
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    )


def relative(ends: Ends) -> Any:
    """The turn from the frame on a to that on b, in the axes of the former: conj(q_a) q_b."""
    w, x, y, z = ends.frame_a
    return multiply((w, -x, -y, -z), ends.frame_b)


def reciprocal(x: Any) -> Any:
    """1 / x, or 0 where x is not positive."""
    return select(x > 0, 1 / x, 0)


def double_angle(c: Any, s: Any) -> Any:
    """2 atan2(s, c), taken to −π … π: the angle of a turn whose quaternion is (c, s) times any positive number.

    t = tan(φ/4) = s / (√(c² + s²) + |c|) is at most 1. Halving the angle twice more, tan(x/2) = t / (1 + √(1 + t²)), leaves at most 0.2, where eleven
    terms of the series of the arctangent are exact to 1e-16.
    """
    size = sqrt(c * c + s * s) + select(c < 0, -c, c)
    t = select(c < 0, -s, s) * reciprocal(size)
    for _ in range(2):
        t = t / (1 + sqrt(1 + t * t))
    square = t * t
    series = full(t, 1 / 21)
    for k in range(9, -1, -1):
        series = 1 / (2 * k + 1) - square * series
    return 16 * t * series
