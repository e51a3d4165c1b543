"""Contact points of two shapes along a known normal, from the features that face each other.

Where a face meets something (face, edge or vertex), the other shape's feature is cut to the outline of the face by
the method of I. E. Sutherland and G. W. Hodgman, "Reentrant Polygon Clipping", CACM 17(1), 1974, one side plane after
the other; depths are measured along the face's own normal. Where two edges run side by side, there is a point at each
end of what they share. Else there is one point.

A normal from GJK, EPA or SAT gives way to that of a face that faces it, if the face's normal parts the shapes as well
up to ``bias``: so a box at rest has its face's exact normal whatever round-off says, and keeps the same features from
step to step.

Feature numbers: an incident vertex has its own id; a crossing of an incident edge and a side (or of two sides) has
the ids of both, each being that of the vertex where it starts; bit 29 tells that the face belongs to the second
shape; bit 30 marks contacts without a face.
"""

import math

import numpy as np

from atlasphys.engine.jit import allocating_routine, routine
from atlasphys.engine.math import mat, vec
from atlasphys.engine.narrowphase.gjk import difference_support
from atlasphys.engine.narrowphase.pair import write_normal, write_point
from atlasphys.engine.shapes.feature import supporting_feature
from atlasphys.engine.shapes.support import rounding
from atlasphys.engine.shapes.table import FEATURE_POINTS
from atlasphys.engine.trace import TRACED, note

FACING = 0.995
"""Cosine of the angle (5.7°) within which a face may stand in for the normal. Larger: round-off flips between one
point and four. Smaller: a face that only roughly faces the other shape is clipped, at a loss of depth that the bias
bounds."""

FACE_PREFERENCE = 0.025
"""Bias, as a part of the speculative margin (0.5 mm by default), in favour of faces over other normals, and of
vertices over the sides that they nearly touch. Smaller: features flicker in tilted stacks. Larger: a worse than the
least depth is reported by so much."""

PARALLEL = 0.03
"""Sine of the angle under which two edges count as parallel. Larger: crossing edges get two points, apart from where
they meet."""

ID_MASK, SIDE, CROSSING, ON_SECOND, NO_FACE = 0x1FFF, 0x2000, 1 << 28, 1 << 29, 1 << 30


@allocating_routine
def clip_scratch(shapes, dtype):
    """Memory for one feature as it comes, for both as placed, and for a polygon before and after a cut: points and
    ids of each.

    The last two are halves of one array: an array per half would be counted in and out at every use.
    """
    size = 2
    for row in range(len(shapes.layout)):
        size = max(size, shapes.layout[row, FEATURE_POINTS])
    return (
        np.empty((size, 3), dtype),
        np.empty(size, np.int32),
        np.empty((2 * size, 3), dtype),
        np.empty(2 * size, np.int32),
        np.empty((4 * size + 4, 3), dtype),
        np.empty((4 * size + 4, 2), np.int32),
    )


@routine
def _place_feature(points, ids, count, rotation, offset, placed, placed_ids, first):
    """From a shape's own frame to that of the pair, into rows ``first`` and following."""
    for k in range(count):
        vec.store(placed, first + k, vec.add(mat.mul_vec(rotation, vec.load(points, k)), offset))
        placed_ids[first + k] = ids[k] & ID_MASK


@routine
def _outward(points, first, count):
    """Unit normal of a polygon whose corners run counter-clockwise about it: the sum of the cross products (M. E.
    Newell)."""
    real = points.dtype.type
    n = (real(0), real(0), real(0))
    start = vec.load(points, first)
    u = vec.sub(vec.load(points, first + 1), start)
    for k in range(2, count):
        v = vec.sub(vec.load(points, first + k), start)
        n = vec.add(n, vec.cross(u, v))
        u = v
    length = vec.length(n)
    if length > 0:
        n = vec.scale(n, real(1) / length)
    return n


