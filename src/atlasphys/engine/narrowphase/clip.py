"""Contact points of two shapes along a known normal, from the features that face each other.

Where a face meets something (face, edge or vertex), the other shape's feature is cut to the outline of the face by the method of
I. E. Sutherland and G. W. Hodgman, "Reentrant Polygon Clipping", CACM 17(1), 1974, one side plane after the other; depths are measured
along the face's own normal. Where two edges run side by side, there is a point at each end of what they share. Else there is one point.

A normal from GJK, EPA or SAT gives way to that of a face that faces it, if the face's normal parts the shapes as well up to ``bias``:
so a box at rest has its face's exact normal whatever round-off says, and keeps the same features from step to step.

Feature numbers: an incident vertex has its own id; a crossing of an incident edge and a side (or of two sides) has the ids of both, each
being that of the vertex where it starts; bit 29 tells that the face belongs to the second shape; bit 30 marks contacts without a face.
"""

import math

import numpy as np

from atlasphys.engine.jit import routine
from atlasphys.engine.math import mat, vec
from atlasphys.engine.narrowphase.gjk import difference_support
from atlasphys.engine.narrowphase.pair import write_normal, write_point
from atlasphys.engine.shapes.feature import supporting_feature
from atlasphys.engine.shapes.support import rounding
from atlasphys.engine.shapes.table import FEATURE_POINTS

FACING = 0.995
"""Cosine of the angle (5.7°) within which a face may stand in for the normal. Larger: round-off flips between one point and four.
Smaller: a face that only roughly faces the other shape is clipped, at a loss of depth that the bias bounds."""

FACE_PREFERENCE = 0.025
"""Bias, as a part of the speculative margin (0.5 mm by default), in favour of faces over other normals, and of vertices over the sides
that they nearly touch. Smaller: features flicker in tilted stacks. Larger: a worse than the least depth is reported by so much."""

PARALLEL = 0.03
"""Sine of the angle under which two edges count as parallel. Larger: crossing edges get two points, apart from where they meet."""

ID_MASK, SIDE, CROSSING, ON_SECOND, NO_FACE = 0x1FFF, 0x2000, 1 << 28, 1 << 29, 1 << 30


@routine
def clip_scratch(shapes, real):
    """Memory for two features and for a polygon before and after a cut: points and ids of each."""
    size = 2
    for row in range(len(shapes.layout)):
        size = max(size, shapes.layout[row, FEATURE_POINTS])
    return (
        np.empty((2, size, 3), real),
        np.empty((2, size), np.int32),
        np.empty((2, 2 * size + 2, 3), real),
        np.empty((2, 2 * size + 2, 2), np.int32),
    )


@routine
def _turn(points, count, rotation, offset):
    """From a shape's own frame to that of the pair."""
    for k in range(count):
        vec.store(points, k, vec.add(mat.mul_vec(rotation, vec.load(points, k)), offset))


@routine
def _outward(points, count):
    """Unit normal of a polygon whose corners run counter-clockwise about it: the sum of the cross products (M. E. Newell)."""
    zero = points.dtype.type(0)
    n = (zero, zero, zero)
    first = vec.load(points, 0)
    for k in range(1, count - 1):
        n = vec.add(n, vec.cross(vec.sub(vec.load(points, k), first), vec.sub(vec.load(points, k + 1), first)))
    length = vec.length(n)
    if length > 0:
        n = vec.scale(n, type(zero)(1) / length)
    return n


@routine
def _cut(source, source_ids, count, corner, outward, side, result, result_ids):
    """Cut a polygon (or segment, or point) by a side plane through ``corner``. Returns the number of corners left."""
    kept = 0
    last = count - 1
    last_distance = vec.dot(vec.sub(vec.load(source, last), corner), outward)
    for k in range(count):
        distance = vec.dot(vec.sub(vec.load(source, k), corner), outward)
        # A segment's two ends are joined once, not there and back.
        if (distance > 0) != (last_distance > 0) and not (count == 2 and k == 0):
            s = last_distance / (last_distance - distance)
            edge = source_ids[last, 1]
            crossing = vec.add_scaled(vec.load(source, last), vec.sub(vec.load(source, k), vec.load(source, last)), s)
            vec.store(result, kept, crossing)
            result_ids[kept, 0] = CROSSING | (edge << 14) | side
            result_ids[kept, 1] = side if distance > 0 else edge
            kept += 1
        if distance <= 0:
            vec.store(result, kept, vec.load(source, k))
            result_ids[kept, 0], result_ids[kept, 1] = source_ids[k, 0], source_ids[k, 1]
            kept += 1
        last, last_distance = k, distance
    return kept


