"""Islands that fall asleep and wake, against a search through the graph of contacts."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from atlasphys.engine.islands.sleep import TIME_TO_SLEEP, list_active, list_awake, note_rest, put_to_sleep, wake_touched
from atlasphys.engine.jit import kernel
from atlasphys.engine.state.bodies import AWAKE, CHANGED, DYNAMIC, KINEMATIC, STATIC


@kernel
def sleep(pairs, live, number, body, linked, kind, island, rest, motion, active, count, parent, ready):
    return put_to_sleep(pairs, live, number, body, linked, kind, island, rest, motion, active, count, parent, ready)


@kernel
def wake(pairs, live, number, body, linked, kind, island, rest, active, count, marked, island_before, rest_before):
    return wake_touched(
        pairs, live, number, body, linked, kind, island, rest, active, count, marked, island_before, rest_before
    )  # fmt: skip


@kernel
def activity(kind, island, rest, motion, count, active):
    list_active(kind, island, rest, motion, count, active)


@kernel
def awake_lists(kind, island, frame, count, plain, tumbling):
    return list_awake(kind, island, frame, count, plain, tumbling)


@kernel
def rest_for(rows, blocks, kind, motion, response, radius, slow, h, rest):
    note_rest(rows, blocks, kind, motion, response, radius, slow, h, rest)


def islands_of(kind, pairs):
    """Sets of dynamic rows connected by contacts, by a search from each."""
    neighbours = {i: set() for i in np.flatnonzero(kind == DYNAMIC)}
    for a, b in pairs:
        if a in neighbours and b in neighbours:
            neighbours[a].add(b)
            neighbours[b].add(a)
    found, left = [], set(neighbours)
    while left:
        island, border = set(), {min(left)}
        while border:
            island |= border
            border = {j for i in border for j in neighbours[i]} - island
        found.append(island)
        left -= island
    return found


@st.composite
def worlds(draw):
    """Kinds, pairs in contact, velocities and times at rest."""
    count = draw(st.integers(1, 14))
    kind = np.array(
        draw(st.lists(st.sampled_from([DYNAMIC] * 4 + [STATIC, KINEMATIC]), min_size=count, max_size=count))
    )
    row = st.integers(0, count - 1)
    pairs = draw(st.lists(st.tuples(row, row).filter(lambda p: p[0] < p[1]), unique=True, max_size=25))
    pairs = [(a, b) for a, b in pairs if DYNAMIC in (kind[a], kind[b])]
    rest = np.array(draw(st.lists(st.sampled_from([0.0, 0.4, TIME_TO_SLEEP, 3.0]), min_size=count, max_size=count)))
    motion = np.zeros((count, 16))
    motion[:, draw(st.integers(0, 5))] = draw(st.lists(st.sampled_from([0, 0, 1]), min_size=count, max_size=count))
    motion[kind == STATIC] = 0
    return kind.astype(np.int8), pairs, rest, motion


def columns(pairs, count):
    pairs = np.array(pairs, np.int32).reshape(-1, 2)
    number = len(pairs)
    return pairs, np.arange(number, dtype=np.int32), number, np.arange(count, dtype=np.int32)


def contacts_and_joints(pairs, count):
    """Every other pair as a contact, the rest as joints, as the kernels take them."""
    return *columns(pairs[::2], count), np.array(pairs[1::2], np.int32).reshape(-1, 2)


@settings(max_examples=150)
@given(worlds())
def test_islands_sleep_and_wake_as_a_whole(world):
    kind, pairs, rest, motion = world
    count = len(kind)
    island, active = np.full(count, AWAKE, np.int32), np.zeros(count, np.uint8)
    activity(kind, island, rest, motion, count, active)
    moving = motion[:, :6].any(axis=1)
    np.testing.assert_array_equal(active, (kind == DYNAMIC) | ((kind == KINEMATIC) & moving))
    driven = {i for i in range(count) if kind[i] == KINEMATIC and moving[i]}

    parent, ready = np.zeros(count, np.int32), np.zeros(count, np.uint8)
    contacts = contacts_and_joints(pairs, count)
    slept = sleep(*contacts, kind, island, rest, motion, active, count, parent, ready)
    expected = np.full(count, AWAKE)
    for members in islands_of(kind, pairs):
        carried = any(set(pair) & members and set(pair) & driven for pair in pairs)
        if all(rest[i] >= TIME_TO_SLEEP for i in members) and not carried:
            expected[list(members)] = min(members)
    np.testing.assert_array_equal(island, expected)
    assert slept == (expected != AWAKE).sum()
    assert not motion[expected != AWAKE, :6].any()
    assert not active[expected != AWAKE].any()
    assert not ready.any()

    # Something comes to touch some of them: each island that has a contact with what is active wakes, and no other.
    before, touched = island.copy(), rest.copy()
    was, rested = np.full(count, -7, np.int32), np.full(count, -7.0)
    pairs = pairs + [(0, count - 1)] if count > 1 else pairs
    more = contacts_and_joints(pairs, count)
    woken = {
        int(before[i])
        for i, j in [*pairs, *((j, i) for i, j in pairs)]
        if kind[i] == DYNAMIC and before[i] != AWAKE and active[j]
    }
    number = wake(*more, kind, island, rest, active, count, ready, was, rested)
    waking = np.isin(before, list(woken)) & (before != AWAKE)
    np.testing.assert_array_equal(island, np.where(waking, AWAKE, before))
    assert number == waking.sum()
    assert active[waking].all()
    assert not rest[waking].any()
    np.testing.assert_array_equal(was[waking], before[waking])
    np.testing.assert_array_equal(rested[waking], touched[waking])
    assert not ready.any()


def test_what_was_changed_by_hand_is_active():
    kind = np.array([STATIC, STATIC, KINEMATIC, KINEMATIC], np.int8)
    rest, motion, active = np.array([0, CHANGED, CHANGED, 0]), np.zeros((4, 16)), np.zeros(4, np.uint8)
    activity(kind, np.full(4, AWAKE, np.int32), rest, motion, 4, active)
    assert active.tolist() == [0, 1, 1, 0]


@settings(max_examples=60)
@given(st.lists(st.tuples(st.sampled_from([STATIC, KINEMATIC, DYNAMIC]), st.booleans(), st.booleans()), max_size=40))
def test_bodies_to_be_moved_are_listed_in_blocks(bodies):
    kind = np.array([kind for kind, _, _ in bodies], np.int8)
    island = np.array([0 if sleeps else AWAKE for _, sleeps, _ in bodies], np.int32)
    frame = np.zeros((len(bodies), 8))
    frame[:, 3] = [tumbles for _, _, tumbles in bodies]
    lists = [np.full((6, 8), -1, np.int32) for _ in range(2)]
    blocks = awake_lists(kind, island, frame, len(bodies), *lists)
    for tumbles, rows, number in zip((False, True), lists, blocks, strict=True):
        wanted = [
            i for i, (k, s, t) in enumerate(bodies) if t == tumbles and (k == KINEMATIC or (k == DYNAMIC and not s))
        ]
        assert number == -(-len(wanted) // 8)
        assert rows[:number].ravel().tolist() == wanted + wanted[-1:] * (8 * number - len(wanted))


def test_rest_counts_speed_and_spin_at_the_rim():
    count = 9
    kind = np.array([DYNAMIC] * 8 + [KINEMATIC], np.int8)
    motion, response = np.zeros((count, 16)), np.zeros((count, 4))
    motion[1, 0], motion[2, 2] = 0.049, 0.051
    motion[3, 4], motion[4, 4] = 0.09, 0.11  # at a radius of 0.5 m
    motion[5, 1], motion[5, 5] = 0.04, 0.08
    response[6, 3] = 1  # never sleeps
    rest, radius = np.full(count, 0.3), np.full(count, 0.5)
    rows = np.array([[*range(8)], [8] * 8], np.int32)
    rest_for(rows, 2, kind, motion, response, radius, 0.05, 0.1, rest)
    assert rest == pytest.approx([0.4, 0.4, 0, 0.4, 0, 0, 0, 0.4, 0.3])
