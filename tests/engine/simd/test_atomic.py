"""Integers that threads share, waiting, and calls by address: compiled, and as Python has them."""

import threading

import numpy as np
import pytest

from atlasphys.engine.jit import kernel, routine
from atlasphys.engine.simd.address import address_call, call_address
from atlasphys.engine.simd.atomic import atomic_add, atomic_load, atomic_store, give_way, nap, now, pause


@kernel
def count_up(entries, rounds):
    for _ in range(rounds):
        atomic_add(entries, 3, 1)


@kernel
def use_all(entries):
    atomic_store(entries, 0, atomic_load(entries, 1) + 5)
    entries[2] = atomic_add(entries, 1, -7)
    start = now()
    pause()
    give_way()
    nap(200)
    return now() - start


@routine
def note(arguments, i, j, k):
    numbers, scale = arguments
    if i < 0:
        raise ValueError("negative")
    numbers[i] += scale * (10 * j + k)


@kernel
def call_note(numbers, scale, i, j, k):
    code, data = address_call(note, (numbers, scale))
    return call_address(code, data, i, j, k)


def test_no_addition_is_lost_between_threads():
    entries, rounds = np.zeros(8, np.int64), 200_000
    count_up(entries, 0)
    threads = [threading.Thread(target=count_up, args=(entries, rounds)) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert entries.tolist() == [0, 0, 0, 3 * rounds, 0, 0, 0, 0]


@pytest.mark.parametrize("function", [use_all, getattr(use_all, "py_func", use_all)], ids=["compiled", "Python"])
def test_entries_and_the_clock(function):
    entries = np.array([1, 2, 3], np.int64)
    waited = function(entries)
    assert entries.tolist() == [7, -5, 2]
    assert 0 <= waited < 10_000_000_000
    assert function is not use_all or waited >= 200_000  # Python's nap returns at once


def test_only_int64_entries_are_atomic():
    with pytest.raises(Exception, match="int64"):
        count_up(np.zeros(8, np.int32), 1)


def test_a_call_by_address_reaches_the_arguments():
    numbers = np.zeros(4)
    assert call_note(numbers, 0.5, 2, 3, 4) == 0
    assert numbers.tolist() == [0, 0, 17, 0]


def test_python_calls_by_address_too():
    numbers = np.zeros(4)
    code, data = address_call(getattr(note, "py_func", note), (numbers, 0.5))
    assert call_address(code, data, 2, 3, 4) == 0
    assert numbers.tolist() == [0, 0, 17, 0]


def test_an_exception_in_a_call_by_address_is_reported():
    numbers = np.zeros(4)
    assert call_note(numbers, 0.5, -1, 3, 4) == 1
    assert not numbers.any()
