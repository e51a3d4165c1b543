"""Three-vectors and matrices as tuples of lanes, for the bodies of ``@simd_kernel``.

Plain functions: they are traced into the body that calls them, or run on NumPy arrays. Matrices are nine lanes, row by
row; symmetric ones six: xx, yy, zz, xy, xz, yz. ``engine/math`` has the same for scalars.
"""

from __future__ import annotations

from typing import Any

from atlasphys.engine.simd.lanes import full, select, sqrt


def add(u: Any, v: Any) -> Any:
    """u + v."""
    return u[0] + v[0], u[1] + v[1], u[2] + v[2]


def sub(u: Any, v: Any) -> Any:
    """u − v."""
    return u[0] - v[0], u[1] - v[1], u[2] - v[2]


def neg(u: Any) -> Any:
    """−u."""
    return -u[0], -u[1], -u[2]


def scale(u: Any, s: Any) -> Any:
    """s u."""
    return u[0] * s, u[1] * s, u[2] * s


def add_scaled(u: Any, v: Any, s: Any) -> Any:
    """u + s v."""
    return u[0] + v[0] * s, u[1] + v[1] * s, u[2] + v[2] * s


def dot(u: Any, v: Any) -> Any:
    """u · v."""
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def cross(u: Any, v: Any) -> Any:
    """u × v."""
    return u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]


def length_squared(u: Any) -> Any:
    """|u|²."""
    return u[0] * u[0] + u[1] * u[1] + u[2] * u[2]


def length(u: Any) -> Any:
    """|u|."""
    return sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2])


def select_vec(mask: Any, u: Any, v: Any) -> Any:
    """u in the lanes of the mask, v in the others: for two tuples of lanes of equal length."""
    return tuple(select(mask, a, b) for a, b in zip(u, v, strict=True))


def tangents(n: Any) -> Any:
    """Two unit vectors that make a right-handed orthonormal triple with the unit vector n: as
    ``engine/math/vec.py``."""
    sign = select(n[2] >= 0, full(n[2], 1), -1)
    a = -1 / (sign + n[2])
    b = n[0] * n[1] * a
    return (1 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]), (b, sign + n[1] * n[1] * a, -n[1])


def column(m: Any, k: int) -> Any:
    """Column k of a matrix: of a rotation, the body's axis k in world coordinates."""
    return m[k], m[3 + k], m[6 + k]


def mat_mul_vec(m: Any, v: Any) -> Any:
    """M v: for a rotation, from the body's frame to the world's."""
    return dot(m[0:3], v), dot(m[3:6], v), dot(m[6:9], v)


def mat_transpose_mul_vec(m: Any, v: Any) -> Any:
    """Mᵀ v: for a rotation, from the world's frame to the body's."""
    return dot(column(m, 0), v), dot(column(m, 1), v), dot(column(m, 2), v)


def sym_mul_vec(s: Any, v: Any) -> Any:
    """S v for a symmetric S."""
    return (
        s[0] * v[0] + s[3] * v[1] + s[4] * v[2],
        s[3] * v[0] + s[1] * v[1] + s[5] * v[2],
        s[4] * v[0] + s[5] * v[1] + s[2] * v[2],
    )
