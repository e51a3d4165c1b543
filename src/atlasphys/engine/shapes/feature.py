"""Supporting features: the face, edge or vertex of a shape that meets another shape in a given direction.

Contacts between two shapes are found by clipping the supporting feature of one against that of the other. A
feature's id numbers tell its points apart from step to step:

==========  ==============================================================================
box, hull   vertex number
capsule     0 upper end, 1 lower end
cylinder    0–7 upper rim, 8–15 lower rim, 16 and 17 upper and lower rim at the direction's azimuth
cone        0–7 rim, 8 apex, 9 rim at the direction's azimuth
sphere      0
==========  ==============================================================================
"""

import math

from atlasphys.engine.jit import routine
from atlasphys.engine.shapes.support import azimuth
from atlasphys.engine.shapes.table import (
    BOX,
    CAPSULE,
    CONE,
    CYLINDER,
    FACE_COUNT,
    FIRST_FACE,
    FIRST_VERTEX,
    HULL,
    KIND,
    RIM_POINTS,
    SPHERE,
)

ALIGNED = 0.1
"""Sine of the angle (5.7°) up to which a curved shape's flat or straight part counts as facing the direction.
Smaller: a rolling or rocking body loses its second contact point early. Larger: points are sought where the surfaces
have long parted; they lie apart by more than the margin and are thrown away, at some cost."""


@routine
def _point(points, ids, p, identity):
    points[0, 0], points[0, 1], points[0, 2] = p[0], p[1], p[2]
    ids[0] = identity
    return 1


@routine
def _segment(points, ids, p, p_identity, q, q_identity):
    _point(points, ids, p, p_identity)
    points[1, 0], points[1, 1], points[1, 2] = q[0], q[1], q[2]
    ids[1] = q_identity
    return 2


@routine
def _rim(radius, half, upper, points, ids, first_identity):
    """The regular octagon inscribed in a flat end of a cylinder or cone, a corner on +x."""
    real = type(radius)
    zero, diagonal = real(0), radius * real(math.sqrt(0.5))
    for k in range(RIM_POINTS):
        # Corner k is at 45° k from +x towards +z; about +y that is clockwise, so the upper end is walked backwards.
        corner = (RIM_POINTS - k) % RIM_POINTS if upper else k
        if corner % 4 == 0:
            x, z = radius, zero
        elif corner % 4 == 1:
            x, z = diagonal, diagonal
        elif corner % 4 == 2:
            x, z = zero, radius
        else:
            x, z = -diagonal, diagonal
        sign = real(1) if corner < 4 else real(-1)
        points[k, 0], points[k, 1], points[k, 2] = sign * x, half if upper else -half, sign * z
        ids[k] = first_identity + corner
    return RIM_POINTS


@routine
def _face(shapes, row, d, points, ids):
    """The face of a polyhedron whose normal is nearest d."""
    first = shapes.layout[row, FIRST_FACE]
    best, nearest = first, d[0] * shapes.faces[first, 0] + d[1] * shapes.faces[first, 1] + d[2] * shapes.faces[first, 2]
    for f in range(first + 1, first + shapes.layout[row, FACE_COUNT]):
        along = d[0] * shapes.faces[f, 0] + d[1] * shapes.faces[f, 1] + d[2] * shapes.faces[f, 2]
        if along > nearest:
            best, nearest = f, along
    start, count = shapes.face_range[best, 0], shapes.face_range[best, 1]
    for k in range(count):
        vertex = shapes.face_vertices[start + k]
        points[k, 0], points[k, 1], points[k, 2] = (
            shapes.vertices[vertex, 0],
            shapes.vertices[vertex, 1],
            shapes.vertices[vertex, 2],
        )
        ids[k] = vertex - shapes.layout[row, FIRST_VERTEX]
    return count


@routine
def supporting_feature(shapes, row, d, points, ids):
    """Write the part of the shape's core that best faces ``d`` and return its number of points.

    Args:
        shapes: table of shapes.
        row: the shape's row.
        d: direction in the shape's own frame; not necessarily of unit length, but its square must be a normal number.
        points: (FEATURE_POINTS, 3) or longer, written: 1 vertex, 2 ends of an edge, or a face's corners
            counter-clockwise as seen from outside, in the shape's own frame [m].
        ids: (FEATURE_POINTS,) or longer, written: the points' id numbers.

    A polyhedron always gives the face whose normal is nearest ``d`` (the first such face). A capsule gives its
    segment if ``d`` is square to it up to ALIGNED, else the nearer end. A cylinder or cone gives a flat end (eight
    points of the rim, fixed in the shape) or a line of its side (at the azimuth of ``d``) if ``d`` is along the
    end's or the side's normal up to ALIGNED, else the nearest point of rim or apex. A sphere gives its centre. A
    plane gives nothing.
    """
    kind = shapes.layout[row, KIND]
    if kind in (BOX, HULL):
        return _face(shapes, row, d, points, ids)
    s0, s1 = shapes.size[row, 0], shapes.size[row, 1]
    real = type(s0)
    zero, aligned = real(0), real(ALIGNED)
    if kind in (CYLINDER, CONE):
        cosine, sine, radial = azimuth(d[0], d[2])
        x, z = s0 * cosine, s0 * sine
        upper = d[1] >= 0
        if radial <= aligned * abs(d[1]) and (kind == CYLINDER or not upper):
            return _rim(s0, s1, upper, points, ids, 8 if kind == CYLINDER and not upper else 0)
        if kind == CYLINDER:
            if abs(d[1]) <= aligned * radial:
                return _segment(points, ids, (x, s1, z), 16, (x, -s1, z), 17)
            return _point(points, ids, (x, s1 if upper else -s1, z), 16 if upper else 17)
        # In the half-plane of the azimuth the side runs along (r, −2h) and its normal is (2h, r).
        height = s1 + s1
        length = math.sqrt(height * height + s0 * s0)
        along, across = height * radial + s0 * d[1], s0 * radial - height * d[1]
        if along > 0 and abs(across) <= aligned * length * math.sqrt(radial * radial + d[1] * d[1]):
            return _segment(points, ids, (zero, s1, zero), 8, (x, -s1, z), 9)
        if across <= 0:
            return _point(points, ids, (zero, s1, zero), 8)
        return _point(points, ids, (x, -s1, z), 9)
    if kind == CAPSULE:
        upper_end, lower_end = (zero, s1, zero), (zero, -s1, zero)
        if d[1] * d[1] <= aligned * aligned * (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]):
            return _segment(points, ids, upper_end, 0, lower_end, 1)
        return _point(points, ids, upper_end if d[1] > 0 else lower_end, 0 if d[1] > 0 else 1)
    if kind == SPHERE:
        return _point(points, ids, (zero, zero, zero), 0)
    return 0
