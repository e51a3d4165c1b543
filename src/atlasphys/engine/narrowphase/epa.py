"""The expanding polytope algorithm: least depth of two overlapping convex cores.

G. van den Bergen, "Proximity Queries and Penetration Depth Computation on 3D Game Objects", Game Developers
Conference, 2001; *Collision Detection in Interactive 3D Environments*, Morgan Kaufmann, 2003, section 4.3.8.

A polytope inside A − B that holds the origin grows towards the boundary where the boundary is nearest: its closest
face is asked for the support point along its normal n, and the faces which that point sees give way to a fan over
their horizon. The closest face's distance bounds the depth from below; the support h(n) = max over A − B of n · x
bounds it from above, since moving b by h(n) along n parts the shapes. The normal returned is the one with the least
h(n) ever probed: a valid way out however the search ended.
"""

import math

import numpy as np

from atlasphys.engine.jit import allocating_routine, routine
from atlasphys.engine.math import mat, vec
from atlasphys.engine.narrowphase.gjk import ON_A, difference_support, precision
from atlasphys.engine.shapes.table import CONE, CYLINDER, KIND
from atlasphys.engine.trace import TRACED, note

MAX_VERTICES = 64
"""Polyhedra need about 10, most curved cores 20 to 40. Smaller: some of those are left with a deeper normal than the
least. Where a whole circle of normals is equally good (coaxial round shapes), no number would do; see FINAL_STEPS."""

FINAL_STEPS = 20
"""Of these vertices the last are all spent on one place: only the newest faces are grown. Smaller: a place that is
not the flattest bit of the boundary around it is returned. Larger: fewer are left to find the best place."""

MAX_FACES = 2 * MAX_VERTICES
"""A closed surface of triangles has four less."""

SEEN, TAKEN = 1, 2
"""Marks of faces that a new vertex sees, and of those of them that are replaced."""


@allocating_routine
def polytope_scratch(real):
    """Memory for one polytope: vertices (6 columns: of A − B and on A), face planes, face corners, horizon edges.

    Corners have a fourth column for a mark. A plane has a fifth column: its distance again, or infinity if there is
    no more to be found beyond the face.
    """
    return (
        np.empty((MAX_VERTICES, 6), real),
        np.empty((MAX_FACES, 5), real),
        np.empty((MAX_FACES, 4), np.int32),
        np.empty((MAX_FACES, 2), np.int32),
    )


@routine
def _add_vertex(vertices, i, w, on_a):
    vertices[i, 0], vertices[i, 1], vertices[i, 2] = w
    vertices[i, 3], vertices[i, 4], vertices[i, 5] = on_a


@routine
def _set_face(vertices, planes, corners, f, i, j, k, noise):
    """Face f with corners i, j, k, counter-clockwise as seen from outside.

    One narrower than the ``noise`` of its corners has no normal: it stays to keep the surface closed, and is never
    looked at.
    """
    a, b, c = vec.load(vertices, i), vec.load(vertices, j), vec.load(vertices, k)
    ab, ac, bc = vec.sub(b, a), vec.sub(c, a), vec.sub(c, b)
    n = vec.cross(ab, ac)
    squared = vec.length_squared(n)
    real = type(squared)
    longest = max(vec.length_squared(ab), vec.length_squared(ac), vec.length_squared(bc))
    corners[f, 0], corners[f, 1], corners[f, 2] = i, j, k
    if squared <= noise * noise * longest:
        planes[f, 0], planes[f, 1], planes[f, 2] = real(0), real(0), real(0)
        planes[f, 3] = real(math.inf)
    else:
        n = vec.scale(n, real(1) / math.sqrt(squared))
        vec.store(planes, f, n)
        planes[f, 3] = vec.dot(n, a)
    planes[f, 4] = planes[f, 3]


@routine
def _span_direction(vertices, count, trial):
    """Where to look for one more vertex of a polytope of one, two or three: off its point, line or plane."""
    real = vertices.dtype.type
    zero, one = real(0), real(1)
    first = vec.load(vertices, 0)
    sign = one if trial % 2 == 0 else -one
    if count == 1:
        axis = trial // 2
        return sign if axis == 0 else zero, sign if axis == 1 else zero, sign if axis == 2 else zero
    t = vec.sub(vec.load(vertices, 1), first)
    if count == 2:
        u, v = vec.tangents(vec.unit(t))
        return vec.scale(u if trial < 2 else v, sign)
    n = vec.cross(t, vec.sub(vec.load(vertices, 2), first))
    return vec.scale(n, sign / vec.length(n))


