"""What can be drawn about bodies: arrows, contact points, bounds, centres of mass, as plain arrays of points.

Arrows of velocity have 0.25 m for each m/s. Arrows of force and impulse are as long as a typical body is wide where they are as large as its
weight (its weight times the step), so that they can be seen in worlds of any scale.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from atlasphys.engine.shapes.box import Box
from atlasphys.engine.shapes.capsule import Capsule
from atlasphys.engine.shapes.cone import Cone
from atlasphys.engine.shapes.cylinder import Cylinder
from atlasphys.engine.shapes.plane import Plane
from atlasphys.engine.shapes.sphere import Sphere
from atlasphys.viewer.frame import Frame, Table
from atlasphys.world.rotation import rotate

Floats = npt.NDArray[np.float64]

METRES_PER_SPEED = 0.25
"""Length of a velocity arrow [m per m/s]."""

LONGEST = 6.0
"""Longest arrow, in widths of a typical body. Impacts would fill the sky."""

SHORTEST = 0.03
"""Arrows that are shorter than this, in the same unit, are left out."""

MOST_ARROWS = 1500
MOST_BOXES = 600
"""Most arrows and bounding boxes of a kind that are drawn: the longest arrows, the first boxes."""


class Scale(NamedTuple):
    """What is typical of a world's dynamic bodies."""

    width: float
    """Edge of a cube of the median volume [m]."""
    mass: float
    """Median mass [kg]."""


def typical(table: Table) -> Scale:
    """The scale of a world's dynamic bodies; 1 m and 1 kg if it has none."""
    moving = [entry for entry in table.entries if entry.kind == "dynamic"]
    if not moving:
        return Scale(1.0, 1.0)
    width = float(np.median([np.cbrt(entry.shape.volume) for entry in moving]))
    return Scale(width, float(np.median([entry.mass for entry in moving])))


def centers(frame: Frame) -> Floats:
    """(n, 3) centres of mass [m]."""
    return np.asarray(frame.position + rotate(frame.orientation.astype(np.float64), frame.table.center))


def velocity_arrows(frame: Frame, scale: Scale, size: float = 1.0) -> Floats:
    """(k, 2, 3) start and end of an arrow for each moving body [m]."""
    rows = _present(frame, everything=True)
    return _arrows(centers(frame)[rows], METRES_PER_SPEED * size * frame.velocity[rows], scale)


def force_arrows(frame: Frame, scale: Scale, size: float = 1.0) -> Floats:
    """(k, 2, 3) mass times acceleration of each dynamic body, from its centre of mass."""
    rows = _present(frame)
    force = frame.table.mass[rows, None] * frame.acceleration[rows]
    return _arrows(centers(frame)[rows], size * scale.width / _weight(frame, scale) * force, scale)


def impulse_arrows(frame: Frame, scale: Scale, size: float = 1.0) -> Floats:
    """(k, 2, 3) the impulse of each contact point on each dynamic body of the two, from the point."""
    if frame.contacts is None or len(frame.contacts) == 0:
        return np.empty((0, 2, 3))
    contacts, dynamic = frame.contacts, frame.table.is_dynamic
    on_b = contacts["normal_impulse"][:, None] * contacts["normal"] + contacts["friction_impulse"]
    on_a, to_b = dynamic[contacts["body_a"]], dynamic[contacts["body_b"]]
    start = np.concatenate([contacts["point"][to_b], contacts["point"][on_a]])
    impulse = np.concatenate([on_b[to_b], -on_b[on_a]])
    return _arrows(start, size * scale.width / (_weight(frame, scale) * frame.dt) * impulse, scale)


def _weight(frame: Frame, scale: Scale) -> float:
    gravity = float(np.sqrt((frame.gravity**2).sum()))
    return scale.mass * (gravity or 9.81)


def _present(frame: Frame, *, everything: bool = False) -> npt.NDArray[np.int64]:
    """Rows of the bodies that are in the world and dynamic, or all but planes."""
    there = ~np.isnan(frame.position[:, 0])
    return np.flatnonzero(there if everything else there & frame.table.is_dynamic)


