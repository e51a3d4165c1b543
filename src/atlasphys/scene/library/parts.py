"""What the scenes of the library are put together from.

A scene must be the same to the bit on every computer: no random numbers but ``random.Random(seed).random()``, and
values of functions that each system's library rounds its own way (sine, cosine) are rounded to 12 digits.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

Vector = tuple[float, float, float]
Body = dict[str, Any]
"""Arguments of ``World.add``, as a scene file has them."""

Joint = dict[str, Any]
"""Kind of a joint, names of its bodies, and its arguments, as a scene file has them."""

ALONG_X = (math.sqrt(0.5), 0.0, 0.0, -math.sqrt(0.5))
"""The quaternion that lays a capsule or cylinder, whose own axis is y, along x; its upper end is at +x."""

ALONG_Z = (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)
"""The one that lays it along z."""


class Layout(NamedTuple):
    """What a scene of the library consists of."""

    bodies: list[Body]
    joints: Sequence[Joint] = ()
    world: Mapping[str, Any] = MappingProxyType({})
    """Arguments of the world."""
    seconds: float = 10.0
    """Time after which the scene has shown what it shows [s]."""
    dt: float = 1 / 60
    """Suggested time step [s]."""


def body(shape: str, position: Vector, /, sizes: dict[str, Any], **settings: Any) -> Body:
    """A body of any shape: its type, position and sizes, then arguments of ``World.add``."""
    return {"shape": {"type": shape, **sizes}, "position": position, **settings}


def box(size: Vector, position: Vector, **settings: Any) -> Body:
    """A box."""
    return body("box", position, {"size": size}, **settings)


def sphere(radius: float, position: Vector, **settings: Any) -> Body:
    """A sphere."""
    return body("sphere", position, {"radius": radius}, **settings)


def capsule(radius: float, length: float, position: Vector, **settings: Any) -> Body:
    """A capsule."""
    return body("capsule", position, {"radius": radius, "length": length}, **settings)


def joint(kind: str, a: str | None, b: str, **settings: Any) -> Joint:
    """A joint of any kind between bodies by name, or, with None, the world and a body."""
    given = {name: list(value) if isinstance(value, tuple) else value for name, value in settings.items()}
    return {"type": kind, **({} if a is None else {"a": a}), "b": b, **given}


def ground(**settings: Any) -> Body:
    """The plane y = 0."""
    return {"shape": {"type": "plane"}, "name": "ground", **settings}


def pit(size: float, height: float, thickness: float = 1.0) -> list[Body]:
    """A square floor between four walls: inside, it reaches from −size/2 to size/2 along x and z."""
    outer, offset, middle = size + 2 * thickness, (size + thickness) / 2, height / 2
    walls: list[tuple[str, Vector, Vector]] = [
        ("wall −x", (thickness, height, outer), (-offset, middle, 0.0)),
        ("wall +x", (thickness, height, outer), (offset, middle, 0.0)),
        ("wall −z", (size, height, thickness), (0.0, middle, -offset)),
        ("wall +z", (size, height, thickness), (0.0, middle, offset)),
    ]
    return [ground(), *(box(extent, place, kind="static", name=name) for name, extent, place in walls)]


def sine(degrees: float) -> float:
    """Sine, rounded."""
    return round(math.sin(math.radians(degrees)), 12)


def cosine(degrees: float) -> float:
    """Cosine, rounded."""
    return round(math.cos(math.radians(degrees)), 12)


def turned(axis: Vector, degrees: float) -> tuple[float, float, float, float]:
    """The quaternion of a rotation about a unit axis."""
    s = sine(degrees / 2)
    return cosine(degrees / 2), axis[0] * s, axis[1] * s, axis[2] * s
