"""Closest points of two segments.

C. Ericson, *Real-Time Collision Detection*, Morgan Kaufmann, 2004, section 5.1.9. There the lines' closest points are
clamped one after the other, which in single precision goes wrong for nearly parallel lines; here each end is tried
too, and the nearest pair taken.
"""

from atlasphys.engine.jit import routine
from atlasphys.engine.math import vec


@routine
def _clamp(s):
    return min(max(s, type(s)(0)), type(s)(1))


@routine
def closest_on_segment(point, start, along):
    """Parameter, 0 to 1, of the point of the segment ``start + s along`` closest to ``point``."""
    squared = vec.length_squared(along)
    if squared > 0:
        return _clamp(vec.dot(vec.sub(point, start), along) / squared)
    return squared


@routine
def closest_of_segments(p, u, q, v):
    """Parameters s, t in 0 to 1 of the closest points ``p + s u`` and ``q + t v`` of two segments."""
    r = vec.sub(q, p)
    uu, vv, uv = vec.length_squared(u), vec.length_squared(v), vec.dot(u, v)
    zero, one = type(uu)(0), type(uu)(1)
    ru, rv = vec.dot(r, u), vec.dot(r, v)
    # |u × v|² rather than uu vv − uv²: the difference would be lost to round-off.
    determinant = vec.length_squared(vec.cross(u, v))
    best_s, best_t = zero, closest_on_segment(p, q, v)
    best = _squared_distance(r, u, v, best_s, best_t)
    if determinant > 0:
        s, t = (ru * vv - rv * uv) / determinant, (ru * uv - rv * uu) / determinant
        if 0 <= s <= 1 and 0 <= t <= 1:
            distance = _squared_distance(r, u, v, s, t)
            if distance < best:
                best, best_s, best_t = distance, s, t
    for end in range(3):
        s, t = one, one
        if end == 0:
            t = closest_on_segment(vec.add(p, u), q, v)
        elif end == 1:
            t = zero
            s = closest_on_segment(q, p, u)
        else:
            s = closest_on_segment(vec.add(q, v), p, u)
        distance = _squared_distance(r, u, v, s, t)
        if distance < best:
            best, best_s, best_t = distance, s, t
    return best_s, best_t


@routine
def _squared_distance(r, u, v, s, t):
    return vec.length_squared(vec.sub(vec.add_scaled(r, v, t), vec.scale(u, s)))
