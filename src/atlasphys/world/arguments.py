"""Checks of what the user gives to a world or a body. Each returns clean values or raises InvalidArgumentError."""

from __future__ import annotations

import math
import operator
from collections.abc import Iterable, Mapping
from typing import Any

from atlasphys.engine.shapes.arguments import entries, invalid, number, vector
from atlasphys.errors import InvalidArgumentError

LOCKS = ("x", "y", "z", "rx", "ry", "rz")
"""Names of the axes along which (x, y, z) or about which (rx, ry, rz) a body's motion can be locked, in the order of their bits."""

LARGEST_COORDINATE = 1e9
"""Greatest absolute coordinate [m], speed [m/s] and angular speed [rad/s]: squares and products stay finite in single precision."""


def bounded_vector(name: str, value: object) -> tuple[float, float, float]:
    """Three finite numbers whose absolute value is at most LARGEST_COORDINATE."""
    result = vector(name, value)
    if max(abs(x) for x in result) > LARGEST_COORDINATE:
        raise invalid(name, f"three numbers between -{LARGEST_COORDINATE:g} and {LARGEST_COORDINATE:g}", value)
    return result


def unit_quaternion(name: str, value: object) -> tuple[float, float, float, float]:
    """Four finite numbers (w, x, y, z), not all zero, scaled to length 1."""
    wanted = "four finite numbers (w, x, y, z), not all zero"
    w, x, y, z = (number(f"{name}[{i}]", entry) for i, entry in enumerate(entries(name, value, 4, wanted)))
    greatest = max(abs(w), abs(x), abs(y), abs(z))
    if greatest == 0.0:
        raise invalid(name, wanted, value)
    w, x, y, z = w / greatest, x / greatest, y / greatest, z / greatest
    length = math.sqrt(w * w + x * x + y * y + z * z)
    return w / length, x / length, y / length, z / length


def in_range(name: str, value: object, least: float, greatest: float) -> float:
    """A number from ``least`` to ``greatest``."""
    wanted = f"a number from {least:g} to {greatest:g}"
    result = number(name, value, wanted)
    if not least <= result <= greatest:
        raise invalid(name, wanted, value)
    return result


def bits(name: str, value: object) -> int:
    """A set of groups as the lowest 32 bits of an integer; ``~0`` is all of them."""
    wanted = "an integer of 32 bits"
    try:
        result = operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        raise invalid(name, wanted, value) from None
    if isinstance(value, bool) or not -(2**31) <= result < 2**32:
        raise invalid(name, wanted, value)
    return result & 0xFFFFFFFF


def lock_bits(value: object) -> int:
    """Names out of LOCKS as bits."""
    wanted = f"None or a sequence of names out of {', '.join(LOCKS)}"
    if value is None:
        return 0
    if isinstance(value, str) or not isinstance(value, Iterable):
        raise invalid("locks", wanted, value)
    result = 0
    for entry in value:
        if not isinstance(entry, str) or entry not in LOCKS:
            raise invalid("locks", wanted, value)
        result |= 1 << LOCKS.index(entry)
    return result


def choice(name: str, value: object, options: Mapping[str, Any] | Iterable[str]) -> str:
    """One of a number of names."""
    names = list(options)
    if not isinstance(value, str) or value not in names:
        raise InvalidArgumentError(f"{name} must be one of {', '.join(map(repr, names))} (got {value!r})")
    return value


def rgb(value: object) -> tuple[float, float, float] | None:
    """A colour: None, ``"#rrggbb"``, or three numbers from 0 to 1."""
    wanted = "None, '#rrggbb', or three numbers from 0 to 1"
    if value is None:
        return None
    if isinstance(value, str):
        digits = value.removeprefix("#")
        if len(value) != 7 or len(digits) != 6 or any(c not in "0123456789abcdefABCDEF" for c in digits):
            raise invalid("color", wanted, value)
        r, g, b = (int(digits[i : i + 2], 16) / 255 for i in (0, 2, 4))
        return r, g, b
    r, g, b = (in_range(f"color[{i}]", entry, 0, 1) for i, entry in enumerate(entries("color", value, 3, wanted)))
    return r, g, b


def check_name(name: object) -> None:
    """Refuse what is no name. Python strings may contain halves of characters (lone surrogates), which files cannot hold."""
    try:
        if isinstance(name, str) and name:
            name.encode()
            return
    except UnicodeEncodeError:
        pass
    raise InvalidArgumentError(f"name must be a non-empty string of Unicode text or None (got {name!r})")
