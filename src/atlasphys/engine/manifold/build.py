"""From this step's contacts to manifolds: at most four points a pair, with materials combined and impulses carried over."""

import math

from atlasphys.engine.jit import kernel, routine
from atlasphys.engine.manifold.match import match_points
from atlasphys.engine.manifold.reduce import reduce_points
from atlasphys.engine.math import mat, vec
from atlasphys.engine.state.manifolds import (
    ANCHOR_A,
    ANCHOR_B,
    COLLISION_DEPTH,
    DEPTH,
    FRICTION,
    IS_FRESH,
    LOCAL_A,
    LOCAL_B,
    NORMAL,
    NORMAL_IMPULSE,
    PATCH_FRICTION,
    PATCH_ROLLING,
    PENALTY,
    POINT_COLUMNS,
    RESTITUTION,
    ROLLING,
    TORSIONAL,
)

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
def combine_materials(material, a, b, rules, contact, i):
    """Write the material of the contact between colliders a and b to row i of ``Manifolds.contact``."""
    contact[i, FRICTION] = combine(material[a, 0], material[b, 0], rules[0])
    contact[i, RESTITUTION] = combine(material[a, 1], material[b, 1], rules[1])
    contact[i, ROLLING] = max(material[a, 2], material[b, 2])
    contact[i, TORSIONAL] = max(material[a, 3], material[b, 3])


@routine
def combine_materials_lane(material, a, b, friction_rule, restitution_rule, materials, lane):
    """Write the material of the contact between colliders a and b to a lane of ``materials`` (4, lanes)."""
    materials[0, lane] = combine(material[a, 0], material[b, 0], friction_rule)
    materials[1, lane] = combine(material[a, 1], material[b, 1], restitution_rule)
    materials[2, lane] = max(material[a, 2], material[b, 2])
    materials[3, lane] = max(material[a, 3], material[b, 3])


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
        vec.store_columns(new.contact, i, NORMAL, normal)
        combine_materials(colliders.material, a, b, rules, new.contact, i)

        body_a, body_b = colliders.body[a], colliders.body[b]
        frame_a, frame_b = mat.load(bodies.geometry, body_a), mat.load(bodies.geometry, body_b)
        points = reduce_points(normal, contacts.anchor_b, contacts.depth, contacts.first[p], contacts.count[p], kept)
        new.count[i] = points
        for k in range(points):
            r_a, r_b = vec.load(contacts.anchor_a, kept[k]), vec.load(contacts.anchor_b, kept[k])
            first = POINT_COLUMNS * k
            vec.store_columns(new.points, i, first + ANCHOR_A, r_a)
            vec.store_columns(new.points, i, first + ANCHOR_B, r_b)
            vec.store_columns(new.local, i, first + LOCAL_A, mat.transpose_mul_vec(frame_a, r_a))
            vec.store_columns(new.local, i, first + LOCAL_B, mat.transpose_mul_vec(frame_b, r_b))
            new.points[i, first + DEPTH] = contacts.depth[kept[k]]
            new.local[i, first + COLLISION_DEPTH] = 0  # for recycling alone
            new.feature[i, k] = contacts.feature[kept[k]]
        zero = normal[0] - normal[0]
        none = (zero, zero, zero)
        for k in range(points, 4):  # unused points are zero, so that equal states are equal bits
            new.feature[i, k] = 0
            for c in range(POINT_COLUMNS * k, POINT_COLUMNS * (k + 1)):
                new.points[i, c] = new.local[i, c] = zero

        while j < old_count and (old.a[j] < a or (old.a[j] == a and old.b[j] < b)):
            ended[j] = True
            j += 1
        goes_on = j < old_count and old.a[j] == a and old.b[j] == b
        for k in range(4):
            origin[k] = -1
        if goes_on:
            match_points(
                i, points, new.feature, new.local, j, old.count[j], old.feature, old.local, distance, origin
            )  # fmt: skip
        for k in range(4):
            q = origin[k]
            pushed = old.points[j, POINT_COLUMNS * q + NORMAL_IMPULSE] if q >= 0 else zero
            new.points[i, POINT_COLUMNS * k + NORMAL_IMPULSE] = pushed
            new.local[i, POINT_COLUMNS * k + PENALTY] = old.local[j, POINT_COLUMNS * q + PENALTY] if q >= 0 else zero
            rubbed = vec.load_columns(old.friction_impulse, j, 3 * q) if q >= 0 else none
            vec.store_columns(new.friction_impulse, i, 3 * k, rubbed)
        for c in range(PATCH_FRICTION, PATCH_ROLLING + 3):
            new.contact[i, c] = old.contact[j, c] if goes_on else zero
        new.total[i] = 0
        new.collided[i], new.contact[i, IS_FRESH] = 0, 1
        new.reference[i] = 0  # not recyclable
        new.touching[i] = goes_on and old.touching[j]
        if goes_on:
            ended[j] = False
            j += 1
    while j < old_count:
        ended[j] = True
        j += 1
    return count
