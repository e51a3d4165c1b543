"""A capsule and a box: the segment's nearest point to the box, or the least overlap of segment and box, then clipping.

The squared distance of the point c + t u of the segment from the box is convex in t and quadratic between the values
at which the point passes one of the six planes of the faces. Those that lie in the range halve it by the sign of the
derivative, until it is linear.
"""

import math

from atlasphys.engine.jit import allocating_kernel, routine
from atlasphys.engine.math import mat, vec
from atlasphys.engine.narrowphase.clip import FACE_PREFERENCE, clip_scratch, write_contact
from atlasphys.engine.narrowphase.gjk import precision
from atlasphys.engine.narrowphase.pair import place
from atlasphys.engine.narrowphase.sat import PARALLEL_SQUARED
from atlasphys.engine.narrowphase.segments import closest_of_segments


@routine
def _to_box(point, half):
    """The vector from the box to a point outside it; zero inside."""
    x, y, z = point
    hx, hy, hz = half
    return x - min(max(x, -hx), hx), y - min(max(y, -hy), hy), z - min(max(z, -hz), hz)


@routine
def nearest_parameter(center, along, half):
    """The t in −1 to 1 for which ``center + t along`` is nearest to the box about the origin."""
    real = type(center[0])
    lower, upper = real(-1), real(1)
    for k in range(6):
        c, u, h = center[0], along[0], half[0]
        if k % 3 == 1:
            c, u, h = center[1], along[1], half[1]
        elif k % 3 == 2:
            c, u, h = center[2], along[2], half[2]
        if u != 0:
            t = ((h if k < 3 else -h) - c) / u
            if lower < t < upper:
                if vec.dot(_to_box(vec.add_scaled(center, along, t), half), along) > 0:
                    upper = t
                else:
                    lower = t
    slope_lower = vec.dot(_to_box(vec.add_scaled(center, along, lower), half), along)
    slope_upper = vec.dot(_to_box(vec.add_scaled(center, along, upper), half), along)
    if slope_lower >= 0:
        return lower if slope_lower > 0 or slope_upper > 0 else real(0.5) * (lower + upper)
    if slope_upper <= 0:
        return upper
    return lower + (upper - lower) * slope_lower / (slope_lower - slope_upper)


@routine
def _overlap(center, along, half, bias):
    """Least overlap of a segment with the box, by the separating axis test over three faces and three edges.

    Returns:
        the unit normal out of the box, the distance along it (negative), and the point of the segment deepest in the
        box.
    """
    real = type(center[0])
    zero, one = real(0), real(1)
    best = -real(math.inf)
    normal = (one, zero, zero)
    for k in range(3):
        c, u, h = center[0], along[0], half[0]
        axis = (one, zero, zero)
        if k == 1:
            c, u, h = center[1], along[1], half[1]
            axis = (zero, one, zero)
        elif k == 2:
            c, u, h = center[2], along[2], half[2]
            axis = (zero, zero, one)
        distance = abs(c) - h - abs(u)
        if distance > best:
            best = distance
            normal = axis if c >= 0 else vec.neg(axis)
    end = vec.sub(center, along) if vec.dot(along, normal) > 0 else vec.add(center, along)
    face = best
    for k in range(3):
        axis = (zero, -along[2], along[1])
        edge = (half[0], zero, zero)
        if k == 1:
            axis = (along[2], zero, -along[0])
            edge = (zero, half[1], zero)
        elif k == 2:
            axis = (-along[1], along[0], zero)
            edge = (zero, zero, half[2])
        squared = vec.length_squared(axis)
        if squared > real(PARALLEL_SQUARED) * vec.length_squared(along):
            axis = vec.scale(axis, one / math.sqrt(squared))
            side = vec.dot(center, axis)
            distance = abs(side) - half[0] * abs(axis[0]) - half[1] * abs(axis[1]) - half[2] * abs(axis[2])
            if distance > best and distance > face + bias:
                best = distance
                normal = axis if side >= 0 else vec.neg(axis)
                corner = (
                    half[0] if normal[0] > 0 else -half[0],
                    half[1] if normal[1] > 0 else -half[1],
                    half[2] if normal[2] > 0 else -half[2],
                )
                start = (
                    corner[0] if k != 0 else -half[0],
                    corner[1] if k != 1 else -half[1],
                    corner[2] if k != 2 else -half[2],
                )
                s, _ = closest_of_segments(vec.sub(center, along), vec.add(along, along), start, vec.add(edge, edge))
                end = vec.add_scaled(center, along, s + s - one)
    return normal, best, end


@allocating_kernel
def capsule_box(rows, bodies, colliders, shapes, margin, contacts):
    """Contacts of pairs of a capsule and a box."""
    real = contacts.depth.dtype.type
    margin = real(margin)
    bias = real(FACE_PREFERENCE) * margin
    scratch = clip_scratch(shapes, contacts.depth.dtype)
    for p in rows:
        pair, target = place(bodies, colliders, shapes, contacts, p)
        capsule, box, capsule_rotation, rotation, d = pair
        half = (shapes.size[box, 0], shapes.size[box, 1], shapes.size[box, 2])
        center = mat.transpose_mul_vec(rotation, vec.neg(d))
        axis = (capsule_rotation[1], capsule_rotation[4], capsule_rotation[7])
        along = vec.scale(mat.transpose_mul_vec(rotation, axis), shapes.size[capsule, 1])
        point = vec.add_scaled(center, along, nearest_parameter(center, along, half))
        out = _to_box(point, half)
        distance = vec.length(out)
        if distance - shapes.size[capsule, 0] >= margin:
            continue
        # Where the segment all but touches the box, the direction between them is round-off.
        noise = real(64) * precision(distance) * (vec.length(half) + shapes.size[capsule, 1])
        if distance > noise:
            normal = vec.scale(out, real(1) / distance)
        else:
            normal, distance, point = _overlap(center, along, half, bias)
        normal = vec.neg(mat.mul_vec(rotation, normal))
        on_a = vec.add(mat.mul_vec(rotation, point), d)
        on_b = vec.add_scaled(on_a, normal, distance)
        write_contact(shapes, contacts, target, pair, normal, distance, on_a, on_b, bias, margin, scratch)
