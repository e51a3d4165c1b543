"""New manifolds from the contact points of eight pairs, with the impulses of last step's points carried over.

A new point goes on from the old one that lies nearest to it on either body, within the matching distance; where both have the same feature the
distance counts a tenth. Each old point serves one new one. (``match.py`` does the same for one pair at a time.)
"""

from atlasphys.engine.manifold.recycle import NEW_ROW, OLD_COUNT, OLD_ROW, PAIR_A, PAIR_B, QUATERNION, SWAPPED
from atlasphys.engine.simd import full, gather, load, minimum, scatter, select, simd_kernel, vec
from atlasphys.engine.state.manifolds import (
    LOCAL_A,
    LOCAL_B,
    NORMAL_IMPULSE,
    PATCH_FRICTION,
    POINT_COLUMNS,
)

FEATURE_FACTOR = 0.01
"""Factor on the squared distance of points with the same feature."""


@simd_kernel
def renew(integers, delta, geometry, contact, tags, materials, features, old, new, distance):
    """Write the manifolds of eight pairs whose narrow phase has filled ``contact`` (24, 8) and ``tags`` (8, 8).

    ``delta`` (3, 8) is x_b − x_a, ``materials`` (4, 8) the combined materials, ``features`` (4, 8) those of the old points. Pairs without
    points are left alone. In lanes with SWAPPED the narrow phase saw b as the first shape.
    """
    count, old_count, row = load(tags, 4), load(integers, OLD_COUNT), load(integers, OLD_ROW)
    swapped = load(integers, SWAPPED) != 0
    frame_a, frame_b = gather(geometry, load(integers, PAIR_A), 16), gather(geometry, load(integers, PAIR_B), 16)
    head, before, local_before = gather(old.contact, row, 16), gather(old.points, row, 32), gather(old.local, row, 32)
    raw = load(contact, 0), load(contact, 1), load(contact, 2)
    n = vec.select_vec(swapped, vec.neg(raw), raw)
    zero, one = full(n[0], 0), full(n[0], 1)
    between = load(delta, 0), load(delta, 1), load(delta, 2)
    limit = distance * distance

    points, local = [], []
    free = [old_count > q for q in range(4)]
    for k in range(4):
        valid = count > k
        feature = load(tags, k)
        from_first = load(contact, 4 + 4 * k), load(contact, 5 + 4 * k), load(contact, 6 + 4 * k)
        arm_a = vec.select_vec(swapped, vec.add(from_first, between), from_first)
        arm_b = vec.select_vec(swapped, from_first, vec.sub(from_first, between))
        in_a, in_b = vec.mat_transpose_mul_vec(frame_a, arm_a), vec.mat_transpose_mul_vec(frame_b, arm_b)
        depth = load(contact, 7 + 4 * k)
        impulse, best = zero, limit
        chosen = [valid & ~valid] * 4
        for q in range(4):
            first = POINT_COLUMNS * q
            apart = minimum(
                vec.length_squared(vec.sub(in_a, local_before[first + LOCAL_A : first + LOCAL_A + 3])),
                vec.length_squared(vec.sub(in_b, local_before[first + LOCAL_B : first + LOCAL_B + 3])),
            )
            apart = select(feature == load(features, q), FEATURE_FACTOR * apart, apart)
            better = free[q] & valid & (apart <= best)
            best = select(better, apart, best)
            impulse = select(better, before[first + NORMAL_IMPULSE], impulse)
            chosen = [c & ~better for c in chosen[:q]] + [better] + chosen[q + 1 :]
        free = [f & ~c for f, c in zip(free, chosen, strict=True)]
        point = (*arm_a, *arm_b, depth, impulse)
        points += [select(valid, value, zero) for value in point]
        local += [select(valid, value, zero) for value in (*in_a, *in_b, depth, zero)]

    carried = [select(old_count > 0, head[i], zero) for i in range(PATCH_FRICTION, PATCH_FRICTION + 7)]
    material = [load(materials, i) for i in range(4)]
    target, touches = load(integers, NEW_ROW), count > 0
    scatter(new.contact, target, (*n, *material, *carried, one, zero), where=touches)
    scatter(new.points, target, tuple(points), where=touches)
    scatter(new.local, target, tuple(local), where=touches)
    in_a = vec.mat_transpose_mul_vec(frame_a, n)
    reference = (*frame_a[QUATERNION:16], *frame_b[QUATERNION:16], *in_a, one, zero, zero, zero, zero)
    scatter(new.reference, target, reference, where=touches)