def _arrows(start: Floats, arrow: Floats, scale: Scale) -> Floats:
    """Arrows of readable length from their starts: the longest of them, cut to size."""
    length = np.sqrt((arrow**2).sum(axis=1))
    chosen = np.flatnonzero(length > SHORTEST * scale.width)
    if len(chosen) > MOST_ARROWS:
        chosen = np.sort(chosen[np.argsort(-length[chosen], kind="stable")[:MOST_ARROWS]])
    shrink = np.minimum(1.0, LONGEST * scale.width / length[chosen])
    return np.stack([start[chosen], start[chosen] + shrink[:, None] * arrow[chosen]], axis=1)


def contact_normals(frame: Frame, scale: Scale) -> Floats:
    """(k, 2, 3) a short line along the normal of each contact point."""
    if frame.contacts is None:
        return np.empty((0, 2, 3))
    points = frame.contacts["point"]
    return np.stack([points, points + 0.35 * scale.width * frame.contacts["normal"]], axis=1)


# Bounding boxes ------------------------------------------------------------------------------------------------------

_CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
_EDGES = np.array([(i, j) for i in range(8) for j in range(i) if np.abs(_CORNERS[i] - _CORNERS[j]).sum() == 1])


def bounds(frame: Frame, rows: npt.NDArray[np.int64]) -> tuple[Floats, Floats]:
    """(k, 3) least and greatest coordinates of the bodies of some rows, exact for their present orientation; planes have infinite ones."""
    lower, upper = np.empty((len(rows), 3)), np.empty((len(rows), 3))
    for k, row in enumerate(rows.tolist()):
        shape = frame.table.entries[row].shape
        # Row i of the matrix is world axis i as seen from the shape.
        axes = rotate(np.repeat(frame.orientation[row, None].astype(np.float64), 3, 0), np.eye(3)).T
        y = axes[:, 1]
        across = np.sqrt(np.maximum(0.0, 1.0 - y * y))
        low = None
        match shape:
            case Sphere(radius=r):
                high = np.full(3, r)
            case Box(size=size):
                high = np.abs(axes) @ (0.5 * np.array(size))
            case Capsule(radius=r, length=length):
                high = r + 0.5 * length * np.abs(y)
            case Cylinder(radius=r, length=length):
                high = r * across + 0.5 * length * np.abs(y)
            case Cone(radius=r, height=height):
                apex = 0.5 * height * y
                low, high = np.minimum(apex, -apex - r * across), np.maximum(apex, -apex + r * across)
            case Plane():
                high = np.full(3, np.inf)
            case _:
                solid = shape.polyhedron
                assert solid is not None
                points = solid.vertices @ axes.T
                low, high = points.min(axis=0), points.max(axis=0)
        lower[k] = frame.position[row] + (-high if low is None else low)
        upper[k] = frame.position[row] + high
    return lower, upper


def box_edges(lower: Floats, upper: Floats) -> Floats:
    """(12 k, 2, 3) edges of boxes."""
    corners = lower[:, None] + _CORNERS * (upper - lower)[:, None]
    return corners[:, _EDGES].reshape(-1, 2, 3)


def bounding_boxes(frame: Frame) -> Floats:
    """(k, 2, 3) edges of the bounding boxes of the first bodies that are no planes."""
    rows = _present(frame, everything=True)
    finite = [row for row in rows.tolist() if not isinstance(frame.table.entries[row].shape, Plane)]
    return box_edges(*bounds(frame, np.array(finite[:MOST_BOXES], np.int64)))


def world_box(frame: Frame) -> tuple[Floats, Floats]:
    """(3,), (3,) bounds of the centres of all bodies but planes, widened by a typical body; those of the unit cube if there are none."""
    rows = [r for r in _present(frame, everything=True) if not isinstance(frame.table.entries[r].shape, Plane)]
    if not rows:
        return np.full(3, -0.5), np.full(3, 0.5)
    few = np.array(rows if len(rows) <= MOST_BOXES else [], np.int64)
    if len(few):
        lower, upper = bounds(frame, few)
        return lower.min(axis=0), upper.max(axis=0)
    width = typical(frame.table).width
    return frame.position[rows].min(axis=0) - width, frame.position[rows].max(axis=0) + width
