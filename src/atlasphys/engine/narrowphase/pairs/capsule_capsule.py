"""Two capsules: the closest points of their segments, or both ends of what they share where the segments are
parallel."""

import numpy as np

from atlasphys.engine.jit import allocating_kernel
from atlasphys.engine.math import vec
from atlasphys.engine.narrowphase.clip import write_edges
from atlasphys.engine.narrowphase.gjk import precision
from atlasphys.engine.narrowphase.pair import place, write_normal
from atlasphys.engine.narrowphase.segments import closest_of_segments


@allocating_kernel
def capsule_capsule(rows, bodies, colliders, shapes, margin, contacts):
    """Contacts of pairs of capsules. Where the segments cross, the normal is square to both."""
    real = contacts.depth.dtype.type
    margin = real(margin)
    ends = np.empty((4, 3), contacts.depth.dtype)
    ids = np.empty(4, np.int32)
    ids[0] = ids[2] = 0
    ids[1] = ids[3] = 1
    for pair_row in rows:
        pair, target = place(bodies, colliders, shapes, contacts, pair_row)
        row_a, row_b, rotation_a, rotation_b, d = pair
        axis_a, axis_b = (rotation_a[1], rotation_a[4], rotation_a[7]), (rotation_b[1], rotation_b[4], rotation_b[7])
        radius_a, radius_b = shapes.size[row_a, 0], shapes.size[row_b, 0]
        half_a, half_b = shapes.size[row_a, 1], shapes.size[row_b, 1]
        p, u = vec.scale(axis_a, half_a), vec.scale(axis_a, real(-2) * half_a)
        q, v = vec.add_scaled(d, axis_b, half_b), vec.scale(axis_b, real(-2) * half_b)
        s, t = closest_of_segments(p, u, q, v)
        on_a, on_b = vec.add_scaled(p, u, s), vec.add_scaled(q, v, t)
        between = vec.sub(on_b, on_a)
        distance = vec.length(between)
        depth = radius_a + radius_b - distance
        if depth <= -margin:
            continue
        # Inside both segments the normal is square to both axes; where they all but touch, nothing else is known of it.
        across = vec.cross(axis_a, axis_b)
        sine = vec.length(across)
        touching = distance <= real(64) * precision(distance) * (half_a + half_b + vec.length(d))
        crossing = 0 < s < 1 and 0 < t < 1 and sine > real(0.001)
        if not touching and not crossing:
            normal = vec.scale(between, real(1) / distance)
        else:
            if sine > real(0.001):
                normal = vec.scale(across, real(1) / sine)
            else:
                normal, _ = vec.tangents(axis_a)
            if vec.dot(normal, between if distance > 0 else d) < 0:
                normal = vec.neg(normal)
        vec.store(ends, 0, p)
        vec.store(ends, 1, vec.add(p, u))
        vec.store(ends, 2, q)
        vec.store(ends, 3, vec.add(q, v))
        write_normal(contacts, target, normal)
        write_edges(contacts, target, normal, depth, on_a, on_b, radius_a, radius_b, margin, ends, ids, 2, 2, 2)
