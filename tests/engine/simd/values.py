"""Numbers that vector code could treat differently from NumPy, and how results are compared."""

import numpy as np


def awkward(real, count, seed):
    """Random numbers with every special kind among them: an array of shape (count, 8)."""
    rng = np.random.default_rng(seed)
    tiny, least, largest = np.finfo(real).tiny, np.finfo(real).smallest_subnormal, np.finfo(real).max
    special = [0, -0.0, np.inf, -np.inf, np.nan, tiny, -tiny / 2, least, -least, largest, -largest, 1, -1, 0.5]
    values = (rng.normal(size=(count, 8)) * 10.0 ** rng.integers(-3, 4, (count, 8))).astype(real)
    chosen = rng.random((count, 8)) < 0.4
    values[chosen] = rng.choice(np.array(special, real), chosen.sum())
    return values


def bits(array):
    """The bits of an array's numbers, those of all NaN being one: IEEE leaves the sign and payload of a NaN open."""
    array = np.array(array)
    if array.dtype.kind != "f":
        return array
    array[np.isnan(array)] = np.nan
    return array.view(f"i{array.dtype.itemsize}")
