"""A plane and any convex shape, exactly: the shape's lowest points.

The signed distance of the shape's origin from the plane is taken in double precision, so that a plane whose origin is
far away is as exact as one at hand. Then all points are worked out from the shape's own origin.

A polyhedron gives every vertex near enough; a rounded shape the ends of its core. The rim of a cylinder or cone has
one lowest point, at the azimuth of the plane. Where the flat end faces the plane, the eight fixed points of the rim
that are the shape's supporting feature are given too: a lone lowest point wanders about the rim with every bit of
round-off.
"""

import math

import numpy as np

from atlasphys.engine.jit import allocating_kernel, routine
from atlasphys.engine.math import mat, vec
from atlasphys.engine.narrowphase.apart import certain_gap
from atlasphys.engine.narrowphase.pair import place, write_normal
from atlasphys.engine.shapes.feature import supporting_feature
from atlasphys.engine.shapes.support import rounding, support
from atlasphys.engine.shapes.table import BOX, CAPSULE, FIRST_VERTEX, HULL, KIND, RIM_POINTS, VERTEX_COUNT

LEVEL = 1e-4
"""Sine of the tilt above which the lowest point of a rim is told from its neighbours. Smaller: it wanders with
round-off."""

LOWEST = 18
"""Feature number of the lowest point of a rim whose eight fixed points are also listed."""


@routine
def _write_low_point(contacts, target, height, margin, n, center, far_center, radius, point, feature):
    """Add the point of a core ``point`` (as seen from the shape's origin) if its surface is low enough."""
    real = type(height)
    distance = height + vec.dot(n, point) - radius
    contacts.gap[target[0]] = min(contacts.gap[target[0]], distance - margin)
    if distance < margin:
        middle = vec.add_scaled(point, n, real(-0.5) * distance - radius)
        p, swapped, _, _ = target
        slot = contacts.first[p] + contacts.count[p]
        from_shape = vec.sub(middle, center)
        from_plane = vec.add(from_shape, far_center)
        vec.store(contacts.anchor_a, slot, from_plane if swapped else from_shape)
        vec.store(contacts.anchor_b, slot, from_shape if swapped else from_plane)
        contacts.depth[slot] = -distance
        contacts.feature[slot] = feature
        contacts.count[p] += 1


@allocating_kernel
def plane_convex(rows, bodies, colliders, shapes, margin, contacts):
    """Contacts of pairs of a plane and a convex shape."""
    real = contacts.depth.dtype.type
    margin = real(margin)
    zero = real(0)
    points = np.empty((RIM_POINTS, 3), contacts.depth.dtype)
    ids = np.empty(RIM_POINTS, np.int32)
    for p in rows:
        # Kinds are in order: the shape comes first, the plane second.
        pair, target = place(bodies, colliders, shapes, contacts, p)
        row, plane, rotation, plane_rotation, _ = pair
        swapped = target[1]
        a, b = colliders.body[contacts.a[p]], colliders.body[contacts.b[p]]
        body, plane_body = (b, a) if swapped else (a, b)
        normal = mat.mul_vec(plane_rotation, (shapes.size[plane, 0], shapes.size[plane, 1], shapes.size[plane, 2]))
        nx, ny, nz = np.float64(normal[0]), np.float64(normal[1]), np.float64(normal[2])
        length = math.sqrt(nx * nx + ny * ny + nz * nz)
        x = bodies.position[body, 0] - bodies.position[plane_body, 0]
        y = bodies.position[body, 1] - bodies.position[plane_body, 1]
        z = bodies.position[body, 2] - bodies.position[plane_body, 2]
        height = real((nx * x + ny * y + nz * z) / length - np.float64(shapes.size[plane, 3]))
        n = (real(nx / length), real(ny / length), real(nz / length))
        center = (bodies.geometry[body, 9], bodies.geometry[body, 10], bodies.geometry[body, 11])
        far_center = (
            real(x + bodies.geometry[body, 9] - bodies.geometry[plane_body, 9]),
            real(y + bodies.geometry[body, 10] - bodies.geometry[plane_body, 10]),
            real(z + bodies.geometry[body, 11] - bodies.geometry[plane_body, 11]),
        )
        write_normal(contacts, target, vec.neg(n))
        contacts.gap[p] = math.inf
        kind = shapes.layout[row, KIND]
        radius = rounding(shapes, row)
        half = shapes.size[row, 1]
        down = vec.neg(mat.transpose_mul_vec(rotation, n))
        if kind in (BOX, HULL):
            first = shapes.layout[row, FIRST_VERTEX]
            for k in range(shapes.layout[row, VERTEX_COUNT]):
                point = mat.mul_vec(rotation, vec.load(shapes.vertices, first + k))
                _write_low_point(contacts, target, height, margin, n, center, far_center, zero, point, k)
        elif kind == CAPSULE:
            for end in range(2):
                point = mat.mul_vec(rotation, (zero, half if end == 0 else -half, zero))
                _write_low_point(contacts, target, height, margin, n, center, far_center, radius, point, end)
        else:
            count = supporting_feature(shapes, row, down, points, ids)
            for k in range(count):
                point = mat.mul_vec(rotation, vec.load(points, k))
                _write_low_point(contacts, target, height, margin, n, center, far_center, radius, point, ids[k])
            if count == RIM_POINTS and max(abs(down[0]), abs(down[2])) > LEVEL:
                point = mat.mul_vec(rotation, support(shapes, row, down))
                _write_low_point(contacts, target, height, margin, n, center, far_center, radius, point, LOWEST)
        contacts.gap[p] = certain_gap(contacts.gap[p], shapes, pair)
