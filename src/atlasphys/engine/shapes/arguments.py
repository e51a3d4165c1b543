"""Checks of numbers and vectors given by the user. Each returns plain floats or raises InvalidArgumentError."""

import math
import reprlib
from collections.abc import Sequence
from numbers import Real

import numpy as np

from atlasphys.errors import InvalidArgumentError

SMALLEST_LENGTH, LARGEST_LENGTH = 1e-6, 1e6
"""Least and greatest size of a shape [m]. Between them the inertia of a body of any usual density (it grows with the
fifth power of the size) and its inverse are normal numbers in single precision; so are products of four lengths in
the narrow phase."""


def invalid(name: str, wanted: str, value: object) -> InvalidArgumentError:
    """The error that says what was given and what would be right."""
    return InvalidArgumentError(f"{name} must be {wanted} (got {reprlib.repr(value)})")


def number(name: str, value: object, wanted: str = "a finite number") -> float:
    """A finite number; bool is not taken for one."""
    if not isinstance(value, Real) or isinstance(value, bool):
        raise invalid(name, wanted, value)
    try:
        result = float(value)
    except (OverflowError, ValueError):
        raise invalid(name, wanted, value) from None
    if not math.isfinite(result):
        raise invalid(name, wanted, value)
    return result


def length(name: str, value: object) -> float:
    """A size between SMALLEST_LENGTH and LARGEST_LENGTH."""
    wanted = f"a length between {SMALLEST_LENGTH:g} and {LARGEST_LENGTH:g} m"
    result = number(name, value, wanted)
    if not SMALLEST_LENGTH <= result <= LARGEST_LENGTH:
        raise invalid(name, wanted, value)
    return result


def entries(name: str, value: object, count: int, wanted: str) -> tuple[object, ...]:
    """The entries of a sequence or array of ``count``."""
    if isinstance(value, (str, bytes)) or not isinstance(value, (Sequence, np.ndarray)):
        raise invalid(name, wanted, value)
    if (isinstance(value, np.ndarray) and value.ndim == 0) or len(value) != count:
        raise invalid(name, wanted, value)
    return tuple(value)


def vector(name: str, value: object) -> tuple[float, float, float]:
    """Three finite numbers."""
    wanted = "three finite numbers (x, y, z)"
    x, y, z = (number(f"{name}[{i}]", entry) for i, entry in enumerate(entries(name, value, 3, wanted)))
    return x, y, z
