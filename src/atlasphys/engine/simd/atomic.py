"""What threads need to work in step: integers that several of them read and write, ways of waiting, a clock.

Compiled, each function is one instruction or one call to the operating system. Called from Python, where there is but one thread, they do
the same to the array. All orderings are sequentially consistent: what a thread wrote before it set an entry is seen by those that see the entry.
"""

from __future__ import annotations

import ctypes
import os
import platform
import time
from collections.abc import Callable
from typing import Any

import llvmlite.binding as llvm
from llvmlite import ir
from numba.core import cgutils
from numba.core import types as _types
from numba.core.typing.templates import infer, infer_global, make_intrinsic_template

types: Any = _types  # Numba's own annotations are incomplete

_I32, _I64 = ir.IntType(32), ir.IntType(64)
_ALIGNMENT = 8


def compiled_as(function: Callable[..., Any]) -> Callable[[Any], Any]:
    """Decorator of a definition (typing context, argument types → signature, code generator): what compiled kernels run for ``function``."""

    def register(definition: Any) -> Any:
        template = make_intrinsic_template(function, definition, function.__name__)
        infer(template)
        infer_global(function, types.Function(template))
        return definition

    return register


def atomic_load(array: Any, index: int) -> int:
    """An entry of an array of int64."""
    return int(array[index])


def atomic_store(array: Any, index: int, value: int) -> None:
    """Set an entry of an array of int64."""
    array[index] = value


def atomic_add(array: Any, index: int, value: int) -> int:
    """Add to an entry of an array of int64; return what it was before."""
    before = int(array[index])
    array[index] = before + value
    return before


def pause() -> None:
    """Tell the CPU that this thread only waits: some ten nanoseconds."""


def give_way() -> None:
    """Let another thread have this CPU, if one wants it."""


def nap(microseconds: int) -> None:
    """Leave the CPU alone for so long or, as systems do, some 60 µs longer; on Windows for one millisecond or more."""


def now() -> int:
    """A clock that only goes forward [ns]."""
    return time.perf_counter_ns()


def _pointer(context: Any, builder: Any, kind: Any, array: Any, index: Any) -> Any:
    data = context.make_array(kind)(context, builder, array).data
    return builder.gep(data, [index])


def _check(array: Any) -> None:
    if not isinstance(array, types.Array) or array.dtype != types.int64 or array.ndim != 1 or array.layout != "C":
        raise TypeError(f"atomic entries are those of a contiguous int64 array, not of {array}")


@compiled_as(atomic_load)
def _load(context: Any, array: Any, index: Any) -> Any:
    _check(array)

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        pointer = _pointer(context, builder, array, values[0], values[1])
        return builder.load_atomic(pointer, ordering="seq_cst", align=_ALIGNMENT)

    return types.int64(array, types.int64), generate


@compiled_as(atomic_store)
def _store(context: Any, array: Any, index: Any, value: Any) -> Any:
    _check(array)

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        pointer = _pointer(context, builder, array, values[0], values[1])
        builder.store_atomic(values[2], pointer, ordering="seq_cst", align=_ALIGNMENT)
        return context.get_dummy_value()

    return types.none(array, types.int64, types.int64), generate


@compiled_as(atomic_add)
def _add(context: Any, array: Any, index: Any, value: Any) -> Any:
    _check(array)

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return builder.atomic_rmw("add", _pointer(context, builder, array, values[0], values[1]), values[2], "seq_cst")

    return types.int64(array, types.int64, types.int64), generate


def _pause_instruction() -> tuple[str, list[Any]] | None:
    """LLVM intrinsic of this CPU's instruction for loops that wait, and its arguments."""
    machine = platform.machine().lower()
    if machine in ("x86_64", "amd64", "i386", "i686", "x86"):
        return "llvm.x86.sse2.pause", []
    if machine in ("aarch64", "arm64"):
        return "llvm.aarch64.hint", [ir.Constant(_I32, 1)]
    return None


@compiled_as(pause)
def _pause(context: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        instruction = _pause_instruction()
        if instruction is not None:
            name, arguments = instruction
            kind = ir.FunctionType(ir.VoidType(), [a.type for a in arguments])
            builder.call(cgutils.get_or_insert_function(builder.module, kind, name), arguments)
        return context.get_dummy_value()

    return types.none(), generate


def _system_functions() -> tuple[Any, Any, Any]:
    """The operating system's functions to yield, to sleep and to read a clock."""
    if _WINDOWS:
        kernel32 = ctypes.WinDLL("kernel32")  # type: ignore[attr-defined,unused-ignore]
        return kernel32.SwitchToThread, kernel32.Sleep, kernel32.QueryPerformanceCounter
    library = ctypes.CDLL(None)
    return library.sched_yield, library.usleep, library.clock_gettime


_WINDOWS = os.name == "nt"
_YIELD, _SLEEP, _CLOCK = "atlasphys_yield", "atlasphys_sleep", "atlasphys_clock"
for _name, _function in zip((_YIELD, _SLEEP, _CLOCK), _system_functions(), strict=True):
    llvm.add_symbol(_name, ctypes.cast(_function, ctypes.c_void_p).value)


def _call_system(builder: Any, name: str, *arguments: Any) -> None:
    kind = ir.FunctionType(_I32, [argument.type for argument in arguments])
    builder.call(cgutils.get_or_insert_function(builder.module, kind, name), arguments)


@compiled_as(give_way)
def _give_way(context: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        _call_system(builder, _YIELD)
        return context.get_dummy_value()

    return types.none(), generate


@compiled_as(nap)
def _nap(context: Any, microseconds: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        _call_system(builder, _SLEEP, ir.Constant(_I32, 1) if _WINDOWS else builder.trunc(values[0], _I32))
        return context.get_dummy_value()

    return types.none(types.int64), generate


@compiled_as(now)
def _now(context: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        time_type = ir.ArrayType(_I64, 2)
        slot = cgutils.alloca_once(builder, time_type)
        if _WINDOWS:
            _call_system(builder, _CLOCK, slot)
            return builder.mul(builder.extract_value(builder.load(slot), 0), ir.Constant(_I64, 100))  # 10 MHz
        _call_system(builder, _CLOCK, ir.Constant(_I32, time.CLOCK_MONOTONIC), slot)
        read = builder.load(slot)
        seconds = builder.mul(builder.extract_value(read, 0), ir.Constant(_I64, 10**9))
        return builder.add(seconds, builder.extract_value(read, 1))

    return types.int64(), generate
