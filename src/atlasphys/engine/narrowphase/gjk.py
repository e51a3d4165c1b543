"""The Gilbert–Johnson–Keerthi algorithm: distance and closest points of two convex cores.

E. G. Gilbert, D. W. Johnson, S. S. Keerthi, "A fast procedure for computing the distance between complex objects in
three-dimensional space", IEEE J. Robotics and Automation 4(2), 1988. Stopping by the relative duality gap:
G. van den Bergen, "A Fast and Robust GJK Implementation for Collision Detection of Convex Objects", J. Graphics Tools
4(2), 1999. Closest point of a simplex by signed volumes: M. Montanari, N. Petrinic, E. Barbieri, "Improving the GJK
Algorithm for Faster and More Reliable Distance Queries Between Convex Objects", ACM Trans. Graphics 36(3), 2017.

A and B touch exactly where their difference A − B = {a − b} contains the origin. GJK walks through A − B with a
simplex of one to four of its points, always the closest to the origin found so far, and asks for the point of A − B
farthest against it.

Two shapes are placed by ``pair = (row_a, row_b, rotation_a, rotation_b, d)``: rows in the table of shapes, rotation
matrices, and the vector from a's origin to b's. All vectors are along the world's axes with a's origin at zero.
"""

import math

from atlasphys.engine.jit import inlined, routine
from atlasphys.engine.math import mat, vec
from atlasphys.engine.shapes.support import support
from atlasphys.engine.trace import TRACED, note

SEPARATED, TOUCHING, OVERLAPPING = 0, 1, 2
"""The cores are apart; they are apart or overlap by no more than round-off can tell; the origin lies inside a
tetrahedron."""

MAX_ITERATIONS = 64
"""Polyhedra need about 5, curved cores in double precision up to 40. Smaller: curved cores in a glancing pose are
left inexact."""

W, ON_A, WEIGHT = 0, 3, 6
"""Columns of the simplex, an array (4, 7): a point of A − B, the point of A that it came from, its barycentric
weight."""


@routine
def precision(x):
    """The machine epsilon of the type of x: what is lost when 4/3 is rounded."""
    real = type(x)
    return abs((real(4) / real(3) - real(1)) * real(3) - real(1))


@inlined
def difference_support(shapes, pair, direction):
    """The point of A − B farthest along a direction, and the point of A that it came from."""
    row_a, row_b, rotation_a, rotation_b, d = pair
    on_a = mat.mul_vec(rotation_a, support(shapes, row_a, mat.transpose_mul_vec(rotation_a, direction)))
    on_b = mat.mul_vec(rotation_b, support(shapes, row_b, mat.transpose_mul_vec(rotation_b, vec.neg(direction))))
    return vec.sub(vec.sub(on_a, on_b), d), on_a


@routine
def segment_weights(a, b):
    """Barycentric weights of the point of segment ab closest to the origin."""
    zero, one = type(a[0])(0), type(a[0])(1)
    t = vec.sub(b, a)
    along = -vec.dot(a, t)
    length_squared = vec.length_squared(t)
    if along <= 0:
        return one, zero
    if along >= length_squared:
        return zero, one
    s = along / length_squared
    return one - s, s


@routine
def triangle_weights(a, b, c):
    """Barycentric weights of the point of triangle abc closest to the origin; a flat triangle counts as its edges."""
    zero = type(a[0])(0)
    eps = precision(zero)
    ab, ac = vec.sub(b, a), vec.sub(c, a)
    n = vec.cross(ab, ac)
    n_squared = vec.length_squared(n)
    # The area's own round-off is about eps |ab| |ac|: below it the normal has no meaning.
    flat = n_squared <= type(zero)(16) * eps * eps * vec.length_squared(ab) * vec.length_squared(ac)
    area_a = vec.dot(n, vec.cross(b, c))
    area_b = vec.dot(n, vec.cross(c, a))
    area_c = vec.dot(n, vec.cross(a, b))
    if not flat and area_a > 0 and area_b > 0 and area_c > 0:
        total = area_a + area_b + area_c
        return area_a / total, area_b / total, area_c / total
    wa, wb, wc = zero, zero, zero
    best = type(zero)(math.inf)
    if flat or area_c <= 0:
        u, v = segment_weights(a, b)
        best = vec.length_squared(vec.add_scaled(vec.scale(a, u), b, v))
        wa, wb = u, v
    if flat or area_a <= 0:
        u, v = segment_weights(b, c)
        distance = vec.length_squared(vec.add_scaled(vec.scale(b, u), c, v))
        if distance < best:
            best = distance
            wa, wb, wc = zero, u, v
    if flat or area_b <= 0:
        u, v = segment_weights(c, a)
        distance = vec.length_squared(vec.add_scaled(vec.scale(c, u), a, v))
        if distance < best:
            wa, wb, wc = v, zero, u
    return wa, wb, wc


