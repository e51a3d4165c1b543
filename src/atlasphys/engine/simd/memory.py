"""Reading and writing lanes: blocks of eight neighbours, and rows of a table picked by eight indices.

Two layouts of memory, both C-contiguous:

- blocks, ``[..., lane]``, such as constraints as ``[block, field, lane]``: ``load`` and ``store`` move eight neighbours;
- rows, ``[row, column]``, such as bodies: ``gather`` reads eight rows whole and transposes them in registers, which is
  faster than the CPU's gather instructions; ``scatter`` transposes back and writes eight rows.

Row and block numbers are trusted: not negative, within the array.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir

from atlasphys.engine.simd.lanes import LANES, LLVM_TYPES, Lanes, pick

_I32, _I64 = ir.IntType(32), ir.IntType(64)


class Index:
    """An integer, the same for all lanes, that is known only when the kernel runs: a block's number."""

    __hash__ = None  # type: ignore[assignment]

    def __init__(self, builder: Any, value: Any) -> None:
        self.builder, self.value = builder, value

    def __bool__(self) -> bool:
        raise TypeError("an index is not known while the body is traced: branch on it in the driver")

    def __eq__(self, other: object) -> bool:
        return bool(self)

    def _emit(self, name: str, other: Any) -> Index:
        return Index(self.builder, getattr(self.builder, name)(self.value, as_i64(other)))

    def __add__(self, other: Any) -> Index:
        return self._emit("add", other)

    def __sub__(self, other: Any) -> Index:
        return self._emit("sub", other)

    def __mul__(self, other: Any) -> Index:
        return self._emit("mul", other)

    __radd__, __rmul__ = __add__, __mul__


def as_i64(index: Any) -> Any:
    """LLVM value of an index."""
    if isinstance(index, Index):
        return index.value
    if isinstance(index, (int, np.integer)):
        return ir.Constant(_I64, int(index))
    raise TypeError(f"an index must be an integer, the same for all lanes, not {type(index).__name__}")


class Beside:
    """Numbers of two blocks that are worked on at the same time, one's lanes after the other's.

    What one waits for, such as the result of a multiplication, is time for the other; blocks that do not depend on each other are done in little
    more than half the time. If both are the same block it is done once, twice.
    """

    def __init__(self, first: Any, second: Any) -> None:
        self.blocks = first, second


def beside(first: Any, second: Any) -> Beside:
    """An index for ``load`` and ``store`` that stands for two blocks."""
    return Beside(first, second)


def _each(index: tuple[Any, ...]) -> list[tuple[Any, ...]] | None:
    """The index of each of two blocks side by side; None if it is of one."""
    if not any(isinstance(number, Beside) for number in index):
        return None
    return [tuple(number.blocks[k] if isinstance(number, Beside) else number for number in index) for k in range(2)]


def _halves(lanes: Any) -> list[Any]:
    """The lanes of each of two blocks side by side, or of a mask for them."""
    parts = [list(range(LANES * k, LANES * (k + 1))) for k in range(2)]
    if isinstance(lanes, Lanes):
        wide = lanes.widened(2 * LANES)
        return [lanes.like(pick(lanes.builder, wide.value, wide.value, part)) for part in parts]
    return [np.broadcast_to(lanes, 2 * LANES)[part] for part in parts] if lanes is not None else [None, None]


def _joined(first: Any, second: Any) -> Any:
    """Lanes side by side."""
    if isinstance(first, Lanes):
        value = pick(first.builder, first.value, second.value, list(range(2 * LANES)))
        return Lanes(first.builder, first.dtype, value, first.scalars + second.scalars if not first.is_float else None)
    return np.concatenate([first, second])