@routine
def _span(shapes, pair, vertices, count, size):
    """Add support points until there are four that span a volume. ``size`` is the greatest length of those there are.

    Returns the number of vertices, and a unit vector at right angles to all of A − B when that is flat (fewer than
    four).
    """
    zero = type(size)(0)
    tolerance = type(size)(32) * precision(size)
    best = zero
    trial = 0
    direction = _span_direction(vertices, count, 0)
    while count < 4:
        direction = _span_direction(vertices, count, trial)
        w, on_a = difference_support(shapes, pair, direction)
        size = max(size, vec.length(w))
        off = vec.sub(w, vec.load(vertices, 0))
        if count == 1:
            distance = vec.length(off)
        elif count == 2:
            t = vec.unit(vec.sub(vec.load(vertices, 1), vec.load(vertices, 0)))
            distance = vec.length(vec.cross(t, off))
        else:
            distance = abs(vec.dot(direction, off))
        if distance > max(best, tolerance * size):
            best = distance
            _add_vertex(vertices, count, w, on_a)
        trial += 1
        if trial == 8 - 2 * count:
            if best == 0:
                break
            count, trial, best = count + 1, 0, zero
    return count, direction


@routine
def _take(corners, edges, f, horizon):
    """Take face f into the disc of faces whose rim is the first ``horizon`` edges, if it stays a disc.

    It does if the two share one edge and not the corner opposite to that, or two edges. Returns the new number of
    edges.
    """
    shared = 0
    for k in range(3):
        i, j, opposite = corners[f, k], corners[f, (k + 1) % 3], corners[f, (k + 2) % 3]
        for e in range(horizon):
            # Two faces walk along a common edge in opposite directions.
            if edges[e, 0] == j and edges[e, 1] == i:
                shared += 1
                for other in range(horizon):
                    if edges[other, 0] == opposite:
                        shared += 2
    # Two shared edges are met twice, each with its opposite corner on the rim.
    if horizon > 0 and shared != 1 and shared != 6:
        return horizon
    corners[f, 3] = TAKEN
    for k in range(3):
        i, j = corners[f, k], corners[f, (k + 1) % 3]
        twin = -1
        for e in range(horizon):
            if edges[e, 0] == j and edges[e, 1] == i:
                twin = e
        if twin >= 0:
            horizon -= 1
            edges[twin, 0], edges[twin, 1] = edges[horizon, 0], edges[horizon, 1]
        else:
            edges[horizon, 0], edges[horizon, 1] = i, j
            horizon += 1
    return horizon


@routine
def _replace_seen(vertices, planes, corners, edges, faces, closest, new, tolerance):
    """Replace the faces which vertex ``new`` sees by a fan over their horizon.

    They are taken in from the closest face outwards, and only while they make up a disc: what round-off says of faces
    in one plane with the vertex may be a ring or islands, over whose rims no fan closes the surface.

    Returns the number of the first new face and the number of faces.
    """
    w = vec.load(vertices, new)
    for f in range(faces):
        corners[f, 3] = SEEN if vec.dot(vec.load(planes, f), w) > planes[f, 3] + tolerance else 0
    horizon = _take(corners, edges, closest, 0)
    grown = True
    while grown:
        grown = False
        for f in range(faces):
            if corners[f, 3] == SEEN:
                horizon = _take(corners, edges, f, horizon)
                grown |= corners[f, 3] == TAKEN
    if TRACED:
        note("epa.horizon", removed=corners[:faces, 3] == TAKEN, edges=edges[:horizon])
    kept = 0
    for f in range(faces):
        if corners[f, 3] != TAKEN:
            if kept != f:
                for k in range(5):
                    planes[kept, k] = planes[f, k]
                for k in range(3):
                    corners[kept, k] = corners[f, k]
            kept += 1
    for e in range(horizon):
        _set_face(vertices, planes, corners, kept + e, edges[e, 0], edges[e, 1], new, tolerance)
    return kept, kept + horizon


@routine
def _wall_normal(shapes, pair, side, n):
    """The normal n turned into that of a cylinder's or cone's curved wall, at the azimuth of n about its axis.

    ``side`` is 1 for shape a, 2 for shape b. For other shapes it is n itself.
    """
    row = pair[0] if side == 1 else pair[1]
    rotation = pair[2] if side == 1 else pair[3]
    kind = shapes.layout[row, KIND]
    if kind not in (CYLINDER, CONE):
        return n
    x, y, z = mat.transpose_mul_vec(rotation, n)
    if kind == CYLINDER:
        y = type(y)(0)
    else:
        # In the half-plane of the azimuth the wall's normal is (2h, r).
        outward = type(y)(1 if side == 1 else -1)
        y = outward * math.sqrt(x * x + z * z) * shapes.size[row, 0] / (shapes.size[row, 1] + shapes.size[row, 1])
    length = math.sqrt(x * x + y * y + z * z)
    if length == 0:
        return n
    return vec.scale(mat.mul_vec(rotation, (x, y, z)), type(y)(1) / length)


