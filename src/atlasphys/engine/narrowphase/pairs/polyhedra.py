"""Two polyhedra, boxes or hulls: the separating axis test, then clipping."""

from atlasphys.engine.jit import allocating_kernel, routine
from atlasphys.engine.math import vec
from atlasphys.engine.narrowphase.apart import certain_gap
from atlasphys.engine.narrowphase.clip import FACE_PREFERENCE, clip_scratch, write_contact
from atlasphys.engine.narrowphase.pair import place
from atlasphys.engine.narrowphase.sat import hull_scratch, polyhedra_axes
from atlasphys.engine.trace import TRACED, note

ROUND_OFF = 1e-5
"""Round-off of a distance from a face, as a part of the sizes of the two shapes."""

COSINE_OF_TENTH = 0.995
"""What is left of a distance along an axis that has turned by a tenth: a little less than its cosine."""


@routine
def clear_gap(shapes, pair, distance, hold, limit):
    """How far two polyhedra may at least move before the separating axis test finds them nearer than ``limit``.

    ``distance`` is theirs along some axis; ``hold`` is from :func:`polyhedra_axes`. The greatest of four bounds:

    The true distance D is at least ``distance`` less the motion. Where a corner is the nearest point of one, the test
    finds less than D: the direction in which they are D apart is a sum, with positive factors, of axes of the test that
    are normals at the corner. Were it at a greater angle to each of these than they are to their middle, it would be
    longer than 1. So the test finds at least D times the cosine of that angle: ``Shapes.bluntness``, the greater one of
    the two.

    The distance from a face of a shrinks by no more than b moves as seen from a. When a turns, that is the turn times
    how far away b reaches, and what counts as a's travel is the turn times a's own extent. So with b.

    The distance along the axis of two edges shrinks by no more than their nearest points move, apart from what the
    axis' own turn takes off, as long as the edges' arcs on the Gauss map cross; and the bodies turn by no more than what
    they travel over their extents.
    """
    real = type(distance)
    blunt = max(shapes.bluntness[pair[0]], shapes.bluntness[pair[1]])
    gap = certain_gap(distance - limit / max(blunt, real(1e-3)), shapes, pair)
    extent_a, extent_b = shapes.extent[pair[0]], shapes.extent[pair[1]]
    apart, round_off = vec.length(pair[4]), real(ROUND_OFF) * (extent_a + extent_b)
    for from_face, own, other in ((hold[0], extent_a, extent_b), (hold[1], extent_b, extent_a)):
        room = from_face - limit - round_off
        if room > 0:
            gap = max(gap, room / max(real(1), (apart + other + room) / own))
    room = real(COSINE_OF_TENTH) * distance - limit - round_off
    return max(gap, min(room, real(0.99) * hold[2] * min(extent_a, extent_b)))


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
        normal, distance, on_a, on_b, hold = polyhedra_axes(shapes, pair, margin, bias, vertices)
        if TRACED:
            note("sat.result", normal=normal, distance=distance, on_a=on_a, on_b=on_b, limit=margin)
        if distance >= margin:
            contacts.gap[p] = clear_gap(shapes, pair, distance, hold, margin + bias)
        else:
            write_contact(shapes, contacts, target, pair, normal, distance, on_a, on_b, bias, margin, scratch)
