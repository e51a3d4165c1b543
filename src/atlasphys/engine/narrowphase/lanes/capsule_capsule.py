"""Two capsules: the closest points of their segments, or both ends of what they share where the segments run side by
side."""

from __future__ import annotations

from typing import Any

import numpy as np

from atlasphys.engine.narrowphase.clip import FACE_PREFERENCE, PARALLEL
from atlasphys.engine.narrowphase.lanes.common import (
    ASIDE,
    FIRST,
    SECOND,
    clamp,
    one_or_two_points,
    room_of_segment,
    vector,
    write_contact,
)
from atlasphys.engine.simd import absolute, full, gather, load, maximum, minimum, select, simd_kernel, sqrt, vec

CROSSING = 1e-3
"""Sine of the angle above which the cross product of the axes is a normal where the segments cross."""


def _closest(d: Any, a: Any, b: Any, half_a: Any, half_b: Any, sine_squared: Any) -> Any:
    """The closest points ``s a`` and ``d + t b`` of two segments with unit axes, |s| ≤ half_a, |t| ≤ half_b.

    Returns ``s, t`` and whether both lie inside. The lines' closest points count if they are on the segments; each end
    is tried too, since for nearly parallel lines round-off leaves nothing of the first.
    """
    da, db, ab = vec.dot(d, a), vec.dot(d, b), vec.dot(a, b)
    s, t = (da - db * ab) / sine_squared, (da * ab - db) / sine_squared
    tries = [(s, t, (absolute(s) < half_a) & (absolute(t) < half_b))]
    anywhere = half_a == half_a
    for side in (-1, 1):
        s = side * half_a
        tries.append((s, clamp(s * ab - db, half_b), anywhere))
        t = side * half_b
        tries.append((clamp(da + t * ab, half_a), t, anywhere))
    best, least, inside = tries[1][:2], full(da, float("inf")), None
    for s, t, allowed in tries:
        squared = vec.length_squared(vec.add_scaled(vec.add_scaled(d, b, t), a, -s))
        better = allowed & (squared < least)
        best, least = vec.select_vec(better, (s, t), best), select(better, squared, least)
        inside = better if inside is None else inside & ~better
    return *best, inside


@simd_kernel
def capsule_capsule(pairs, geometry, place, margin, contact, tags) -> bool:
    """Contacts of eight pairs of capsules. Where the segments cross, the normal is square to both.

    Features: 0 a single point, 1 and 2 the ends of what the segments share.
    """
    d = vector(place)
    a, b = (vec.column(gather(geometry, load(pairs, k), 16), 1) for k in range(2))
    radius_a, half_a = load(place, FIRST), load(place, FIRST + 1)
    radius_b, half_b = load(place, SECOND), load(place, SECOND + 1)
    across = vec.cross(a, b)
    sine_squared = vec.length_squared(across)
    s, t, inside = _closest(d, a, b, half_a, half_b, sine_squared)
    between = vec.sub(vec.add_scaled(d, b, t), vec.scale(a, s))
    distance = vec.length(between)

    # Inside both segments the normal is square to both axes; where they all but touch, nothing else is known of it.
    noise = 64 * float(np.finfo(distance.dtype).eps) * (half_a + half_b + vec.length(d))
    crossing = sine_squared > CROSSING * CROSSING
    square = vec.select_vec(crossing, vec.scale(across, 1 / sqrt(sine_squared)), vec.tangents(a)[0])
    away = vec.dot(square, vec.select_vec(distance > 0, between, d)) < 0
    square = vec.select_vec(away, vec.neg(square), square)
    normal = vec.select_vec((distance <= noise) | (inside & crossing), square, vec.scale(between, 1 / distance))

    # What they share: from low to high along a. There, b is nearly parallel to a, so ab is nearly ±1.
    da, ab = vec.dot(d, a), vec.dot(a, b)
    low, high = maximum(da - half_b * absolute(ab), -half_a), minimum(da + half_b * absolute(ab), half_a)
    both = (
        (sine_squared <= PARALLEL * PARALLEL)
        & (absolute(vec.dot(normal, a)) <= PARALLEL)
        & (absolute(vec.dot(normal, b)) <= PARALLEL)
        & (low < high)
    )
    radii = radius_a + radius_b

    def point(s: Any, t: Any, gap: Any) -> Any:
        """Midway between the surfaces about the points of the segments."""
        middle = vec.scale(vec.add(vec.scale(a, s), vec.add_scaled(d, b, t)), 0.5)
        return vec.add_scaled(middle, normal, 0.5 * (radius_a - radius_b)), radii - gap

    ends, nearest = [], full(s, float("inf"))
    for s_end in (low, high):
        t_end = (s_end - da) / ab
        across = vec.sub(vec.add_scaled(d, b, t_end), vec.scale(a, s_end))
        gap = vec.dot(across, normal)
        both = both & (vec.length_squared(across) - gap * gap <= ASIDE * ASIDE * radii * radii)
        nearest = minimum(gap, nearest)
        ends.append(point(s_end, t_end, gap))
    both = both & (nearest <= distance + 2 * FACE_PREFERENCE * margin)
    points = one_or_two_points(point(s, t, distance), ends, both, margin, load(pairs, 0))
    return write_contact(pairs, contact, tags, normal, points, room_of_segment(distance - radii, radii, margin))
