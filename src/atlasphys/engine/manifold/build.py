"""From this step's contacts to manifolds: at most four points a pair, with materials combined and impulses carried over."""

import math

from atlasphys.engine.jit import kernel, routine
from atlasphys.engine.manifold.match import match_points
from atlasphys.engine.manifold.reduce import reduce_points
from atlasphys.engine.math import mat, vec
from atlasphys.engine.state.bodies import DYNAMIC

COMBINE_RULES = {"geometric_mean": 0, "average": 1, "min": 2, "max": 3, "multiply": 4}
"""How the coefficients of two bodies give that of their contact: √(xy), ½(x + y), the lesser, the greater, xy."""


@routine
def combine(x, y, rule):
    """The coefficient of a contact between materials x and y."""
    if rule == 0:
        return math.sqrt(x * y)
    if rule == 1:
        return type(x)(0.5) * (x + y)
    if rule == 2:
        return min(x, y)
    if rule == 3:
        return max(x, y)
    return x * y


@routine
def combine_materials(material, a, b, rules, combined, i):
    """Write the material of the contact between colliders a and b to row i of ``combined``."""
    combined[i, 0] = combine(material[a, 0], material[b, 0], rules[0])
    combined[i, 1] = combine(material[a, 1], material[b, 1], rules[1])
    combined[i, 2] = max(material[a, 2], material[b, 2])
    combined[i, 3] = max(material[a, 3], material[b, 3])


@kernel
def build_manifolds(contacts, pairs, bodies, colliders, old, old_count, new, ended, rules, distance, kept, origin):
    """Fill ``new`` with the manifolds of all pairs that have contact points, and return their number.

    ``ended`` (one flag per row of ``old``) is set where last step's pair has no contact any more. ``rules`` are the combine rules of friction
    and restitution; rolling and torsional friction take the greater. ``kept`` and ``origin`` are scratch for four indices each.
    """
    count = 0
    j = 0
    for p in range(pairs):
        if contacts.count[p] == 0:
            continue
        i = count
        count += 1
        a, b = contacts.a[p], contacts.b[p]
        normal = vec.load(contacts.normal, p)
        new.a[i], new.b[i] = a, b
        vec.store(new.normal, i, normal)
        combine_materials(colliders.material, a, b, rules, new.material, i)

        body_a, body_b = colliders.body[a], colliders.body[b]
        near_a = bodies.kind[body_a] == DYNAMIC
        frame_a, frame_b = mat.load(bodies.geometry, body_a), mat.load(bodies.geometry, body_b)
        points = reduce_points(normal, contacts.anchor_b, contacts.depth, contacts.first[p], contacts.count[p], kept)
        new.count[i] = points
        for k in range(points):
            r_a, r_b = vec.load(contacts.anchor_a, kept[k]), vec.load(contacts.anchor_b, kept[k])
            vec.store_at(new.anchor_a, i, k, r_a)
            vec.store_at(new.anchor_b, i, k, r_b)
            # Seen from a body that cannot be a plane with a far-off origin
            vec.store_at(
                new.point, i, k,
                vec.add(vec.load(bodies.center, body_a), r_a) if near_a else vec.add(vec.load(bodies.center, body_b), r_b),
            )  # fmt: skip
            vec.store_at(new.local_a, i, k, mat.transpose_mul_vec(frame_a, r_a))
            vec.store_at(new.local_b, i, k, mat.transpose_mul_vec(frame_b, r_b))
            new.depth[i, k] = contacts.depth[kept[k]]
            new.feature[i, k] = contacts.feature[kept[k]]
        zero = normal[0] - normal[0]
        none = (zero, zero, zero)
        for k in range(points, 4):  # unused points are zero, so that equal states are equal bits
            new.depth[i, k], new.feature[i, k] = zero, 0
            vec.store_at(new.anchor_a, i, k, none)
            vec.store_at(new.anchor_b, i, k, none)
            vec.store_at(new.local_a, i, k, none)
            vec.store_at(new.local_b, i, k, none)
            vec.store_at(new.point, i, k, none)

        while j < old_count and (old.a[j] < a or (old.a[j] == a and old.b[j] < b)):
            ended[j] = True
            j += 1
        goes_on = j < old_count and old.a[j] == a and old.b[j] == b
        for k in range(4):
            origin[k] = -1
        if goes_on:
            match_points(
                i, points, new.feature, new.local_a, new.local_b,
                j, old.count[j], old.feature, old.local_a, old.local_b, distance, origin,
            )  # fmt: skip
        for k in range(4):
            q = origin[k]
            new.normal_impulse[i, k] = old.normal_impulse[j, q] if q >= 0 else zero
            vec.store_at(new.friction_impulse, i, k, vec.load_at(old.friction_impulse, j, q) if q >= 0 else none)
        vec.store(new.rolling_impulse, i, vec.load(old.rolling_impulse, j) if goes_on else none)
        new.torsional_impulse[i] = old.torsional_impulse[j] if goes_on else zero
        new.touching[i] = goes_on and old.touching[j]
        if goes_on:
            ended[j] = False
            j += 1
    while j < old_count:
        ended[j] = True
        j += 1
    return count
