"""Eight values computed at once, and eight truths about them.

``Lanes`` and ``Mask`` exist only while a kernel is being compiled: their operators emit LLVM vector instructions. In the
NumPy reading of the same body, arrays of eight stand in their place, and the functions below take either.

Arithmetic is strict IEEE: no instruction carries a fast-math flag, so nothing is fused or reordered, and both readings
give the same bits on every CPU. Only the sign and payload of a NaN are not fixed by IEEE, and may differ.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir

LANES = 8

LLVM_TYPES = {
    np.dtype(np.float32): ir.FloatType(),
    np.dtype(np.float64): ir.DoubleType(),
    np.dtype(np.int32): ir.IntType(32),
    np.dtype(np.int64): ir.IntType(64),
}
_BOOL, _I32 = ir.IntType(1), ir.IntType(32)


def _no_branch(self: Any) -> bool:
    raise TypeError(
        "a kernel body cannot branch on lanes (if, and, or, not, chained comparison): "
        "use select(mask, a, b) and the operators & | ~ on masks"
    )


def _no_in_place(self: Any, other: Any) -> Any:
    raise TypeError("write x = x + y, not x += y: the NumPy reading would change every name of the array")


class Lanes:
    """Eight numbers of one dtype, float32, float64, int32 or int64, in a vector register; or sixteen, of two blocks side by side (``beside``).

    Python numbers take the lanes' dtype. Numbers of another dtype are refused: ``lanes.astype(dtype)`` converts.
    """

    __array_ufunc__ = None  # NumPy scalars leave their operators to these
    __hash__ = None  # type: ignore[assignment]
    __bool__ = _no_branch
    __iadd__ = __isub__ = __imul__ = __itruediv__ = __iand__ = __ior__ = _no_in_place

    def __init__(self, builder: Any, dtype: np.dtype[Any], value: Any, scalars: list[Any] | None = None) -> None:
        self.builder, self.dtype, self.value, self._scalars = builder, dtype, value, scalars

    @property
    def scalars(self) -> list[Any]:
        """The LLVM value of each number by itself. Of those that were loaded as such it is cheaper than taking the vector apart."""
        if self._scalars is None:
            self._scalars = [
                self.builder.extract_element(self.value, ir.Constant(_I32, lane)) for lane in range(self.count)
            ]
        return self._scalars

    @property
    def count(self) -> int:
        """Number of lanes."""
        return int(self.value.type.count)

    @property
    def is_float(self) -> bool:
        """Whether the lanes hold floating-point numbers."""
        return self.dtype.kind == "f"

    def constant(self, number: Any) -> Any:
        """LLVM value of a number in every lane, in the lanes' dtype."""
        with np.errstate(over="ignore"):  # 1e300 is infinite in float32, as in NumPy
            number = self.dtype.type(number).item()
        return ir.Constant(self.value.type, [number] * self.count)

    def operand(self, other: Any) -> Any:
        """LLVM value of the other operand.

        Raises
        ------
        TypeError
            If it is not a number or has a dtype of its own that differs.
        """
        if isinstance(other, (Lanes, np.generic)):
            if other.dtype != self.dtype:
                raise TypeError(f"operands are {self.dtype} and {other.dtype}: convert one of them with astype")
            return other.widened(self.count).value if isinstance(other, Lanes) else self.constant(other)
        if isinstance(other, bool) or not isinstance(other, (int, float)):
            raise TypeError(f"an operand of lanes must be lanes or a number, not {type(other).__name__}")
        if isinstance(other, float) and not self.is_float:
            raise TypeError(f"{other!r} meets lanes of {self.dtype}: convert them with astype first")
        return self.constant(other)

    def like(self, value: Any) -> Lanes:
        """Lanes of the same dtype with another LLVM value."""
        return Lanes(self.builder, self.dtype, value)

    def widened(self, count: int) -> Lanes:
        """The same numbers for each of two blocks side by side, if ``count`` is theirs."""
        return self if self.count >= count else self.like(repeat(self.builder, self.value, count))

    def _meet(self, other: Any) -> tuple[Any, Any]:
        """LLVM values of both operands, of the same number of lanes."""
        wide = self.widened(other.count) if isinstance(other, Lanes) else self
        return wide.value, wide.operand(other)

    def _arithmetic(self, name: str, other: Any, swapped: bool = False) -> Lanes:
        left, right = self._meet(other)
        if swapped:
            left, right = right, left
        return self.like(getattr(self.builder, "f" + name if self.is_float else name)(left, right))

    def _bits(self, name: str, other: Any) -> Lanes:
        if self.is_float:
            raise TypeError(f"bit operations need integer lanes, not {self.dtype}")
        return self.like(getattr(self.builder, name)(*self._meet(other)))

    def _compare(self, sign: str, other: Any) -> Mask:
        left, right = self._meet(other)
        if not self.is_float:
            compare = self.builder.icmp_signed
        elif sign == "!=":
            compare = self.builder.fcmp_unordered  # NaN differs from everything
        else:
            compare = self.builder.fcmp_ordered
        return Mask(self.builder, compare(sign, left, right))

    def __add__(self, other: Any) -> Lanes:
        return self._arithmetic("add", other)

    def __radd__(self, other: Any) -> Lanes:
        return self._arithmetic("add", other, swapped=True)

    def __sub__(self, other: Any) -> Lanes:
        return self._arithmetic("sub", other)

    def __rsub__(self, other: Any) -> Lanes:
        return self._arithmetic("sub", other, swapped=True)

    def __mul__(self, other: Any) -> Lanes:
        return self._arithmetic("mul", other)

    def __rmul__(self, other: Any) -> Lanes:
        return self._arithmetic("mul", other, swapped=True)

    def __truediv__(self, other: Any) -> Lanes:
        return self._divide(other)

    def __rtruediv__(self, other: Any) -> Lanes:
        return self._divide(other, swapped=True)

    def _divide(self, other: Any, swapped: bool = False) -> Lanes:
        if not self.is_float:
            raise TypeError(f"division needs floating-point lanes, not {self.dtype}")
        return self._arithmetic("div", other, swapped)

    def __neg__(self) -> Lanes:
        return self.like((self.builder.fneg if self.is_float else self.builder.neg)(self.value))

    def __and__(self, other: Any) -> Lanes:
        return self._bits("and_", other)

    def __or__(self, other: Any) -> Lanes:
        return self._bits("or_", other)

    __rand__, __ror__ = __and__, __or__

    def __lt__(self, other: Any) -> Mask:
        return self._compare("<", other)

    def __le__(self, other: Any) -> Mask:
        return self._compare("<=", other)

    def __gt__(self, other: Any) -> Mask:
        return self._compare(">", other)

    def __ge__(self, other: Any) -> Mask:
        return self._compare(">=", other)

    def __eq__(self, other: object) -> Mask:  # type: ignore[override]
        return self._compare("==", other)

    def __ne__(self, other: object) -> Mask:  # type: ignore[override]
        return self._compare("!=", other)

    def astype(self, dtype: Any) -> Lanes:
        """The numbers in another dtype, rounded to the nearest. From floating point to integer is refused: out of
        range it is undefined."""
        dtype = np.dtype(dtype)
        if dtype == self.dtype:
            return self
        target = ir.VectorType(LLVM_TYPES[dtype], self.count)
        wider = dtype.itemsize > self.dtype.itemsize
        if self.is_float and dtype.kind == "f":
            convert = self.builder.fpext if wider else self.builder.fptrunc
        elif dtype.kind == "f":
            convert = self.builder.sitofp
        elif self.is_float:
            raise TypeError(f"{self.dtype} to {dtype} is undefined out of range")
        else:
            convert = self.builder.sext if wider else self.builder.trunc
        return Lanes(self.builder, dtype, convert(self.value, target))


