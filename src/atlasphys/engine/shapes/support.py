"""Support points: the farthest point of a shape in a direction.

Round shapes are split into a core and a radius about it: a sphere is a point, a capsule a segment, widened by
``rounding``. Distances between cores are found more exactly and in fewer steps than between round surfaces, and
overlaps of up to the sum of the radii need no penetration algorithm at all.
"""

import math

from atlasphys.engine.jit import routine
from atlasphys.engine.shapes.table import (
    BOX,
    CAPSULE,
    CONE,
    CYLINDER,
    FIRST_VERTEX,
    HULL,
    KIND,
    VERTEX_COUNT,
)


@routine
def rounding(shapes, row):
    """The radius about the core [m]: that of a sphere or capsule, else 0."""
    if shapes.layout[row, KIND] <= CAPSULE:  # SPHERE comes before it
        return shapes.size[row, 0]
    return shapes.size.dtype.type(0)


@routine
def azimuth(x, z):
    """Cosine and sine of the direction (x, z) about the y axis, and its length; (1, 0) where it is zero.

    Scaled first, so that the squares of a very short direction do not vanish.
    """
    largest = max(abs(x), abs(z))
    if largest == 0:
        return type(x)(1), type(x)(0), type(x)(0)
    x, z = x / largest, z / largest
    length = math.sqrt(x * x + z * z)
    return x / length, z / length, length * largest


@routine
def support(shapes, row, d):
    """The point of the shape's core farthest along ``d``, both in the shape's own frame [m].

    ``d`` may have any length, also zero. Of several points equally far, polyhedra give the lowest vertex, the rest the
    positive end. A plane has no farthest point; (0, 0, 0) is returned.
    """
    kind = shapes.layout[row, KIND]
    s0, s1, s2 = shapes.size[row, 0], shapes.size[row, 1], shapes.size[row, 2]
    zero = type(s0)(0)
    if kind == BOX:
        return s0 if d[0] > 0 else -s0, s1 if d[1] > 0 else -s1, s2 if d[2] > 0 else -s2
    if kind == HULL:
        first = shapes.layout[row, FIRST_VERTEX]
        best = first
        farthest = d[0] * shapes.vertices[best, 0] + d[1] * shapes.vertices[best, 1] + d[2] * shapes.vertices[best, 2]
        for k in range(first + 1, first + shapes.layout[row, VERTEX_COUNT]):
            along = d[0] * shapes.vertices[k, 0] + d[1] * shapes.vertices[k, 1] + d[2] * shapes.vertices[k, 2]
            if along > farthest:
                best, farthest = k, along
        return shapes.vertices[best, 0], shapes.vertices[best, 1], shapes.vertices[best, 2]
    if kind == CAPSULE:
        return zero, s1 if d[1] >= 0 else -s1, zero
    if kind in (CYLINDER, CONE):
        cosine, sine, radial = azimuth(d[0], d[2])
        level = s1 if d[1] >= 0 else -s1
        if kind == CONE:
            if (s1 + s1) * d[1] >= s0 * radial:
                return zero, s1, zero
            level = -s1
        return s0 * cosine, level, s0 * sine
    return zero, zero, zero
