"""World bounds of colliders, exact for the rotated shape."""

import math

import numpy as np

from atlasphys.engine.jit import kernel, routine
from atlasphys.engine.shapes.table import (
    BOX,
    CAPSULE,
    CONE,
    CYLINDER,
    FIRST_VERTEX,
    HULL,
    KIND,
    SPHERE,
    VERTEX_COUNT,
)


@routine
def rotated_bounds(shapes, row, x, y, z):
    """Least and greatest value of (x, y, z) · p over the points p of a shape: its bounds along that direction.

    (x, y, z) is a row of the rotation matrix, so the direction is a world axis seen from the shape. A plane has no
    bounds.
    """
    kind = shapes.layout[row, KIND]
    s0, s1, s2 = shapes.size[row, 0], shapes.size[row, 1], shapes.size[row, 2]
    if kind == SPHERE:
        return -s0, s0
    if kind == CAPSULE:
        reach = s0 + s1 * abs(y)
        return -reach, reach
    if kind == BOX:
        reach = s0 * abs(x) + s1 * abs(y) + s2 * abs(z)
        return -reach, reach
    if kind == CYLINDER:
        reach = s0 * math.sqrt(x * x + z * z) + s1 * abs(y)
        return -reach, reach
    if kind == CONE:
        apex, rim = s1 * y, s0 * math.sqrt(x * x + z * z)
        return min(apex, -apex - rim), max(apex, -apex + rim)
    infinite = type(s0)(np.inf)
    if kind == HULL:
        lower, upper = infinite, -infinite
        first = shapes.layout[row, FIRST_VERTEX]
        for k in range(first, first + shapes.layout[row, VERTEX_COUNT]):
            along = x * shapes.vertices[k, 0] + y * shapes.vertices[k, 1] + z * shapes.vertices[k, 2]
            lower, upper = min(lower, along), max(upper, along)
        return lower, upper
    return -infinite, infinite


@kernel
def update_bounds(bodies, colliders, shapes, count, margin):
    """Write ``colliders.lower`` and ``upper`` of the first ``count`` colliders, widened by ``margin`` [m].

    Reads the bodies' positions and rotation matrices. Only the extent about the position is computed in the world's
    precision. It is rounded like the surface points that the narrow phase finds, from the same matrix, so what can be
    lost is a few units in the last place of the shape's size: in single precision a millionth of it, less than the
    default margin for shapes up to 20 km across. So the margin needs no addition for round-off.
    """
    for i in range(count):
        body, row = colliders.body[i], colliders.shape[i]
        for axis in range(3):
            lower, upper = rotated_bounds(
                shapes,
                row,
                bodies.geometry[body, 3 * axis],
                bodies.geometry[body, 3 * axis + 1],
                bodies.geometry[body, 3 * axis + 2],
            )
            colliders.lower[i, axis] = bodies.position[body, axis] + np.float64(lower) - margin
            colliders.upper[i, axis] = bodies.position[body, axis] + np.float64(upper) + margin
