"""A sphere and a box: the centre clamped to the box is the nearest point; a centre inside the box leaves by the
nearest face."""

from atlasphys.engine.jit import kernel
from atlasphys.engine.math import mat, vec
from atlasphys.engine.narrowphase.pair import place, write_normal, write_point


@kernel
def sphere_box(rows, bodies, colliders, shapes, margin, contacts):
    """Contacts of pairs of a sphere and a box."""
    real = contacts.depth.dtype.type
    margin = real(margin)
    zero, one, half = real(0), real(1), real(0.5)
    for p in rows:
        pair, target = place(bodies, colliders, shapes, contacts, p)
        sphere, box, _, rotation, d = pair
        radius = shapes.size[sphere, 0]
        hx, hy, hz = shapes.size[box, 0], shapes.size[box, 1], shapes.size[box, 2]
        x, y, z = mat.transpose_mul_vec(rotation, vec.neg(d))  # the sphere's centre in the box's frame
        nearest = (min(max(x, -hx), hx), min(max(y, -hy), hy), min(max(z, -hz), hz))
        between = vec.sub(nearest, (x, y, z))
        distance = vec.length(between)
        if distance - radius >= margin:
            continue
        if distance > 0:
            normal = vec.scale(between, one / distance)
        else:
            inside_x, inside_y, inside_z = hx - abs(x), hy - abs(y), hz - abs(z)
            if inside_x <= inside_y and inside_x <= inside_z:
                distance, normal = -inside_x, (-one if x >= 0 else one, zero, zero)
            elif inside_y <= inside_z:
                distance, normal = -inside_y, (zero, -one if y >= 0 else one, zero)
            else:
                distance, normal = -inside_z, (zero, zero, -one if z >= 0 else one)
        normal = mat.mul_vec(rotation, normal)
        write_normal(contacts, target, normal)
        write_point(contacts, target, vec.scale(normal, half * (distance + radius)), radius - distance, 0)