@routine
def _cut(polygon, ids, source, count, result, corner, outward, limit, side):
    """Cut a polygon (or segment, or point) to where ``(p − corner) · outward`` is at most ``limit``.

    Args:
        polygon, ids: the corners with their own ids and those of the edges that they begin.
        source, count: first row and number of corners.
        result: first row of the corners that are left.
        side: id of the edge that the cut makes.

    Returns:
        the number of corners left.
    """
    kept = result
    last = source + count - 1
    last_distance = vec.dot(vec.sub(vec.load(polygon, last), corner), outward) - limit
    for k in range(source, source + count):
        distance = vec.dot(vec.sub(vec.load(polygon, k), corner), outward) - limit
        # A segment's two ends are joined once, not there and back.
        if (distance > 0) != (last_distance > 0) and (count != 2 or k != source):
            s = last_distance / (last_distance - distance)
            edge = ids[last, 1]
            begin = vec.load(polygon, last)
            vec.store(polygon, kept, vec.add_scaled(begin, vec.sub(vec.load(polygon, k), begin), s))
            ids[kept, 0] = CROSSING | (edge << 14) | side
            ids[kept, 1] = side if distance > 0 else edge
            kept += 1
        if distance <= 0:
            vec.store(polygon, kept, vec.load(polygon, k))
            ids[kept, 0], ids[kept, 1] = ids[k, 0], ids[k, 1]
            kept += 1
        last, last_distance = k, distance
    return kept - result


@routine
def _clip_to_face(placed, placed_ids, face, face_count, n, other, count, slack, polygon, polygon_ids):
    """Cut a feature (rows ``other`` and following) to the outline of a face (rows ``face`` and following), widened by
    ``slack``.

    The face's corners run counter-clockwise about its outward unit normal n. Returns the first row of the result in
    ``polygon``, and its number of corners.
    """
    for k in range(count):
        vec.store(polygon, k, vec.load(placed, other + k))
        polygon_ids[k, 0] = polygon_ids[k, 1] = placed_ids[other + k]
    now, free = 0, len(polygon) // 2
    corner = vec.load(placed, face + face_count - 1)
    side = placed_ids[face + face_count - 1]
    for k in range(face, face + face_count):
        following = vec.load(placed, k)
        outward = vec.cross(vec.sub(following, corner), n)
        length = vec.length(outward)
        if length > 0 and count > 0:
            count = _cut(polygon, polygon_ids, now, count, free, corner, outward, slack * length, SIDE | side)
            now, free = free, now
            if TRACED:
                note("clip.cut", corner=corner, outward=outward, side=side, polygon=polygon[now : now + count])
        corner, side = following, placed_ids[k]
    return now, count


@routine
def _write_face_points(
    contacts, target, n, level, second, radius_a, radius_b, margin, polygon, polygon_ids, first, count
):
    """Write the points of a clipped polygon nearer to the face (at n · x = level) than the margin. Returns the
    greatest depth found."""
    real = type(margin)
    deepest = -real(math.inf)
    half = real(0.5)
    for k in range(first, first + count):
        p = vec.load(polygon, k)
        gap = level - vec.dot(p, n)
        depth = (-gap if second else gap) + radius_a + radius_b
        if TRACED:
            note("clip.depth", point=p, depth=depth, kept=depth > -margin, margin=margin)
        if depth > -margin:
            deepest = max(deepest, depth)
            middle = vec.add_scaled(p, n, half * (gap + radius_a - radius_b))
            write_point(contacts, target, middle, depth, polygon_ids[k, 0] | (ON_SECOND if second else 0))
    return deepest


@routine
def _supporting_edge(points, first, count, n):
    """The edge (or vertex) of a feature that lies farthest along n, its start first: two rows, and how many of them
    count."""
    if count == 1:
        return first, first, 1
    best = first
    for k in range(first + 1, first + count):
        if vec.dot(vec.sub(vec.load(points, k), vec.load(points, best)), n) > 0:
            best = k
    after = first + (best - first + 1) % count
    before = first + (best - first + count - 1) % count
    here = vec.load(points, best)
    u, v = vec.sub(vec.load(points, after), here), vec.sub(vec.load(points, before), here)
    fall_u, fall_v = -vec.dot(u, n), -vec.dot(v, n)
    length_u, length_v = vec.length(u), vec.length(v)
    parallel = type(fall_u)(PARALLEL)
    if fall_v * length_u < fall_u * length_v:
        return (before, best, 2) if fall_v <= parallel * length_v else (best, best, 1)
    return (best, after, 2) if fall_u <= parallel * length_u else (best, best, 1)


