"""Allocation of state arrays: 64-byte aligned rows, whose number grows by doubling."""

from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

Rows = TypeVar("Rows", bound=tuple[npt.NDArray[Any], ...])

CACHE_LINE = 64
"""Bytes. A row that straddles two cache lines costs two loads, and two threads may contend for the shared line."""


def aligned_zeros(shape: tuple[int, ...], dtype: npt.DTypeLike) -> npt.NDArray[Any]:
    """Zeros whose first element lies on a cache line."""
    dtype = np.dtype(dtype)
    size = int(np.prod(shape)) * dtype.itemsize
    buffer = np.zeros(size + CACHE_LINE, np.uint8)
    start = -buffer.ctypes.data % CACHE_LINE
    return buffer[start : start + size].view(dtype).reshape(shape)


def aligned_copy(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """A copy of ``array`` that lies on a cache line."""
    result = aligned_zeros(array.shape, array.dtype)
    result[...] = array
    return result


def with_capacity(rows: Rows, capacity: int) -> Rows:
    """The same table with room for ``capacity`` rows; the rows that were there are kept."""
    fields = []
    for array in rows:
        grown = aligned_zeros((capacity, *array.shape[1:]), array.dtype)
        kept = min(capacity, len(array))
        grown[:kept] = array[:kept]
        fields.append(grown)
    return type(rows)(*fields)


def copy_rows(rows: Rows) -> Rows:
    """An independent copy of a table."""
    return type(rows)(*(aligned_copy(array) for array in rows))
