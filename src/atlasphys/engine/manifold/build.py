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


@kernel
def build_manifolds(contacts, pairs, bodies, colliders, old, old_count, new, ended, rules, distance, kept):
    """Fill ``new`` with the manifolds of all pairs that have contact points, and return their number.

    ``ended`` (one flag per row of ``old``) is set where last step's pair has no contact any more. ``rules`` are the combine rules of friction
    and restitution; rolling and torsional friction take the greater. ``kept`` is scratch for four indices.
    """
    count = 0
    j = 0
    for p in range(pairs):
        if contacts.count[p] == 0:
            continue
        i = count
        count += 1
        a, b = contacts.a[p], contacts.b[p]
        new.a[i], new.b[i], new.touching[i] = a, b, False
        normal = vec.load(contacts.normal, p)
        vec.store(new.normal, i, normal)
        x, y, material = colliders.material[a], colliders.material[b], new.material[i]
        material[0], material[1] = combine(x[0], y[0], rules[0]), combine(x[1], y[1], rules[1])
        material[2], material[3] = max(x[2], y[2]), max(x[3], y[3])

        body_a, body_b = colliders.body[a], colliders.body[b]
        near = body_a if bodies.kind[body_a] == DYNAMIC else body_b
        frame_a, frame_b = mat.load(bodies.geometry, body_a), mat.load(bodies.geometry, body_b)
        new.count[i] = reduce_points(
            normal, contacts.anchor_b, contacts.depth, contacts.first[p], contacts.count[p], kept
        )
        for k in range(new.count[i]):
            r_a, r_b = vec.load(contacts.anchor_a, kept[k]), vec.load(contacts.anchor_b, kept[k])
            vec.store(new.anchor_a[i], k, r_a)
            vec.store(new.anchor_b[i], k, r_b)
            for c in range(3):  # from the body that cannot be a plane with a far-off origin
                new.point[i, k, c] = bodies.center[near, c] + (r_a[c] if near == body_a else r_b[c])
            vec.store(new.local_a[i], k, mat.transpose_mul_vec(frame_a, r_a))
            vec.store(new.local_b[i], k, mat.transpose_mul_vec(frame_b, r_b))
            new.depth[i, k] = contacts.depth[kept[k]]
            new.feature[i, k] = contacts.feature[kept[k]]
            new.normal_impulse[i, k] = 0
            for c in range(3):
                new.friction_impulse[i, k, c] = 0
        for k in range(new.count[i], 4):  # unused points are zero, so that equal states are equal bits
            new.depth[i, k] = new.normal_impulse[i, k] = new.feature[i, k] = 0
            for c in range(3):
                new.point[i, k, c] = new.anchor_a[i, k, c] = new.anchor_b[i, k, c] = new.local_a[i, k, c] = new.local_b[i, k, c] = 0
                new.friction_impulse[i, k, c] = 0
        for c in range(3):
            new.rolling_impulse[i, c] = 0
        new.torsional_impulse[i] = 0

        while j < old_count and (old.a[j] < a or (old.a[j] == a and old.b[j] < b)):
            ended[j] = True
            j += 1
        if j < old_count and old.a[j] == a and old.b[j] == b:
            match_points(new, i, old, j, distance)
            ended[j] = False
            j += 1
    while j < old_count:
        ended[j] = True
        j += 1
    return count
