"""The decorator that makes a plain Python function over lanes callable from compiled kernels.

While Numba compiles a kernel that calls the function, the function's body runs once, on ``Lanes`` that emit LLVM vector
instructions into the place of the call. Numba types a single call, however long the body. Called from Python, the body
runs on NumPy arrays instead.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils
from numba.core import types as _types
from numba.core.typing.templates import infer, infer_global, make_intrinsic_template
from numba.np.numpy_support import as_dtype

from atlasphys.engine.simd.by_address import TableType, read_field
from atlasphys.engine.simd.lanes import LANES, LLVM_TYPES, Lanes, Mask, splat
from atlasphys.engine.simd.memory import Index, Table

_I64 = ir.IntType(64)

types: Any = _types  # Numba's own annotations are incomplete


def simd_kernel(body: Callable[..., Any]) -> SimdKernel:
    """Make a kernel body over lanes callable: in a compiled ``@kernel`` as vector code, from Python as NumPy code.

    The body takes positional arguments. What it sees of each, compiled:

    - an array: a table for ``load``, ``store``, ``gather`` and ``scatter``;
    - an integer: an index; a literal stays a Python integer, fit for ``range``;
    - a float: that number in every lane, in the kernel's dtype, which is the narrowest floating-point dtype among the
      arrays (positions are double also in single precision);
    - a bool: a mask, the same for all lanes;
    - a tuple or NamedTuple of these: the same tuple of what it holds; None: None.

    It returns nothing, or, annotated ``-> bool``, one truth, the answer of ``any_lane`` or ``all_lanes``, or, annotated
    ``-> int``, a mask, which the driver gets as an integer: bit k is the truth of lane k.

    Raises
    ------
    TypeError
        If the body takes keyword-only or a variable number of arguments.
    """
    return SimdKernel(body)


class SimdKernel:
    """A kernel body over lanes; ``simd_kernel`` makes it. Calling it from Python runs the body on NumPy arrays."""

    def __init__(self, body: Callable[..., Any]) -> None:
        functools.update_wrapper(self, body)
        self.body = body
        signature = inspect.signature(body)
        parameters = list(signature.parameters.values())
        if any(p.kind not in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD) for p in parameters):
            raise TypeError(f"{body.__name__}: a kernel body takes positional arguments only")
        self.returns_truth = signature.return_annotation in (bool, "bool")
        self.returns_bits = signature.return_annotation in (int, "int")

        def definition(context: Any, *arguments: Any) -> Any:
            answer = types.boolean if self.returns_truth else types.int64 if self.returns_bits else types.none
            return answer(*arguments), self._emit

        # Numba matches calls against this signature, not against the star.
        context_parameter = inspect.Parameter("context", inspect.Parameter.POSITIONAL_ONLY)
        positional = [p.replace(kind=p.POSITIONAL_ONLY, annotation=p.empty) for p in parameters]
        definition.__signature__ = inspect.Signature([context_parameter, *positional])  # type: ignore[attr-defined]
        template = make_intrinsic_template(self, definition, body.__name__, prefer_literal=True)
        infer(template)
        infer_global(self, types.Function(template))

    def __call__(self, *arguments: Any) -> Any:
        """Run the body on NumPy arrays: the oracle of the compiled kernel, and what runs where compiling is disabled."""
        real = _narrowest(array.dtype for array in _arrays(arguments))
        with np.errstate(all="ignore"):  # idle lanes divide by zero
            result = self.body(*(_numpy_argument(real, argument) for argument in arguments))
        if self.returns_bits:
            return int(np.packbits(np.broadcast_to(result, LANES), bitorder="little")[0])
        return bool(result) if self.returns_truth else None

    def _emit(self, context: Any, builder: Any, signature: Any, values: Any) -> Any:
        """Trace the body into a basic block of its own, behind one that checks the extents of the arrays it uses."""
        checks = ir.IRBuilder(builder.block)
        block = builder.append_basic_block(self.body.__name__)
        builder.position_at_end(block)
        real = _narrowest(as_dtype(array.dtype) for array in _array_types(signature.args))
        tracer = _Tracer(context, builder, checks, real, self.body.__name__)
        result = self.body(*map(tracer.argument, signature.args, values))
        checks.branch(block)
        if self.returns_bits:
            if not isinstance(result, Mask):
                raise TypeError(f"{self.body.__name__} must return a mask")
            return builder.zext(builder.bitcast(result.spread().value, ir.IntType(LANES)), _I64)
        if not self.returns_truth:
            if result is not None:
                raise TypeError(
                    f"{self.body.__name__} returns a value: annotate it -> bool or -> int, or store what it computes"
                )
            return context.get_dummy_value()
        if not (isinstance(result, Mask) and result.is_uniform):
            raise TypeError(f"{self.body.__name__} must return any_lane(mask) or all_lanes(mask)")
        return result.value


class _Fields:
    """A table that is passed by address, of which only what the body uses is read."""

    def __init__(self, tracer: _Tracer, kind: TableType, address: Any) -> None:
        self._read = functools.partial(tracer.field, kind, address)

    def __getattr__(self, name: str) -> Any:
        value = self._read(name)
        setattr(self, name, value)
        return value


class _Tracer:
    """Makes traced arguments of LLVM values."""

    def __init__(self, context: Any, builder: Any, checks: Any, real: np.dtype[Any], name: str) -> None:
        self.context, self.builder, self.checks, self.real, self.name = context, builder, checks, real, name
        self.checked: set[Any] = set()

    def argument(self, kind: Any, value: Any) -> Any:
        """The traced form of an argument of a Numba type."""
        builder, before = self.builder, self.checks
        if isinstance(kind, types.Array):
            return self.table(kind, value)
        if isinstance(kind, types.BaseTuple):
            parts = list(map(self.argument, kind.types, cgutils.unpack_tuple(before, value)))
            return kind.instance_class(*parts) if hasattr(kind, "instance_class") else tuple(parts)
        if isinstance(kind, TableType):
            return _Fields(self, kind, value)
        if isinstance(kind, types.IntegerLiteral):
            return kind.literal_value
        if isinstance(kind, types.NoneType):
            return None
        if isinstance(kind, (types.Boolean, types.BooleanLiteral)):
            return Mask(builder, self.context.cast(before, value, kind, types.boolean))
        if isinstance(kind, types.Integer):
            return Index(builder, self.context.cast(before, value, kind, types.int64))
        if isinstance(kind, types.Float):
            target = types.float32 if self.real == np.float32 else types.float64
            return Lanes(builder, self.real, splat(before, self.context.cast(before, value, kind, target)))
        raise TypeError(f"{self.name}: a kernel body cannot take an argument of type {kind}")

    def field(self, kind: TableType, address: Any, name: str) -> Any:
        """The traced form of a field."""
        return self.argument(kind.fields[name], read_field(self.context, self.checks, kind, address, name))

    def table(self, kind: Any, value: Any) -> Table:
        """The traced form of an array."""
        array = self.context.make_array(kind)(self.context, self.checks, value)
        shape = cgutils.unpack_tuple(self.checks, array.shape, kind.ndim)
        return Table(self.builder, as_dtype(kind.dtype), array.data, shape, kind.layout == "C", self.require)

    def require(self, extent: Any, sign: str, number: int, message: str) -> None:
        """Have the kernel raise ValueError unless ``extent sign number`` holds."""
        if (extent, sign, number) in self.checked:
            return
        self.checked.add((extent, sign, number))
        fits = self.checks.icmp_signed(sign, extent, ir.Constant(_I64, number))
        with self.checks.if_then(self.checks.not_(fits), likely=False):
            self.context.call_conv.return_user_exc(self.checks, ValueError, (f"{self.name}: {message}",))


def _narrowest(dtypes: Iterator[np.dtype[Any]]) -> np.dtype[Any]:
    """The dtype of a kernel's floats: the narrowest that its arrays have."""
    floats = [dtype for dtype in dtypes if dtype in LLVM_TYPES and dtype.kind == "f"]
    return min(floats, key=lambda dtype: dtype.itemsize, default=np.dtype(np.float64))


def _arrays(arguments: tuple[Any, ...]) -> Iterator[np.ndarray[Any, Any]]:
    for argument in arguments:
        if isinstance(argument, np.ndarray):
            yield argument
        elif isinstance(argument, tuple):
            yield from _arrays(argument)


def _array_types(kinds: Any) -> Iterator[Any]:
    for kind in kinds:
        if isinstance(kind, types.Array):
            yield kind
        elif isinstance(kind, types.BaseTuple):
            yield from _array_types(kind.types)
        elif isinstance(kind, TableType):
            yield from _array_types(kind.kinds)


def _numpy_argument(real: np.dtype[Any], argument: Any) -> Any:
    """An argument as the NumPy reading sees it: floats in the kernel's dtype, truths as NumPy's."""
    if isinstance(argument, tuple):
        parts = [_numpy_argument(real, part) for part in argument]
        return type(argument)(*parts) if hasattr(argument, "_fields") else tuple(parts)
    if isinstance(argument, (bool, np.bool_)):
        return np.bool_(argument)
    if isinstance(argument, (float, np.floating)):
        return real.type(argument)
    return argument
