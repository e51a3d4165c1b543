"""Vectors of lanes against NumPy's linear algebra, and compiled against read."""

import numpy as np
import pytest

from atlasphys.engine.jit import kernel
from atlasphys.engine.simd import load, simd_kernel, store, vec


@simd_kernel
def every_function(block, given, found):
    u, v = (tuple(load(given, block, first + k) for k in range(3)) for first in (0, 3))
    m, s = tuple(load(given, block, 6 + k) for k in range(9)), tuple(load(given, block, 15 + k) for k in range(6))
    n = vec.scale(u, 1 / vec.length(u))
    results = (
        *vec.add(u, v),
        *vec.sub(u, v),
        *vec.neg(u),
        *vec.scale(u, v[0]),
        *vec.add_scaled(u, v, s[0]),
        vec.dot(u, v),
        vec.length_squared(u),
        vec.length(u),
        *vec.cross(u, v),
        *vec.select_vec(u[0] < v[0], u, v),
        *vec.tangents(n)[0],
        *vec.tangents(n)[1],
        *vec.column(m, 1),
        *vec.mat_mul_vec(m, v),
        *vec.mat_transpose_mul_vec(m, v),
        *vec.sym_mul_vec(s, v),
    )
    for k in range(len(results)):
        store(found, block, k, results[k])


@kernel
def every_function_everywhere(given, found):
    for block in range(given.shape[0]):
        every_function(block, given, found)


@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_vectors_are_numpys(real):
    given = np.random.default_rng(0).normal(size=(20, 21, 8)).astype(real)
    answers = [np.zeros((20, 42, 8), real) for _ in range(2)]
    every_function_everywhere(given, answers[0])
    every_function_everywhere.py_func(given, answers[1])
    np.testing.assert_array_equal(*answers)
    wanted = []
    for values in np.moveaxis(given, 1, 2).reshape(-1, 21).astype(float):
        u, v, m, s = values[:3], values[3:6], values[6:15].reshape(3, 3), values[15:]
        symmetric = np.array([[s[0], s[3], s[4]], [s[3], s[1], s[5]], [s[4], s[5], s[2]]])
        wanted.append(
            [
                *(u + v),
                *(u - v),
                *-u,
                *(u * v[0]),
                *(u + v * s[0]),
                u @ v,
                u @ u,
                np.linalg.norm(u),
                *np.cross(u, v),
                *(u if u[0] < v[0] else v),
                *np.full(6, np.nan),
                *m[:, 1],
                *(m @ v),
                *(m.T @ v),
                *(symmetric @ v),
            ]
        )
    found = np.moveaxis(answers[0], 1, 2).reshape(-1, 42)
    wanted = np.array(wanted)
    known = ~np.isnan(wanted[0])
    np.testing.assert_allclose(found[:, known], wanted[:, known], rtol=1e-5, atol=1e-5)
    triples = np.stack(
        [given[:, :3], *(answers[0][:, ~known].reshape(20, 2, 3, 8).transpose(1, 0, 2, 3))], axis=1
    ).transpose(0, 3, 1, 2)
    triples[:, :, 0] /= np.linalg.norm(triples[:, :, 0], axis=2, keepdims=True)
    np.testing.assert_allclose(
        triples @ np.swapaxes(triples, 2, 3), np.broadcast_to(np.eye(3), (20, 8, 3, 3)), atol=1e-5
    )
    assert (np.linalg.det(triples.astype(float)) > 0.9).all()
