"""The expanding polytope algorithm: least depth of two overlapping convex cores.

G. van den Bergen, "Proximity Queries and Penetration Depth Computation on 3D Game Objects", Game Developers Conference, 2001;
*Collision Detection in Interactive 3D Environments*, Morgan Kaufmann, 2003, section 4.3.8.

A polytope inside A − B that holds the origin grows towards the boundary where the boundary is nearest: its closest face is asked for
the support point along its normal n, and the faces which that point sees give way to a fan over their horizon. The closest face's
distance bounds the depth from below; the support h(n) = max over A − B of n · x bounds it from above, since moving b by h(n) along n
parts the shapes. The normal returned is the one with the least h(n) ever probed: a valid way out however the search ended.
"""

import math

import numpy as np

from atlasphys.engine.jit import routine
from atlasphys.engine.math import vec
from atlasphys.engine.narrowphase.gjk import ON_A, difference_support, precision

MAX_VERTICES = 96
"""Polyhedra need about 10, curved cores in double precision up to 60. Smaller: curved cores are left with a deeper normal than the least."""

MAX_FACES = 2 * MAX_VERTICES


@routine
def polytope_scratch(real):
    """Memory for one polytope: vertices (6 columns: of A − B and on A), face planes, face corners, horizon edges."""
    return (
        np.empty((MAX_VERTICES, 6), real),
        np.empty((MAX_FACES, 4), real),
        np.empty((MAX_FACES, 3), np.int32),
        np.empty((MAX_FACES, 2), np.int32),
    )


@routine
def _add_vertex(vertices, i, w, on_a):
    vertices[i, 0], vertices[i, 1], vertices[i, 2] = w
    vertices[i, 3], vertices[i, 4], vertices[i, 5] = on_a


@routine
def _set_face(vertices, planes, corners, f, i, j, k):
    """Face f with corners i, j, k, counter-clockwise as seen from outside. One without area is put out of reach, at infinity."""
    a, b, c = vec.load(vertices, i), vec.load(vertices, j), vec.load(vertices, k)
    ab, ac = vec.sub(b, a), vec.sub(c, a)
    n = vec.cross(ab, ac)
    length_squared = vec.length_squared(n)
    real = type(length_squared)
    eps = precision(length_squared)
    corners[f, 0], corners[f, 1], corners[f, 2] = i, j, k
    if length_squared <= real(64) * eps * eps * vec.length_squared(ab) * vec.length_squared(ac):
        planes[f, 0], planes[f, 1], planes[f, 2] = real(0), real(0), real(0)
        planes[f, 3] = real(math.inf)
        return
    n = vec.scale(n, real(1) / math.sqrt(length_squared))
    vec.store(planes, f, n)
    # The mean of the three corners' distances is no better than one of them, but the least is a safe lower bound.
    planes[f, 3] = min(vec.dot(n, a), vec.dot(n, b), vec.dot(n, c))


@routine
def _span(shapes, pair, vertices, count, size):
    """Add support points until there are four that span a volume.

    Returns the number of vertices, and a unit vector at right angles to all of A − B when that is flat (fewer than four).
    """
    zero = size * 0
    one = type(zero)(1)
    tolerance = type(zero)(32) * precision(zero) * size
    first = vec.load(vertices, 0)
    flat = (one, zero, zero)
    if count == 1:
        best = tolerance
        for axis in range(6):
            sign = one if axis < 3 else -one
            k = axis % 3
            direction = (sign if k == 0 else zero, sign if k == 1 else zero, sign if k == 2 else zero)
            w, on_a = difference_support(shapes, pair, direction)
            distance = vec.length(vec.sub(w, first))
            if distance > best:
                best = distance
                _add_vertex(vertices, 1, w, on_a)
                count = 2
    if count == 2:
        t = vec.unit(vec.sub(vec.load(vertices, 1), first))
        u, v = vec.tangents(t)
        flat = u
        best = tolerance
        for axis in range(4):
            direction = u if axis < 2 else v
            if axis % 2 == 1:
                direction = vec.neg(direction)
            w, on_a = difference_support(shapes, pair, direction)
            distance = vec.length(vec.cross(t, vec.sub(w, first)))
            if distance > best:
                best = distance
                _add_vertex(vertices, 2, w, on_a)
                count = 3
    if count == 3:
        n = vec.cross(vec.sub(vec.load(vertices, 1), first), vec.sub(vec.load(vertices, 2), first))
        length = vec.length(n)
        if length == 0:
            return count, flat
        n = vec.scale(n, one / length)
        flat = n
        best = tolerance
        for side in range(2):
            w, on_a = difference_support(shapes, pair, n if side == 0 else vec.neg(n))
            distance = abs(vec.dot(n, vec.sub(w, first)))
            if distance > best:
                best = distance
                _add_vertex(vertices, 3, w, on_a)
                count = 4
    return count, flat


@routine
def _replace_seen(vertices, planes, corners, edges, faces, closest, new, tolerance):
    """Replace the faces which vertex ``new`` sees by a fan over their horizon. Returns the number of faces, or −1 if out of room."""
    w = vec.load(vertices, new)
    horizon = 0
    f = 0
    kept = 0
    while f < faces:
        seen = f == closest or vec.dot(vec.load(planes, f), w) > planes[f, 3] + tolerance
        if seen:
            for k in range(3):
                i, j = corners[f, k], corners[f, (k + 1) % 3]
                # An edge between two seen faces comes up once in each direction, and is not on the horizon.
                twin = -1
                for e in range(horizon):
                    if edges[e, 0] == j and edges[e, 1] == i:
                        twin = e
                if twin >= 0:
                    horizon -= 1
                    edges[twin, 0], edges[twin, 1] = edges[horizon, 0], edges[horizon, 1]
                elif horizon < len(edges):
                    edges[horizon, 0], edges[horizon, 1] = i, j
                    horizon += 1
        else:
            if kept != f:
                for k in range(4):
                    planes[kept, k] = planes[f, k]
                for k in range(3):
                    corners[kept, k] = corners[f, k]
            kept += 1
        f += 1
    if kept + horizon > len(planes):
        return -1
    for e in range(horizon):
        _set_face(vertices, planes, corners, kept + e, edges[e, 0], edges[e, 1], new)
    return kept + horizon