class Table:
    """A traced array argument of a kernel body. The kernel makes it; ``load``, ``store``, ``gather``, ``scatter`` use it.

    ``require(axis, sign, number, message)`` has the compiled kernel check an extent of the array before anything else.
    """

    def __init__(
        self, builder: Any, dtype: np.dtype[Any], data: Any, shape: Any, contiguous: bool, require: Any
    ) -> None:
        self.builder, self.dtype, self.data, self.shape = builder, dtype, data, shape
        self.contiguous, self.require = contiguous, require
        self.ndim = len(shape)

    def element(self, offset: Any) -> Any:
        """Pointer to an element, counted from the first."""
        return self.builder.gep(self.data, [offset])

    def read(self, element: Any, skip: int = 0) -> Any:
        """Eight neighbours, from ``skip`` elements behind a pointer on. No alignment is asked for: where they lie
        aligned, they are as fast."""
        return self.builder.load(self._neighbours(element, skip), align=self.dtype.itemsize)

    def read_one(self, element: Any, skip: int) -> Any:
        """The element ``skip`` behind a pointer."""
        return self.builder.load(self.builder.gep(element, [ir.Constant(_I64, skip)]))

    def write(self, element: Any, vector: Any, skip: int = 0) -> None:
        """Write eight neighbours."""
        self.builder.store(vector, self._neighbours(element, skip), align=self.dtype.itemsize)

    def _neighbours(self, element: Any, skip: int) -> Any:
        vector = ir.VectorType(LLVM_TYPES[self.dtype], LANES)
        return self.builder.bitcast(self.builder.gep(element, [ir.Constant(_I64, skip)]), vector.as_pointer())


def _check(array: Any, ndim: int | None = None) -> None:
    """Refuse arrays that lanes cannot be read from."""
    if array.dtype not in LLVM_TYPES:
        raise TypeError(f"lanes are float32, float64, int32 or int64; the array is {array.dtype}")
    contiguous = array.contiguous if isinstance(array, Table) else array.flags.c_contiguous
    if not contiguous:
        raise TypeError("the array must be C-contiguous")
    if ndim is not None and array.ndim != ndim:
        raise TypeError(f"the array has {array.ndim} axes where {ndim} are addressed")


def _extent(array: Any, axis: int, sign: str, number: int, message: str) -> None:
    """Refuse an array whose extent along an axis is not ``sign number`` (``==`` or ``>=``): a compiled kernel before its
    first load, the NumPy reading at once."""
    if isinstance(array, Table):
        array.require(array.shape[axis], sign, number, message)
    elif not (array.shape[axis] == number if sign == "==" else array.shape[axis] >= number):
        raise ValueError(message)


def _check_blocks(blocks: Any, index: tuple[Any, ...]) -> None:
    _check(blocks, len(index) + 1)
    _extent(blocks, -1, "==", LANES, f"the last axis of an array of blocks must have {LANES} lanes")


def _block_pointer(blocks: Table, index: tuple[Any, ...]) -> Any:
    builder = blocks.builder
    offset = ir.Constant(_I64, 0)
    for axis, i in enumerate(index):
        offset = builder.add(builder.mul(offset, blocks.shape[axis]), as_i64(i))
    return blocks.element(builder.mul(offset, ir.Constant(_I64, LANES)))


def load(blocks: Any, *index: Any) -> Any:
    """The lanes ``blocks[index]``, a copy. ``index`` has a number for each axis but the last, which has eight lanes.

    Raises
    ------
    TypeError, ValueError
        If the array has another dtype, number of axes or number of lanes, or is not contiguous.
    """
    if (each := _each(index)) is not None:
        return _joined(*(load(blocks, *one) for one in each))
    _check_blocks(blocks, index)
    if not isinstance(blocks, Table):
        return blocks[index].copy()
    pointer = _block_pointer(blocks, index)
    scalars = [blocks.read_one(pointer, lane) for lane in range(LANES)] if blocks.dtype.kind == "i" else None
    return Lanes(blocks.builder, blocks.dtype, blocks.read(pointer), scalars)


