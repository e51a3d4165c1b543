"""Slow and obvious oracles for the narrow phase: support functions in closed form and a dense sweep over directions.

h(n) = max over A of n · a − min over B of n · b is the overlap of two shapes along the unit vector n: moving B by h(n)
along n parts them. The least h(n) is the depth; where it is negative, its absolute value is the distance. So an answer
(n, depth) is right exactly if h(n) = depth and no direction has a smaller h.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from atlasphys.engine.shapes.box import Box
from atlasphys.engine.shapes.capsule import Capsule
from atlasphys.engine.shapes.cone import Cone
from atlasphys.engine.shapes.cylinder import Cylinder
from atlasphys.engine.shapes.hull import ConvexHull
from atlasphys.engine.shapes.shape import Shape
from atlasphys.engine.shapes.sphere import Sphere

Array = npt.NDArray[np.float64]


def reach(shape: Shape, d: Array) -> Array:
    """max of d · p over the points p of a shape, for directions d (..., 3) in the shape's own frame."""
    x, y, z = d[..., 0], d[..., 1], d[..., 2]
    if isinstance(shape, Sphere):
        return shape.radius * np.linalg.norm(d, axis=-1)
    if isinstance(shape, Capsule):
        return shape.radius * np.linalg.norm(d, axis=-1) + 0.5 * shape.length * np.abs(y)
    if isinstance(shape, Box):
        return 0.5 * (shape.size[0] * np.abs(x) + shape.size[1] * np.abs(y) + shape.size[2] * np.abs(z))
    if isinstance(shape, Cylinder):
        return shape.radius * np.hypot(x, z) + 0.5 * shape.length * np.abs(y)
    if isinstance(shape, Cone):
        half = 0.5 * shape.height
        return np.maximum(half * y, shape.radius * np.hypot(x, z) - half * y)
    assert isinstance(shape, ConvexHull)
    return (d @ np.array(shape.vertices).T).max(axis=-1)


def overlap(a: Shape, b: Shape, rotation_a: Array, rotation_b: Array, d: Array, n: Array) -> Array:
    """h(n) for unit vectors n (..., 3); d is the vector from a's origin to b's."""
    return reach(a, n @ rotation_a) + reach(b, -n @ rotation_b) - n @ d


def sphere_points(number: int) -> Array:
    """Directions spread evenly over the unit sphere: the Fibonacci lattice."""
    k = np.arange(number) + 0.5
    z = 1.0 - 2.0 * k / number
    azimuth = math.pi * (1.0 + math.sqrt(5.0)) * k
    r = np.sqrt(1.0 - z * z)
    return np.stack([r * np.cos(azimuth), r * np.sin(azimuth), z], axis=1)


DIRECTIONS = sphere_points(600)
_RING = np.array([(math.cos(t), math.sin(t)) for t in np.linspace(0.0, 2.0 * math.pi, 16, endpoint=False)])


def sweep(
    a: Shape, b: Shape, rotation_a: Array, rotation_b: Array, d: Array, starts: int = 6, rounds: int = 60
) -> tuple[float, Array]:
    """The least overlap found over many directions and near the best of them, and its direction.

    The refinement asks sixteen directions on a ring about the best one so far; the ring turns, and shrinks when none
    is better.
    """

    def h(n: Array) -> Array:
        return overlap(a, b, rotation_a, rotation_b, d, n)

    values = h(DIRECTIONS)
    n = DIRECTIONS[np.argsort(values)[:starts]]
    best = h(n)
    radius = np.full(starts, 0.1)
    for k in range(rounds):
        u = np.cross(n, np.eye(3)[np.argmin(np.abs(n), axis=1)])
        u /= np.linalg.norm(u, axis=1, keepdims=True)
        v = np.cross(n, u)
        turn = 0.7 * k
        c, s = math.cos(turn), math.sin(turn)
        ring = _RING @ np.array([[c, s], [-s, c]])
        trial = n[:, None] + radius[:, None, None] * (ring[None, :, :1] * u[:, None] + ring[None, :, 1:] * v[:, None])
        trial /= np.linalg.norm(trial, axis=2, keepdims=True)
        value = h(trial)
        index = value.argmin(axis=1)
        rows = np.arange(starts)
        better = value[rows, index] < best
        best = np.where(better, value[rows, index], best)
        n = np.where(better[:, None], trial[rows, index], n)
        radius = np.where(better, radius, 0.6 * radius)
    index = int(best.argmin())
    return float(best[index]), n[index]


def difference_faces(a: Shape, b: Shape, rotation_a: Array, rotation_b: Array, d: Array) -> tuple[Array, Array]:
    """Normals and offsets of the faces of A − B for two polyhedra (boxes or hulls), by Qhull."""
    from scipy.spatial import ConvexHull as Qhull

    points = (corners(a) @ rotation_a.T)[:, None] - (corners(b) @ rotation_b.T + d)[None]
    equations = Qhull(points.reshape(-1, 3), qhull_options="QJ Pp").equations
    return equations[:, :3], -equations[:, 3]


def corners(shape: Shape) -> Array:
    """Vertices of a box or hull in its own frame."""
    if isinstance(shape, Box):
        half = 0.5 * np.array(shape.size)
        return half * np.array([(x, y, z) for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
    assert isinstance(shape, ConvexHull)
    return np.array(shape.vertices)


def rotation(quaternion: npt.ArrayLike) -> Array:
    """Rotation matrix of a quaternion (w, x, y, z) of any length."""
    w, x, y, z = np.asarray(quaternion, float) / np.linalg.norm(quaternion)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
