"""Blocks, gathered and scattered rows, and the arrays that they refuse."""

import numpy as np
import pytest

from atlasphys.engine.jit import kernel
from atlasphys.engine.simd import beside, gather, load, scatter, simd_kernel, store

DTYPES = (np.float32, np.float64, np.int32, np.int64)


@simd_kernel
def move(block, index, source, target, mask):
    """Copy columns 8 to 23 of rows to columns 1 to 16 of the same rows of another table, in chosen lanes."""
    rows = load(index, block)
    scatter(target, rows, gather(source, rows, 16, 8), 1, where=load(mask, block) > 0)


@kernel
def moved(index, source, target, mask):
    for block in range(index.shape[0]):
        move(block, index, source, target, mask)


@simd_kernel
def move_two(block, other, index, source, target, mask):
    """The same for two blocks side by side; the mask is given as integers."""
    block = beside(block, other)
    rows = load(index, block)
    scatter(target, rows, gather(source, rows, 16, 8), 1, where=load(mask, block))


@kernel
def moved_by_twos(index, source, target, mask):
    for block in range(0, index.shape[0], 2):
        move_two(block, min(block + 1, index.shape[0] - 1), index, source, target, mask)


@simd_kernel
def add_rows(block, index, rows):
    i = load(index, block)
    scatter(rows, i, [x + x for x in gather(rows, i)])


@kernel
def rows_added(index, rows):
    for block in range(index.shape[0]):
        add_rows(block, index, rows)


@simd_kernel
def copy(plane, block, source, target):
    for field in range(3):
        store(target, block, plane + 1, 2 - field, load(source, plane, block * 2 - block, field))


@kernel
def copied(source, target):
    for plane in range(source.shape[0]):
        for block in range(source.shape[1]):
            copy(plane, block, source, target)


def both(driver, *arrays):
    answers = []
    for function in (driver, driver.py_func):
        copies = [array.copy() for array in arrays]
        function(*copies)
        answers.append(copies)
    return answers


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("integer", [np.int32, np.int64])
def test_rows(dtype, integer):
    rng = np.random.default_rng(0)
    source, target = rng.integers(-1000, 1000, (40, 27)).astype(dtype), np.full((40, 19), 7777, dtype)
    index, mask = rng.permutation(40).reshape(5, 8).astype(integer), rng.integers(0, 2, (5, 8)).astype(integer)
    expected = target.copy()
    chosen = index[mask > 0]
    expected[chosen, 1:17] = source[chosen, 8:24]
    for driver in (moved, moved_by_twos):
        for answer in both(driver, index, source, target, mask):
            np.testing.assert_array_equal(answer[2], expected)
            np.testing.assert_array_equal(answer[1], source)


def test_rows_named_twice_keep_the_last_lanes_values_and_later_blocks_see_them():
    index = np.array([[3, 3, 1, 0, 2, 3, 1, 3], [3, 4, 5, 6, 7, 8, 9, 10]])
    rows = np.arange(11 * 8, dtype="d").reshape(11, 8)
    compiled, read = both(rows_added, index, rows)
    np.testing.assert_array_equal(compiled[1], read[1])
    np.testing.assert_array_equal(compiled[1], rows * np.array([2, 2, 2, 4, 2, 2, 2, 2, 2, 2, 2])[:, None])


@pytest.mark.parametrize("dtype", DTYPES)
def test_blocks_of_any_number_of_axes(dtype):
    source = np.arange(4 * 5 * 3 * 8).reshape(4, 5, 3, 8).astype(dtype)
    target = np.zeros((5, 5, 3, 8), dtype)
    for answer in both(copied, source, target):
        np.testing.assert_array_equal(answer[1][:, 1:], source.transpose(1, 0, 2, 3)[:, :, ::-1])
        assert not answer[1][:, 0].any()


def test_loaded_lanes_are_a_copy():
    @simd_kernel
    def body(x):
        before = load(x, 0)
        store(x, 0, before + 1)
        store(x, 1, before)

    x = np.zeros((2, 8))
    body(x)
    assert (x == [[1], [0]]).all()


INDEX, ROWS, MASK = np.arange(8)[None], np.ones((8, 24), "f"), np.ones((1, 8), np.int32)
TARGET = np.zeros((8, 17), "f")


@pytest.mark.parametrize(
    ("error", "arguments", "message"),
    [
        (ValueError, (np.arange(7)[None], ROWS, TARGET, MASK), "must have 8 lanes"),
        (ValueError, (INDEX, ROWS[:, :23].copy(), TARGET, MASK), "rows must have at least 24 columns"),
        (ValueError, (INDEX, ROWS, TARGET[:, :16].copy(), MASK), "rows must have at least 17 columns"),
        (TypeError, (INDEX, ROWS[:, ::-1], TARGET, MASK), "must be C-contiguous"),
        (TypeError, (INDEX, ROWS, TARGET.astype("d"), MASK), "the value is float32, the array float64"),
        (TypeError, (INDEX.astype("d"), ROWS, TARGET, MASK), "row numbers must be integer lanes, not float64"),
        (TypeError, (INDEX.astype(np.uint8), ROWS, TARGET, MASK), "lanes are float32, float64, int32 or int64"),
        (TypeError, (INDEX[None], ROWS, TARGET, MASK), "the array has 3 axes where 2 are addressed"),
    ],
)
@pytest.mark.parametrize("reading", ["compiled", "numpy"])
def test_what_memory_refuses(reading, error, arguments, message):
    before = arguments[2].copy()
    with pytest.raises(error, match=message):
        (moved if reading == "compiled" else moved.py_func)(*arguments)
    assert (arguments[2] == before).all()


def test_odd_numbers_of_columns_are_refused():
    with pytest.raises(ValueError, match="asked for 12"):
        gather(np.ones((8, 24)), np.arange(8), 12)