@routine
def clip_to_face(face, face_ids, face_count, n, points, ids, count, slack, polygons, polygon_ids):
    """Cut a feature to the outline of a face, widened by ``slack``.

    Args:
        face, face_ids, face_count: corners of the face, counter-clockwise about its outward unit normal n.
        points, ids, count: corners of the other feature.
        polygons, polygon_ids: scratch of two polygons.

    Returns:
        which of the two polygons holds the result, and its number of corners.
    """
    for k in range(count):
        vec.store(polygons[0], k, vec.load(points, k))
        polygon_ids[0, k, 0] = polygon_ids[0, k, 1] = ids[k] & ID_MASK
    now = 0
    for k in range(face_count):
        corner = vec.load(face, k)
        outward = vec.cross(vec.sub(vec.load(face, (k + 1) % face_count), corner), n)
        length = vec.length(outward)
        if length > 0 and count > 0:
            outward = vec.scale(outward, type(length)(1) / length)
            side = SIDE | (face_ids[k] & ID_MASK)
            count = _cut(
                polygons[now],
                polygon_ids[now],
                count,
                vec.add_scaled(corner, outward, slack),
                outward,
                side,
                polygons[1 - now],
                polygon_ids[1 - now],
            )
            now = 1 - now
    return now, count


@routine
def _write_face_points(contacts, target, n, plane_point, second, radius_a, radius_b, margin, polygon, polygon_ids, count):
    """Write the points of a clipped polygon nearer to the face than the margin. Returns the greatest depth found."""
    real = type(margin)
    deepest = -real(math.inf)
    half = real(0.5)
    for k in range(count):
        p = vec.load(polygon, k)
        gap = vec.dot(vec.sub(plane_point, p), n)
        depth = (-gap if second else gap) + radius_a + radius_b
        if depth > -margin:
            deepest = max(deepest, depth)
            middle = vec.add_scaled(p, n, half * (gap + radius_a - radius_b))
            write_point(contacts, target, middle, depth, polygon_ids[k, 0] | (ON_SECOND if second else 0))
    return deepest


@routine
def _supporting_edge(points, ids, count, n):
    """The edge (or vertex) of a feature that lies farthest along n, its start first: two rows, and how many count."""
    if count == 1:
        return 0, 0, 1
    best = 0
    for k in range(1, count):
        if vec.dot(vec.sub(vec.load(points, k), vec.load(points, best)), n) > 0:
            best = k
    after, before = (best + 1) % count, (best + count - 1) % count
    here = vec.load(points, best)
    u, v = vec.sub(vec.load(points, after), here), vec.sub(vec.load(points, before), here)
    fall_u, fall_v = -vec.dot(u, n), -vec.dot(v, n)
    length_u, length_v = vec.length(u), vec.length(v)
    first, second, fall, length = best, after, fall_u, length_u
    if fall_v * length_u < fall_u * length_v:
        first, second, fall, length = before, best, fall_v, length_v
    if fall > type(fall)(PARALLEL) * length:
        return best, best, 1
    return first, second, 2


