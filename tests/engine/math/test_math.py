"""Tuples of scalars against NumPy's linear algebra. Only kernels may call a compiled routine, so one kernel calls them all."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from atlasphys.engine.jit import kernel
from atlasphys.engine.math import mat, quat, vec

NUMBERS = st.floats(-100, 100)
VECTORS = st.tuples(NUMBERS, NUMBERS, NUMBERS)
DIRECTIONS = st.one_of(
    VECTORS,
    st.sampled_from([(1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0), (0.0, 0.0, 1.0), (1e-7, 0.0, -1.0)]),
).filter(lambda v: np.linalg.norm(v) > 1e-3)
QUATERNIONS = st.tuples(NUMBERS, NUMBERS, NUMBERS, NUMBERS).filter(lambda q: np.linalg.norm(q) > 1e-3)
MATRICES = st.tuples(*[NUMBERS] * 9)


def plain(routine):
    """The routine as written, for those that call no other."""
    return getattr(routine, "py_func", routine)


@kernel
def all_of_them(u, v, p, q, m, s, out):
    """Every routine once, compiled."""
    vec.store(out, 0, vec.add(u, v))
    vec.store(out, 1, vec.sub(u, v))
    vec.store(out, 2, vec.neg(u))
    vec.store(out, 3, vec.scale(u, s))
    vec.store(out, 4, vec.add_scaled(u, v, s))
    vec.store(out, 5, vec.cross(u, v))
    out[6, 0], out[6, 1], out[6, 2] = vec.dot(u, v), vec.length(u), vec.length_squared(v)
    vec.store(out, 7, vec.unit(u))
    t1, t2 = vec.tangents(vec.unit(u))
    vec.store(out, 8, t1)
    vec.store(out, 9, t2)
    vec.store(out, 10, mat.mul_vec(m, v))
    vec.store(out, 11, mat.transpose_mul_vec(m, v))
    vec.store(out, 12, mat.sym_mul_vec((m[0], m[4], m[8], m[1], m[2], m[5]), v))
    turned = mat.rotated_diagonal(m, v)
    vec.store(out, 13, (turned[0], turned[1], turned[2]))
    vec.store(out, 14, (turned[3], turned[4], turned[5]))
    quat.store(out, 15, quat.mul(p, q))
    quat.store(out, 16, quat.conjugate(p))
    quat.store(out, 17, quat.unit(p))
    quat.store(out, 18, quat.cayley(u))
    mat.store(out, 19, quat.matrix(quat.unit(p)))


def rotation(q):
    """The matrix of a unit quaternion by its definition, q v q*."""

    def product(a, b):
        return np.array([a[0] * b[0] - a[1:] @ b[1:], *(a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:]))])

    conjugate = q * [1, -1, -1, -1]
    return np.array([product(product(q, np.array([0, *e])), conjugate)[1:] for e in np.eye(3)]).T


@pytest.mark.parametrize("real", [np.float32, np.float64])
@given(u=DIRECTIONS, v=VECTORS, p=QUATERNIONS, q=QUATERNIONS, m=MATRICES, s=NUMBERS)
def test_against_numpy(real, u, v, p, q, m, s):
    u, v, p, q, m = (np.array(x, real) for x in (u, v, p, q, m))
    if not u.any() or not p.any():
        return
    out = np.zeros((20, 9), real)
    with np.errstate(all="ignore"):
        all_of_them(tuple(u), tuple(v), tuple(p), tuple(q), tuple(m), real(s), out)
    u, v, p, q, s = u.astype(float), v.astype(float), p.astype(float), q.astype(float), float(real(s))
    matrix = m.astype(float).reshape(3, 3)
    symmetric = np.triu(matrix) + np.triu(matrix, 1).T
    diagonal = matrix @ np.diag(v) @ matrix.T
    n, unit = u / np.linalg.norm(u), p / np.linalg.norm(p)
    product = np.array([p[0] * q[0] - p[1:] @ q[1:], *(p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:]))])
    eps = np.finfo(real).eps
    size = (1 + np.linalg.norm(u)) * (1 + np.linalg.norm(v)) * (1 + abs(s))
    big = (1 + np.abs(m).max()) * (1 + np.abs(v).max())
    for row, wanted, scale in (
        (0, u + v, size),
        (1, u - v, size),
        (2, -u, size),
        (3, s * u, size),
        (4, u + s * v, size),
        (5, np.cross(u, v), size),
        (6, [u @ v, np.linalg.norm(u), v @ v], size * size),
        (7, n, 1),
        (10, matrix @ v, big),
        (11, matrix.T @ v, big),
        (12, symmetric @ v, big),
        (13, np.diag(diagonal), big * (1 + np.abs(m).max())),
        (14, diagonal[[0, 0, 1], [1, 2, 2]], big * (1 + np.abs(m).max())),
        (15, product, 1 + np.linalg.norm(p) * np.linalg.norm(q)),
        (16, p * [1, -1, -1, -1], 1),
        (17, unit, 1),
        (19, rotation(unit).ravel(), 1),
    ):
        np.testing.assert_allclose(out[row, : len(wanted)], wanted, rtol=0, atol=20 * eps * scale, err_msg=str(row))
    frame = np.array([out[8, :3], out[9, :3], n])
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=20 * eps)
    assert np.linalg.det(frame) > 0
    # The Cayley rotation by θ turns by 2 atan(|θ| / 2) about θ.
    angle = 2 * np.arctan(np.linalg.norm(u) / 2)
    np.testing.assert_allclose(out[18, :4], [np.cos(angle / 2), *(np.sin(angle / 2) * n)], atol=20 * eps)


@given(DIRECTIONS)
def test_tangents_have_no_pole_that_breaks_them(u):
    n = np.array(u) / np.linalg.norm(u)
    t1, t2 = plain(vec.tangents)(tuple(n))
    frame = np.array([t1, t2, n])
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-12)


@pytest.mark.parametrize("angle", [1e-9, 1e-4, 1e-2, 0.1])
def test_cayley_agrees_with_the_exponential_to_third_order(angle):
    out = np.zeros((20, 9))
    x = (1.0, 0.0, 0.0)
    all_of_them((0.0, angle, 0.0), x, (1.0, *x), (1.0, *x), (0.0,) * 9, 1.0, out)
    assert out[18, 2] == pytest.approx(np.sin(angle / 2), abs=angle**3 / 10)
    assert np.linalg.norm(out[18]) == pytest.approx(1, abs=1e-15)


def test_loads_and_stores():
    rows = np.arange(24.0).reshape(2, 12)
    assert plain(vec.load)(rows, 1) == (12, 13, 14)
    assert plain(quat.load)(rows, 1) == (12, 13, 14, 15)
    assert plain(mat.load)(rows, 1) == tuple(range(12, 21))
    assert plain(vec.load_columns)(rows, 1, 6) == (18, 19, 20)
    plain(vec.store_columns)(rows, 0, 9, (1.0, 2.0, 3.0))
    assert rows[0].tolist() == [0, 1, 2, 3, 4, 5, 6, 7, 8, 1, 2, 3]
