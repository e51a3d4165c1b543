"""A sphere and a box: the centre clamped to the box is the nearest point; a centre inside the box leaves by the
nearest face."""

from __future__ import annotations

from atlasphys.engine.narrowphase.lanes.common import FIRST, SECOND, clamp, sign, vector, write_contact
from atlasphys.engine.simd import absolute, full, gather, load, select, simd_kernel, vec


@simd_kernel
def sphere_box(pairs, geometry, place, margin, contact, tags) -> bool:
    """Contacts of eight pairs of a sphere and a box."""
    rotation = gather(geometry, load(pairs, 1), 16)[0:9]
    radius, half = load(place, FIRST), vector(place, SECOND)
    center = vec.mat_transpose_mul_vec(rotation, vec.neg(vector(place)))
    between = [clamp(x, h) - x for x, h in zip(center, half, strict=True)]
    distance = vec.length(between)
    outside = distance > 0

    zero = full(distance, 0)
    x, y, z = (h - absolute(c) for c, h in zip(center, half, strict=True))
    by_x = (x <= y) & (x <= z)
    by_y = ~by_x & (y <= z)
    inward = [-sign(c) for c in center]
    inside = (
        select(by_x, inward[0], zero),
        select(by_y, inward[1], zero),
        select(by_x | by_y, zero, inward[2]),
    )
    normal = vec.mat_mul_vec(rotation, vec.select_vec(outside, vec.scale(between, 1 / distance), inside))
    distance = select(outside, distance, -select(by_x, x, select(by_y, y, z)))
    point = vec.scale(normal, 0.5 * (distance + radius))
    gap = distance - radius
    return write_contact(pairs, contact, tags, normal, [(gap < margin, point, -gap, 0)], gap - margin)
