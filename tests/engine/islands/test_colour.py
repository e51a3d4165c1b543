"""Colours of contacts against a plain check, and their layout in blocks of eight."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from atlasphys.engine.islands.colour import COLOURS, block_ranges, colour_contacts, fill_blocks
from atlasphys.engine.jit import kernel
from atlasphys.engine.simd import LANES
from atlasphys.engine.state.blocks import BODY_A, BODY_B, COUNT, INTEGERS, MANIFOLD, MOVES_A, MOVES_B


@kernel
def colour(a, b, count, live, number, body, moves, used, colours, sizes, starts):
    colour_contacts(a, b, count, live, number, body, moves, used, colours, sizes)
    block_ranges(sizes, starts)


@kernel
def fill(a, b, count, live, number, body, moves, colours, starts, cursor, integers_one, integers_many):
    fill_blocks(a, b, count, live, number, body, moves, colours, starts, cursor, integers_one, integers_many)


def coloured(pairs, points, moves, live):
    """Colours, sizes, first blocks and the integers of the blocks of both classes."""
    pairs = np.array(pairs, np.int32).reshape(-1, 2)
    a, b = pairs[:, 0].copy(), pairs[:, 1].copy()
    points, moves, live = np.array(points, np.int32), np.array(moves, np.uint8), np.array(live, np.int32)
    body = np.arange(len(moves), dtype=np.int32)
    colours, used = np.full(len(a), -1, np.int8), np.zeros(len(moves), np.uint64)
    sizes, starts = np.zeros((2, COLOURS + 1), np.int64), np.zeros((2, COLOURS + 2), np.int64)
    colour(a, b, points, live, len(live), body, moves, used, colours, sizes, starts)
    blocks = [np.full((starts[k, COLOURS + 1] + 1, INTEGERS, LANES), 7, np.int32) for k in range(2)]
    cursor = np.zeros((2, COLOURS + 1), np.int64)
    fill(a, b, points, live, len(live), body, moves, colours, starts, cursor, *blocks)
    return colours, sizes, starts, blocks


def check(pairs, points, moves, live):
    colours, sizes, starts, blocks = coloured(pairs, points, moves, live)
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
                i = mine[MANIFOLD, lane]
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


@pytest.mark.parametrize("moves_plate", [0, 1])
def test_one_plate_under_five_hundred_bodies(moves_plate):
    """A static or kinematic plate never conflicts: one colour. A dynamic one takes all colours, and the rest overflows one by one."""
    pairs = [(0, i) for i in range(1, 501)]
    colours = check(pairs, [4] * 500, [moves_plate] + [1] * 500, range(500))
    if moves_plate:
        assert sorted(colours) == [*range(COLOURS), *[COLOURS] * (500 - COLOURS)]
    else:
        assert set(colours) == {0}