@routine
def epa(shapes, pair, simplex, count, hint, polytope):
    """Least depth of two cores whose difference holds the origin, or misses it by round-off.

    Args:
        simplex: from :func:`gjk`: ``count`` points of A − B whose hull holds the origin.
        hint: a direction from a towards b, any length: the normal where every direction is equally good (concentric points).
        polytope: scratch from :func:`polytope_scratch`.

    Returns:
        ``normal, depth, on_a``: the unit normal from a to b, the cores' overlap along it, and the deepest point of a.
    """
    vertices, planes, corners, edges = polytope
    zero = simplex.dtype.type(0)
    one = type(zero)(1)
    eps = precision(zero)
    size = zero
    on_a = (zero, zero, zero)
    for i in range(count):
        for k in range(6):
            vertices[i, k] = simplex[i, k]
        size = max(size, vec.length(vec.load(vertices, i)))
        on_a = vec.add_scaled(on_a, (simplex[i, ON_A], simplex[i, ON_A + 1], simplex[i, ON_A + 2]), simplex[i, ON_A + 3])
    if count == 4:
        # A simplex that has lost its volume to round-off is spanned anew from three of its points.
        a, b, c = vec.load(vertices, 0), vec.load(vertices, 1), vec.load(vertices, 2)
        n = vec.cross(vec.sub(b, a), vec.sub(c, a))
        if abs(vec.dot(n, vec.sub(vec.load(vertices, 3), a))) <= type(zero)(32) * eps * size * vec.length(n):
            count = 3
    count, flat = _span(shapes, pair, vertices, count, size)
    if count < 4:
        # A − B is flat (points, segments and discs): it can be left at right angles, and the depth is zero.
        if count == 1 and vec.length_squared(hint) > 0:
            flat = vec.unit(hint)
        if vec.dot(flat, hint) < 0:
            flat = vec.neg(flat)
        w, w_on_a = difference_support(shapes, pair, flat)
        return flat, vec.dot(w, flat), on_a

    a, b, c = vec.load(vertices, 0), vec.load(vertices, 1), vec.load(vertices, 2)
    volume = vec.dot(vec.cross(vec.sub(b, a), vec.sub(c, a)), vec.sub(vec.load(vertices, 3), a))
    p, q = (1, 2) if volume < 0 else (2, 1)
    _set_face(vertices, planes, corners, 0, 0, p, q)
    _set_face(vertices, planes, corners, 1, 0, q, 3)
    _set_face(vertices, planes, corners, 2, q, p, 3)
    _set_face(vertices, planes, corners, 3, p, 0, 3)
    faces = 4

    noise = type(zero)(8) * eps * size
    relative = type(zero)(16) * eps if eps > 1e-10 else type(zero)(4096) * eps
    best = zero + type(zero)(math.inf)
    normal = flat
    while True:
        closest = 0
        for f in range(1, faces):
            if planes[f, 3] < planes[closest, 3]:
                closest = f
        n = vec.load(planes, closest)
        lower = planes[closest, 3]
        if lower >= best:
            break
        w, w_on_a = difference_support(shapes, pair, n)
        h = vec.dot(w, n)
        if h < best:
            best = h
            normal = n
            on_a = _on_a(vertices, corners, closest, n, lower)
        if best - lower <= noise + relative * best or count == MAX_VERTICES:
            break
        known = False
        for i in range(count):
            if vertices[i, 0] == w[0] and vertices[i, 1] == w[1] and vertices[i, 2] == w[2]:
                known = True
        if known:
            break
        _add_vertex(vertices, count, w, w_on_a)
        size = max(size, vec.length(w))
        faces = _replace_seen(vertices, planes, corners, edges, faces, closest, count, eps * size)
        count += 1
        if faces < 1:
            break
    return normal, best, on_a


@routine
def _on_a(vertices, corners, f, n, distance):
    """The point of A from which the point of face f closest to the origin came, by that point's barycentric weights."""
    i, j, k = corners[f, 0], corners[f, 1], corners[f, 2]
    foot = vec.scale(n, distance)
    a, b, c = vec.sub(vec.load(vertices, i), foot), vec.sub(vec.load(vertices, j), foot), vec.sub(vec.load(vertices, k), foot)
    wa, wb, wc = vec.dot(n, vec.cross(b, c)), vec.dot(n, vec.cross(c, a)), vec.dot(n, vec.cross(a, b))
    zero = distance * 0
    wa, wb, wc = max(wa, zero), max(wb, zero), max(wc, zero)
    scale = type(zero)(1) / (wa + wb + wc)
    point = vec.scale((vertices[i, 3], vertices[i, 4], vertices[i, 5]), wa * scale)
    point = vec.add_scaled(point, (vertices[j, 3], vertices[j, 4], vertices[j, 5]), wb * scale)
    return vec.add_scaled(point, (vertices[k, 3], vertices[k, 4], vertices[k, 5]), wc * scale)