@routine
def _row(simplex, i):
    return simplex[i, 0], simplex[i, 1], simplex[i, 2]


@routine
def _best_face(simplex):
    """Set the weights to those of the closest point on the four faces of a tetrahedron."""
    zero = simplex.dtype.type(0)
    best = type(zero)(math.inf)
    for apex in range(4):
        i, j, k = (apex + 1) % 4, (apex + 2) % 4, (apex + 3) % 4
        a, b, c = _row(simplex, i), _row(simplex, j), _row(simplex, k)
        u, v, w = triangle_weights(a, b, c)
        distance = vec.length_squared(vec.add_scaled(vec.add_scaled(vec.scale(a, u), b, v), c, w))
        if distance < best:
            best = distance
            simplex[apex, WEIGHT] = zero
            simplex[i, WEIGHT], simplex[j, WEIGHT], simplex[k, WEIGHT] = u, v, w


@routine
def _set_weights(simplex, count):
    """Barycentric weights of the point of the simplex closest to the origin, written to its last column."""
    zero = simplex.dtype.type(0)
    if count == 1:
        simplex[0, WEIGHT] = type(zero)(1)
        return
    a, b = _row(simplex, 0), _row(simplex, 1)
    if count == 2:
        simplex[0, WEIGHT], simplex[1, WEIGHT] = segment_weights(a, b)
        return
    c = _row(simplex, 2)
    if count == 3:
        simplex[0, WEIGHT], simplex[1, WEIGHT], simplex[2, WEIGHT] = triangle_weights(a, b, c)
        return
    d = _row(simplex, 3)
    # Signed volumes of the tetrahedra that the origin makes with each face; they add up to the whole.
    cd, ab = vec.cross(c, d), vec.cross(a, b)
    va, vb, vc, vd = vec.dot(b, cd), -vec.dot(a, cd), vec.dot(d, ab), -vec.dot(c, ab)
    total = va + vb + vc + vd
    size = abs(va) + abs(vb) + abs(vc) + abs(vd)
    inside = (va > 0 and vb > 0 and vc > 0 and vd > 0) or (va < 0 and vb < 0 and vc < 0 and vd < 0)
    da, db, dc = vec.sub(a, d), vec.sub(b, d), vec.sub(c, d)
    scale = math.sqrt(vec.length_squared(da) * vec.length_squared(db) * vec.length_squared(dc))
    if inside and size > type(zero)(4) * precision(zero) * scale:
        simplex[0, WEIGHT], simplex[1, WEIGHT] = va / total, vb / total
        simplex[2, WEIGHT], simplex[3, WEIGHT] = vc / total, vd / total
        return
    _best_face(simplex)


@routine
def _compact(simplex, count):
    """Move the points of positive weight to the front. Returns their number."""
    kept = 0
    for i in range(count):
        if simplex[i, WEIGHT] > 0:
            if kept != i:
                for k in range(7):
                    simplex[kept, k] = simplex[i, k]
            kept += 1
    return kept


@routine
def _holds(simplex, count, w):
    held = False
    for i in range(count):
        held |= simplex[i, 0] == w[0] and simplex[i, 1] == w[1] and simplex[i, 2] == w[2]
    return held


@routine
def _squared_up(simplex, count, v):
    """v made exactly square to the simplex on which it was found.

    As a weighted sum v is as wrong as its points are, on a sliver of a triangle worse: for a small gap, that is a large
    angle. The simplex's own directions are better known as long as the simplex is longer than v.
    """
    a = _row(simplex, 0)
    t = vec.sub(_row(simplex, 1), a)
    if count == 2 and vec.length_squared(t) > vec.length_squared(v):
        return vec.add_scaled(v, t, -vec.dot(v, t) / vec.length_squared(t))
    if count == 3:
        u = vec.sub(_row(simplex, 2), a)
        n = vec.cross(t, u)
        squared = vec.length_squared(n)
        longest = max(vec.length_squared(t), vec.length_squared(u), vec.length_squared(vec.sub(u, t)))
        if squared > 0 and longest > vec.length_squared(v):
            return vec.scale(n, vec.dot(n, v) / squared)
    return v