def store(blocks: Any, *index_and_value: Any) -> None:
    """``blocks[index] = value``: ``store(blocks, block, field, value)``.

    Raises
    ------
    TypeError, ValueError
        As ``load`` does, or if the value has another dtype than the array.
    """
    *numbers, value = index_and_value
    index = tuple(numbers)
    if (each := _each(index)) is not None:
        for one, part in zip(each, _halves(value), strict=True):
            store(blocks, *one, part)
        return
    _check_blocks(blocks, index)
    value = _of_dtype(blocks, value)
    if isinstance(blocks, Table):
        blocks.write(_block_pointer(blocks, index), value)
    else:
        blocks[index] = value


def _of_dtype(array: Any, value: Any, count: int = LANES) -> Any:
    """A value to be written, as an LLVM vector or as a NumPy array of so many lanes."""
    dtype = getattr(value, "dtype", None)
    if dtype is not None and dtype != array.dtype:
        raise TypeError(f"the value is {dtype}, the array {array.dtype}: convert the value with astype")
    if isinstance(array, Table):
        kind = LLVM_TYPES[array.dtype]
        like = Lanes(array.builder, array.dtype, ir.Constant(ir.VectorType(kind, count), ir.Undefined))
        return like.operand(value)
    return np.broadcast_to(np.asarray(value, dtype=array.dtype), count)


def _check_rows(rows: Any, index: Any, first: int, columns: int) -> None:
    _check(rows, 2)
    if index.dtype.kind != "i":
        raise TypeError(f"row numbers must be integer lanes, not {index.dtype}")
    if columns % LANES or columns <= 0 or first < 0:
        raise ValueError(f"columns are moved {LANES} at a time; asked for {columns} from {first} on")
    _extent(rows, 1, ">=", first + columns, f"rows must have at least {first + columns} columns")


def gather(rows: Any, index: Any, columns: int = LANES, first: int = 0) -> tuple[Any, ...]:
    """Columns of the eight rows that ``index`` names: the lanes ``rows[index, first + k]`` for k below ``columns``.

    Parameters
    ----------
    rows : array of shape (rows, at least first + columns), C-contiguous
    index : lanes of int32 or int64
    columns : how many columns, a multiple of eight
    first : the first of them

    Raises
    ------
    TypeError, ValueError
        If the array's dtype, number of axes or of columns does not fit, or it is not contiguous.
    """
    _check_rows(rows, index, first, columns)
    if not isinstance(rows, Table):
        return tuple(np.ascontiguousarray(rows[index, first : first + columns].T))
    pointers = _row_pointers(rows, index, first)
    lanes: list[Lanes] = []
    for start in range(0, columns, LANES):
        read = [rows.read(pointer, start) for pointer in pointers]
        lanes += [Lanes(rows.builder, rows.dtype, column) for column in _columns_of(rows.builder, read)]
    return tuple(lanes)


def scatter(rows: Any, index: Any, values: Any, first: int = 0, where: Any = None) -> None:
    """``rows[index, first + k] = values[k]`` for eight rows and all k, in the lanes where ``where`` holds: a mask, or integers that are not 0 there.

    If an index is repeated, the last lane's values stay. Other rows, and rows of other lanes, are not touched: in them
    index may name any row, such as that of a static body which other threads read.

    Raises
    ------
    TypeError, ValueError
        As ``gather`` does, or if a value has another dtype than the array.
    """
    _check_rows(rows, index, first, len(values))
    count = index.count if isinstance(index, Lanes) else len(index)
    columns = [_of_dtype(rows, value, count) for value in values]
    if not isinstance(rows, Table):
        written = np.broadcast_to(True if where is None else where, count)
        for lane in range(count):
            if written[lane]:
                rows[index[lane], first : first + len(columns)] = [column[lane] for column in columns]
        return
    pointers = _row_pointers(rows, index, first)
    if where is not None:
        pointers = _elsewhere(rows, pointers, where, len(columns))
    for start in range(0, len(columns), LANES):
        each = _rows_of(rows.builder, columns[start : start + LANES])
        for pointer, row in zip(pointers, each, strict=True):
            rows.write(pointer, row, start)


