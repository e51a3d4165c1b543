"""The formulas of docs/theory/collision.md, with the engine's own routines on small cases."""

import numpy as np
import pytest
import scipy.spatial
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

import atlasphys as ap
from atlasphys.engine.narrowphase.clip import _cut
from atlasphys.engine.narrowphase.gjk import (
    OVERLAPPING,
    SEPARATED,
    TOUCHING,
    WEIGHT,
    _set_weights,
    difference_support,
    gjk,
    segment_weights,
    triangle_weights,
)
from atlasphys.engine.narrowphase.sat import box_axes
from atlasphys.engine.shapes.support import support
from atlasphys.engine.shapes.table import ShapeTable
from tests.theory.formulas import checks, interpreted

TURN = scipy.spatial.transform.Rotation.from_rotvec([0.4, -0.9, 0.3]).as_matrix()
CORNERS = np.array([(i, j, k) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]) * 0.5
TABLE = ShapeTable(np.float64)
BOX = TABLE.row_of(ap.Box(size=(1, 2, 3)))
CUBE = TABLE.row_of(ap.Box(size=(1, 1, 1)))
SHAPES = TABLE.arrays
SUPPORT, SUPPORT_OF_DIFFERENCE, GJK = interpreted(support), interpreted(difference_support), interpreted(gjk)
UNIT = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda n: sum(e * e for e in n) > 0.01)


def two_boxes(d):
    """The pair, and all points of A − B that can be its corners."""
    pair = (BOX, CUBE, tuple(np.eye(3).ravel()), tuple(TURN.ravel()), tuple(d))
    a, b = CORNERS * (1, 2, 3), CORNERS @ TURN.T + d
    return pair, (a[:, None] - b[None]).reshape(-1, 3)


@checks("collision-minkowski", "collision-convex", "collision-support", "collision-placed")
@settings(max_examples=30)
@given(UNIT)
def test_support_of_the_difference(direction):
    pair, corners = two_boxes((1.5, 0.3, -0.2))
    w, on_a = SUPPORT_OF_DIFFERENCE(SHAPES, pair, direction)
    n = np.array(direction)
    assert n @ np.array(w) == pytest.approx((corners @ n).max(), abs=1e-12)
    of_b = TURN @ np.array(SUPPORT(SHAPES, CUBE, tuple(TURN.T @ -n))) + (1.5, 0.3, -0.2)
    assert np.allclose(w, np.array(on_a) - of_b, atol=1e-14)
    assert -n @ of_b == pytest.approx((-(CORNERS @ TURN.T + (1.5, 0.3, -0.2)) @ n).max(), abs=1e-12)


def test_the_article_s_support_is_another_set():
    """s_A(d) + s_B(d) belongs to the sum: it says that two distant boxes overlap."""
    n = np.array([1.0, 0, 0])
    right = np.array(SUPPORT(SHAPES, CUBE, tuple(n))) - (np.array(SUPPORT(SHAPES, CUBE, tuple(-n))) + (5, 0, 0))
    wrong = np.array(SUPPORT(SHAPES, CUBE, tuple(n))) + (np.array(SUPPORT(SHAPES, CUBE, tuple(n))) + (5, 0, 0))
    assert n @ right < 0 < n @ wrong


@checks("collision-convex")
def test_differences_of_convex_sets_are_convex():
    s, *rest = sp.symbols("s a1 b1 a2 b2")
    a1, b1, a2, b2 = rest
    assert sp.expand(s * (a1 - b1) + (1 - s) * (a2 - b2) - ((s * a1 + (1 - s) * a2) - (s * b1 + (1 - s) * b2))) == 0


@checks("collision-gap", "collision-witness", "collision-minkowski")
@settings(max_examples=40)
@given(UNIT, st.floats(0.5, 6))
def test_gjk_against_the_whole_difference(direction, reach):
    pair, corners = two_boxes(np.array(direction) * reach)
    simplex = np.zeros((4, 7))
    status, v, on_a, count = GJK(SHAPES, pair, tuple(direction), np.inf, simplex)
    hull = scipy.spatial.ConvexHull(corners)
    inside = hull.equations[:, 3].max()  # distance to the nearest face plane, negative inside
    if inside < -1e-9:
        assert status in (OVERLAPPING, TOUCHING)
    elif inside > 1e-9:
        assert status == SEPARATED
        length = np.linalg.norm(v)
        w, _ = SUPPORT_OF_DIFFERENCE(SHAPES, pair, tuple(-e for e in v))
        assert np.dot(v, w) / length == pytest.approx(length, rel=1e-6)
        # The dual bound holds for any v at all.
        other = np.array(v) + 0.3 * length * np.array(direction)
        w, _ = SUPPORT_OF_DIFFERENCE(SHAPES, pair, tuple(-other))
        assert np.dot(other, w) / np.linalg.norm(other) <= length * (1 + 1e-9)
        weights = simplex[:count, WEIGHT]
        assert weights.sum() == pytest.approx(1)
        assert np.allclose(weights @ simplex[:count, 3:6], on_a, atol=1e-9)
        assert np.allclose(weights @ simplex[:count, :3], v, atol=1e-6)


