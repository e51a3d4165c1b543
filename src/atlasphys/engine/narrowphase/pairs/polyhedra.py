"""Two polyhedra, boxes or hulls: the separating axis test, then clipping."""

from atlasphys.engine.jit import allocating_kernel, routine
from atlasphys.engine.narrowphase.clip import FACE_PREFERENCE, clip_scratch, write_contact
from atlasphys.engine.narrowphase.pair import place
from atlasphys.engine.narrowphase.sat import hull_scratch, polyhedra_axes


@routine
def clear_gap(shapes, pair, distance, limit):
    """How far two polyhedra, ``distance`` apart along some axis, may at least move before the separating axis test finds them nearer than ``limit``.

    Where a corner is the nearest point of one, the test finds less than the true distance D. The direction in which they are D apart is a sum, with
    positive factors, of axes of the test that are normals at the corner. Were it at a greater angle to each than these are to their middle, it
    would be longer than 1. So the test finds at least D times the cosine of that angle: ``Shapes.bluntness``, the greater one of the two. And D
    is at least ``distance`` less the motion.
    """
    blunt = max(shapes.bluntness[pair[0]], shapes.bluntness[pair[1]])
    return max(distance - limit / max(blunt, type(distance)(1e-3)), type(distance)(0))


@allocating_kernel
def polyhedra(rows, bodies, colliders, shapes, margin, contacts):
    """Contacts of pairs of polyhedra."""
    real = contacts.depth.dtype.type
    margin = real(margin)
    bias = real(FACE_PREFERENCE) * margin
    vertices = hull_scratch(shapes, contacts.depth.dtype)
    scratch = clip_scratch(shapes, contacts.depth.dtype)
    for p in rows:
        pair, target = place(bodies, colliders, shapes, contacts, p)
        normal, distance, on_a, on_b = polyhedra_axes(shapes, pair, margin, bias, vertices)
        if distance >= margin:
            contacts.gap[p] = clear_gap(shapes, pair, distance, margin + bias)
        else:
            write_contact(shapes, contacts, target, pair, normal, distance, on_a, on_b, bias, margin, scratch)
