"""A capsule and a box: the segment's nearest point to the box, or the least overlap of segment and box; two points
where the segment lies along a face or an edge.

The squared distance of the point c + t u of the segment from the box is convex in t and quadratic between the values
at which the point passes one of the six planes of the faces. Those that lie in the range halve it by the sign of the
derivative, until it is linear.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from atlasphys.engine.narrowphase.clip import FACE_PREFERENCE, FACING, PARALLEL
from atlasphys.engine.narrowphase.lanes.common import (
    ASIDE,
    FIRST,
    SECOND,
    clamp,
    one_or_two_points,
    room_of_segment,
    sign,
    vector,
    within,
    write_contact,
)
from atlasphys.engine.narrowphase.sat import PARALLEL_SQUARED
from atlasphys.engine.simd import absolute, full, gather, load, maximum, minimum, select, simd_kernel, sqrt, vec


def _to_box(point: Any, half: Any) -> Any:
    """The vector from the box to a point outside it; zero inside."""
    return tuple(x - clamp(x, h) for x, h in zip(point, half, strict=True))


def _nearest_parameter(center: Any, along: Any, half: Any) -> Any:
    """The t in −1 to 1 for which ``center + t along`` is nearest to the box about the origin."""

    def slope(t: Any) -> Any:
        return vec.dot(_to_box(vec.add_scaled(center, along, t), half), along)

    lower, upper = full(center[0], -1), full(center[0], 1)
    for c, u, h in zip(center, along, half, strict=True):
        for face in (h, -h):
            t = (face - c) / u
            between = (lower < t) & (t < upper)  # not where u is zero
            rising = slope(t) > 0
            upper, lower = select(between & rising, t, upper), select(between & ~rising, t, lower)
    low, high = slope(lower), slope(upper)
    inside = lower + (upper - lower) * low / (low - high)
    inside = select(high <= 0, upper, inside)
    at_lower = select((low > 0) | (high > 0), lower, 0.5 * (lower + upper))
    return select(low >= 0, at_lower, inside)


def _overlap(center: Any, along: Any, half: Any, bias: Any) -> Any:
    """Least overlap of a segment with the box, by the separating axis test over three faces and three edges.

    Returns ``normal, distance, t``: the unit normal out of the box, the distance along it (negative), and where on the
    segment its deepest point is.
    """
    zero, one = full(center[0], 0), full(center[0], 1)
    best, normal = full(zero, -float("inf")), (one, zero, zero)
    for k in range(3):
        distance = absolute(center[k]) - half[k] - absolute(along[k])
        better = distance > best
        axis = tuple(sign(center[k]) if i == k else zero for i in range(3))
        best, normal = select(better, distance, best), vec.select_vec(better, axis, normal)
    t = -sign(vec.dot(along, normal))
    face = best
    length_squared = vec.length_squared(along)
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        squared = along[i] * along[i] + along[j] * along[j]
        inverse = 1 / sqrt(squared)
        x, y = -along[j] * inverse, along[i] * inverse  # the axis, square to the edge and the segment
        side = center[i] * x + center[j] * y
        distance = absolute(side) - half[i] * absolute(x) - half[j] * absolute(y)
        better = (distance > best) & (distance > face + bias) & (squared > PARALLEL_SQUARED * length_squared)
        x, y = sign(side) * x, sign(side) * y
        from_i, from_j = sign(x) * half[i] - center[i], sign(y) * half[j] - center[j]
        nearest = clamp((from_i * along[i] + from_j * along[j]) / squared, one)
        axis = tuple(x if n == i else y if n == j else zero for n in range(3))
        best, normal, t = (
            select(better, distance, best),
            vec.select_vec(better, axis, normal),
            select(better, nearest, t),
        )
    return normal, best, t


@simd_kernel
def capsule_box(pairs, geometry, place, margin, contact, tags) -> bool:
    """Contacts of eight pairs of a capsule and a box.

    Features: 0 a single point, 1 and 2 the ends of the part of the segment along a face or edge.
    """
    rotation = gather(geometry, load(pairs, 1), 16)[0:9]
    axis = vec.column(gather(geometry, load(pairs, 0), 16), 1)
    radius, length, half = load(place, FIRST), load(place, FIRST + 1), vector(place, SECOND)
    d = vector(place)
    bias = FACE_PREFERENCE * margin
    # In the box's frame.
    center = vec.mat_transpose_mul_vec(rotation, vec.neg(d))
    along = vec.scale(vec.mat_transpose_mul_vec(rotation, axis), length)
    t = _nearest_parameter(center, along, half)
    out = _to_box(vec.add_scaled(center, along, t), half)
    distance = vec.length(out)
    # Where the segment all but touches the box, the direction between them is round-off.
    apart = distance > 64 * float(np.finfo(distance.dtype).eps) * (vec.length(half) + length)
    normal, overlap, deepest = _overlap(center, along, half, bias)
    normal = vec.select_vec(apart, vec.scale(out, 1 / distance), normal)
    distance, t = select(apart, distance, overlap), select(apart, t, deepest)

    # A face stands in for the normal if it parts the two as well.
    zero = full(t, 0)
    on_face, least = [], distance
    for k in range(3):
        level = absolute(center[k]) - absolute(along[k]) - half[k]
        on_face.append((normal[k] * sign(center[k]) > FACING) & (level >= distance - bias))
        least = select(on_face[k], level, least)
    flat = on_face[0] | on_face[1] | on_face[2]
    standing = tuple(select(flat, select(on_face[k], sign(center[k]), zero), normal[k]) for k in range(3))

    # The part of the segment along the face, or along an edge that is nearly parallel and square to the normal.
    low, high, tangential = full(t, -1), full(t, 1), []
    square = ~flat & (absolute(vec.dot(normal, along)) <= PARALLEL * length) & (length > 0)
    for k in range(3):
        parallel = square & (absolute(along[k]) >= (1 - 0.5 * PARALLEL * PARALLEL) * length)
        tangential.append((flat & ~on_face[k]) | parallel)
        begin, end = within(center[k], along[k], half[k] + bias)
        low, high = select(tangential[k], maximum(begin, low), low), select(tangential[k], minimum(end, high), high)
    both = (tangential[0] | tangential[1] | tangential[2]) & (low < high)

    inward = vec.neg(vec.mat_mul_vec(rotation, normal))
    inward_ends = vec.neg(vec.mat_mul_vec(rotation, standing))

    def point(t: Any, gap: Any, inward: Any) -> Any:
        """Midway between the surfaces about a point of the segment."""
        return vec.add_scaled(vec.scale(axis, t * length), inward, 0.5 * (gap + radius)), radius - gap

    ends, nearest = [], full(t, float("inf"))
    for end in (low, high):
        core = vec.add_scaled(center, along, end)
        out = tuple(select(tangential[k], zero, core[k] - select(standing[k] < 0, -half[k], half[k])) for k in range(3))
        gap = vec.dot(out, standing)
        both = both & (vec.length_squared(out) - gap * gap <= ASIDE * ASIDE * radius * radius)
        nearest = minimum(gap, nearest)
        ends.append(point(end, gap, inward_ends))
    both = both & (nearest <= least + 2 * bias)
    points = one_or_two_points(point(t, distance, inward), ends, both, margin, load(pairs, 0))
    room = room_of_segment(distance - radius, radius, margin)
    return write_contact(pairs, contact, tags, vec.select_vec(both, inward_ends, inward), points, room)
