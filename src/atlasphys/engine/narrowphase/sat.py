"""The separating axis test for polyhedra: the normal along which two polyhedra are farthest apart, or overlap least.

Two polyhedra are apart exactly where they are apart along a face normal of one or along a cross product of an edge of
each: S. Gottschalk, M. C. Lin, D. Manocha, "OBBTree", SIGGRAPH 1996, for boxes. For others only those pairs of edges
count whose arcs cross on the Gauss map (the unit sphere of normals, on which an edge is the arc between its two
faces' normals), for the others do not bound the difference A − B.

A face normal is preferred to an edge axis that is better by less than ``bias``, and the first shape's faces to the
second's: so the features in contact do not change with every bit of round-off. Where the two are apart corner to
corner, the best axis gives less than the true distance.
"""

import math

import numpy as np

from atlasphys.engine.jit import allocating_routine, routine
from atlasphys.engine.math import mat, vec
from atlasphys.engine.narrowphase.segments import closest_of_segments
from atlasphys.engine.shapes.support import support
from atlasphys.engine.shapes.table import EDGE_COUNT, FACE_COUNT, FIRST_EDGE, FIRST_FACE, FIRST_VERTEX, VERTEX_COUNT
from atlasphys.engine.trace import TRACED, note

PARALLEL_SQUARED = 1e-6
"""Squared sine under which two edges count as parallel. Their axis would be round-off, and faces or other edges bound
the overlap."""

NEARLY_PARALLEL = 0.01
"""Sine under which the axis of two edges is not relied on for more than one step: ten times what counts as parallel."""


@routine
def _column(rotation, k):
    if k == 0:
        return rotation[0], rotation[3], rotation[6]
    if k == 1:
        return rotation[1], rotation[4], rotation[7]
    return rotation[2], rotation[5], rotation[8]


@routine
def box_axes(shapes, pair, limit, bias, r):
    """Separating axis test of two boxes: Gottschalk's fifteen axes, in the first box's frame.

    Args:
        limit: as soon as the boxes are known to be farther apart, that distance is returned with whatever axis gave it.
        bias: loss of distance at which a face is still preferred [m].
        r: scratch (5, 3).

    Returns:
        ``normal, distance, on_a, on_b`` as :func:`core_contact`.
    """
    row_a, row_b, rotation_a, rotation_b, d = pair
    real = r.dtype.type
    zero = real(0)
    # Rows 0 to 2: entry (i, j) is the product of a's axis i and b's axis j. Row 3: half sizes of b. Row 4: the offset.
    r[4, 0], r[4, 1], r[4, 2] = mat.transpose_mul_vec(rotation_a, d)
    ha = shapes.size[row_a]
    hb = shapes.size[row_b]
    for j in range(3):
        r[0, j], r[1, j], r[2, j] = mat.transpose_mul_vec(rotation_a, _column(rotation_b, j))
    best = -real(math.inf)
    best_i, best_j = -1, -1
    for i in range(3):
        distance = abs(r[4, i]) - ha[i] - (hb[0] * abs(r[i, 0]) + hb[1] * abs(r[i, 1]) + hb[2] * abs(r[i, 2]))
        if TRACED:
            note("sat.axis", of="face of a", a=i, b=-1, axis=_column(rotation_a, i), distance=distance, best=best)
        if distance > best:
            best, best_i = distance, i
            if TRACED:
                note("sat.best")
    face_a = best
    for j in range(3):
        along = r[4, 0] * r[0, j] + r[4, 1] * r[1, j] + r[4, 2] * r[2, j]
        distance = abs(along) - hb[j] - (ha[0] * abs(r[0, j]) + ha[1] * abs(r[1, j]) + ha[2] * abs(r[2, j]))
        if TRACED:
            note("sat.axis", of="face of b", a=-1, b=j, axis=_column(rotation_b, j), distance=distance, best=best)
        if distance > best and distance > face_a + bias:
            best, best_i, best_j = distance, -1, j
            if TRACED:
                note("sat.best")
    if best < limit:
        face = best
        for i in range(3):
            i1, i2 = (i + 1) % 3, (i + 2) % 3
            for j in range(3):
                squared = r[i1, j] * r[i1, j] + r[i2, j] * r[i2, j]
                if squared > real(PARALLEL_SQUARED):
                    j1, j2 = (j + 1) % 3, (j + 2) % 3
                    reach = ha[i1] * abs(r[i2, j]) + ha[i2] * abs(r[i1, j])
                    reach += hb[j1] * abs(r[i, j2]) + hb[j2] * abs(r[i, j1])
                    distance = (abs(r[4, i2] * r[i1, j] - r[4, i1] * r[i2, j]) - reach) / math.sqrt(squared)
                    if TRACED:
                        axis = vec.cross(_column(rotation_a, i), _column(rotation_b, j))
                        note("sat.axis", of="edges", a=i, b=j, axis=axis, distance=distance, best=best)
                    if distance > best and distance > face + bias:
                        best, best_i, best_j = distance, i, j
                        if TRACED:
                            note("sat.best")
                elif TRACED:
                    note("sat.parallel", a=i, b=j)
    if best_i >= 0 and best_j >= 0:
        axis_a, axis_b = _column(rotation_a, best_i), _column(rotation_b, best_j)
        n = vec.unit(vec.cross(axis_a, axis_b))
        if vec.dot(n, d) < 0:
            n = vec.neg(n)
        # The edges in contact run along those axes through the boxes' support points.
        half_a, half_b = ha[best_i], hb[best_j]
        p = mat.mul_vec(rotation_a, support(shapes, row_a, mat.transpose_mul_vec(rotation_a, n)))
        q = vec.add(mat.mul_vec(rotation_b, support(shapes, row_b, mat.transpose_mul_vec(rotation_b, vec.neg(n)))), d)
        p = vec.add_scaled(p, axis_a, -half_a - vec.dot(p, axis_a))
        q = vec.add_scaled(q, axis_b, -half_b - vec.dot(vec.sub(q, d), axis_b))
        s, t = closest_of_segments(p, vec.scale(axis_a, half_a + half_a), q, vec.scale(axis_b, half_b + half_b))
        return (
            n,
            best,
            vec.add_scaled(p, axis_a, s * (half_a + half_a)),
            vec.add_scaled(q, axis_b, t * (half_b + half_b)),
        )
    if best_i >= 0:
        n = _column(rotation_a, best_i)
        n = vec.neg(n) if r[4, best_i] < zero else n
    else:
        n = _column(rotation_b, best_j)
        n = vec.neg(n) if vec.dot(n, d) < zero else n
    q = vec.add(mat.mul_vec(rotation_b, support(shapes, row_b, mat.transpose_mul_vec(rotation_b, vec.neg(n)))), d)
    return n, best, vec.add_scaled(q, n, -best), q


