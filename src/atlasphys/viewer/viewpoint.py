"""Where a picture is taken from."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from atlasphys.viewer.frame import Frame
from atlasphys.viewer.overlays import world_box

FIELD_OF_VIEW = 50.0
"""Vertical angle of view [°]."""

VIEWS = {
    "oblique": (0.75, 0.55, 1.0), "front": (0.0, 0.12, 1.0), "back": (0.0, 0.12, -1.0), "right": (1.0, 0.12, 0.0), "left": (-1.0, 0.12, 0.0),
    "top": (0.0, 1.0, 0.001),
}  # fmt: skip
"""Directions from which the world is seen."""

FARTHER = 2.5
"""How far a film follows bodies that scatter. Farther, and all would be small."""

Vector = npt.NDArray[np.float64]


class Viewpoint(NamedTuple):
    """A camera, y up in the picture."""

    position: Vector
    """(3,) [m]."""
    look_at: Vector
    """(3,) the point in the middle of the picture [m]."""
    field_of_view: float = FIELD_OF_VIEW
    """Vertical angle of view [°]."""
    orthographic: bool = False
    """Parallel instead of perspective: what is at ``look_at`` keeps its size."""


def view_from(
    name: str, frame: Frame, field_of_view: float = FIELD_OF_VIEW, *, orthographic: bool = False
) -> Viewpoint:
    """The viewpoint in a direction of ``VIEWS`` from which all bodies of a frame are seen."""
    return view_of_box(name, *world_box(frame), field_of_view, orthographic=orthographic)


def view_of_box(
    name: str, lower: Vector, upper: Vector, field_of_view: float = FIELD_OF_VIEW, *, orthographic: bool = False
) -> Viewpoint:
    """The viewpoint in a direction of ``VIEWS`` from which a box is seen whole."""
    middle = 0.5 * (lower + upper)
    radius = max(0.5 * float(np.sqrt(((upper - lower) ** 2).sum())), 1e-3)
    direction = np.array(VIEWS[name])
    distance = 1.1 * radius / math.sin(math.radians(field_of_view) / 2)
    return Viewpoint(middle + distance * direction / np.sqrt((direction**2).sum()), middle, field_of_view, orthographic)


def box_of_all(frames: Sequence[Frame]) -> tuple[Vector, Vector]:
    """(3,), (3,) bounds of the bodies of all frames, but no more than ``FARTHER`` times as far from the middle of the first as its own."""
    boxes = np.array([world_box(frame) for frame in frames])
    middle, half = 0.5 * (boxes[0, 0] + boxes[0, 1]), 0.5 * float((boxes[0, 1] - boxes[0, 0]).max())
    most = max(FARTHER * half, 1e-3)
    return np.maximum(boxes[:, 0].min(axis=0), middle - most), np.minimum(boxes[:, 1].max(axis=0), middle + most)