@routine
def write_edges(contacts, target, n, depth, on_a, on_b, radius_a, radius_b, margin, points, ids, count_a, count_b):
    """Contact without a face: two points where edges run side by side, else the one given (``on_a`` and ``on_b``, on the cores)."""
    real = type(depth)
    half = real(0.5)
    a0, a1, ends_a = _supporting_edge(points[0], ids[0], count_a, n)
    b0, b1, ends_b = _supporting_edge(points[1], ids[1], count_b, vec.neg(n))
    feature = NO_FACE | ((ids[0, a0] & ID_MASK) << 14) | (ids[1, b0] & ID_MASK)
    if ends_a == 2 and ends_b == 2:
        start, other = vec.load(points[0], a0), vec.load(points[1], b0)
        u = vec.sub(vec.load(points[0], a1), start)
        v = vec.sub(vec.load(points[1], b1), other)
        uu = vec.length_squared(u)
        if vec.length_squared(vec.cross(u, v)) <= real(PARALLEL * PARALLEL) * uu * vec.length_squared(v) and uu > 0:
            zero, one = real(0), real(1)
            s0 = vec.dot(vec.sub(other, start), u) / uu
            s1 = s0 + vec.dot(v, u) / uu
            lower, upper = max(zero, min(s0, s1)), min(one, max(s0, s1))
            if upper > lower and s0 != s1:
                deepest = -real(math.inf)
                for end in range(2):
                    s = lower if end == 0 else upper
                    p = vec.add_scaled(start, u, s)
                    q = vec.add_scaled(other, v, (s - s0) / (s1 - s0))
                    point_depth = radius_a + radius_b - vec.dot(vec.sub(q, p), n)
                    if point_depth > -margin:
                        middle = vec.add_scaled(vec.scale(vec.add(p, q), half), n, half * (radius_a - radius_b))
                        write_point(contacts, target, middle, point_depth, feature + (SIDE if end == 1 else 0))
                        deepest = max(deepest, point_depth)
                if deepest >= depth - half * margin:
                    return
                contacts.count[target[0]] = 0
    middle = vec.add_scaled(vec.scale(vec.add(on_a, on_b), half), n, half * (radius_a - radius_b))
    write_point(contacts, target, middle, depth, feature)


@routine
def write_contact(shapes, contacts, target, pair, n, distance, on_a, on_b, bias, margin, scratch):
    """All contact points of two shapes that meet along the unit normal n.

    Args:
        distance: of the cores along n, negative where they overlap.
        on_a, on_b: the points of the cores that are nearest to each other or overlap most.
        bias: the loss of distance at which a face's normal is still preferred to n.
        scratch: from :func:`clip_scratch`.
    """
    row_a, row_b, rotation_a, rotation_b, d = pair
    points, ids, polygons, polygon_ids = scratch
    zero = type(distance)(0)
    radius_a, radius_b = rounding(shapes, row_a), rounding(shapes, row_b)
    count_a = supporting_feature(shapes, row_a, mat.transpose_mul_vec(rotation_a, n), points[0], ids[0])
    count_b = supporting_feature(shapes, row_b, mat.transpose_mul_vec(rotation_b, vec.neg(n)), points[1], ids[1])
    _turn(points[0], count_a, rotation_a, (zero, zero, zero))
    _turn(points[1], count_b, rotation_b, d)

    # A face stands in for n if it parts the shapes as well; the first shape's face goes before the second's, the flatter way round.
    face = -1
    face_normal = n
    for side in range(2):
        count = count_a if side == 0 else count_b
        if face < 0 and count >= 3:
            outward = _outward(points[side], count)
            candidate = outward if side == 0 else vec.neg(outward)
            if vec.dot(candidate, n) > type(zero)(FACING):
                w, _ = difference_support(shapes, pair, candidate)
                if -vec.dot(w, candidate) >= distance - bias:
                    face = side
                    face_normal = candidate
    depth = radius_a + radius_b - distance
    if face >= 0:
        write_normal(contacts, target, face_normal)
        other = 1 - face
        face_count, other_count = (count_a, count_b) if face == 0 else (count_b, count_a)
        now, count = clip_to_face(
            points[face],
            ids[face],
            face_count,
            face_normal if face == 0 else vec.neg(face_normal),
            points[other],
            ids[other],
            other_count,
            bias,
            polygons,
            polygon_ids,
        )
        deepest = _write_face_points(
            contacts,
            target,
            face_normal,
            vec.load(points[face], 0),
            face == 1,
            radius_a,
            radius_b,
            margin,
            polygons[now],
            polygon_ids[now],
            count,
        )
        # The deepest point may be missing where a round rim is clipped as an octagon.
        if deepest < depth - bias - bias:
            middle = vec.add_scaled(vec.scale(vec.add(on_a, on_b), type(zero)(0.5)), n, type(zero)(0.5) * (radius_a - radius_b))
            write_point(contacts, target, middle, depth, NO_FACE | (SIDE << 14))
        return
    write_normal(contacts, target, n)
    write_edges(contacts, target, n, depth, on_a, on_b, radius_a, radius_b, margin, points, ids, count_a, count_b)
