"""A sphere and a capsule: two balls, the second about the point of the capsule's segment closest to the sphere's
centre."""

from atlasphys.engine.jit import kernel
from atlasphys.engine.math import vec
from atlasphys.engine.narrowphase.pair import place
from atlasphys.engine.narrowphase.pairs.sphere_sphere import write_round_contact
from atlasphys.engine.narrowphase.segments import closest_on_segment


@kernel
def sphere_capsule(rows, bodies, colliders, shapes, margin, contacts):
    """Contacts of pairs of a sphere and a capsule. With the centre on the axis, the normal is square to the axis."""
    real = contacts.depth.dtype.type
    margin = real(margin)
    zero = real(0)
    for p in rows:
        pair, target = place(bodies, colliders, shapes, contacts, p)
        sphere, capsule, _, rotation, d = pair
        axis = (rotation[1], rotation[4], rotation[7])
        half = shapes.size[capsule, 1]
        start, along = vec.add_scaled(d, axis, -half), vec.scale(axis, half + half)
        center = (zero, zero, zero)
        s = closest_on_segment(center, start, along)
        nearest = vec.add_scaled(start, along, s)
        if 0 < s < 1:
            # Made exactly square to the axis: at a small distance, round-off along it is a large angle.
            nearest = vec.add_scaled(nearest, axis, -vec.dot(nearest, axis))
        square, _ = vec.tangents(axis)
        write_round_contact(
            contacts, target, center, nearest, shapes.size[sphere, 0], shapes.size[capsule, 0], square, margin, 0
        )
