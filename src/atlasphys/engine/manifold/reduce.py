"""Reduction of a pair's contact points to at most four, for depth and area.

Kept are the deepest point; the point farthest from it; the point that makes the largest triangle with the two; and the point that adds
most area on the other side of one of the triangle's edges. The first holds the pair apart, the rest span the support area
that keeps it from rocking. Ties go to the lower index, so that equal input gives equal output.
"""

from atlasphys.engine.jit import routine
from atlasphys.engine.math import vec
from atlasphys.engine.trace import TRACED, note


@routine
def reduce_points(normal, anchors, depths, first, count, kept):
    """Write the indices (first … first + count − 1) of at most four points into ``kept``, ascending, and return their number."""
    if count <= 4:
        for k in range(count):
            kept[k] = first + k
        return count
    end = first + count
    deepest = first
    for k in range(first + 1, end):
        if depths[k] > depths[deepest]:
            deepest = k
    p = vec.load(anchors, deepest)
    if TRACED:
        note("reduce.keep", why="deepest", index=deepest - first, value=depths[deepest])

    farthest, best = -1, depths[first] - depths[first]
    for k in range(first, end):
        distance = vec.length_squared(vec.sub(vec.load(anchors, k), p))
        if distance > best:
            farthest, best = k, distance
    if farthest < 0:  # all points coincide
        kept[0] = deepest
        return 1
    q = vec.load(anchors, farthest)
    if TRACED:
        note("reduce.keep", why="farthest", index=farthest - first, value=best)

    # Twice the signed area of p, q, k, seen along the normal.
    third, most = -1, best - best
    for k in range(first, end):
        area = vec.dot(normal, vec.cross(vec.sub(q, p), vec.sub(vec.load(anchors, k), p)))
        if abs(area) > abs(most):
            third, most = k, area
    if third < 0:  # all points lie on a line
        kept[0], kept[1] = min(deepest, farthest), max(deepest, farthest)
        return 2
    r = vec.load(anchors, third)
    if TRACED:
        note("reduce.keep", why="triangle", index=third - first, value=most)
    if most < 0:
        q, r = r, q  # p, q, r now run counter-clockwise

    fourth, best = -1, best - best
    for k in range(first, end):
        s = vec.load(anchors, k)
        outside = max(
            -vec.dot(normal, vec.cross(vec.sub(q, p), vec.sub(s, p))),
            -vec.dot(normal, vec.cross(vec.sub(r, q), vec.sub(s, q))),
            -vec.dot(normal, vec.cross(vec.sub(p, r), vec.sub(s, r))),
        )
        if outside > best:
            fourth, best = k, outside
    if TRACED and fourth >= 0:
        note("reduce.keep", why="other side", index=fourth - first, value=best)

    number = 0
    for k in range(first, end):
        if k in (deepest, farthest, third, fourth):
            kept[number] = k
            number += 1
    return number