@routine
def epa(shapes, pair, simplex, count, hint, polytope):
    """Least depth of two cores whose difference holds the origin, or misses it by round-off.

    Args:
        simplex: from :func:`gjk`: ``count`` points of A − B whose hull holds the origin.
        hint: a direction from a towards b, any length: the normal where every direction is equally good (concentric
        points). polytope: scratch from :func:`polytope_scratch`.

    Returns:
        ``normal, depth, on_a``: the unit normal from a to b, the cores' overlap along it, and the deepest point of a.
    """
    vertices, planes, corners, edges = polytope
    zero = simplex.dtype.type(0)
    eps = precision(zero)
    size = zero
    on_a = (zero, zero, zero)
    for i in range(count):
        for k in range(6):
            vertices[i, k] = simplex[i, k]
        size = max(size, vec.length(vec.load(vertices, i)))
        on_a = vec.add_scaled(
            on_a, (simplex[i, ON_A], simplex[i, ON_A + 1], simplex[i, ON_A + 2]), simplex[i, ON_A + 3]
        )
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
        if TRACED:
            note("epa.end", reason="flat")
        return flat, vec.dot(vec.load(vertices, 0), flat), on_a

    a, b, c = vec.load(vertices, 0), vec.load(vertices, 1), vec.load(vertices, 2)
    volume = vec.dot(vec.cross(vec.sub(b, a), vec.sub(c, a)), vec.sub(vec.load(vertices, 3), a))
    p, q = (1, 2) if volume < 0 else (2, 1)
    for i in range(4):
        size = max(size, vec.length(vec.load(vertices, i)))
    noise = type(zero)(4) * eps * size
    _set_face(vertices, planes, corners, 0, 0, p, q, noise)
    _set_face(vertices, planes, corners, 1, 0, q, 3, noise)
    _set_face(vertices, planes, corners, 2, q, p, 3, noise)
    _set_face(vertices, planes, corners, 3, p, 0, 3, noise)
    faces = 4
    if TRACED:
        note("epa.polytope", vertices=vertices[:count], corners=corners[:faces, :3], planes=planes[:faces, :4])
    relative = type(zero)(16) * eps if eps > 1e-10 else type(zero)(4096) * eps
    best = type(zero)(math.inf)
    normal = flat
    newest = 0
    wall = 0  # 1 and 2: try the walls of a and b, in case a whole circle of normals about them is equally good
    while wall < 3:
        late = count > MAX_VERTICES - FINAL_STEPS
        closest = newest if late else 0
        for f in range(closest + 1, faces):
            if planes[f, 4] < planes[closest, 4]:
                closest = f
        lower = planes[closest, 4]
        if wall == 0 and (lower >= best or lower == math.inf):
            if not late:
                if TRACED:
                    note("epa.end", reason="no closer face", lower=lower)
                break
            wall = 1
        n = vec.load(planes, closest) if wall == 0 else _wall_normal(shapes, pair, wall, normal)
        w, w_on_a = difference_support(shapes, pair, n)
        h = vec.dot(w, n)
        if h < best:
            best = h
            normal = n
            on_a = _on_a(vertices, corners, closest, n, lower) if wall == 0 else w_on_a
        done = best - lower <= noise + relative * best
        if TRACED:
            note("epa.probe", face=closest, wall=wall, normal=n, lower=lower, point=w, on_a=w_on_a, upper=h, best=best)
        if done and not late:
            if TRACED:
                note("epa.end", reason="converged", lower=lower)
            break
        if done or wall > 0 or count == MAX_VERTICES:
            wall += 1
            continue
        known = False
        for i in range(count):
            if vec.length_squared(vec.sub(vec.load(vertices, i), w)) <= noise * noise:
                known = True
        if known:
            planes[closest, 4] = type(zero)(math.inf)
            if TRACED:
                note("epa.known", face=closest)
            continue
        _add_vertex(vertices, count, w, w_on_a)
        newest, faces = _replace_seen(vertices, planes, corners, edges, faces, closest, count, noise)
        count += 1
        if TRACED:
            note("epa.polytope", vertices=vertices[:count], corners=corners[:faces, :3], planes=planes[:faces, :4])
    return normal, best, on_a


@routine
def _on_a(vertices, corners, f, n, distance):
    """The point of A from which the point of face f closest to the origin came, by that point's barycentric weights."""
    i, j, k = corners[f, 0], corners[f, 1], corners[f, 2]
    foot = vec.scale(n, distance)
    a, b = vec.sub(vec.load(vertices, i), foot), vec.sub(vec.load(vertices, j), foot)
    c = vec.sub(vec.load(vertices, k), foot)
    wa, wb, wc = vec.dot(n, vec.cross(b, c)), vec.dot(n, vec.cross(c, a)), vec.dot(n, vec.cross(a, b))
    zero = type(distance)(0)
    wa, wb, wc = max(wa, zero), max(wb, zero), max(wc, zero)
    scale = type(zero)(1) / (wa + wb + wc)
    point = vec.scale((vertices[i, 3], vertices[i, 4], vertices[i, 5]), wa * scale)
    point = vec.add_scaled(point, (vertices[j, 3], vertices[j, 4], vertices[j, 5]), wb * scale)
    return vec.add_scaled(point, (vertices[k, 3], vertices[k, 4], vertices[k, 5]), wc * scale)
