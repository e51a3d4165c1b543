"""Rotation of many vectors at once, a row each, in double precision."""

import numpy as np
import numpy.typing as npt

Doubles = npt.NDArray[np.float64]


def conjugate(q: Doubles) -> Doubles:
    """q* for rows of quaternions."""
    return np.concatenate([q[:, :1], -q[:, 1:]], axis=1)


def rotate(q: Doubles, v: Doubles) -> Doubles:
    """q v q* for rows of unit quaternions and vectors."""
    t = 2.0 * np.cross(q[:, 1:], v)
    result: Doubles = v + q[:, :1] * t + np.cross(q[:, 1:], t)
    return result
