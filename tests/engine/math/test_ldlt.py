"""The written-out 6×6 solution against LAPACK, and disjoint sets against a walk through the graph."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from atlasphys.engine.jit import kernel
from atlasphys.engine.math.ldlt import solve_6x6
from atlasphys.engine.math.union_find import find_root, unite


@kernel
def solve(matrix, right, out):
    """``out`` = ``matrix``⁻¹ ``right``."""
    a = (matrix[0, 0], matrix[1, 1], matrix[2, 2], matrix[0, 1], matrix[0, 2], matrix[1, 2])
    b = (
        matrix[3, 0], matrix[3, 1], matrix[3, 2], matrix[4, 0], matrix[4, 1], matrix[4, 2],
        matrix[5, 0], matrix[5, 1], matrix[5, 2],
    )  # fmt: skip
    d = (matrix[3, 3], matrix[4, 4], matrix[5, 5], matrix[3, 4], matrix[3, 5], matrix[4, 5])
    x, y = solve_6x6(a, b, d, (right[0], right[1], right[2]), (right[3], right[4], right[5]))
    for k in range(3):
        out[k], out[3 + k] = x[k], y[k]


def solution(matrix, right):
    out = np.zeros_like(right)
    solve(matrix, right, out)
    return out


@given(st.integers(0, 2**32 - 1), st.integers(-12, 12), st.integers(0, 5))
def test_the_solution_is_lapacks(seed, scale, decades):
    """Matrices M + Σ k J Jᵀ as the solver makes them, of any scale, stiff by up to five decades."""
    rng = np.random.default_rng(seed)
    mass = np.diag(rng.uniform(0.5, 2, 6))
    jacobians = rng.normal(size=(rng.integers(0, 8), 6))
    matrix = 10.0**scale * (mass + 10.0**decades * jacobians.T @ jacobians)
    right = rng.normal(size=6)
    expected = np.linalg.solve(matrix, right)
    found = solution(matrix, right)
    error = np.abs(found - expected).max() / np.abs(expected).max()
    assert error < 1e-14 * np.linalg.cond(matrix)


@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_a_diagonal_matrix_divides(real):
    right = np.arange(1, 7).astype(real)
    found = solution(np.diag(np.array([1, 2, 4, 8, 16, 32], real)), right)
    assert found.dtype == real
    assert found.tolist() == (right / [1, 2, 4, 8, 16, 32]).tolist()


@kernel
def label(edges, parent):
    """Name each element's set by its lowest member."""
    for i in range(len(parent)):
        parent[i] = i
    for e in range(len(edges)):
        unite(parent, edges[e, 0], edges[e, 1])
    for i in range(len(parent)):
        parent[i] = find_root(parent, i)


@given(st.integers(1, 20), st.lists(st.tuples(st.integers(0, 19), st.integers(0, 19)), max_size=25))
def test_sets_are_the_components_of_the_graph(count, edges):
    edges = np.array([e for e in edges if max(e) < count], np.int32).reshape(-1, 2)
    parent = np.zeros(count, np.int32)
    label(edges, parent)
    expected = np.arange(count)
    for _ in range(count):
        for a, b in edges:
            expected[a] = expected[b] = min(expected[a], expected[b])
    assert parent.tolist() == expected.tolist()