@routine
def gjk(shapes, pair, start, limit, simplex):
    """Distance of two cores.

    Args:
        start: a direction from a towards b, of any length, to begin with; last step's normal is best.
        limit: return as soon as the distance is known to be greater; the result is then only a lower bound.
        simplex: scratch (4, 7); on return its first ``count`` rows hold the closest simplex with its weights.

    Returns:
        ``status, v, on_a, count``: v is the point of A − B closest to the origin, so the distance is |v|, the normal
        from a to b is −v / |v|, and the closest points are ``on_a`` and ``on_a − v``.
    """
    zero = simplex.dtype.type(0)
    eps = precision(zero)
    gap_tolerance = type(zero)(16) * eps if eps > 1e-10 else type(zero)(4096) * eps
    noise = type(zero)(4) * eps
    # Nearer than this, v is mostly round-off and says little about the direction.
    near = type(zero)(0.03) * math.sqrt(eps)
    count = 0
    v = vec.neg(start)
    vv = zero
    largest = zero
    bound = -type(zero)(math.inf)
    best = v
    on_a = (zero, zero, zero)
    for step in range(MAX_ITERATIONS):
        w, w_on_a = difference_support(shapes, pair, vec.neg(v))
        largest = max(largest, vec.length_squared(w))
        if TRACED:
            note("gjk.support", direction=vec.neg(v), point=w, on_a=w_on_a)
        if step > 0:
            vw = vec.dot(v, w)
            if vw > bound * math.sqrt(vv):
                bound, best = vw / math.sqrt(vv), v
            if vw > 0 and vw * vw > limit * limit * vv:
                if TRACED:
                    note("gjk.end", reason="beyond limit", lower=vw / math.sqrt(vv), limit=limit)
                return SEPARATED, vec.scale(v, vw / vv), on_a, count
            if vv - vw <= gap_tolerance * vv + noise * math.sqrt(largest * vv):
                if TRACED:
                    note("gjk.end", reason="converged", lower=vw / math.sqrt(vv))
                break
            if _holds(simplex, count, w):
                if TRACED:
                    note("gjk.end", reason="known point", lower=vw / math.sqrt(vv))
                break
        vec.store(simplex, count, w)
        simplex[count, ON_A], simplex[count, ON_A + 1], simplex[count, ON_A + 2] = w_on_a
        _set_weights(simplex, count + 1)
        if TRACED:
            note("gjk.weights", simplex=simplex[: count + 1])
        count = _compact(simplex, count + 1)
        closest, closest_on_a = (zero, zero, zero), (zero, zero, zero)
        for i in range(count):
            closest = vec.add_scaled(closest, _row(simplex, i), simplex[i, WEIGHT])
            closest_on_a = vec.add_scaled(
                closest_on_a, (simplex[i, ON_A], simplex[i, ON_A + 1], simplex[i, ON_A + 2]), simplex[i, WEIGHT]
            )
        previous = vv
        v, on_a = _squared_up(simplex, count, closest), closest_on_a
        vv = vec.length_squared(v)
        if TRACED:
            note("gjk.closest", point=v, on_a=on_a)
        if count == 4:
            if TRACED:
                note("gjk.end", reason="inside")
            return OVERLAPPING, v, on_a, count
        if vv <= near * near * largest:
            if TRACED:
                note("gjk.end", reason="on the boundary")
            return TOUCHING, v, on_a, count
        if step > 0 and vv >= previous:
            if TRACED:
                note("gjk.end", reason="round-off")
            break  # round-off has stopped the descent: this is as good as it gets
    # What was found is not |v| but how far n = −v / |v| parts the cores, for the n that parts them farthest: round-off
    # in v cannot make the two disagree.
    length = vec.length(v)
    w, _ = difference_support(shapes, pair, vec.neg(v))
    vw = vec.dot(v, w)
    if vw >= bound * length:
        bound, best = vw / length, v
    if bound <= 0:
        return TOUCHING, v, on_a, count
    return SEPARATED, vec.scale(best, bound / vec.length(best)), on_a, count
