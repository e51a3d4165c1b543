"""Instructions of the processor that Python has no operator for: which bits are set, and memory that is soon wanted."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core import cgutils
from numba.core import types as _types

from atlasphys.engine.simd.atomic import compiled_as

types: Any = _types  # Numba's own annotations are incomplete

_BYTE, _I32 = ir.IntType(8), ir.IntType(32)


def trailing_ones(bits: Any) -> int:
    """Number of ones below the lowest zero of a uint64."""
    zeros = ~int(bits) & (1 << 64) - 1
    return (zeros & -zeros).bit_length() - 1 if zeros else 64


@compiled_as(trailing_ones)
def _trailing_ones(typing: Any, bits: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return builder.cttz(builder.not_(values[0]), ir.Constant(ir.IntType(1), 0))

    return types.int64(types.uint64), generate


def fetch(table: Any, row: int, column: int) -> None:
    """Have the cache line of an entry of a table brought near, to the second level, since it is soon wanted."""


@compiled_as(fetch)
def _fetch(typing: Any, table: Any, row: Any, column: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        array = context.make_array(table)(context, builder, values[0])
        strides = cgutils.unpack_tuple(builder, array.strides, table.ndim)
        offset = builder.add(builder.mul(values[1], strides[0]), builder.mul(values[2], strides[1]))
        place = cgutils.pointer_add(builder, array.data, offset, _BYTE.as_pointer())
        kind = ir.FunctionType(ir.VoidType(), [_BYTE.as_pointer(), _I32, _I32, _I32])
        function = cgutils.get_or_insert_function(builder.module, kind, "llvm.prefetch.p0i8")
        builder.call(function, [place, *(ir.Constant(_I32, number) for number in (0, 2, 1))])
        return context.get_dummy_value()

    return types.none(table, types.int64, types.int64), generate
