"""The tree broad phase: its boxes, its order, and the pairs that it keeps from step to step, against brute force."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import atlasphys as ap
from atlasphys.engine.broadphase import BROADPHASES
from atlasphys.engine.broadphase.bvh import HILBERT, Tree, overlapping, refit, store_interval
from atlasphys.engine.broadphase.fat_boxes import has_left, near, room_left
from atlasphys.engine.broadphase.pair_list import merge_pairs, sort_pairs
from atlasphys.engine.broadphase.tree import FatTree, in_blocks
from atlasphys.engine.jit import kernel
from atlasphys.engine.shapes.bounds import update_bounds
from atlasphys.engine.simd import LANES
from atlasphys.engine.state.pose import refresh
from tests.engine.simd.values import awkward, bits

FATTENING, MARGIN, H = 0.1, 0.02, 1 / 60

SHAPES = [
    ap.Sphere(radius=0.5),
    ap.Capsule(radius=0.2, length=0.8),
    ap.Box(size=(1, 2, 0.5)),
    ap.Box(size=(4, 0.01, 0.01)),
    ap.Cylinder(radius=0.4, length=0.6),
    ap.Cone(radius=0.5, height=1),
    ap.ConvexHull(points=[(0, 0, 0), (2, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)]),
    ap.Sphere(radius=1e-4),
]


@kernel
def any_left(rows, center, geometry, fat, margin, offset, room):
    return has_left(0, len(rows), rows, center, geometry, fat, margin, offset, room)


@kernel
def hits(block, nodes, box):
    return overlapping(block, nodes, box[0], box[1], box[2], box[3], box[4], box[5])


@kernel
def rooms(block, rows, geometry, bound, half, offset, clock, margin, room, reach):
    return room_left(block, rows, geometry, bound, half, offset, clock, margin, room, reach)


@kernel
def near_pairs(pairs, reach, gap):
    return near(pairs, reach, gap)


@kernel
def intervals(values, boxes):
    for row in range(len(values)):
        store_interval(boxes, row, 0, values[row, 0], values[row, 1])


def random_world(count, rng, precision="single", spread=4.0, offset=(0, 0, 0)):
    """Bodies of all shapes and kinds, planes among them."""
    world = ap.World(precision=precision, gravity=(0, 0, 0))
    for number in range(count):
        if number % 40 == 20:
            world.add(ap.Plane(normal=rng.normal(size=3), offset=-0.5 * spread), position=offset)
            continue
        world.add(
            SHAPES[rng.integers(len(SHAPES))],
            position=rng.uniform(-spread, spread, 3) + offset,
            orientation=rng.normal(size=4),
            kind=rng.choice(["dynamic"] * 6 + ["static"] * 3 + ["kinematic"]),
            group=int(rng.choice([1, 1, 1, 2, 3])),
            mask=int(rng.choice([~0, ~0, ~0, 1, 2])),
        )
    return world._state


def derive(state):
    refresh(state.bodies, 0, state.count)
    update_bounds(state.bodies, state.colliders, state.table.arrays, state.count, MARGIN)


def brute(state):
    derive(state)
    pairs = np.zeros((64, 2), np.int32)
    pairs, count = BROADPHASES["brute"](state.bodies, state.colliders, state.table.arrays, state.count, pairs)
    return {tuple(pair) for pair in pairs[:count].tolist()}


def update(tree, state):
    derive(state)
    n = state.count
    flying = (np.arange(n) % 50 > 0).astype(np.uint8)
    return tree.update(state.bodies, state.colliders, state.table.arrays, n, H, MARGIN, flying, (0.0, -9.81, 0.0))


def left(tree, state):
    bodies, fat = state.bodies, tree.fat
    real = fat.half.dtype
    offset, room = np.zeros((6, LANES), real), np.zeros((len(tree.rows), LANES), real)
    return any_left(tree.rows, bodies.center, bodies.geometry, fat, MARGIN, offset, room)


def move(tree, state, rng, h=H):
    """Free motion of what may move, with a push now and then."""
    tree.fat.clock[0] += h
    n, bodies = state.count, state.bodies
    free = bodies.kind[:n] != 0
    pushed = free & (rng.random(n) < 0.02)
    bodies.motion[:n][pushed, :6] = rng.normal(size=(pushed.sum(), 6)) * rng.choice([0.1, 3, 30])
    bodies.position[:n][free] += h * bodies.motion[:n][free, :3]
    half = 0.5 * h * bodies.motion[:n, 3:6]
    q = bodies.orientation[:n].astype(float)
    w, v = q[:, :1], q[:, 1:]
    turned = np.concatenate([w - (half * v).sum(1, keepdims=True), v + w * half + np.cross(half, v)], axis=1)
    turned /= np.linalg.norm(turned, axis=1, keepdims=True)
    bodies.orientation[:n][free] = turned[free]


def check(tree, state):
    """The pairs are in order, once each, and all that brute force finds is among them."""
    pairs = [tuple(pair) for pair in tree.pairs.tolist()]
    assert pairs == sorted(set(pairs))
    assert all(a < b for a, b in pairs)
    assert brute(state) <= set(pairs)


def meet(fat, i, j):
    """Whether two fat boxes are not parted by the same side of one of them at both ends of the time for which they are good."""
    half, rounding = fat.half.astype(float), 1 + 2**-20
    time, sizes = min(half[i, 6], half[j, 6]) - fat.clock[0], (half[i, :3] + half[j, :3]) * rounding
    now = fat.center[j] - fat.center[i] + (half[j, 3:6] - half[i, 3:6]) * fat.clock[0]
    then = now + (half[j, 3:6] - half[i, 3:6]) * time
    return not (((now > sizes) & (then > sizes)) | ((now < -sizes) & (then < -sizes))).any()


def fat_pairs(tree, state):
    """What the list must be: the pairs of fat boxes that may meet or reach a plane, and may collide."""
    n, c, kind = state.count, state.colliders, state.bodies.kind
    boxes, is_plane = tree.fat.boxes.astype(float), np.isin(np.arange(state.count), tree.parts.planes)
    shapes, result = state.table.arrays, set()
    for i, j in itertools.combinations(range(n), 2):
        if kind[i] != 2 and kind[j] != 2:
            continue
        if not (int(c.mask[i]) & int(c.group[j]) and int(c.mask[j]) & int(c.group[i])):
            continue
        if is_plane[i] or is_plane[j]:
            plane, k = (i, j) if is_plane[i] else (j, i)
            size = shapes.size[c.shape[plane]]
            normal = (state.bodies.geometry[plane, :9].reshape(3, 3) @ size[:3]).astype(float)
            corner = np.where(normal > 0, boxes[k, :3], boxes[k, 3:6]) - state.bodies.position[plane]
            near = normal @ corner <= size[3] + 1e-6
        else:
            near = (
                (boxes[i, :3] <= boxes[j, 3:6]).all() and (boxes[j, :3] <= boxes[i, 3:6]).all() and meet(tree.fat, i, j)
            )
        if near:
            result.add((i, j))
    return result


@pytest.mark.parametrize("precision", ["single", "double"])
@pytest.mark.parametrize("offset", [(0, 0, 0), (1e6, -2e6, 3e5)])
def test_pairs_hold_until_a_body_leaves_its_box(precision, offset):
    rng = np.random.default_rng(5)
    state = random_world(90, rng, precision, offset=offset)
    tree = FatTree(state.real, FATTENING)
    assert update(tree, state)
    updates = partial = 0
    for _ in range(150):
        move(tree, state, rng)
        derive(state)
        before = tree.pairs.tolist()
        if left(tree, state):
            assert update(tree, state)
            assert not left(tree, state)
            updates += 1
            partial += tree._refitted > 0
        else:
            assert not update(tree, state)
            assert tree.pairs.tolist() == before
        check(tree, state)
    assert {tuple(pair) for pair in tree.pairs.tolist()} >= fat_pairs(tree, state)
    assert 20 < updates < 149
    assert partial > 10


def test_found_all_anew_the_pairs_are_those_that_may_meet_from_now_on():
    """Found in part, some are left that might have met before."""
    rng = np.random.default_rng(6)
    state = random_world(200, rng, spread=5)
    tree = FatTree(state.real, FATTENING)
    update(tree, state)
    parts = left_over = total = 0
    for _ in range(20):
        move(tree, state, rng)
        update(tree, state)
        parts += tree._refitted > 0
        pairs = {tuple(pair) for pair in tree.pairs.tolist()}
        tree._find_all(static=True)
        found = {tuple(pair) for pair in tree.pairs.tolist()}
        assert found == fat_pairs(tree, state)
        assert found <= pairs
        check(tree, state)
        left_over += len(pairs - found)
        total += len(pairs)
    assert parts > 5
    assert left_over < 0.05 * total


def test_static_bodies_and_planes_that_were_moved():
    world = ap.World()
    plane = world.add(ap.Plane(normal=(0, 1, 0)))
    wall = world.add(ap.Box(size=(1, 1, 1)), position=(10, 5, 0), kind="static")
    ball = world.add(ap.Sphere(radius=0.5), position=(0, 5, 0))
    state = world._state
    tree = FatTree(state.real, FATTENING)
    assert update(tree, state)
    assert tree.pairs.tolist() == []
    assert not update(tree, state)
    state.bodies.position[1] = (1, 5, 0)
    assert update(tree, state)
    assert tree.pairs.tolist() == [[1, 2]]
    state.bodies.position[0] = (0, 4.5, 0)
    assert update(tree, state)
    assert tree.pairs.tolist() == [[0, 2], [1, 2]]
    assert not update(tree, state)
    assert len({plane, wall, ball}) == 3


def test_bodies_added_and_removed():
    world = ap.World()
    rng = np.random.default_rng(2)
    bodies, tree = [], FatTree(world._state.real, FATTENING)
    for step in range(40):
        if bodies and rng.random() < 0.4:
            world.remove(bodies.pop(rng.integers(len(bodies))))
        else:
            kind = "static" if step % 5 == 0 else "dynamic"
            bodies.append(world.add(SHAPES[step % len(SHAPES)], position=rng.uniform(-2, 2, 3), kind=kind))
        tree.invalidate()
        assert update(tree, world._state)
        check(tree, world._state)
        assert {tuple(pair) for pair in tree.pairs.tolist()} == fat_pairs(tree, world._state)
    for body in bodies:
        world.remove(body)
    tree.invalidate()
    assert update(tree, world._state)
    assert len(tree.pairs) == 0
    assert not left(tree, world._state)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e300])
def test_positions_that_are_no_numbers_do_no_harm(bad):
    """The step raises later; until then nothing crashes, hangs or grows, and the others' pairs stay right."""
    rng = np.random.default_rng(1)
    state = random_world(50, rng)
    tree = FatTree(state.real, FATTENING)
    update(tree, state)
    moving = tree.parts.moving
    state.bodies.position[moving[3]] = bad
    state.bodies.position[moving[5], 1] = bad
    lost = {moving[3], moving[5]}
    for first in (True, False, False):
        finite = bad == 1e300
        assert update(tree, state) == (first or not finite)  # what is no number is always outside
        assert left(tree, state) != finite
        wanted = {pair for pair in brute(state) if not lost & set(pair)}
        assert wanted <= {tuple(pair) for pair in tree.pairs.tolist()}
    state.bodies.position[: state.count] = bad
    update(tree, state)
    if bad != 1e300:
        assert len(tree.pairs) == 0
    derive(state)
    BROADPHASES["tree"](state.bodies, state.colliders, state.table.arrays, state.count, np.zeros((1, 2), np.int32))