@routine
def write_edges(
    contacts, target, n, depth, on_a, on_b, radius_a, radius_b, margin, placed, ids, count_a, first_b, count_b
):
    """Contact without a face: two points where edges run side by side, else the one given (``on_a`` and ``on_b``, on
    the cores)."""
    real = type(depth)
    half = real(0.5)
    a0, a1, ends_a = _supporting_edge(placed, 0, count_a, n)
    b0, b1, ends_b = _supporting_edge(placed, first_b, count_b, vec.neg(n))
    feature = NO_FACE | (ids[a0] << 14) | ids[b0]
    if ends_a == 2 and ends_b == 2:
        start, other = vec.load(placed, a0), vec.load(placed, b0)
        u = vec.sub(vec.load(placed, a1), start)
        v = vec.sub(vec.load(placed, b1), other)
        uu = vec.length_squared(u)
        if uu > 0 and vec.length_squared(vec.cross(u, v)) <= real(PARALLEL * PARALLEL) * uu * vec.length_squared(v):
            s0 = vec.dot(vec.sub(other, start), u) / uu
            s1 = s0 + vec.dot(v, u) / uu
            lower, upper = max(real(0), min(s0, s1)), min(real(1), max(s0, s1))
            if upper > lower:
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
                if deepest >= depth - real(2 * FACE_PREFERENCE) * margin:
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
    points, ids, placed, placed_ids, polygon, polygon_ids = scratch
    real = type(distance)
    half = real(0.5)
    radius_a, radius_b = rounding(shapes, row_a), rounding(shapes, row_b)
    count_a = supporting_feature(shapes, row_a, mat.transpose_mul_vec(rotation_a, n), points, ids)
    _place_feature(points, ids, count_a, rotation_a, (real(0), real(0), real(0)), placed, placed_ids, 0)
    count_b = supporting_feature(shapes, row_b, mat.transpose_mul_vec(rotation_b, vec.neg(n)), points, ids)
    _place_feature(points, ids, count_b, rotation_b, d, placed, placed_ids, count_a)

    if TRACED:
        features = placed[:count_a], placed[count_a : count_a + count_b]
        note("clip.features", normal=n, distance=distance, on_a=features[0], on_b=features[1])
    # A face stands in for n if it parts the shapes as well; the first shape's face goes before the second's.
    face = -1
    face_normal = n
    for side in range(2):
        count = count_a if side == 0 else count_b
        if face < 0 and count >= 3:
            candidate = _outward(placed, side * count_a, count)
            if side == 1:
                candidate = vec.neg(candidate)
            if vec.dot(candidate, n) > real(FACING):
                w, _ = difference_support(shapes, pair, candidate)
                along = -vec.dot(w, candidate)
                if TRACED:
                    note("clip.face", side=side, normal=candidate, distance=along, allowed=distance - bias)
                if along >= distance - bias:
                    face = side
                    face_normal = candidate
                    distance = along
    depth = radius_a + radius_b - distance
    write_normal(contacts, target, face_normal)
    if face < 0:
        write_edges(
            contacts,
            target,
            n,
            depth,
            on_a,
            on_b,
            radius_a,
            radius_b,
            margin,
            placed,
            placed_ids,
            count_a,
            count_a,
            count_b,
        )
        return
    second = face == 1
    begin, count, other, other_count = (count_a, count_b, 0, count_a) if second else (0, count_a, count_a, count_b)
    outward = vec.neg(face_normal) if second else face_normal
    first, left = _clip_to_face(
        placed, placed_ids, begin, count, outward, other, other_count, bias, polygon, polygon_ids
    )
    level = vec.dot(vec.load(placed, begin), face_normal)
    deepest = _write_face_points(
        contacts, target, face_normal, level, second, radius_a, radius_b, margin, polygon, polygon_ids, first, left
    )
    # The deepest point may be missing where a round rim is clipped as an octagon.
    if deepest < depth - bias - bias:
        middle = vec.add_scaled(vec.scale(vec.add(on_a, on_b), half), n, half * (radius_a - radius_b))
        write_point(contacts, target, middle, depth, NO_FACE | (SIDE << 14))