@allocating_routine
def hull_scratch(shapes, dtype):
    """Memory for two polyhedra in the pair's frame: vertices and face normals of each."""
    most_vertices, most_faces = 1, 1
    for row in range(len(shapes.layout)):
        most_vertices = max(most_vertices, shapes.layout[row, VERTEX_COUNT])
        most_faces = max(most_faces, shapes.layout[row, FACE_COUNT])
    return np.empty((2, most_vertices, 3), dtype), np.empty((2, most_faces, 3), dtype)


@routine
def _turn_polyhedron(shapes, row, rotation, offset, vertices, normals):
    first = shapes.layout[row, FIRST_VERTEX]
    for k in range(shapes.layout[row, VERTEX_COUNT]):
        vec.store(vertices, k, vec.add(mat.mul_vec(rotation, vec.load(shapes.vertices, first + k)), offset))
    first = shapes.layout[row, FIRST_FACE]
    for k in range(shapes.layout[row, FACE_COUNT]):
        vec.store(normals, k, mat.mul_vec(rotation, vec.load(shapes.faces, first + k)))


@routine
def _face_axis(shapes, row, other, vertices, other_vertices, normals):
    """The face of ``row`` from which the other polyhedron is farthest: its number and the distance."""
    real = vertices.dtype.type
    best, best_face = -real(math.inf), 0
    first = shapes.layout[row, FIRST_FACE]
    for f in range(shapes.layout[row, FACE_COUNT]):
        n = vec.load(normals, f)
        corner = shapes.face_vertices[shapes.face_range[first + f, 0]] - shapes.layout[row, FIRST_VERTEX]
        level = vec.dot(n, vec.load(vertices, corner))
        distance = real(math.inf)
        for k in range(shapes.layout[other, VERTEX_COUNT]):
            distance = min(distance, vec.dot(n, vec.load(other_vertices, k)) - level)
            if distance <= best:
                break
        if TRACED:
            note("sat.face", face=f, axis=n, distance=distance, best=best)
        if distance > best:
            best, best_face = distance, f
            if TRACED:
                note("sat.best")
    return best, best_face


@routine
def _turn_of_edges(u, v, normals, edges, edge_a, face_a, edge_b, face_b):
    """By what angle two edges may turn, together, before their arcs on the Gauss map may cease to cross or their axis has turned by a tenth."""
    real = normals.dtype.type
    u, v = vec.unit(u), vec.unit(v)
    sine = vec.length(vec.cross(u, v))
    if sine < real(NEARLY_PARALLEL):
        return real(0)
    crossing = sine
    for k in range(2, 4):
        of_a, of_b = vec.load(normals[0], edges[edge_a, k] - face_a), vec.load(normals[1], edges[edge_b, k] - face_b)
        crossing = min(crossing, abs(vec.dot(of_a, v)), abs(vec.dot(of_b, u)))
    return min(real(0.5) * crossing, real(0.1) * sine)


