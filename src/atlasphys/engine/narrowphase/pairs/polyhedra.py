"""Two polyhedra, boxes or hulls: the separating axis test, then clipping."""

from atlasphys.engine.jit import allocating_kernel
from atlasphys.engine.narrowphase.clip import FACE_PREFERENCE, clip_scratch, write_contact
from atlasphys.engine.narrowphase.pair import place
from atlasphys.engine.narrowphase.sat import hull_scratch, polyhedra_axes


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
        if distance < margin:
            write_contact(shapes, contacts, target, pair, normal, distance, on_a, on_b, bias, margin, scratch)