class Mask:
    """Eight truths, or one for all lanes (an argument, or the answer of ``any_lane`` and ``all_lanes``)."""

    __hash__ = None  # type: ignore[assignment]
    __bool__ = _no_branch
    __iand__ = __ior__ = _no_in_place

    def __init__(self, builder: Any, value: Any) -> None:
        self.builder, self.value = builder, value

    @property
    def is_uniform(self) -> bool:
        """Whether one truth holds for all lanes."""
        return bool(self.value.type == _BOOL)

    def _combine(self, name: str, other: Any) -> Mask:
        if not isinstance(other, Mask):
            raise TypeError(f"a mask combines with masks, not with {type(other).__name__}")
        left, right = self, other
        if left.value.type != right.value.type:
            count = max(mask.value.type.count for mask in (left, right) if not mask.is_uniform)
            left, right = left.spread(count), right.spread(count)
        return Mask(self.builder, getattr(self.builder, name)(left.value, right.value))

    def spread(self, count: int = LANES) -> Mask:
        """The mask with a truth for each of so many lanes."""
        if self.is_uniform:
            return Mask(self.builder, splat(self.builder, self.value, count))
        return self if self.value.type.count >= count else Mask(self.builder, repeat(self.builder, self.value, count))

    def __and__(self, other: Any) -> Mask:
        return self._combine("and_", other)

    def __or__(self, other: Any) -> Mask:
        return self._combine("or_", other)

    def __eq__(self, other: object) -> Any:
        raise TypeError("masks are not compared: use the operators & | ~")

    def __invert__(self) -> Mask:
        return Mask(self.builder, self.builder.not_(self.value))


def splat(builder: Any, scalar: Any, count: int = LANES) -> Any:
    """LLVM vector with a scalar in every lane."""
    empty = ir.Constant(ir.VectorType(scalar.type, count), ir.Undefined)
    first = builder.insert_element(empty, scalar, ir.Constant(_I32, 0))
    return pick(builder, first, empty, [0] * count)