def test_one_body_far_away_changes_nothing():
    """Its box is coarse and its cell the lattice's last; the blocks of the others stay as compact as they were."""
    rng = np.random.default_rng(0)
    boxes = np.zeros((1001, 8), np.float32)
    boxes[:, :3] = rng.uniform(0, 10, (1001, 3))
    boxes[:, 3:6] = boxes[:, :3] + 1
    boxes[1000, :3], boxes[1000, 3:6] = np.inf, -np.inf
    volumes = []
    for far in (5.0, 1e5, 1e30):
        boxes[0, :3], boxes[0, 3:6] = far, far * 1.01
        tree = Tree()
        tree.build(boxes, np.arange(1000, dtype=np.int32))
        assert sorted(tree.leaf_rows.ravel()) == list(range(1000))
        leaves = tree.nodes[: tree.first[1]].astype(float)
        sizes = (leaves[:, 3:].max(axis=2) - leaves[:, :3].min(axis=2)).prod(axis=1)
        volumes.append(np.sort(sizes)[:-1].mean())  # all but the block that holds it
    assert max(volumes) < 1.1 * min(volumes)


def test_nodes_hold_their_children():
    rng = np.random.default_rng(3)
    boxes = np.zeros((700, 8), np.float32)
    boxes[:, :3] = rng.normal(size=(700, 3))
    boxes[:, 3:6] = boxes[:, :3] + rng.random((700, 3))
    boxes[-1, :3], boxes[-1, 3:6] = np.inf, -np.inf
    tree = Tree()
    tree.build(boxes, np.arange(699, dtype=np.int32))
    assert np.diff(tree.first).tolist() == [88, 11, 2, 1]
    again = np.zeros_like(tree.nodes)
    refit.py_func(boxes, tree.leaf_rows, tree.first, again)
    np.testing.assert_array_equal(tree.nodes, again)
    for level in range(1, 4):
        below = tree.nodes[tree.first[level - 1] : tree.first[level]]
        for child, block in enumerate(below):
            box = tree.nodes[tree.first[level] + child // 8, :, child % 8]
            np.testing.assert_array_equal(box, [*block[:3].min(axis=1), *block[3:].max(axis=1)])


def test_the_curve_visits_every_cell_and_walks_from_neighbour_to_neighbour():
    levels = 4
    cells = np.array(list(itertools.product(range(2**levels), repeat=3)))
    place, state = np.zeros(len(cells), int), np.zeros(len(cells), int)
    for level in range(levels - 1, -1, -1):
        entry = HILBERT[state, (cells >> level & 1) @ [1, 2, 4]]
        place, state = place << 3 | entry & 7, entry >> 3
    assert sorted(place) == list(range(8**levels))
    assert (abs(np.diff(cells[np.argsort(place)], axis=0)).sum(axis=1) == 1).all()


def test_intervals_are_rounded_outwards():
    rng = np.random.default_rng(4)
    lower = np.concatenate([rng.normal(size=300) * 10.0 ** rng.integers(-320, 300, 300), [0, -0.0, 1e6, 1 / 3, -1e39]])
    upper = lower + abs(lower) * rng.choice([0, 1e-12, 0.1, 2], len(lower))
    values = np.stack([lower, upper], axis=1)
    boxes = np.zeros((len(values), 8), np.float32)
    intervals(values, boxes)
    low, high = boxes[:, 0].astype(float), boxes[:, 3].astype(float)
    assert np.isfinite(boxes).all()
    inside = abs(values).max(axis=1) < 3e38
    assert (low <= lower)[inside].all()
    assert (high >= upper)[inside].all()
    assert (low >= lower - 3e-7 * abs(lower) - 3e-37)[inside].all()
    assert (high <= upper + 3e-7 * abs(upper) + 3e-37)[inside].all()
    # Cut off, they still overlap whatever they overlapped.
    assert (low <= np.maximum(lower, 3e38)).all()
    for bad in [(np.nan, 1), (1, np.nan), (np.inf, np.inf), (-np.inf, np.inf)]:
        intervals(np.array([bad], float), boxes)
        assert boxes[0, 0] == np.inf
        assert boxes[0, 3] == -np.inf


@settings(max_examples=60)
@given(st.lists(st.tuples(st.integers(0, 12), st.integers(0, 12)), max_size=80), st.sets(st.integers(0, 12)))
def test_pair_lists(pairs, changed_rows):
    rng = np.random.default_rng(len(pairs))
    wanted = sorted({(min(p), max(p)) for p in pairs if p[0] != p[1]})
    shuffled = np.array(wanted, np.int32).reshape(-1, 2)[rng.permutation(len(wanted))]
    places, result = np.full((2, 13), 99, np.int64), np.zeros((len(wanted), 2), np.int32)
    sort_pairs(shuffled, places[0], places[1], np.zeros(len(wanted), np.int32), result)
    assert [tuple(pair) for pair in result.tolist()] == wanted

    changed = np.isin(np.arange(13), list(changed_rows)).astype(np.uint8)
    kept = [pair for pair in wanted if not changed_rows & set(pair)]
    fresh = [pair for pair in itertools.combinations(range(13), 2) if changed_rows & set(pair)][::3]
    merged = np.zeros((len(wanted) + len(fresh), 2), np.int32)
    count = merge_pairs(result, np.array(fresh, np.int32).reshape(-1, 2), changed, merged)
    assert [tuple(pair) for pair in merged[:count].tolist()] == sorted(kept + fresh)


def test_box_tests_equal_their_numpy_reading():
    for seed in range(40):
        nodes = awkward(np.float32, 6, seed)[None]
        box = awkward(np.float32, 6, seed + 1000)[:, 0].copy()
        answer = hits(0, nodes, box)
        assert answer == hits.py_func(0, nodes, box)
        low, high = nodes[0, :3], nodes[0, 3:]
        mask = (low <= box[3:, None]).all(axis=0) & (high >= box[:3, None]).all(axis=0)
        assert answer == sum(1 << k for k in range(8) if mask[k])


@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_room_left_equals_its_numpy_reading(real):
    for seed in range(30):
        rows = np.random.default_rng(seed).integers(0, 20, (1, 8)).astype(np.int32)
        geometry = awkward(real, 40, seed).reshape(20, 16)
        bound, half, offset = awkward(real, 20, seed + 1), abs(awkward(real, 20, seed + 2)), awkward(real, 6, seed + 3)
        if seed % 2:  # numbers of which some bodies are inside
            geometry, bound = np.nan_to_num(geometry).clip(-1, 1), np.nan_to_num(bound).clip(-1, 1)
            half, offset = np.nan_to_num(half).clip(-1, 1) + 6, np.nan_to_num(offset).clip(-1, 1)
            half[:, 6] = np.arange(20) / 32
        rooms_of, reaches = ([np.zeros((number, 8), real) for _ in range(2)] for number in (1, 20))
        answers = [
            function(0, rows, geometry, bound, half, offset, real(0.125), 0.02, room, reach)
            for function, room, reach in zip((rooms, rooms.py_func), rooms_of, reaches, strict=True)
        ]
        np.testing.assert_array_equal(*map(bits, rooms_of))
        np.testing.assert_array_equal(*map(bits, reaches))
        assert answers[0] == answers[1] == bool((rooms_of[0] < 0).any())


@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_room_left_is_what_lies_between_body_and_box(real):
    rng = np.random.default_rng(9)
    state = random_world(60, rng, "single" if real == np.float32 else "double")
    tree = FatTree(state.real, FATTENING)
    update(tree, state)
    state.bodies.position[: state.count] += rng.normal(size=(state.count, 3)) * 0.05
    derive(state)
    for block, rows in enumerate(in_blocks(tree.parts.moving)):
        room, reach = np.zeros((len(tree.rows), 8), real), tree.fat.reach
        center = state.bodies.center[rows]
        offset = np.ascontiguousarray(np.concatenate([center - tree.fat.center[rows], center], axis=1).T, real)
        answer = rooms(
            block, tree.rows, state.bodies.geometry, tree.fat.bound, tree.fat.half, offset, real(0), MARGIN, room, reach
        )
        assert answer == (room[block] < 0).any()
        for lane, row in enumerate(rows):
            middle, half = tree.fat.center[row], tree.fat.half[row, :3].astype(float)
            sides = state.colliders.lower[row] - (middle - half), middle + half - state.colliders.upper[row]
            # The shape's own box, turned, holds the shape's bounds; for boxes, spheres and capsules it is them.
            exact = state.table.arrays.layout[state.colliders.shape[row], 0] <= 2
            assert room[block, lane] <= np.min(sides) + 1e-6
            if exact:
                np.testing.assert_allclose(room[block, lane], np.min(sides), atol=1e-5)
                np.testing.assert_allclose(reach[row, :3], state.colliders.lower[row], atol=1e-5)
                np.testing.assert_allclose(reach[row, 3:6], state.colliders.upper[row], atol=1e-5)
            assert (reach[row, :3] <= state.colliders.lower[row]).all()
            assert (reach[row, 3:6] >= state.colliders.upper[row]).all()


@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_tight_boxes_that_touch(real):
    rng = np.random.default_rng(3)
    seen = set()
    for _ in range(60):
        reach = np.zeros((12, 8), real)
        reach[:, :3] = rng.integers(-3, 3, (12, 3))
        reach[:, 3:6] = reach[:, :3] + rng.integers(0, 4, (12, 3))  # touching counts
        reach[11] = (-np.inf,) * 3 + (np.inf,) * 3 + (0, 0)  # a plane
        pairs = rng.integers(0, 12, (2, 8)).astype(np.int32)
        a, b = reach[pairs]
        touch = ((a[:, :3] <= b[:, 3:6]) & (b[:, :3] <= a[:, 3:6])).all(axis=1)
        gap, read = np.zeros((2, 1, 8), reach.dtype)
        answer = near_pairs(pairs, reach, gap)
        assert answer == near_pairs.py_func(pairs, reach, read) == sum(1 << k for k in range(8) if touch[k])
        np.testing.assert_array_equal(gap, read)
        seen |= set(touch.tolist())
    assert seen == {True, False}


def test_fast_and_spinning_bodies_keep_their_boxes_for_some_steps():
    world = ap.World(gravity=(0, 0, 0))
    world.add(ap.Box(size=(1, 2, 0.2)), velocity=(30, -20, 0), angular_velocity=(0, 3, 8))
    world.add(ap.Cone(radius=0.5, height=2), position=(9, 9, 9), velocity=(0, 20, 0), angular_velocity=(9, 0, 0))
    state = world._state
    tree = FatTree(state.real, FATTENING)
    update(tree, state)
    for _ in range(7):
        world.step(H)
        tree.fat.clock[0] += H
        derive(state)
        assert not left(tree, state)
    for _ in range(20):
        world.step(H)
        tree.fat.clock[0] += H
    derive(state)
    assert left(tree, state)


def test_bodies_of_every_size_rest_in_their_boxes():
    """Also where single precision cannot tell the box from the body's size."""
    world = ap.World()
    for exponent in range(-4, 6):
        world.add(ap.Box(size=(10.0**exponent,) * 3), position=(10.0**exponent, -(10.0 ** min(2 * exponent, 9)), 0.3))
    state = world._state
    tree = FatTree(state.real, FATTENING)
    update(tree, state)
    assert not left(tree, state)
    assert not update(tree, state)
