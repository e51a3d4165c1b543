"""Reduction to four points, matching with last step's, and the manifolds built from both."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import atlasphys as ap
from atlasphys.engine.jit import kernel
from atlasphys.engine.manifold.build import COMBINE_RULES
from atlasphys.engine.manifold.match import match_points
from atlasphys.engine.manifold.reduce import reduce_points
from atlasphys.engine.state.manifolds import (
    DEPTH,
    FRICTION,
    LOCAL_A,
    LOCAL_B,
    NORMAL_IMPULSE,
    POINT_COLUMNS,
    RESTITUTION,
    ROLLING,
    TORSIONAL,
    live_rows,
)
from tests.world.scenes import stack, steps


@kernel
def reduced(normal, anchors, depths, first, count, kept):
    """reduce_points, callable."""
    return reduce_points(normal, anchors, depths, first, count, kept)


@kernel
def matched(count, feature, local, old_count, old_feature, old_local, distance, origin):
    """match_points of manifold 0 with manifold 0, callable."""
    match_points(0, count, feature, local, 0, old_count, old_feature, old_local, distance, origin)


def reduce(points, depths, first=0, normal=(0.0, 0.0, 1.0)):
    kept = np.full(4, -1, np.int64)
    number = reduced(normal, np.array(points, float), np.array(depths, float), first, len(points) - first, kept)
    return kept[:number].tolist()


def area(points):
    """Area of the convex hull of points in the plane z = 0: the greatest over all orders of at most four points."""
    if len(points) < 3:
        return 0.0
    best = 0.0
    for order in itertools.permutations(points):
        x, y = np.array(order)[:, 0], np.array(order)[:, 1]
        best = max(best, abs(0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())))
    return best


GRID = st.integers(-4, 4).map(lambda i: i / 4)
FLOATS = st.floats(-1, 1)
POINTS = st.lists(st.tuples(GRID, GRID) | st.tuples(FLOATS, FLOATS), min_size=5, max_size=10)


@given(points=POINTS, data=st.data())
def test_reduction_keeps_the_deepest_and_a_large_area(points, data):
    depths = data.draw(st.lists(st.floats(-0.01, 0.1), min_size=len(points), max_size=len(points)))
    spatial = [(x, y, 0.0) for x, y in points]
    kept = reduce(spatial, depths)
    assert kept == sorted(set(kept))
    assert 1 <= len(kept) <= 4
    deepest = int(np.argmax(depths))
    assert deepest in kept
    best = max(
        area([points[i] for i in {deepest, *chosen}]) for chosen in itertools.combinations(range(len(points)), 3)
    )
    # The farthest point and the largest triangle on it give at least half of the best; the fourth point only adds.
    assert area([points[i] for i in kept]) >= 0.5 * best - 1e-12


@pytest.mark.parametrize("turn", [0.0, 0.3])
def test_corners_are_kept_and_points_between_them_dropped(turn):
    corners = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
    points = corners + [(1, 0), (0, 1), (0, 0), (0.5, -0.5)]
    c, s = np.cos(turn), np.sin(turn)
    spatial = [(c * x - s * y, s * x + c * y, 3.0) for x, y in points]
    assert reduce(spatial, [0.01] + [0.0] * 7) == [0, 1, 2, 3]


def test_few_points_are_all_kept():
    assert reduce([(0, 0, 0)] * 4, [0, 0, 0, 0]) == [0, 1, 2, 3]
    assert reduce([(5, 5, 5), (0, 0, 0), (1, 0, 0)], [9, 0, 1], first=1) == [1, 2]


def test_degenerate_point_sets():
    assert reduce([(1, 2, 3)] * 6, [0, 0, 1, 0, 0, 0]) == [2]
    line = [(x, 0, 0) for x in (0, 1, 2, 3, 4)]
    assert reduce(line, [0] * 5) == [0, 4]
    assert set(reduce(line, [0, 0, 1, 0, 0])) == {0, 2}
    triangle = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 0), (1, 0, 0)]
    assert len(reduce(triangle, [0] * 5)) == 3


def test_ties_go_to_the_lower_index():
    square = [(x, y, 0) for x in (-1, 1) for y in (-1, 1)]
    assert reduce(square * 2, [0] * 8) == reduce(square * 3, [0] * 12)


def match(new, old, distance=0.02, features=None, old_features=None, apart_b=0.0):
    def padded(points, apart_b):
        array = np.zeros((4, POINT_COLUMNS))
        array[: len(points), LOCAL_A : LOCAL_A + 3] = np.reshape(points, (-1, 3))
        array[: len(points), LOCAL_B : LOCAL_B + 3] = np.reshape(points, (-1, 3)) + apart_b
        return array.reshape(1, -1)

    def numbers(given, count):
        return np.array([list(given if given is not None else range(count)) + [0] * (4 - count)], np.int32)

    origin = np.full(4, -1, np.int64)
    matched(
        len(new),
        numbers(features, len(new)),
        padded(new, apart_b),
        len(old),
        numbers(old_features, len(old)),
        padded(old, 0.0),
        distance,
        origin,
    )
    return origin[: len(new)].tolist()


SQUARE = [(1, 0, 1), (-1, 0, 1), (-1, 0, -1), (1, 0, -1)]


def test_equal_points_match_whatever_their_order_and_features():
    assert match(SQUARE, SQUARE) == [0, 1, 2, 3]
    for order in itertools.permutations(range(4)):
        shuffled = [SQUARE[i] for i in order]
        assert match(shuffled, SQUARE, features=order, old_features=range(4)) == list(order)
        assert match(shuffled, SQUARE, features=(7, 8, 9, 10)) == list(order)


def test_equal_features_match_farther_than_different_ones():
    assert match([(0.1, 0, 0)], [(0, 0, 0)], features=[5], old_features=[5]) == [0]
    assert match([(0.1, 0, 0)], [(0, 0, 0)], features=[5], old_features=[6]) == [-1]
    assert match([(0.01, 0, 0)], [(0, 0, 0)], features=[5], old_features=[6]) == [0]
    assert match([(0.3, 0, 0)], [(0, 0, 0)], features=[5], old_features=[5]) == [-1]


def test_a_point_that_slides_along_one_body_matches_by_the_other():
    assert match([(0.0, 0, 0)], [(0, 0, 0)], features=[1], old_features=[2], apart_b=0.5) == [0]


@given(st.lists(st.tuples(GRID, GRID, GRID), min_size=1, max_size=4), st.data())
def test_each_old_point_serves_at_most_one(old, data):
    new = data.draw(st.lists(st.sampled_from(old), min_size=1, max_size=4))
    features = data.draw(st.lists(st.integers(0, 2), min_size=len(new), max_size=len(new)))
    old_features = data.draw(st.lists(st.integers(0, 2), min_size=len(old), max_size=len(old)))
    origin = [q for q in match(new, old, features=features, old_features=old_features) if q >= 0]
    assert len(set(origin)) == len(origin)
    assert all(q < len(old) for q in origin)


def rows(world):
    """The present manifolds as a dictionary by pair."""
    state = world._state
    m = state.manifolds
    return {
        (int(m.a[i]), int(m.b[i])): {
            "count": m.count[i],
            "feature": m.feature[i].copy(),
            "contact": m.contact[i].copy(),
            "points": m.points[i].reshape(4, POINT_COLUMNS).copy(),
            "local": m.local[i].reshape(4, POINT_COLUMNS).copy(),
            "friction_impulse": m.friction_impulse[i].reshape(4, 3).copy(),
        }
        for i in live_rows(m, state.manifold_count)
    }


def test_manifolds_are_ordered_by_pair_and_unused_points_are_zero():
    world = stack(3)
    world.add(ap.Sphere(radius=0.5), position=(0, 3.5, 0))
    steps(world, 10)
    pairs = rows(world)
    assert list(pairs) == sorted(pairs) == [(0, 1), (1, 2), (2, 3), (3, 4)]
    assert pairs[3, 4]["count"] == 1
    for name in ("points", "local", "feature", "friction_impulse"):
        assert pairs[3, 4][name].shape[0] == 4
        assert not pairs[3, 4][name][1:].any()
    assert pairs[3, 4]["points"][0, NORMAL_IMPULSE] > 0
    assert pairs[0, 1]["count"] == 4


def test_impulses_carry_over_from_step_to_step():
    world = stack(4)
    steps(world, 30)
    for _ in range(10):
        before = rows(world)
        # Without a sweep's work only the carried impulses are left: they hold the stack up alone, nearly.
        world.step(1 / 60)
        for pair, manifold in rows(world).items():
            np.testing.assert_allclose(
                np.sort(manifold["points"][:, NORMAL_IMPULSE]),
                np.sort(before[pair]["points"][:, NORMAL_IMPULSE]),
                rtol=0.02,
            )


def test_a_pair_in_sight_but_apart_has_no_contact_yet():
    world = ap.World(gravity=(0, 0, 0))
    world.add(ap.Plane(normal=(0, 1, 0)))
    world.add(ap.Sphere(radius=0.5), position=(0, 0.51, 0))
    world.step(1 / 60)
    assert list(rows(world)) == [(0, 1)]
    assert rows(world)[0, 1]["points"][0, DEPTH] == pytest.approx(-0.01, abs=1e-6)
    assert len(world.contacts) == 0
    assert world.events == []


RULES = {
    "geometric_mean": lambda x, y: (x * y) ** 0.5,
    "average": lambda x, y: 0.5 * (x + y),
    "min": min,
    "max": max,
    "multiply": lambda x, y: x * y,
}


@pytest.mark.parametrize("rule", COMBINE_RULES)
def test_combine_rules(rule):
    world = ap.World(gravity=(0, 0, 0), friction_combine=rule, restitution_combine=rule)
    world.add(ap.Sphere(radius=1), friction=0.3, restitution=0.9, rolling_friction=0.01, torsional_friction=0.04)
    world.add(
        ap.Sphere(radius=1),
        position=(1.9, 0, 0),
        friction=0.8,
        restitution=0.2,
        rolling_friction=0.03,
        torsional_friction=0.02,
    )
    world.step(1 / 60)
    combine = RULES[rule]
    material = rows(world)[0, 1]["contact"][[FRICTION, RESTITUTION, ROLLING, TORSIONAL]]
    assert material == pytest.approx([combine(0.3, 0.8), combine(0.9, 0.2), 0.03, 0.04], rel=1e-6)
    assert set(RULES) == set(COMBINE_RULES)