def repeat(builder: Any, vector: Any, count: int) -> Any:
    """LLVM vector of ``count`` lanes in which a shorter one is repeated."""
    return pick(builder, vector, vector, [lane % vector.type.count for lane in range(count)])


def pick(builder: Any, first: Any, second: Any, lanes: list[int]) -> Any:
    """LLVM vector of the lanes of two others, numbered through, that are listed."""
    return builder.shuffle_vector(first, second, ir.Constant(ir.VectorType(_I32, len(lanes)), lanes))


def select(mask: Any, if_true: Any, if_false: Any) -> Any:
    """Lane-wise choice: the branch of a kernel body. Both sides are computed.

    Raises
    ------
    TypeError
        If both sides are plain Python numbers, which have no dtype (``full`` gives them one), or their dtypes differ.
    """
    typed = if_true if hasattr(if_true, "dtype") else if_false
    if not hasattr(typed, "dtype"):
        raise TypeError("select between two Python numbers has no dtype: give one as full(like, number)")
    if not isinstance(mask, Mask):
        for side in (if_true, if_false):
            if getattr(side, "dtype", typed.dtype) != typed.dtype:
                raise TypeError(f"sides are {typed.dtype} and {side.dtype}: convert one of them with astype")
        return np.where(mask, if_true, if_false)
    if not isinstance(typed, Lanes):
        raise TypeError(f"select with a mask needs lanes, not {type(typed).__name__}")
    counts = [side.count for side in (if_true, if_false) if isinstance(side, Lanes)]
    typed = typed.widened(max(*counts, 1 if mask.is_uniform else mask.value.type.count))
    truth = mask.value if mask.is_uniform else mask.spread(typed.count).value
    return typed.like(mask.builder.select(truth, typed.operand(if_true), typed.operand(if_false)))


def minimum(a: Any, b: Any) -> Any:
    """``a`` where a < b, else ``b``: so ``b`` where either is NaN or both are zeros."""
    return select(a < b, a, b)


def maximum(a: Any, b: Any) -> Any:
    """``a`` where a > b, else ``b``: so ``b`` where either is NaN or both are zeros."""
    return select(a > b, a, b)


def sqrt(x: Any) -> Any:
    """Square root, correctly rounded; NaN below zero."""
    return _unary("sqrt", x) if isinstance(x, Lanes) else np.sqrt(x)


def absolute(x: Any) -> Any:
    """Absolute value of floating-point lanes: the sign bit cleared."""
    return _unary("fabs", x) if isinstance(x, Lanes) else np.abs(x)


def _unary(name: str, x: Lanes) -> Lanes:
    if not x.is_float:
        raise TypeError(f"{name} needs floating-point lanes, not {x.dtype}")
    suffix = f"v{x.count}f{8 * x.dtype.itemsize}"
    function = x.builder.module.declare_intrinsic(
        f"llvm.{name}.{suffix}", (), ir.FunctionType(x.value.type, [x.value.type])
    )
    return x.like(x.builder.call(function, [x.value]))


def any_lane(mask: Any) -> Any:
    """Whether the mask holds in at least one lane."""
    return _reduce(mask, "!=", 0) if isinstance(mask, Mask) else np.any(mask)


def all_lanes(mask: Any) -> Any:
    """Whether the mask holds in every lane."""
    return _reduce(mask, "==", -1) if isinstance(mask, Mask) else np.all(mask)


def _reduce(mask: Mask, sign: str, bits: int) -> Mask:
    if mask.is_uniform:
        return mask
    packed = ir.IntType(mask.value.type.count)
    builder = mask.builder
    return Mask(builder, builder.icmp_unsigned(sign, builder.bitcast(mask.value, packed), ir.Constant(packed, bits)))


def full(like: Any, number: float) -> Any:
    """A number in the dtype of other lanes, in every lane."""
    return like.like(like.constant(number)) if isinstance(like, Lanes) else like.dtype.type(number)


def when(condition: Any, action: Callable[[], None]) -> None:
    """Call ``action()`` only if the condition, one truth for all lanes, holds: to leave out what no lane needs.

    What the action computes stays inside it, but for what it stores.

    Raises
    ------
    TypeError
        If the condition differs from lane to lane: ``any_lane`` and ``all_lanes`` make one truth of a mask.
    """
    if isinstance(condition, Mask):
        if not condition.is_uniform:
            raise TypeError("when needs one truth for all lanes: any_lane(mask) or all_lanes(mask)")
        with condition.builder.if_then(condition.value):
            action()
    elif np.ndim(condition):
        raise TypeError("when needs one truth for all lanes: any_lane(mask) or all_lanes(mask)")
    elif condition:
        action()
