"""Tables that are passed by address, their parts, and instructions without an operator."""

from typing import NamedTuple

import numpy as np
import pytest

from atlasphys.engine.jit import kernel, routine
from atlasphys.engine.simd.bits import fetch, trailing_ones
from atlasphys.engine.simd.by_address import by_address, part_of


@by_address
class Shelves(NamedTuple):
    """Arrays of one, two and three axes."""

    flat: np.ndarray
    square: np.ndarray
    cube: np.ndarray


@routine
def fill(part, number):
    for i in range(part.square.shape[0]):
        part.square[i] = number + part.cube[i, 1]


@kernel
def filled_by_routine(shelves, index):
    fill(part_of(shelves, index), shelves.flat[index, 0])


@kernel
def filled(shelves, index):
    part = part_of(shelves, index)
    for i in range(part.square.shape[0]):
        part.square[i] = shelves.flat[index, 0] + part.cube[i, 1]
    return part.cube.shape[0], part.square.shape[0], part.flat[0]


@kernel
def ones_below(numbers, answers):
    for i in range(len(numbers)):
        answers[i] = trailing_ones(numbers[i])


@kernel
def fetched(table, row):
    fetch(table, row, 1)
    return table[row, 0]


@pytest.mark.parametrize("function", [filled, getattr(filled, "py_func", filled)], ids=["compiled", "Python"])
@pytest.mark.parametrize("index", [0, 2])
def test_a_part_is_a_view_of_the_table(function, index):
    shelves = Shelves(np.arange(3.0)[:, None], np.zeros((3, 4)), np.arange(3 * 4 * 2.0).reshape(3, 4, 2))
    assert function(shelves, index) == (4, 4, index)
    expected = np.zeros((3, 4))
    expected[index] = index + shelves.cube[index, :, 1]
    np.testing.assert_array_equal(shelves.square, expected)
    shelves.square[:] = 0
    filled_by_routine(shelves, index)
    np.testing.assert_array_equal(shelves.square, expected)


@pytest.mark.parametrize(
    "function", [ones_below, getattr(ones_below, "py_func", ones_below)], ids=["compiled", "Python"]
)
def test_trailing_ones(function):
    rng = np.random.default_rng(0)
    counts = [*range(65), *rng.integers(0, 64, 50).tolist()]
    above = [int(x) for x in rng.integers(0, 2**63, len(counts))]
    numbers = [((high << (n + 1)) | ((1 << n) - 1)) & (2**64 - 1) for n, high in zip(counts, above, strict=True)]
    answers = np.zeros(len(numbers), np.int64)
    function(np.array(numbers, np.uint64), answers)
    expected = [len(text) - len(text.rstrip("1")) for text in (f"{number:064b}" for number in numbers)]
    assert answers.tolist() == expected
    assert {0, 1, 63, 64} <= set(expected)


@pytest.mark.parametrize("function", [fetched, getattr(fetched, "py_func", fetched)], ids=["compiled", "Python"])
def test_fetching_changes_nothing(function):
    table = np.arange(12.0).reshape(4, 3)
    assert function(table, 2) == 6
    assert table.tolist() == np.arange(12.0).reshape(4, 3).tolist()
