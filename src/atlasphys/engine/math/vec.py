"""Three-vectors as tuples of scalars. In a kernel a cross product of tuples costs 2 ns, one of small arrays 100 ns and more."""

import math

from atlasphys.engine.jit import routine


@routine
def add(u, v):
    """u + v."""
    return u[0] + v[0], u[1] + v[1], u[2] + v[2]


@routine
def sub(u, v):
    """u − v."""
    return u[0] - v[0], u[1] - v[1], u[2] - v[2]


@routine
def neg(u):
    """−u."""
    return -u[0], -u[1], -u[2]


@routine
def scale(u, s):
    """s u."""
    return u[0] * s, u[1] * s, u[2] * s


@routine
def add_scaled(u, v, s):
    """u + s v."""
    return u[0] + v[0] * s, u[1] + v[1] * s, u[2] + v[2] * s


@routine
def dot(u, v):
    """u · v."""
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


@routine
def cross(u, v):
    """u × v."""
    return u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]


@routine
def length_squared(u):
    """|u|²."""
    return u[0] * u[0] + u[1] * u[1] + u[2] * u[2]


@routine
def length(u):
    """|u|."""
    return math.sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2])


@routine
def unit(u):
    """u / |u|; undefined for the zero vector, which the caller excludes."""
    inverse = type(u[0])(1) / math.sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2])
    return u[0] * inverse, u[1] * inverse, u[2] * inverse


@routine
def load(rows, i):
    """Columns 0 to 2 of row i of an (n, ≥ 3) array."""
    return rows[i, 0], rows[i, 1], rows[i, 2]


@routine
def load_columns(rows, i, first):
    """Three columns of row i, from column ``first`` on. (Slicing a row off first would cost time, and much more compile time.)"""
    return rows[i, first], rows[i, first + 1], rows[i, first + 2]


@routine
def store(rows, i, u):
    """Write u to columns 0 to 2 of row i."""
    rows[i, 0], rows[i, 1], rows[i, 2] = u[0], u[1], u[2]


@routine
def store_columns(rows, i, first, u):
    """Write u to three columns of row i, from column ``first`` on."""
    rows[i, first], rows[i, first + 1], rows[i, first + 2] = u[0], u[1], u[2]


@routine
def tangents(n):
    """Two unit vectors that make a right-handed orthonormal triple with the unit vector n.

    Continuous except at one pole, and free of square roots: Duff et al., "Building an Orthonormal Basis, Revisited",
    JCGT 6(1), 2017.
    """
    one = type(n[0])(1)
    sign = one if n[2] >= 0 else -one
    a = -one / (sign + n[2])
    b = n[0] * n[1] * a
    return (one + sign * n[0] * n[0] * a, sign * b, -sign * n[0]), (b, sign + n[1] * n[1] * a, -n[1])
