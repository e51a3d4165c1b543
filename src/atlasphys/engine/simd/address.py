"""Routines with their arguments as addresses, which another thread can call without knowing their types, and without Python being asked."""

from __future__ import annotations

import itertools
import threading
from typing import Any

from llvmlite import ir
from numba.core import cgutils
from numba.core import types as _types

from atlasphys.engine.simd.atomic import compiled_as

types: Any = _types  # Numba's own annotations are incomplete

_I64 = ir.IntType(64)
_CALLED = ir.FunctionType(_I64, [_I64] * 4)

# What stands for addresses in plain Python
_python_code: dict[int, Any] = {}
_python_places: dict[tuple[int, int], int] = {}  # of each thread and routine
_python_data: dict[int, Any] = {}
_numbers = itertools.count(1)


def address_call(routine: Any, arguments: Any) -> tuple[int, int]:
    """Two addresses, of code and of data, with which ``call_address`` calls ``routine(arguments, i, j, k)``. They hold until the function that asks
    for them returns; that of the code as long as the process lives. ``arguments`` is a tuple, the other three are integers."""
    code = id(routine)
    data = _python_places.setdefault((threading.get_ident(), code), next(_numbers))
    _python_code[code], _python_data[data] = routine, arguments
    return code, data


def call_address(code: int, data: int, i: int, j: int, k: int) -> int:
    """Call what ``address_call`` was given. Returns 1 if it raised an exception, else 0."""
    _python_code[code](_python_data[data], i, j, k)
    return 0


@compiled_as(address_call)
def _address_call(typing: Any, routine: Any, arguments: Any) -> Any:
    routine_signature = typing.resolve_function_type(routine, (arguments, *[types.int64] * 3), {})
    compiled = routine.dispatcher.overloads[tuple(routine_signature.args)]

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        data = values[1]
        context.active_code_library.add_linking_library(compiled.library)
        function = ir.Function(builder.module, _CALLED, builder.module.get_unique_name("address_call"))
        function.linkage = "internal"
        inner = ir.IRBuilder(function.append_basic_block())
        unpacked = inner.load(inner.inttoptr(function.args[0], data.type.as_pointer()))
        status, _ = context.call_internal_no_propagate(
            inner, compiled.fndesc, routine_signature, (unpacked, *function.args[1:])
        )
        inner.ret(inner.zext(status.is_error, _I64))
        slot = cgutils.alloca_once_value(builder, data)
        addresses = (builder.ptrtoint(function, _I64), builder.ptrtoint(slot, _I64))
        return context.make_tuple(builder, signature.return_type, addresses)

    return types.UniTuple(types.int64, 2)(routine, arguments), generate


@compiled_as(call_address)
def _call_address(typing: Any, code: Any, data: Any, i: Any, j: Any, k: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return builder.call(builder.inttoptr(values[0], _CALLED.as_pointer()), values[1:])

    return types.int64(*[types.int64] * 5), generate
