"""Brute force against a plain loop over all pairs, and the others against brute force."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import atlasphys as ap
from atlasphys.engine.broadphase import BROADPHASES
from atlasphys.engine.shapes.bounds import update_bounds
from atlasphys.engine.state.pose import refresh

MARGIN = 0.02


def bounded(world):
    """The world's state with fresh bounds."""
    state = world._state
    refresh(state.bodies, 0, state.count)
    update_bounds(state.bodies, state.colliders, state.table.arrays, state.count, state.tolerances.margin)
    return state


def found(state, name, buffer=64):
    pairs = np.zeros((buffer, 2), np.int32)
    pairs, count = BROADPHASES[name](state.bodies, state.colliders, state.table.arrays, state.count, pairs)
    return [tuple(pair) for pair in pairs[:count].tolist()]


def expected(world, state):
    """The pairs by the definition, in plain Python and from the handles."""
    rows = []
    bodies = list(world.bodies)
    lower, upper = state.colliders.lower, state.colliders.upper
    for i, a in enumerate(bodies):
        for j in range(i + 1, len(bodies)):
            b = bodies[j]
            if "dynamic" not in (a.kind, b.kind):
                continue
            groups, masks = state.colliders.group, state.colliders.mask
            if not (int(masks[i]) & int(groups[j]) and int(masks[j]) & int(groups[i])):
                continue
            planes = [k for k, body in ((i, a), (j, b)) if isinstance(body.shape, ap.Plane)]
            if planes:
                (plane,) = planes
                k = j if plane == i else i
                size, frame = state.table.arrays.size[state.colliders.shape[plane]], state.bodies.geometry[plane, :9]
                n = frame.reshape(3, 3) @ size[:3]
                corners = np.where(n > 0, lower[k], upper[k]) - state.bodies.position[plane]
                near = float((n.astype(float) * np.where(n == 0, 0, corners)).sum()) <= size[3]
            else:
                near = all(lower[i, k] <= upper[j, k] and lower[j, k] <= upper[i, k] for k in range(3))
            if near:
                rows.append((i, j))
    return rows


SHAPES = [ap.Sphere(radius=0.5), ap.Box(size=(1, 2, 0.5)), ap.Cone(radius=0.5, height=1), ap.tetrahedron(radius=1)]

# Coordinates on a coarse grid touch and coincide; the others do not.
COORDINATES = st.one_of(st.integers(-3, 3).map(float), st.floats(-3, 3), st.sampled_from([1e6, -1e9, 1e-12]))
BODIES = st.lists(
    st.tuples(
        st.tuples(COORDINATES, COORDINATES, COORDINATES),
        st.integers(0, len(SHAPES)),
        st.sampled_from(["dynamic", "dynamic", "static", "kinematic"]),
        st.sampled_from([1, 1, 2, 3, ~0]),
        st.sampled_from([~0, ~0, 1, 2, 0]),
        st.sampled_from([(1, 0, 0, 0), (0, 1, 0, 0), (1, 0.3, -0.2, 0.7)]),
    ),
    max_size=25,
)


@settings(max_examples=200)
@given(BODIES)
def test_all_find_the_same_pairs_in_the_same_order(bodies):
    world = ap.World()
    for position, shape, kind, group, mask, orientation in bodies:
        plane = shape == len(SHAPES)
        world.add(
            ap.Plane(normal=(0.6, 0.8, 0)) if plane else SHAPES[shape],
            position=position,
            kind=None if plane else kind,
            group=group,
            mask=mask,
            orientation=orientation,
        )
    state = bounded(world)
    wanted = expected(world, state)
    assert found(state, "brute") == wanted
    assert found(state, "sweep") == wanted
    assert found(state, "tree") == wanted


@pytest.mark.parametrize("name", BROADPHASES)
def test_buffers_grow_and_nothing_is_dropped(name):
    world = ap.World()
    for _ in range(60):
        world.add(ap.Sphere(radius=1))
    world.add(ap.Plane(normal=(0, 1, 0)))
    state = bounded(world)
    wanted = [(i, j) for i in range(61) for j in range(i + 1, 61)]
    assert len(wanted) == 1830
    for buffer in (1, 64, 1829, 1830, 4000):
        assert found(state, name, buffer) == wanted


@pytest.mark.parametrize("name", BROADPHASES)
def test_nothing_in_particular(name):
    world = ap.World()
    assert found(bounded(world), name) == []
    world.add(ap.Plane(normal=(0, 1, 0)))
    world.add(ap.Plane(normal=(1, 0, 0)))
    assert found(bounded(world), name) == []
    world.add(ap.Sphere(radius=1))
    assert found(bounded(world), name) == [(0, 2), (1, 2)]
    world.add(ap.Sphere(radius=1), kind="static")
    assert found(bounded(world), name) == [(0, 2), (1, 2), (2, 3)]


@pytest.mark.parametrize("name", BROADPHASES)
@pytest.mark.parametrize(("gap", "pairs"), [(0.0, 1), (2 * MARGIN, 1), (2 * MARGIN + 1e-9, 0), (-1.0, 1)])
def test_bounds_that_touch_are_a_pair(name, gap, pairs):
    world = ap.World()
    world.add(ap.Box(size=(1, 1, 1)))
    world.add(ap.Box(size=(1, 1, 1)), position=(1 + gap, 0.25, -0.25))
    state = bounded(world)
    # The margin is single precision's 0.02: set the bounds to say exactly what is meant.
    half = 0.5 + MARGIN
    for row in range(2):
        state.colliders.lower[row] = state.bodies.position[row] - half
        state.colliders.upper[row] = state.bodies.position[row] + half
    state.colliders.lower[1, 0] = state.colliders.upper[0, 0] + (gap - 2 * MARGIN)
    assert len(found(state, name)) == pairs


@pytest.mark.parametrize(
    ("a", "b", "collide"),
    [
        ({}, {}, True),
        ({"group": 2}, {}, True),
        ({"mask": 2}, {}, False),
        ({"mask": 2}, {"group": 2}, True),
        ({"mask": 2}, {"group": 2, "mask": 2}, False),
        ({"group": 2, "mask": 4}, {"group": 4, "mask": 2}, True),
        ({"group": 0}, {}, False),
        ({"group": 1 << 31}, {"mask": 1 << 31}, True),
        ({"group": 1 << 31}, {"mask": (1 << 31) - 1}, False),
    ],
)
def test_groups_and_masks(a, b, collide):
    world = ap.World(gravity=(0, 0, 0))
    world.add(ap.Sphere(radius=1), **a)
    world.add(ap.Sphere(radius=1), position=(1.5, 0, 0), **b)
    world.step(1 / 60)
    assert (len(world.contacts) == 1) == collide


def test_planes_far_from_their_origin_and_turned():
    """A plane's surface counts, wherever on it its origin lies."""
    turned = (0.5**0.5, 0.5**0.5, 0, 0)  # takes y to z
    world = ap.World(gravity=(0, 0, 0))
    world.add(ap.Plane(normal=(0, 1, 0), offset=2), position=(1e5, -1e5, 1), orientation=turned)
    for z, near in ((3.4, True), (3.6, False), (-50, True)):
        sphere = world.add(ap.Sphere(radius=0.5), position=(0, 0, z))
        for name in BROADPHASES:
            assert found(bounded(world), name) == ([(0, 1)] if near else [])
        world.remove(sphere)
