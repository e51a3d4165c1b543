"""Unit quaternions (w, x, y, z) as tuples of scalars: q v q* turns v from the body's frame to the world's."""

import math

from atlasphys.engine.jit import routine


@routine
def mul(p, q):
    """The Hamilton product p q: turn by q, then by p."""
    return (
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    )


@routine
def conjugate(q):
    """q*, the inverse of a unit quaternion."""
    return q[0], -q[1], -q[2], -q[3]


@routine
def unit(q):
    """q / |q|."""
    inverse = type(q[0])(1) / math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    return q[0] * inverse, q[1] * inverse, q[2] * inverse, q[3] * inverse


@routine
def cayley(theta):
    """The rotation (1 + ½θ̂)(1 − ½θ̂)⁻¹ as a unit quaternion: about θ, by 2 atan(|θ|/2).

    It agrees with the exponential map to third order in |θ| and needs neither sine nor cosine.
    """
    half = type(theta[0])(0.5)
    return unit((half + half, half * theta[0], half * theta[1], half * theta[2]))


@routine
def matrix(q):
    """The rotation matrix of a unit quaternion, as nine scalars, row by row."""
    w, x, y, z = q
    one = type(w)(1)
    two = one + one
    return (
        one - two * (y * y + z * z),
        two * (x * y - w * z),
        two * (x * z + w * y),
        two * (x * y + w * z),
        one - two * (x * x + z * z),
        two * (y * z - w * x),
        two * (x * z - w * y),
        two * (y * z + w * x),
        one - two * (x * x + y * y),
    )


@routine
def load(rows, i):
    """Columns 0 to 3 of row i."""
    return rows[i, 0], rows[i, 1], rows[i, 2], rows[i, 3]


@routine
def store(rows, i, q):
    """Write q to columns 0 to 3 of row i."""
    rows[i, 0], rows[i, 1], rows[i, 2], rows[i, 3] = q[0], q[1], q[2], q[3]
