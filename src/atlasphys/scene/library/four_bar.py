"""A crank that moves a rocker."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import Field

from atlasphys.scene.library.parts import Layout, box, joint

CRANK, COUPLER, ROCKER, GROUND = 0.5, 2.0, 1.5, 2.0
"""Lengths [m]. The shortest and longest together are shorter than the other two, so that the crank turns round and round (Grashof)."""


def four_bar(speed: Annotated[float, Field(ge=-20, le=20)] = 4.0) -> Layout:
    """A motor turns a crank, which swings a rocker: a four-bar linkage."""
    pin = (0.0, CRANK)  # the crank stands upright
    end = _meeting(pin, COUPLER, (GROUND, 0.0), ROCKER)
    bodies, joints = [], []
    for name, a, b in (("crank", (0.0, 0.0), pin), ("coupler", pin, end), ("rocker", (GROUND, 0.0), end)):
        x, y = b[0] - a[0], b[1] - a[1]
        length = math.sqrt(x * x + y * y)
        half = math.sqrt(0.5 * (1 + x / length)), math.sqrt(0.5 * (1 - x / length))  # of the angle from x: cosine, sine
        middle = (0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.0)
        bodies.append(box((length, 0.1, 0.1), middle, orientation=(half[0], 0.0, 0.0, half[1]), name=name))
    pins: list[tuple[str | None, str, tuple[float, float]]] = [
        (None, "crank", (0.0, 0.0)), ("crank", "coupler", pin), ("coupler", "rocker", end), (None, "rocker", (GROUND, 0.0))
    ]  # fmt: skip
    for first, second, place in pins:
        joints.append(joint("hinge", first, second, anchor=(*place, 0.0), axis=(0, 0, 1)))
    joints[0] |= {"name": "drive", "motor": {"speed": speed}}
    return Layout(bodies, joints=joints)


def _meeting(p: tuple[float, float], r: float, q: tuple[float, float], s: float) -> tuple[float, float]:
    """The upper of the two points at distance r from p and s from q."""
    x, y = q[0] - p[0], q[1] - p[1]
    square = x * x + y * y
    along = (r * r - s * s + square) / (2 * square)
    across = math.sqrt(r * r / square - along * along)
    return p[0] + along * x - across * y, p[1] + along * y + across * x
