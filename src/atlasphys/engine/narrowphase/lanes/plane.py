"""A sphere, capsule or box on a plane: the shape's lowest points."""

from __future__ import annotations

from typing import Any

from atlasphys.engine.narrowphase.lanes.common import FIRST, from_axis, sign, vector, write_contact
from atlasphys.engine.simd import absolute, full, gather, load, select, simd_kernel, vec


def _low_point(up: Any, height: Any, radius: Any, core: Any, rise: Any, feature: Any, margin: Any) -> Any:
    """The contact point below a point of a shape's core, ``rise`` above its centre."""
    gap = height + rise - radius
    return gap < margin, vec.add_scaled(core, up, -0.5 * gap - radius), -gap, feature


@simd_kernel
def sphere_plane(pairs, geometry, place, margin, contact, tags) -> bool:
    """Contacts of eight pairs of a sphere and a plane."""
    up, height, radius = vector(place), load(place, 3), load(place, FIRST)
    zero = full(height, 0)
    points = [_low_point(up, height, radius, (zero, zero, zero), 0, 0, margin)]
    return write_contact(pairs, contact, tags, vec.neg(up), points, -points[0][2] - margin)


@simd_kernel
def capsule_plane(pairs, geometry, place, margin, contact, tags) -> bool:
    """Contacts of eight pairs of a capsule and a plane: the two ends, the lower one first. Features: 0 the end at +y,
    1 the end at −y."""
    up, height = vector(place), load(place, 3)
    radius, half = load(place, FIRST), load(place, FIRST + 1)
    rows = load(pairs, 0)
    end = vec.scale(vec.column(gather(geometry, rows, 16), 1), half)
    rise = vec.dot(up, end)
    upper = rise > 0  # the end at +y
    low = vec.select_vec(upper, vec.neg(end), end)
    rise = absolute(rise)
    first = select(upper, full(rows, 1), 0)
    points = [
        _low_point(up, height, radius, low, -rise, first, margin),
        _low_point(up, height, radius, vec.neg(low), rise, 1 - first, margin),
    ]
    return write_contact(pairs, contact, tags, vec.neg(up), points, -points[0][2] - margin)


@simd_kernel
def box_plane(pairs, geometry, place, margin, contact, tags) -> bool:
    """Contacts of eight pairs of a box and a plane: the corners of the face that faces the plane most, lowest first.

    A corner's feature has bit 2, 1 or 0 where it lies on the side of positive x, y or z: its vertex number.
    """
    up, height = vector(place), load(place, 3)
    rows = load(pairs, 0)
    rotation = gather(geometry, rows, 16)
    slope = vec.mat_transpose_mul_vec(rotation[0:9], up)
    steep = tuple(absolute(s) for s in slope)
    is_0 = (steep[0] >= steep[1]) & (steep[0] >= steep[2])
    is_1 = steep[1] >= steep[2]

    def turned(x: Any, y: Any, z: Any) -> Any:
        return from_axis(is_0, is_1, (x, y, z))

    # From here on axis 0 is that of the face; the lowest corner lies against each axis that rises.
    slope, half = turned(*slope), turned(*vector(place, FIRST))
    columns = [turned(*rotation[3 * k : 3 * k + 3]) for k in range(3)]
    bits = turned(full(rows, 4), full(rows, 2), full(rows, 1))
    reach = [-sign(slope[k]) * half[k] for k in range(3)]
    axes = [tuple(column[k] * reach[k] for column in columns) for k in range(3)]
    falls = [absolute(slope[k]) * half[k] for k in range(3)]
    corner = sum_of(axes)
    drop = falls[0] + falls[1] + falls[2]
    feature = sum(select(slope[k] < 0, bits[k], 0) for k in range(3))

    # The next corner up is across the axis that rises less.
    flat_1 = falls[1] <= falls[2]
    near, far = vec.select_vec(flat_1, axes[1], axes[2]), vec.select_vec(flat_1, axes[2], axes[1])
    rise_near, rise_far = select(flat_1, falls[1], falls[2]), select(flat_1, falls[2], falls[1])
    flips = [select(slope[k] < 0, -bits[k], bits[k]) for k in (1, 2)]
    flip_near, flip_far = select(flat_1, flips[0], flips[1]), select(flat_1, flips[1], flips[0])
    across_near, across_far = vec.add_scaled(corner, near, -2), vec.add_scaled(corner, far, -2)
    points = [
        _low_point(up, height, 0, core, rise, number, margin)
        for core, rise, number in (
            (corner, -drop, feature),
            (across_near, 2 * rise_near - drop, feature + flip_near),
            (across_far, 2 * rise_far - drop, feature + flip_far),
            (vec.add_scaled(across_near, far, -2), 2 * (rise_near + rise_far) - drop, feature + flip_near + flip_far),
        )
    ]
    return write_contact(pairs, contact, tags, vec.neg(up), points, -points[0][2] - margin)


def sum_of(vectors: Any) -> Any:
    """The sum of three vectors."""
    return vec.add(vec.add(vectors[0], vectors[1]), vectors[2])
