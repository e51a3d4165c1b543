"""Colours of contacts against a plain check, and their layout in blocks of eight."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from atlasphys.engine.islands.colour import COLOURS, block_ranges, colour_contacts, fill_blocks, weight_first
from atlasphys.engine.islands.split import MOST_CONTACTS
from atlasphys.engine.jit import kernel
from atlasphys.engine.simd import LANES
from atlasphys.engine.state.blocks import BODY_A, BODY_B, COUNT, INTEGERS, MANIFOLD, MOVES_A, MOVES_B
from atlasphys.engine.state.manifolds import NORMAL
from tests.engine.islands.blocks import in_blocks


@kernel
def colour(ends, row, count, live, number, moves, used, colours, sizes, starts):
    colour_contacts(ends, row, count, live, number, moves, used, colours, sizes)
    return block_ranges(sizes, starts)


@kernel
def fill(ends, row, count, live, number, moves, colours, starts, cursor, integers_one, integers_many):
    fill_blocks(ends, row, count, live, number, moves, colours, starts, cursor, integers_one, integers_many)


@kernel
def put_first(contact, row, gravity, live, number, scratch):
    weight_first(contact, row, gravity, live, number, scratch)


def rows_for(pairs):
    """A row of manifolds for each of so many pairs, in no order."""
    return np.random.default_rng(pairs).permutation(pairs + 3)[:pairs].astype(np.int32)


@given(st.lists(st.floats(-1, 1), max_size=30), st.sampled_from([(0.0, -9.81, 0.0), (0.0, 0.0, 0.0), (3.0, 0.0, 4.0)]))
def test_contacts_that_carry_weight_come_first(heights, gravity):
    normals = np.array([(np.sqrt(1 - y * y), y, 0.0) for y in heights]).reshape(-1, 3)
    contact, row = np.zeros((len(heights) + 3, 16)), rows_for(len(heights))
    contact[row, NORMAL : NORMAL + 3] = normals
    live = np.arange(len(heights), dtype=np.int32)[::-1].copy()
    along = [(normals[i] @ gravity) ** 2 >= 0.5 * np.dot(gravity, gravity) for i in live]
    wanted = [i for i, first in zip(live, along, strict=True) if first]
    wanted += [i for i, first in zip(live, along, strict=True) if not first]
    put_first(contact, row, gravity, live, len(live), np.empty(len(live), np.int32))
    assert live.tolist() == wanted


def coloured(pairs, points, moves, live, hubs):
    """Colours, sizes, first blocks and the integers of the blocks of both classes."""
    pairs = np.array(pairs, np.int32).reshape(-1, 2)
    ends = in_blocks(pairs)
    points, moves, live = np.array(points, np.int32), np.array(moves, np.uint8), np.array(live, np.int32)
    colours, used = np.full(len(pairs), -1, np.int8), np.zeros(len(moves), np.uint64)
    used[list(hubs)] = ~np.uint64(0)
    sizes, starts = np.zeros((2, COLOURS + 1), np.int64), np.zeros((2, COLOURS + 2), np.int64)
    row, count = rows_for(len(pairs)), np.zeros(len(pairs) + 3, np.int32)
    count[row] = points
    number = colour(ends, row, count, live, len(live), moves, used, colours, sizes, starts)
    assert number == max((colours[i] + 1 for i in live), default=0)
    blocks = [np.full((starts[k, COLOURS + 1] + 1, INTEGERS, LANES), 7, np.int32) for k in range(2)]
    cursor = np.zeros((2, COLOURS + 1), np.int64)
    fill(ends, row, count, live, len(live), moves, colours, starts, cursor, *blocks)
    return colours, sizes, starts, blocks


def check(pairs, points, moves, live, hubs=()):
    colours, sizes, starts, blocks = coloured(pairs, points, moves, live, hubs)
    assert sizes.sum() == len(live)
    for c in range(COLOURS):
        of_colour = [i for i in live if colours[i] == c]
        moved = [row for i in of_colour for row in pairs[i] if moves[row]]
        assert len(moved) == len(set(moved)), "two contacts of one colour share a body"
        if c:  # no lower colour was free
            for i in of_colour:
                for lower in range(c):
                    shared = {row for j in live if colours[j] == lower and j < i for row in pairs[j] if moves[row]}
                    assert shared & {row for row in pairs[i] if moves[row]}
    placed = []
    for k in range(2):
        for block in range(starts[k, COLOURS + 1]):
            mine = blocks[k][block]
            filled = mine[COUNT] > 0
            c = int(np.searchsorted(starts[k], block, side="right")) - 1
            assert filled.any()
            assert (np.diff(filled.astype(int)) <= 0).all()  # from the first lane on
            if c == COLOURS:
                assert filled.sum() == 1
            for lane in np.flatnonzero(filled):
                i = rows_for(len(pairs)).tolist().index(mine[MANIFOLD, lane])
                placed.append(i)
                assert colours[i] == c
                assert (points[i] > 1) == bool(k)
                assert mine[COUNT, lane] == points[i]
                assert (mine[BODY_A, lane], mine[BODY_B, lane]) == tuple(pairs[i])
                assert (mine[MOVES_A, lane], mine[MOVES_B, lane]) == (moves[pairs[i][0]], moves[pairs[i][1]])
            moved = [
                row for row, m in ((BODY_A, MOVES_A), (BODY_B, MOVES_B)) for row in mine[row][filled & (mine[m] > 0)]
            ]
            assert len(moved) == len(set(moved))
        assert (blocks[k][starts[k, COLOURS + 1] :] == 7).all()  # nothing is written past the end
    assert sorted(placed) == sorted(live)
    return colours


@settings(max_examples=80)
@given(st.data())
def test_random_contacts(data):
    bodies = data.draw(st.integers(2, 12))
    moves = data.draw(st.lists(st.integers(0, 1), min_size=bodies, max_size=bodies))
    row = st.integers(0, bodies - 1)
    pairs = data.draw(st.lists(st.tuples(row, row).filter(lambda p: p[0] < p[1]), unique=True, max_size=40))
    points = data.draw(st.lists(st.integers(1, 4), min_size=len(pairs), max_size=len(pairs)))
    live = [i for i in range(len(pairs)) if data.draw(st.booleans())]
    check(pairs, points, moves, live)


def test_no_contacts():
    check([], [], [1, 1], [])


def test_one_plate_under_five_hundred_bodies():
    """One that is not split takes all colours, and the rest overflows one by one."""
    colours = check([(0, i) for i in range(1, 501)], [4] * 500, [1] * 501, range(500))
    assert sorted(colours) == [*range(COLOURS), *[COLOURS] * (500 - COLOURS)]


def test_a_static_plate_under_five_hundred_bodies_takes_one_colour():
    """So does a kinematic one: what impulses do not move never conflicts."""
    assert set(check([(0, i) for i in range(1, 501)], [4] * 500, [0] + [1] * 500, range(500))) == {0}


def test_hubs_take_the_last_colour():
    """Row 0 is a body that has been split, with whole contacts to some; rows 1 and 2 are its parts."""
    pairs = [(0, 3), (1, 3), (1, 4), (2, 5), (0, 4), (2, 6)]
    assert list(check(pairs, [4, 4, 1, 4, 1, 4], [1] * 7, range(6), hubs=[0])) == [COLOURS, 0, 1, 0, COLOURS, 1]


@pytest.mark.parametrize("seed", range(3))
def test_rows_that_are_not_split_never_run_out_of_colours(seed):
    """Two rows of as many contacts as any may have: the contacts between them, which come last, still find a colour."""
    rng = np.random.default_rng(seed)
    crowd = MOST_CONTACTS - 1
    pairs = [(0, 2 + k) for k in range(crowd)]
    for k in range(crowd):  # neighbours of row 1, the colours of whose contacts with it are pushed up by other contacts
        place = 2 + crowd + k
        others = range(2 + 2 * crowd + crowd * k, 2 + 2 * crowd + crowd * (k + 1))
        pairs += [(place, other) for other in others] + [(1, place)]
    pairs.append((0, 1))
    rows = 2 + 2 * crowd + crowd * crowd
    colours, *_ = coloured(pairs, rng.integers(1, 5, len(pairs)), [1] * rows, range(len(pairs)), ())
    assert np.bincount(np.ravel(pairs)).max() == MOST_CONTACTS
    assert colours[-1] == 2 * crowd
    assert colours.max() < COLOURS