@checks("collision-segment", "collision-triangle", "collision-tetrahedron")
def test_closest_points_of_simplices():
    a, b, c, d = (sp.Matrix(sp.symbols(f"{name}:3", real=True)) for name in "abcd")
    n = (b - a).cross(c - a)
    weights = [n.dot(b.cross(c)), n.dot(c.cross(a)), n.dot(a.cross(b))]
    assert sp.expand(sum(weights) - n.dot(n)) == 0
    # n·n times the foot of the perpendicular: it lies along n.
    corner = dict(zip((*a, *b, *c), (1, 2, -1, 3, 0, 1, -2, 1, 2), strict=True))
    foot = (weights[0] * a + weights[1] * b + weights[2] * c).subs(corner)
    assert foot.cross(n.subs(corner)) == sp.zeros(3, 1)
    va, vb, vc, vd = b.dot(c.cross(d)), -a.dot(c.cross(d)), d.dot(a.cross(b)), -c.dot(a.cross(b))
    assert (va * a + vb * b + vc * c + vd * d).expand() == sp.zeros(3, 1)
    assert sp.expand(va + vb + vc + vd - (b - a).dot((c - a).cross(d - a))) == 0

    assert interpreted(segment_weights)((1.0, 1.0, 0.0), (-1.0, 1.0, 0.0)) == (0.5, 0.5)
    assert interpreted(segment_weights)((1.0, 1.0, 0.0), (3.0, 1.0, 0.0)) == (1.0, 0.0)
    found = interpreted(triangle_weights)((1.0, 0.0, 1.0), (-1.0, 1.0, 1.0), (-1.0, -1.0, 1.0))
    assert np.allclose(found, (0.5, 0.25, 0.25))
    simplex = np.zeros((4, 7))
    simplex[:, :3] = [(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]
    interpreted(_set_weights)(simplex, 4)
    assert np.allclose(simplex[:, WEIGHT], 0.25)


@pytest.mark.parametrize(
    "simplex", [[(0, 0, 0), (1, 0, 0)], [(1, 0, 0), (1, 0, 0)], [(-1, 0, 0), (1, 0, 0), (2, 0, 0)]]
)
def test_degenerate_simplices_have_an_answer(simplex):
    """The origin on a segment, a segment of no length, a flat triangle: what the articles give probability 0."""
    rows = np.zeros((4, 7))
    rows[: len(simplex), :3] = simplex
    interpreted(_set_weights)(rows, len(simplex))
    assert rows[:, WEIGHT].sum() == pytest.approx(1)
    assert np.linalg.norm(rows[:, WEIGHT] @ rows[:, :3]) == min(
        np.linalg.norm(np.outer(1 - s, p) + np.outer(s, q), axis=1).min()
        for s in [np.linspace(0, 1, 7)]
        for p in np.array(simplex)
        for q in np.array(simplex)
    )


@checks("collision-depth", "collision-epa", "collision-gap-along", "collision-boxes")
def test_depth_by_hull_by_faces_and_by_axes():
    d = np.array([0.6, 0.9, 0.4])
    pair, corners = two_boxes(d)
    hull = scipy.spatial.ConvexHull(corners)
    distances = -hull.equations[:, 3]
    depth = distances.min()
    assert depth > 0
    # Every direction is a way out at least as long, and an inner polytope is nearer than the boundary.
    rng = np.random.default_rng(2)
    for n in rng.normal(size=(200, 3)):
        n = n / np.linalg.norm(n)
        assert (corners @ n).max() >= depth - 1e-12
    inner = scipy.spatial.ConvexHull(corners[rng.permutation(len(corners))[:24]])
    assert (-inner.equations[:, 3]).min() <= depth
    # The fifteen axes have the same minimum.
    axes = [*np.eye(3), *TURN.T, *(np.cross(e, u) for e in np.eye(3) for u in TURN.T)]
    gaps = []
    for axis in axes:
        n = axis / np.linalg.norm(axis)
        n = n if n @ d > 0 else -n
        gap = ((CORNERS @ TURN.T + d) @ n).min() - (CORNERS * (1, 2, 3) @ n).max()
        assert gap == pytest.approx(-(corners @ n).max(), abs=1e-12)
        gaps.append(gap)
    assert max(gaps) == pytest.approx(-depth, abs=1e-12)
    for i in range(3):
        claimed = abs(d[i]) - (0.5, 1.0, 1.5)[i] - 0.5 * abs(TURN[i]).sum()
        assert claimed == pytest.approx(gaps[i], abs=1e-12)
    normal, distance, *_ = interpreted(box_axes)(SHAPES, pair, np.inf, 0.0, np.zeros((5, 3)))
    assert distance == pytest.approx(-depth, abs=1e-12)
    assert (corners @ np.array(normal)).max() == pytest.approx(depth, abs=1e-12)


@checks("collision-edge-test")
def test_the_article_s_convergence_test():
    first, second = np.array([1.0, 0, 0]), np.array([3.0, 4, 0])
    between = first + 0.3 * (second - first)
    total = np.linalg.norm(first - between) + np.linalg.norm(second - between)
    assert total == pytest.approx(np.linalg.norm(first - second))
    assert total > 1


@checks("collision-clip")
def test_clipping_a_square_by_a_plane():
    p, q, n, level = sp.Matrix([1, 2, 0]), sp.Matrix([4, -1, 3]), sp.Matrix([1, 2, 2]) / 3, sp.Rational(7, 3)
    at_p, at_q = n.dot(p) - level, n.dot(q) - level
    assert n.dot(p + at_p / (at_p - at_q) * (q - p)) == level
    polygon, ids = np.zeros((16, 3)), np.zeros((16, 2), np.int32)
    polygon[:4] = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
    left = interpreted(_cut)(polygon, ids, 0, 4, 8, (0.25, 0.0, 0.0), (1.0, 0.0, 0.0), 0.0, 1)
    assert left == 4
    assert sorted(map(tuple, polygon[8:12])) == [(-1, -1, 0), (-1, 1, 0), (0.25, -1, 0), (0.25, 1, 0)]
