"""Two spheres."""

from atlasphys.engine.jit import kernel, routine
from atlasphys.engine.math import vec
from atlasphys.engine.narrowphase.pair import place, write_normal, write_point


@routine
def write_round_contact(contacts, target, on_a, on_b, radius_a, radius_b, fallback, margin, feature):
    """Contact of two balls about the points ``on_a`` and ``on_b``; where those coincide, the normal is ``fallback``."""
    between = vec.sub(on_b, on_a)
    distance = vec.length(between)
    real = type(distance)
    depth = radius_a + radius_b - distance
    if depth > -margin:
        normal = vec.scale(between, real(1) / distance) if distance > 0 else fallback
        write_normal(contacts, target, normal)
        middle = vec.add_scaled(vec.scale(vec.add(on_a, on_b), real(0.5)), normal, real(0.5) * (radius_a - radius_b))
        write_point(contacts, target, middle, depth, feature)


@kernel
def sphere_sphere(rows, bodies, colliders, shapes, margin, contacts):
    """Contacts of pairs of spheres. Concentric spheres have the normal +x."""
    real = contacts.depth.dtype.type
    margin = real(margin)
    zero = real(0)
    for p in rows:
        pair, target = place(bodies, colliders, shapes, contacts, p)
        row_a, row_b, _, _, d = pair
        radius_a, radius_b = shapes.size[row_a, 0], shapes.size[row_b, 0]
        origin, x_axis = (zero, zero, zero), (real(1), zero, zero)
        write_round_contact(contacts, target, origin, d, radius_a, radius_b, x_axis, margin, 0)
