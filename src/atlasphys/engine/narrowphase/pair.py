"""What all pair routines share: where the two shapes are, and how contact points are written down.

Positions are double. A pair is worked on in a frame along the world's axes whose origin is that of its first shape,
so single precision is as good a kilometre from the world's origin as it is there.

A pair of collider rows (a, b) has a below b; a routine for, say, sphere and box wants the sphere first. :func:`place`
gives the two in the order of their kinds and remembers whether that swapped them; :func:`write_normal` and
:func:`write_point` swap back.
"""

from atlasphys.engine.jit import routine
from atlasphys.engine.math import mat, vec
from atlasphys.engine.shapes.table import KIND
from atlasphys.engine.trace import TRACED, note


@routine
def place(bodies, colliders, shapes, contacts, p):
    """The two shapes of pair p, in the order of their kinds.

    Returns:
        pair: ``row_a, row_b, rotation_a, rotation_b, d``: rows of the shapes, rotation matrices, vector between the
        origins. target: ``p, swapped, center_a, center_b``: where to write, and the two centres of mass as seen from
        a's origin.
    """
    real = contacts.depth.dtype.type
    a, b = contacts.a[p], contacts.b[p]
    swapped = shapes.layout[colliders.shape[a], KIND] > shapes.layout[colliders.shape[b], KIND]
    if swapped:
        a, b = b, a
    body_a, body_b = colliders.body[a], colliders.body[b]
    d = (
        real(bodies.position[body_b, 0] - bodies.position[body_a, 0]),
        real(bodies.position[body_b, 1] - bodies.position[body_a, 1]),
        real(bodies.position[body_b, 2] - bodies.position[body_a, 2]),
    )
    geometry = bodies.geometry
    center_a = geometry[body_a, 9], geometry[body_a, 10], geometry[body_a, 11]
    center_b = vec.add(d, (geometry[body_b, 9], geometry[body_b, 10], geometry[body_b, 11]))
    pair = colliders.shape[a], colliders.shape[b], mat.load(geometry, body_a), mat.load(geometry, body_b), d
    return pair, (p, swapped, center_a, center_b)


@routine
def write_normal(contacts, target, normal):
    """Begin a pair's contact: its unit normal, from the first shape to the second, and no points yet."""
    p, swapped, _, _ = target
    vec.store(contacts.normal, p, vec.neg(normal) if swapped else normal)
    contacts.count[p] = 0
    if TRACED:
        note("contact.normal", normal=normal)


@routine
def write_point(contacts, target, point, depth, feature):
    """Add a contact point, given as seen from the first shape's origin and midway between the two surfaces."""
    p, swapped, center_a, center_b = target
    slot = contacts.first[p] + contacts.count[p]
    if TRACED:
        note("contact.point", point=point, depth=depth, feature=feature)
    from_a, from_b = vec.sub(point, center_a), vec.sub(point, center_b)
    vec.store(contacts.anchor_a, slot, from_b if swapped else from_a)
    vec.store(contacts.anchor_b, slot, from_a if swapped else from_b)
    contacts.depth[slot] = depth
    contacts.feature[slot] = feature
    contacts.count[p] += 1
