"""Figures as plain arrays: what is drawn for a step, to be shown by the page in the browser or as SVG.

A figure has up to two scenes beside each other: the shapes, and what the algorithm thinks about, such as A − B.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from atlasphys.explainer.slides.solids import Hull

Colour = tuple[int, int, int]

A, B = (58, 118, 196), (236, 134, 42)
"""The first and the second shape."""
DIFFERENCE = (112, 150, 128)
ORIGIN = (20, 20, 24)
SIMPLEX = (200, 30, 84)
"""What the algorithm holds."""
NEW = (14, 140, 74)
"""What it has just found, and the direction in which it looked."""
CLOSEST = (122, 62, 190)
"""What is nearest to the origin, or best."""
DROPPED = (150, 154, 162)


@dataclass(frozen=True, eq=False)
class Solid:
    """A convex body, or a convex polygon."""

    hull: Hull
    colour: Colour
    opacity: float = 0.25
    outlined: bool = True
    hollow: bool = False
    """Drawn from the inside: what is in it is not hidden."""


@dataclass(frozen=True, eq=False)
class Lines:
    """Line segments."""

    points: npt.NDArray[np.floating]
    """(n, 2, 3) their ends."""
    colour: Colour
    width: float = 2.5
    """[pixels]"""


@dataclass(frozen=True, eq=False)
class Arrows:
    """Arrows."""

    points: npt.NDArray[np.floating]
    """(n, 2, 3) tails and heads."""
    colour: Colour


@dataclass(frozen=True, eq=False)
class Dots:
    """Points."""

    points: npt.NDArray[np.floating]
    """(n, 3)"""
    colour: Colour
    size: float = 1.0
    """1: as large as a corner of the simplex."""


@dataclass(frozen=True, eq=False)
class Label:
    """A word at a place."""

    text: str
    at: npt.NDArray[np.floating]
    """(3,)"""
    colour: Colour = ORIGIN
    below: bool = False
    """To the lower left of the place instead of the upper right."""


Mark = Solid | Lines | Arrows | Dots | Label
Marks = tuple[Mark, ...]


def segment(start: npt.ArrayLike, end: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """A single segment or arrow."""
    return np.array([[start, end]], np.float64)


def ring(corners: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """The outline of a polygon as segments."""
    points = np.asarray(corners, np.float64).reshape(-1, 3)
    return np.stack([points, np.roll(points, -1, axis=0)], axis=1)


def square(middle: npt.ArrayLike, normal: npt.ArrayLike, reach: float) -> npt.NDArray[np.float64]:
    """(4, 3) corners of a square about a point, at right angles to a direction."""
    n = np.asarray(normal, np.float64)
    n = n / np.linalg.norm(n)
    # One side lies as near to the x-y plane as it can: of a direction in that plane the square stands on edge there.
    side = np.array((-n[1], n[0], 0.0)) if abs(n[2]) < 0.999 else np.array((1.0, 0.0, 0.0))
    u = side / np.linalg.norm(side)
    v = np.cross(n, u)
    return np.asarray(middle) + reach * np.array([u + v, v - u, -u - v, u - v])
