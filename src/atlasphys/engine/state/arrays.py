"""Allocation of state arrays: 64-byte aligned rows."""

import mmap
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

Rows = TypeVar("Rows", bound=tuple[npt.NDArray[Any], ...])

CACHE_LINE = 64
"""Bytes. A row that straddles two cache lines costs two loads, and two threads may contend for the shared line."""


MAPPED = 1 << 16
"""Size from which on an array has pages of its own [bytes]. They go back to the system with it, and take no memory until something is written."""


def aligned_zeros(shape: tuple[int, ...], dtype: npt.DTypeLike) -> npt.NDArray[Any]:
    """Zeros whose first element lies on a cache line."""
    dtype = np.dtype(dtype)
    size = int(np.prod(shape)) * dtype.itemsize
    if size >= MAPPED and hasattr(mmap, "MAP_PRIVATE"):  # not on Windows
        pages = mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
        return np.frombuffer(pages, dtype).reshape(shape)
    buffer = np.zeros(size + CACHE_LINE, np.uint8)
    start = -buffer.ctypes.data % CACHE_LINE
    return buffer[start : start + size].view(dtype).reshape(shape)


def aligned_copy(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """A copy of ``array`` that lies on a cache line."""
    result = aligned_zeros(array.shape, array.dtype)
    result[...] = array
    return result


def room_for(rows: int) -> int:
    """Rows to allocate for a large table that needs so many now: few, for memory, but enough that it seldom grows."""
    return rows + rows // 8 + 8


def with_capacity(rows: Rows, capacity: int, used: int | None = None) -> Rows:
    """The same table with room for ``capacity`` rows; the first ``used`` rows are kept, or all."""
    fields = []
    for array in rows:
        grown = aligned_zeros((capacity, *array.shape[1:]), array.dtype)
        kept = array[: min(capacity, len(array) if used is None else used)]
        if kept.view(np.uint8).any():  # zeros that nobody writes take no memory; −0 is a bit that counts
            grown[: len(kept)] = kept
        fields.append(grown)
    return type(rows)(*fields)


def copy_rows(rows: Rows) -> Rows:
    """An independent copy of a table."""
    return type(rows)(*(aligned_copy(array) for array in rows))