def _row_pointers(rows: Table, index: Lanes, first: int) -> list[Any]:
    """Pointers to a column of the rows."""
    builder = rows.builder
    pointers = []
    for number in index.scalars:
        row = builder.sext(number, _I64) if number.type != _I64 else number
        offset = builder.add(builder.mul(row, rows.shape[1]), ir.Constant(_I64, first))
        pointers.append(rows.element(offset))
    return pointers


def _elsewhere(rows: Table, pointers: list[Any], where: Any, columns: int) -> list[Any]:
    """The pointers, and for lanes that must not be written a pointer to unused memory: cheaper than eight branches."""
    builder = rows.builder
    with builder.goto_entry_block():
        unused = builder.alloca(LLVM_TYPES[rows.dtype], columns)
    if isinstance(where, Lanes):
        truths = [builder.icmp_signed("!=", number, ir.Constant(number.type, 0)) for number in where.scalars]
    else:
        mask = where.spread(len(pointers)).value
        truths = [builder.extract_element(mask, ir.Constant(_I32, lane)) for lane in range(len(pointers))]
    return [builder.select(truth, pointer, unused) for truth, pointer in zip(truths, pointers, strict=True)]


def _columns_of(builder: Any, rows: list[Any]) -> list[Any]:
    """The eight columns of eight rows, or of sixteen.

    Quarters of rows, four elements each, are transposed four by four, as many as a register holds; the shuffles are those that every x86 has as
    single instructions. Rows lie side by side beforehand so that one more shuffle puts the quarters of each column in order.
    """
    low: tuple[int, ...]
    high: tuple[int, ...]
    if len(rows) == LANES:
        parts = [_transpose_quads(builder, rows[start : start + 4]) for start in (0, 4)]
        low, high = (0, 2), (1, 3)
    else:
        parts = [
            _transpose_quads(
                builder, [_quads(builder, rows[i], rows[i + 4], 0, 1, 2, 3) for i in range(start, start + 4)]
            )
            for start in (0, 8)
        ]
        low, high = (0, 2, 4, 6), (1, 3, 5, 7)
    columns = list(zip(*parts, strict=True))
    return [_quads(builder, x, y, *picked) for picked in (low, high) for x, y in columns]


def _rows_of(builder: Any, columns: list[Any]) -> list[Any]:
    """The eight or sixteen rows of eight columns: ``_columns_of`` backwards."""
    if columns[0].type.count == LANES:
        return _columns_of(builder, columns)
    rows = []
    for half in ((0, 1, 4, 5), (2, 3, 6, 7)):
        joined = [_quads(builder, columns[k], columns[k + 4], *half) for k in range(4)]
        turned = _transpose_quads(builder, joined)
        rows += [_quads(builder, row, row, *picked) for picked in ((0, 2), (1, 3)) for row in turned]
    return rows


def _quads(builder: Any, a: Any, b: Any, *picked: int) -> Any:
    """Quarters of four elements out of two vectors, numbered through."""
    return pick(builder, a, b, [4 * quad + k for quad in picked for k in range(4)])


def _transpose_quads(builder: Any, rows: list[Any]) -> list[Any]:
    """Of four vectors, each four by four elements transposed: pairs of elements are exchanged, then pairs of pairs."""
    count = rows[0].type.count

    def shuffle(x: Any, y: Any, *picked: int) -> Any:
        lanes = [quad + k % 4 + (count if k >= 4 else 0) for quad in range(0, count, 4) for k in picked]
        return pick(builder, x, y, lanes)

    a, b, c, d = rows
    low, high = [(shuffle(x, y, 0, 4, 1, 5), shuffle(x, y, 2, 6, 3, 7)) for x, y in ((a, b), (c, d))]
    return [shuffle(x, y, *picked) for x, y in zip(low, high, strict=True) for picked in ((0, 1, 4, 5), (2, 3, 6, 7))]
