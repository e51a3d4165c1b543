"""What is different while a kernel is compiled, and that it is not afterwards."""

import gc

import numpy as np
import pytest
from numba.core import types
from numba.core.errors import TypingError

from atlasphys.engine.jit import IS_COMPILED, kernel, routine
from atlasphys.engine.simd.compiling import quickly

pytestmark = pytest.mark.skipif(not IS_COMPILED, reason="nothing is compiled")


@routine
def twice(x):
    return x + x


@kernel
def sums(numbers, i):
    numbers[0] = twice(numbers[0]) + numbers[0] * i
    return twice(i) + i


@kernel
def wrong(numbers):
    return numbers + None


def state():
    return gc.isenabled(), types.BaseFunction.get_call_type


def test_it_is_as_before_afterwards():
    before, seen = state(), []
    assert quickly(quickly(lambda kinds: seen.append(state()) or kinds))(5) == 5
    assert seen[0][0] is False
    assert seen[0][1] is not before[1]
    assert state() == before
    with pytest.raises(TypingError):
        wrong(np.zeros(3))
    assert state() == before


def test_it_leaves_the_collector_off_where_it_was():
    gc.disable()
    try:
        quickly(lambda kinds: kinds)(())
        assert not gc.isenabled()
    finally:
        gc.enable()


@pytest.mark.parametrize("dtype", [np.float32, np.float64, np.int64])
def test_each_combination_of_types_has_its_own_answers(dtype):
    for i in (2, np.int32(2), 2.5):
        numbers = np.array([3, 0], dtype)
        assert sums(numbers, i) == 3 * i
        assert numbers[0] == dtype(6 + 3 * i)
