"""Of the corners of a contact polygon at most four are kept, as in ``engine/manifold/reduce.py``: the deepest; the one
farthest from it; the one that makes the largest triangle with the two; the one that adds most area outside one of the
triangle's sides."""

from __future__ import annotations

from typing import Any, NamedTuple

from atlasphys.engine.simd import absolute, full, maximum, select, vec


class Point(NamedTuple):
    """A candidate: whether it counts, its place in the plane of the face, its depth."""

    valid: Any
    x: Any
    y: Any
    depth: Any


def keep_four(points: list[Point], margin: Any, slack: Any, rows: Any) -> Any:
    """At most four of the points deeper than −margin: ``used, x, y, depth, number`` of each.

    Points nearer than ``slack`` to the points or lines kept before do not count: they add no support. Nor is a later
    point deeper that is deeper by less: which one is the first to be kept shall not change with every bit.

    Args:
        rows: any integer lanes, to make more like them.
    """
    valid = [point.valid & (point.depth > -margin) for point in points]
    candidates = [(point.x, point.y, point.depth, full(rows, k)) for k, point in enumerate(points)]
    zero = full(points[0].x, 0)
    nothing = zero, zero, zero, full(rows, 0)
    nowhere = valid[0] & ~valid[0]

    p, used_p, level = nothing, nowhere, full(zero, -1e30)
    for k, point in enumerate(points):
        better = valid[k] & (point.depth > level)
        p, level = vec.select_vec(better, candidates[k], p), select(better, point.depth + slack, level)
        used_p = used_p | better

    apart = [(point.x - p[0], point.y - p[1]) for point in points]
    q, used_q, greatest, to_q = nothing, nowhere, slack * slack, (zero, zero)
    for k, (x, y) in enumerate(apart):
        squared = x * x + y * y
        better = valid[k] & (squared > greatest)
        q, greatest = vec.select_vec(better, candidates[k], q), select(better, squared, greatest)
        to_q, used_q = vec.select_vec(better, (x, y), to_q), used_q | better

    # Twice the signed areas of the triangles p, q, k.
    areas = [to_q[0] * y - to_q[1] * x for x, y in apart]
    least = slack * (absolute(to_q[0]) + absolute(to_q[1]))
    r, used_r, greatest, signed, to_r = nothing, nowhere, least, zero, (zero, zero)
    for k, area in enumerate(areas):
        better = valid[k] & (absolute(area) > greatest)
        r, greatest = vec.select_vec(better, candidates[k], r), select(better, absolute(area), greatest)
        signed, to_r, used_r = select(better, area, signed), vec.select_vec(better, apart[k], to_r), used_r | better

    # Counted as from a triangle that runs counter-clockwise. A point's areas with its three sides add up to its own.
    side = select(signed < 0, full(zero, -1), 1)
    to_r = side * to_r[0], side * to_r[1]
    s, used_s, greatest = nothing, nowhere, least
    for k, (x, y) in enumerate(apart):
        beyond_pq = -(side * areas[k])
        beyond_rp = to_r[0] * y - to_r[1] * x
        beyond_qr = -(absolute(signed) + beyond_pq + beyond_rp)
        outside = maximum(maximum(beyond_pq, beyond_rp), beyond_qr)
        better = valid[k] & used_r & (outside > greatest)
        s, greatest = vec.select_vec(better, candidates[k], s), select(better, outside, greatest)
        used_s = used_s | better
    return [(used, *point) for used, point in ((used_p, p), (used_q, q), (used_r, r), (used_s, s))]
