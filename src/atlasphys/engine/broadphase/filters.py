"""Which pairs of colliders may touch at all: the tests that every broad phase shares, so that all give the same pairs."""

import numpy as np
import numpy.typing as npt

from atlasphys.engine.jit import routine
from atlasphys.engine.math import mat
from atlasphys.engine.shapes.table import PLANE
from atlasphys.engine.state.bodies import DYNAMIC
from atlasphys.engine.trace import TRACED, note


@routine
def may_collide(bodies, colliders, i, j):
    """Whether one of the two bodies is dynamic and both masks admit the other's group."""
    a, b = colliders.body[i], colliders.body[j]
    if TRACED:
        kinds, masks = (bodies.kind[a], bodies.kind[b]), (colliders.mask[i], colliders.mask[j])
        note("broad.filter", i=i, j=j, kinds=kinds, groups=(colliders.group[i], colliders.group[j]), masks=masks)
    if a == b or (bodies.kind[a] != DYNAMIC and bodies.kind[b] != DYNAMIC):
        return False
    return (colliders.mask[i] & colliders.group[j]) != 0 and (colliders.mask[j] & colliders.group[i]) != 0


@routine
def bounds_overlap(colliders, i, j):
    """Whether two bounding boxes overlap or touch."""
    for k in range(3):
        if colliders.lower[i, k] > colliders.upper[j, k] or colliders.lower[j, k] > colliders.upper[i, k]:
            if TRACED:
                note("broad.apart", i=i, j=j, axis=k)
            return False
    if TRACED:
        note("broad.overlap", i=i, j=j)
    return True


@routine
def is_plane(colliders, shapes, i):
    """Whether collider i is an unbounded plane."""
    return shapes.layout[colliders.shape[i], 0] == PLANE


@routine
def reaches_plane(bodies, colliders, shapes, plane, i):
    """Whether the bounding box of collider i reaches below the surface of a plane."""
    size, body = shapes.size[colliders.shape[plane]], colliders.body[plane]
    n = mat.mul_vec(mat.load(bodies.geometry, body), (size[0], size[1], size[2]))
    height = 0.0
    for k in range(3):  # the box's corner that lies deepest
        corner = colliders.lower[i, k] if n[k] > 0 else colliders.upper[i, k]
        height += n[k] * (corner - bodies.position[body, k]) if n[k] != 0 else 0.0
    if TRACED:
        note("broad.plane", plane=plane, i=i, height=height, offset=size[3])
    return height <= size[3]


def without_joined(pairs: npt.NDArray[np.int32], apart: npt.NDArray[np.int32]) -> npt.NDArray[np.int32]:
    """The pairs that are not among those that joints keep from colliding; all lower row first, and each body has the collider of its row."""
    if len(apart) == 0:
        return pairs
    keys, joined = (rows[:, 0].astype(np.int64) << 32 | rows[:, 1] for rows in (pairs, apart))
    return pairs[~np.isin(keys, joined)]
