"""Each operation on lanes, compiled against NumPy, bit for bit."""

import numpy as np
import pytest

from atlasphys.engine.jit import kernel
from atlasphys.engine.simd import (
    absolute,
    all_lanes,
    any_lane,
    full,
    load,
    maximum,
    minimum,
    select,
    simd_kernel,
    sqrt,
    store,
)
from tests.engine.simd.values import awkward, bits

REALS = (np.float32, np.float64)


def truth(mask, like):
    return select(mask, full(like, 1), 0)


FLOATS = [
    lambda x, y: x + y,
    lambda x, y: x - y,
    lambda x, y: x * y,
    lambda x, y: x / y,
    lambda x, y: -x,
    lambda x, y: 0.1 + x,
    lambda x, y: 0.1 - x,
    lambda x, y: 3 * x,
    lambda x, y: 1.0 / x,
    lambda x, y: x + 1e300,
    lambda x, y: full(x, 0.1) * full(y, 3) + x,
    lambda x, y: x * y + x,  # must not be fused
    lambda x, y: x * y - y * x,
    lambda x, y: sqrt(x),
    lambda x, y: absolute(x),
    lambda x, y: minimum(x, y),
    lambda x, y: maximum(x, y),
    lambda x, y: maximum(x, 0.0),
    lambda x, y: minimum(x, -0.0),
    lambda x, y: truth(x < y, x),
    lambda x, y: truth(x <= y, x),
    lambda x, y: truth(x > y, x),
    lambda x, y: truth(x >= y, x),
    lambda x, y: truth(x == y, x),
    lambda x, y: truth(x != y, x),
    lambda x, y: truth((x < 1) & (y > 0), x),
    lambda x, y: truth((x < 1) | (y > 0), x),
    lambda x, y: truth(~(x < 1), x),
    lambda x, y: select(x < y, x, 0.1),
    lambda x, y: select(x < y, 0.1, y),
    lambda x, y: truth(any_lane(x > 100), x),
    lambda x, y: truth(all_lanes(x < 1), x),
    lambda x, y: truth(any_lane(x > 1) & (y > 0), x),
    lambda x, y: truth(~any_lane(x > 1000), x),
    lambda x, y: x.astype(np.float64).astype(x.dtype),
    lambda x, y: (x.astype(np.float64) / 3).astype(np.float32).astype(x.dtype),
]

INTEGERS = [
    lambda i, j: i + j,
    lambda i, j: i - j,
    lambda i, j: i * j,
    lambda i, j: 3 - i,
    lambda i, j: -i,
    lambda i, j: i & j,
    lambda i, j: i | 5,
    lambda i, j: truth(i < j, i),
    lambda i, j: truth(i != j, i),
    lambda i, j: select(i >= 0, i, j),
    lambda i, j: i.astype(np.int64).astype(i.dtype),
]


@simd_kernel
def all_floats(block, x, y, out):
    for field, operation in enumerate(FLOATS):
        store(out, block, field, operation(load(x, block), load(y, block)))


@simd_kernel
def all_integers(block, i, j, out, floats):
    for field, operation in enumerate(INTEGERS):
        store(out, block, field, operation(load(i, block), load(j, block)))
    store(floats, block, load(i, block).astype(np.float32))


@kernel
def run_floats(x, y, out):
    for block in range(x.shape[0]):
        all_floats(block, x, y, out)


@kernel
def run_integers(i, j, out, floats):
    for block in range(i.shape[0]):
        all_integers(block, i, j, out, floats)


def both(driver, *arrays):
    """Copies of the arrays after the compiled and after the NumPy reading."""
    answers = []
    for function in (driver, driver.py_func):
        copies = [array.copy() for array in arrays]
        function(*copies)
        answers.append(copies)
    return answers


@pytest.mark.parametrize("real", REALS)
def test_floating_point(real):
    x, y = awkward(real, 200, 1), awkward(real, 200, 2)
    x[:4], y[:4] = abs(x[:4]) + 1, 0.5  # blocks in which all lanes agree
    compiled, read = both(run_floats, x, y, np.full((200, len(FLOATS), 8), 7, real))
    for field in range(len(FLOATS)):
        assert len(np.unique(read[2][:, field])) > 1, field
        np.testing.assert_array_equal(
            bits(compiled[2][:, field]), bits(read[2][:, field]), err_msg=f"operation {field}"
        )


@pytest.mark.parametrize("integer", [np.int32, np.int64])
def test_integers(integer):
    rng = np.random.default_rng(3)
    limits = np.iinfo(integer)
    i, j = (rng.choice(np.array([0, 1, -1, 7, -12, limits.max, limits.min], integer), (100, 8)) for _ in "ij")
    compiled, read = both(run_integers, i, j, np.zeros((100, len(INTEGERS), 8), integer), np.zeros((100, 8), "f"))
    for a, b in zip(compiled, read, strict=True):
        np.testing.assert_array_equal(bits(a), bits(b))
    assert read[2].any(axis=(0, 2)).all()


@pytest.mark.parametrize("real", REALS)
def test_minimum_and_maximum_take_the_second_where_neither_is_less(real):
    nan = real(np.nan)
    for choose in (minimum, maximum):
        assert np.isnan(choose(real(1), nan))
        assert choose(nan, real(1)) == 1
        assert np.signbit(choose(real(0), real(-0.0)))
        assert not np.signbit(choose(real(-0.0), real(0)))


def in_place(x, k):
    x += 1
    return x


BODIES = {
    "use select": lambda x, k: x if x > 0 else -x,
    "operands are float32 and float64": lambda x, k: x + np.float64(2),
    "operands are float32 and int32": lambda x, k: x + k,
    "the value is int32, the array float32": lambda x, k: k,
    "must be lanes or a number, not str": lambda x, k: x + "2",
    "select between two Python numbers": lambda x, k: select(x > 0, 1.0, 0.0),
    "is undefined out of range": lambda x, k: x.astype(np.int32),
    "division needs floating-point lanes": lambda x, k: k / 2,
    "bit operations need integer lanes": lambda x, k: x & 1,
    "sqrt needs floating-point lanes": lambda x, k: sqrt(k),
    "a mask combines with masks": lambda x, k: select((x > 0) & 1, x, 0),
    "meets lanes of int32": lambda x, k: k * 0.5,
    "write x = x": in_place,
    "masks are not compared": lambda x, k: select((x > 0) == (x < 1), x, 0),
}


@pytest.mark.parametrize("message", BODIES)
def test_what_lanes_refuse(message):
    operation = BODIES[message]

    @simd_kernel
    def body(block, x, k):
        store(x, block, operation(load(x, block), load(k, block)))

    @kernel
    def driver(x, k):
        body(0, x, k)

    with pytest.raises(TypeError, match=message):
        driver(np.ones((1, 8), "f"), np.ones((1, 8), np.int32))


@pytest.mark.parametrize(
    ("operation", "message"),
    [
        (lambda x: x + np.float64(2), "the value is float64, the array float32"),
        (lambda x: select(x > 0, x, np.float64(2)), "sides are float32 and float64"),
        (lambda x: select(x > 0, 1.0, 0.0), "select between two Python numbers"),
    ],
)
def test_what_the_numpy_reading_refuses(operation, message):
    @simd_kernel
    def body(x):
        store(x, 0, operation(load(x, 0)))

    with pytest.raises(TypeError, match=message):
        body(np.ones((1, 8), "f"))
