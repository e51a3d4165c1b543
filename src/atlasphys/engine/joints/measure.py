"""Coordinates of joints and their rates, read in Python: the NumPy reading of the parts, in double precision."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from atlasphys.engine.joints.ends import Ends
from atlasphys.engine.joints.frames import IDENTITY, Vector, difference, multiply, rotate, to_world, unit
from atlasphys.engine.joints.part import Part
from atlasphys.engine.joints.parts import PARTS
from atlasphys.engine.joints.rows import rate
from atlasphys.engine.state.joints import WORLD
from atlasphys.engine.state.state import State


def ends_of(state: State, row: int, part: Part, anchors: tuple[Vector, Vector]) -> tuple[Ends, list[Any]]:
    """The ends of a part of a joint, and the velocities v_a, ω_a, v_b, ω_b of the two bodies. All numbers are arrays of length 1."""
    points, arms, frames, velocities = [], [], [], []
    for end, anchor, frame in zip(
        state.joints.rows.body[row].tolist(), anchors, (part.frame_a, part.frame_b), strict=True
    ):
        position, turned, center, motion = (0.0, 0.0, 0.0), IDENTITY, (0.0, 0.0, 0.0), np.zeros(6)
        if end != WORLD:
            bodies = state.bodies
            position, turned = tuple(bodies.position[end].tolist()), unit(tuple(bodies.orientation[end].tolist()))
            center, motion = tuple(bodies.local_center[end].tolist()), bodies.motion[end, 0:6].astype(np.float64)
        arms.append(rotate(turned, difference(anchor, center)))
        points.append(to_world((position, turned), anchor))
        frames.append(multiply(turned, frame))
        velocities += [_lanes(motion[0:3]), _lanes(motion[3:6])]
    hung = part.hung or (points[0], points[1])
    ends = Ends(
        arm_a=_lanes(arms[0]),
        arm_b=_lanes(arms[1]),
        apart=_lanes(difference(points[1], points[0])),
        frame_a=_lanes(frames[0]),
        frame_b=_lanes(frames[1]),
        ropes=tuple(_lanes(difference(point, ground)) for point, ground in zip(points, hung, strict=True)),
        ratio=_lanes(part.ratio),
        turns=_lanes(part.turns),
        phase=np.zeros(1),
    )
    return ends, velocities


def coordinate(state: State, row: int, part: Part, anchors: tuple[Vector, Vector]) -> tuple[float, float]:
    """Value and rate of the coordinate of an axial part, as if it were one of the joint of a row [rad, m; a second]."""
    ends, velocities = ends_of(state, row, part, anchors)
    kind = PARTS[part.type]
    with np.errstate(all="ignore"):
        value, speed = kind.measure(ends)[0], rate(kind.rows(ends)[0], *velocities)
    return float(value[0]), float(speed[0])


def _lanes(numbers: Any) -> tuple[npt.NDArray[np.float64], ...]:
    return tuple(np.array([float(number)]) for number in numbers)
