"""3×3 matrices as nine scalars, row by row, and symmetric ones as six: xx, yy, zz, xy, xz, yz."""

from atlasphys.engine.jit import routine


@routine
def mul_vec(m, v):
    """M v."""
    return (
        m[0] * v[0] + m[1] * v[1] + m[2] * v[2],
        m[3] * v[0] + m[4] * v[1] + m[5] * v[2],
        m[6] * v[0] + m[7] * v[1] + m[8] * v[2],
    )


@routine
def transpose_mul_vec(m, v):
    """Mᵀ v: for a rotation, from the world's frame to the body's."""
    return (
        m[0] * v[0] + m[3] * v[1] + m[6] * v[2],
        m[1] * v[0] + m[4] * v[1] + m[7] * v[2],
        m[2] * v[0] + m[5] * v[1] + m[8] * v[2],
    )


@routine
def sym_mul_vec(s, v):
    """S v for a symmetric S."""
    return (
        s[0] * v[0] + s[3] * v[1] + s[4] * v[2],
        s[3] * v[0] + s[1] * v[1] + s[5] * v[2],
        s[4] * v[0] + s[5] * v[1] + s[2] * v[2],
    )


@routine
def rotated_diagonal(m, d):
    """M diag(d) Mᵀ as a symmetric matrix: a principal inertia (or its inverse) in world axes."""
    return (
        m[0] * m[0] * d[0] + m[1] * m[1] * d[1] + m[2] * m[2] * d[2],
        m[3] * m[3] * d[0] + m[4] * m[4] * d[1] + m[5] * m[5] * d[2],
        m[6] * m[6] * d[0] + m[7] * m[7] * d[1] + m[8] * m[8] * d[2],
        m[0] * m[3] * d[0] + m[1] * m[4] * d[1] + m[2] * m[5] * d[2],
        m[0] * m[6] * d[0] + m[1] * m[7] * d[1] + m[2] * m[8] * d[2],
        m[3] * m[6] * d[0] + m[4] * m[7] * d[1] + m[5] * m[8] * d[2],
    )


@routine
def load(rows, i):
    """Columns 0 to 8 of row i."""
    return (
        rows[i, 0],
        rows[i, 1],
        rows[i, 2],
        rows[i, 3],
        rows[i, 4],
        rows[i, 5],
        rows[i, 6],
        rows[i, 7],
        rows[i, 8],
    )


@routine
def store(rows, i, m):
    """Write m to columns 0 to 8 of row i."""
    rows[i, 0], rows[i, 1], rows[i, 2] = m[0], m[1], m[2]
    rows[i, 3], rows[i, 4], rows[i, 5] = m[3], m[4], m[5]
    rows[i, 6], rows[i, 7], rows[i, 8] = m[6], m[7], m[8]


@routine
def sym_add_scalar(s, k):
    """S + k 1."""
    return s[0] + k, s[1] + k, s[2] + k, s[3], s[4], s[5]


@routine
def sym_add_square(s, u, k):
    """S + k u uᵀ."""
    x, y, z = k * u[0], k * u[1], k * u[2]
    return s[0] + x * u[0], s[1] + y * u[1], s[2] + z * u[2], s[3] + x * u[1], s[4] + x * u[2], s[5] + y * u[2]