@routine
def polyhedra_axes(shapes, pair, limit, bias, scratch):
    """Separating axis test of two polyhedra.

    Args:
        limit, bias: as for :func:`box_axes`.
        scratch: from :func:`hull_scratch`.

    Returns:
        ``normal, distance, on_a, on_b`` as :func:`core_contact`, and ``hold``: the distances from a face of a and from a
        face of b, and by what angle the two may turn before the axis of the two edges is lost (0: it is of a face).
    """
    row_a, row_b, rotation_a, rotation_b, d = pair
    vertices, normals = scratch
    real = vertices.dtype.type
    zero = real(0)
    _turn_polyhedron(shapes, row_a, rotation_a, (zero, zero, zero), vertices[0], normals[0])
    _turn_polyhedron(shapes, row_b, rotation_b, d, vertices[1], normals[1])
    if TRACED:
        note("sat.faces", of="face of a")
    from_a, face = _face_axis(shapes, row_a, row_b, vertices[0], vertices[1], normals[0])
    best = from_a
    n = vec.load(normals[0], face)
    if TRACED:
        note("sat.faces", of="face of b")
    from_b, face = _face_axis(shapes, row_b, row_a, vertices[1], vertices[0], normals[1])
    if from_b > best + bias:
        best = from_b
        n = vec.neg(vec.load(normals[1], face))
    edge_a, edge_b = -1, -1
    layout, edges = shapes.layout, shapes.edges
    if best < limit:
        face_distance = best
        first_a, first_b = layout[row_a, FIRST_EDGE], layout[row_b, FIRST_EDGE]
        vertex_a, vertex_b = layout[row_a, FIRST_VERTEX], layout[row_b, FIRST_VERTEX]
        for i in range(first_a, first_a + layout[row_a, EDGE_COUNT]):
            p = vec.load(vertices[0], edges[i, 0] - vertex_a)
            u = vec.sub(vec.load(vertices[0], edges[i, 1] - vertex_a), p)
            left_a = vec.load(normals[0], edges[i, 2] - layout[row_a, FIRST_FACE])
            right_a = vec.load(normals[0], edges[i, 3] - layout[row_a, FIRST_FACE])
            for j in range(first_b, first_b + layout[row_b, EDGE_COUNT]):
                # On the Gauss map of A − B, b's arc is mirrored. The arcs cross if each one's ends lie on both sides
                # of the other, and on the same half of the sphere.
                left_b = vec.load(normals[1], edges[j, 2] - layout[row_b, FIRST_FACE])
                right_b = vec.load(normals[1], edges[j, 3] - layout[row_b, FIRST_FACE])
                lb, rb = vec.dot(left_b, u), vec.dot(right_b, u)
                if lb * rb >= 0:
                    continue
                q = vec.load(vertices[1], edges[j, 0] - vertex_b)
                v = vec.sub(vec.load(vertices[1], edges[j, 1] - vertex_b), q)
                la, ra = vec.dot(left_a, v), vec.dot(right_a, v)
                if la * ra >= 0 or lb * ra >= 0:
                    continue
                axis = vec.cross(u, v)
                squared = vec.length_squared(axis)
                if squared <= real(PARALLEL_SQUARED) * vec.length_squared(u) * vec.length_squared(v):
                    continue
                axis = vec.scale(axis, real(1) / math.sqrt(squared))
                if vec.dot(axis, left_a) + vec.dot(axis, right_a) < 0:
                    axis = vec.neg(axis)
                distance = vec.dot(axis, vec.sub(q, p))
                if TRACED:
                    e, f = i - first_a, j - first_b
                    note("sat.axis", of="edges", a=e, b=f, axis=axis, distance=distance, best=best)
                if distance > best and distance > face_distance + bias:
                    best = distance
                    n = axis
                    edge_a, edge_b = i, j
                    if TRACED:
                        note("sat.best")
                    if best > limit:
                        break
    if edge_a >= 0:
        p = vec.load(vertices[0], edges[edge_a, 0] - layout[row_a, FIRST_VERTEX])
        u = vec.sub(vec.load(vertices[0], edges[edge_a, 1] - layout[row_a, FIRST_VERTEX]), p)
        q = vec.load(vertices[1], edges[edge_b, 0] - layout[row_b, FIRST_VERTEX])
        v = vec.sub(vec.load(vertices[1], edges[edge_b, 1] - layout[row_b, FIRST_VERTEX]), q)
        s, t = closest_of_segments(p, u, q, v)
        turn = zero
        if 0 < s < 1 and 0 < t < 1:
            turn = _turn_of_edges(
                u, v, normals, edges, edge_a, layout[row_a, FIRST_FACE], edge_b, layout[row_b, FIRST_FACE]
            )
        return n, best, vec.add_scaled(p, u, s), vec.add_scaled(q, v, t), (from_a, from_b, turn)
    q = vec.add(mat.mul_vec(rotation_b, support(shapes, row_b, mat.transpose_mul_vec(rotation_b, vec.neg(n)))), d)
    return n, best, vec.add_scaled(q, n, -best), q, (from_a, from_b, zero)
