"""``when``: what no lane needs is left out, in both readings."""

import numpy as np
import pytest

from atlasphys.engine.jit import kernel
from atlasphys.engine.simd import all_lanes, any_lane, gather, load, simd_kernel, store, when


@simd_kernel
def halve_the_large(block, x, rows, index, taken) -> bool:
    """Blocks with a value over 1 are halved; inside, those all over 1 take a row of a table, too."""
    value = load(x, block)
    large = any_lane(value > 1)

    def halve():
        store(x, block, 0.5 * value)
        when(all_lanes(value > 1), lambda: store(taken, block, gather(rows, load(index, block))[3]))

    when(large, halve)
    when(~large, lambda: store(taken, block, -1))
    return large


@kernel
def halve_all_the_large(x, rows, index, taken, answers):
    for block in range(len(x)):
        answers[block] = halve_the_large(block, x, rows, index, taken)


@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_an_action_runs_where_its_condition_holds(real):
    rng = np.random.default_rng(0)
    x = rng.uniform(0, 1, (40, 8)).astype(real)
    x[10:20, 3] += 1
    x[20:30] += 1
    rows, index = rng.normal(size=(5, 8)).astype(real), rng.integers(0, 5, (40, 8)).astype(np.int32)
    answers = [(x.copy(), rows, index, np.zeros((40, 8), real), np.zeros(40, np.bool_)) for _ in range(2)]
    halve_all_the_large(*answers[0])
    halve_all_the_large.py_func(*answers[1])
    for one, two in zip(*answers, strict=True):
        np.testing.assert_array_equal(one, two)
    halved, _, _, taken, answer = answers[0]
    np.testing.assert_array_equal(answer, (x > 1).any(axis=1))
    np.testing.assert_array_equal(halved, np.where(answer[:, None], x / 2, x))
    everywhere = (x > 1).all(axis=1)
    assert everywhere.sum() == 10
    np.testing.assert_array_equal(taken[everywhere], rows[index, 3][everywhere])
    assert (taken[~answer] == -1).all()
    assert (taken[answer & ~everywhere] == 0).all()


def test_a_condition_holds_for_all_lanes():
    @simd_kernel
    def branches(x):
        when(load(x, 0) > 0, lambda: store(x, 0, 1))

    @kernel
    def driver(x):
        branches(x)

    for function in (driver, driver.py_func):
        with pytest.raises(TypeError, match="one truth for all lanes"):
            function(np.zeros((1, 8)))
