"""Fat boxes that move with their bodies, on worlds that run: against brute force, at every speed."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import atlasphys as ap
from atlasphys.engine.broadphase import BROADPHASES
from atlasphys.engine.broadphase.fat_boxes import empty_fat_boxes
from atlasphys.engine.broadphase.flight import (
    FOREVER,
    LONGEST_FLIGHT,
    LONGEST_SWEEP,
    keep_meeting,
    longest_flight,
    note_flight,
    time_of_flight,
)
from atlasphys.engine.broadphase.tree import FatTree
from atlasphys.engine.islands.sleep import TIME_TO_SLEEP
from atlasphys.engine.jit import kernel
from atlasphys.engine.shapes.bounds import update_bounds
from atlasphys.engine.state.pose import refresh
from atlasphys.engine.state.work import PAIRS

H = 1 / 60


@kernel
def flight_of(speed, reach, longest, h, fattening):
    return time_of_flight(speed, reach, longest, h, fattening)


def pairs_now(state, broadphase):
    """What a broad phase without memory finds."""
    refresh(state.bodies, 0, state.count)
    shapes = state.table.arrays
    update_bounds(state.bodies, state.colliders, shapes, state.count, state.tolerances.margin)
    pairs, count = BROADPHASES[broadphase](
        state.bodies, state.colliders, shapes, state.count, np.zeros((64, 2), np.int32)
    )
    return {tuple(pair) for pair in pairs[:count].tolist()}


def candidates(world):
    """The pairs that the narrow phase was given in the last step."""
    work = world._state.workspace.work
    return {tuple(pair) for pair in work.pairs[: work.status[PAIRS]].tolist()}


SHAPES = [
    ap.Sphere(radius=0.05),
    ap.Sphere(radius=0.5),
    ap.Box(size=(1, 0.2, 0.5)),
    ap.Capsule(radius=0.2, length=1.5),
    ap.Box(size=(4, 0.02, 0.02)),
    ap.ConvexHull(points=[(0, 0, 0), (2, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)]),
]
SPEEDS = [0, 0.01, 0.3, 3, 30, 300, 1e5]


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1))
def test_every_pair_that_may_touch_is_a_candidate(seed):
    rng = np.random.default_rng(seed)
    sleeping, floor = bool(rng.integers(2)), bool(rng.integers(2))
    gravity = rng.choice([0, 1, 9.81, 100]) * rng.normal(size=3)
    world = ap.World(gravity=gravity, sleeping=sleeping, precision=str(rng.choice(["single", "double"])))
    bodies = []
    for _ in range(30):
        kind, speed = str(rng.choice(["dynamic"] * 7 + ["kinematic", "static"])), rng.choice(SPEEDS)
        bodies.append(
            world.add(
                SHAPES[rng.integers(len(SHAPES))],
                kind=kind,
                position=rng.uniform(-4, 4, 3),
                orientation=rng.normal(size=4),
                velocity=(kind != "static") * speed * rng.normal(size=3),
                angular_velocity=(kind != "static") * rng.choice([0, 1, 100]) * rng.normal(size=3),
                gravity_scale=float(rng.choice([1, 1, 0, -2])),
                linear_damping=float(rng.choice([0, 0, 5])),
                restitution=0.5,
            )
        )
    if floor:
        world.add(ap.Plane(normal=(0, 1, 0), offset=-4))
    state, h, seen = world._state, H, 0
    for _ in range(40):
        if rng.random() < 0.1:
            h = float(rng.choice([1 / 1000, 1 / 240, 1 / 60, 1 / 10]))
        for body in rng.choice(bodies, 2):
            if body.kind == "dynamic" and rng.random() < 0.1:
                body.position = rng.uniform(-4, 4, 3)
            if body.kind != "static" and rng.random() < 0.1:
                body.velocity = rng.choice(SPEEDS) * rng.normal(size=3)
        wanted = pairs_now(state, "brute")
        try:
            world.step(h)
        except ap.DivergenceError:  # hit at 100 km/s, and turned by more than a step can follow
            break
        assert wanted <= candidates(world)
        seen += len(wanted)
    assert seen > 0 or not floor


@pytest.mark.parametrize("speed", [0, -5, 40])
def test_bodies_that_fall_one_behind_the_other_are_no_pairs(speed):
    """And that is seldom looked up."""
    world, looks = ap.World(sleeping=False), 0
    for i, j, k in np.ndindex(4, 12, 4):
        world.add(ap.Box(size=(1, 1, 1)), position=(3 * i, 3 * j, 3 * k), velocity=(0, speed, 0))
    update = FatTree.update
    with pytest.MonkeyPatch.context() as patch:

        def count(self, *arguments):
            nonlocal looks
            looks += 1
            return update(self, *arguments)

        patch.setattr(FatTree, "update", count)
        for _ in range(240):
            world.step(H)
            assert candidates(world) == set()
    assert looks < 240 / 15


def test_a_body_that_meets_a_falling_one_is_found():
    """A fast one from below, one in the way, and one that overtakes."""
    world = ap.World(sleeping=False)
    world.add(ap.Sphere(radius=0.5), position=(0, 60, 0), velocity=(0, -30, 0))
    world.add(ap.Sphere(radius=0.5), position=(0, -60, 0), velocity=(0, 90, 0))
    world.add(ap.Sphere(radius=0.5), position=(50, 0, 0), kind="static")
    world.add(ap.Sphere(radius=0.5), position=(50, 40, 0), velocity=(0, -20, 0))
    world.add(ap.Sphere(radius=0.5), position=(-50, 40, 0), velocity=(0, -10, 0))
    world.add(ap.Sphere(radius=0.5), position=(-50, 60, 0), velocity=(0, -35, 0))
    met = set()
    for _ in range(120):
        world.step(H)
        contacts = world.contacts
        met |= {(int(a), int(b)) for a, b in zip(contacts["body_a"], contacts["body_b"], strict=True)}
    assert met == {(0, 1), (2, 3), (4, 5)}


@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_what_is_left_out_never_meets(real):
    rng = np.random.default_rng(3)
    left_out = 0
    for _ in range(40):
        n = 24
        fat = empty_fat_boxes(n, real)
        fat.center[:] = rng.uniform(-5, 5, (n, 3)) + rng.choice([0, 1e6])
        fat.half[:, :3] = rng.uniform(0, 2, (n, 3))
        moves = rng.random(n) < 0.7
        fat.half[:, 3:6] = rng.normal(size=(n, 3)) * rng.choice([1, 30, 1e4], (n, 1)) * moves[:, None]
        fat.half[:, 6] = np.where(moves, rng.uniform(0, 0.25, n), FOREVER)
        fat.half[0, :3], fat.half[1, :3] = np.inf, np.nan  # a plane, and what is no number
        pairs = np.array([(i, j) for i in range(n) for j in range(i + 1, n)], np.int32)
        kept = pairs.copy()
        for rounding, number in ((0, keep_meeting.py_func(pairs.copy(), fat)), (1, keep_meeting(kept, fat))):
            assert 2 * n - 3 <= number <= len(pairs), rounding
        kept = {tuple(pair) for pair in kept[:number].tolist()}
        half = fat.half.astype(float)
        for i, j in pairs.tolist():
            if (i, j) in kept:
                continue
            left_out += 1
            assert i > 1
            end = min(half[i, 6], half[j, 6], 1.0)
            time = np.append(rng.uniform(0, end, 20), [0, end])[:, None]
            away = abs(fat.center[j] - fat.center[i] + time * (half[j, 3:6] - half[i, 3:6]))
            assert (away > half[i, :3] + half[j, :3]).any(axis=1).all()
    assert left_out > 1000


@settings(max_examples=200)
@given(
    st.floats(0, 1e6),
    st.floats(1e-4, 1e3),
    st.floats(0, 1),
    st.floats(0, 30),
    st.sampled_from([1e-4, 1 / 240, 1 / 60, 0.1, 0.3, 2.0]),
    st.floats(1e-3, 1),
)
def test_how_long_a_box_moves(speed, reach, share, crowd, h, fattening):
    longest = longest_flight(share, crowd, h)
    assert longest == 0 or 8 * h <= longest <= 24 * h or longest == LONGEST_FLIGHT
    time = flight_of(speed, reach, longest, h, fattening)
    if time == 0:
        assert speed * longest <= fattening
    else:
        # It holds for whole steps, which are good until the next one begins; no sleeping body's box moves.
        assert abs(time / h % 1 - 0.25) < 1e-6
        assert time - 0.25 * h <= longest
        assert speed * (time - 0.25 * h) <= LONGEST_SWEEP * reach * (1 + 1e-9)
        assert time < TIME_TO_SLEEP or time == 0.25 * h


def test_boxes_move_if_most_bodies_fly():
    """The longer, the fewer pairs there are."""
    assert [longest_flight(share, 0, H) for share in (0, 0.95, 0.96, 1)] == [0, 0, LONGEST_FLIGHT, LONGEST_FLIGHT]
    times = [longest_flight(1, crowd, H) for crowd in range(9)]
    assert times == sorted(times, reverse=True)
    assert times[1] == 12 * H
    assert times[8] == 8 * H


def test_what_touches_or_is_joined_does_not_fly():
    world = ap.World()
    world.add(ap.Plane(normal=(0, 1, 0)))
    for height in (0.5, 3, 6, 9, 12):
        world.add(ap.Sphere(radius=0.5), position=(0, height, 0))
    world.step(H)
    state, flying = world._state, np.full(6, 7, np.uint8)
    last, rows = state.manifolds, state.manifold_count
    joined = np.array([(2, 3), (-1, 5)], np.int32)
    note_flight(last.a[:rows], last.b[:rows], last.count[:rows], state.colliders.body, joined, flying)
    assert flying.tolist() == [0, 0, 0, 0, 1, 0]
