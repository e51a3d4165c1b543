"""Tables that are passed by address, their parts, and instructions without an operator."""

import copy
import pickle
from typing import NamedTuple

import numpy as np
import pytest

from atlasphys.engine.jit import call, kernel, routine
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


@by_address
class Cabinet(NamedTuple):
    """All that a table may hold."""

    shelves: Shelves
    weight: float
    corner: tuple[float, float, float]
    number: int
    rows: np.ndarray


@kernel
def look_into(cabinet, answers):
    answers[0] = cabinet.shelves.flat[1]
    answers[1] = cabinet.weight
    for k in range(3):
        answers[2 + k] = cabinet.corner[k]
    answers[5], answers[6] = cabinet.number, cabinet.rows[2]


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


def cabinet(real):
    shelves = Shelves(np.arange(3, dtype=real), np.zeros((2, 2), real), np.zeros((2, 2, 2), real))
    return Cabinet(shelves, real(2), (real(3), real(4), real(5)), 6, np.arange(5, 20, dtype=np.int32)[::1])


@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_compiled_code_finds_all_fields_of_a_table(real):
    for passed in (cabinet(real), copy.deepcopy(cabinet(real)), cabinet(real)._replace(number=6)):
        answers = np.zeros(7, real)
        look_into(passed, answers)
        assert answers.tolist() == [1, 2, 3, 4, 5, 6, 7]


def test_a_record_is_made_anew_for_what_is_made_of_a_table():
    table = cabinet(np.float32)
    for other in (copy.copy(table), pickle.loads(pickle.dumps(table)), table._replace(number=7)):
        assert type(other) is Cabinet
        assert table.address == table.record.ctypes.data != other.address
    assert table._replace(number=7).record.tolist() != table.record.tolist()


def test_a_kernel_called_past_the_dispatcher_answers_the_same():
    for real in (np.float32, np.float64):
        for _ in range(2):
            answers, expected = np.zeros(7, real), np.zeros(7, real)
            call(look_into, np.dtype(real).char, cabinet(real), answers)
            look_into(cabinet(real), expected)
            assert answers.tolist() == expected.tolist() == [1, 2, 3, 4, 5, 6, 7]
