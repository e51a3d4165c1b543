"""Of the corners of a contact polygon at most four are kept, as in ``engine/manifold/reduce.py``: the deepest; the one
farthest from it; the one that makes the largest triangle with the two; the one that adds most area outside one of the
triangle's sides."""

from __future__ import annotations

from typing import Any, NamedTuple

from atlasphys.engine.simd import absolute, full, maximum, select


class Point(NamedTuple):
    """A candidate: whether it counts, its place in the plane of the face, its depth."""

    valid: Any
    x: Any
    y: Any
    depth: Any


def keep_four(points: list[Point], fallback: Point, margin: Any, slack: Any, rows: Any) -> Any:
    """At most four of the points deeper than −margin: ``used, (x, y), depth, number`` of each.

    Points nearer than ``slack`` to the points or lines kept before do not count: they add no support. Nor is a later
    point deeper that is deeper by less: which one is the first to be kept shall not change with every bit. Where no
    point counts, the fallback stands in, with number 12.
    """
    valid = [point.valid & (point.depth > -margin) for point in points]

    def better(mask: Any, k: int, kept: Any) -> Any:
        """The candidate in the lanes of the mask."""
        _, x, y, depth = points[k]
        return select(mask, x, kept[0]), select(mask, y, kept[1]), select(mask, depth, kept[2]), select(
            mask, full(rows, k), kept[3]
        )

    def none(like: Any) -> Any:
        zero = full(like, 0)
        return zero, zero, zero, full(rows, 0)

    p = fallback.x, fallback.y, fallback.depth, full(rows, 12)
    nowhere = valid[0] & ~valid[0]
    found, level = nowhere, full(p[2], -1e30)
    for k, point in enumerate(points):
        mask = valid[k] & (point.depth > level)
        p, level = better(mask, k, p), select(mask, point.depth + slack, level)
        found = found | mask
    deepest = found | (fallback.valid & ~found)

    apart = [(point.x - p[0], point.y - p[1]) for point in points]
    q, greatest = none(p[0]), slack * slack
    reach = none(p[0])[0:2]
    used_q = nowhere
    for k, (x, y) in enumerate(apart):
        squared = x * x + y * y
        mask = valid[k] & (squared > greatest)
        q, greatest = better(mask, k, q), select(mask, squared, greatest)
        reach = select(mask, x, reach[0]), select(mask, y, reach[1])
        used_q = used_q | mask

    # Twice the signed areas of the triangles p, q, k.
    least = slack * (absolute(reach[0]) + absolute(reach[1]))
    areas = [reach[0] * y - reach[1] * x for x, y in apart]
    r, signed, most = none(p[0]), none(p[0])[0], least
    used_r = nowhere
    for k, area in enumerate(areas):
        mask = valid[k] & (absolute(area) > most)
        r, most, signed = better(mask, k, r), select(mask, absolute(area), most), select(mask, area, signed)
        used_r = used_r | mask

    # Outside the side p q, q r or r p: the three areas add up to the triangle's.
    side = select(signed < 0, full(signed, -1), 1)
    to_r = side * (r[0] - p[0]), side * (r[1] - p[1])
    s, most = none(p[0]), least
    used_s = nowhere
    for k, (x, y) in enumerate(apart):
        beyond_q = -(side * areas[k])
        beyond_r = to_r[0] * y - to_r[1] * x
        outside = maximum(maximum(beyond_q, beyond_r), -(absolute(signed) + beyond_q + beyond_r))
        mask = valid[k] & (outside > most) & used_r
        s, most = better(mask, k, s), select(mask, outside, most)
        used_s = used_s | mask
    return [
        (used, (point[0], point[1]), point[2], point[3])
        for used, point in ((deepest, p), (used_q, q), (used_r, r), (used_s, s))
    ]
