"""Two spheres."""

from __future__ import annotations

from typing import Any

from atlasphys.engine.narrowphase.lanes.common import FIRST, SECOND, vector, write_contact
from atlasphys.engine.simd import full, load, simd_kernel, vec


def round_contact(
    on_a: Any, on_b: Any, radius_a: Any, radius_b: Any, fallback: Any, margin: Any, pairs: Any, contact: Any, tags: Any
) -> Any:
    """Contact of two balls about the points ``on_a`` and ``on_b``; where those coincide, the normal is ``fallback``."""
    between = vec.sub(on_b, on_a)
    distance = vec.length(between)
    depth = radius_a + radius_b - distance
    normal = vec.select_vec(distance > 0, vec.scale(between, 1 / distance), fallback)
    middle = vec.add_scaled(vec.scale(vec.add(on_a, on_b), 0.5), normal, 0.5 * (radius_a - radius_b))
    return write_contact(pairs, contact, tags, normal, [(depth > -margin, middle, depth, 0)], -depth - margin)


@simd_kernel
def sphere_sphere(pairs, geometry, place, margin, contact, tags) -> bool:
    """Contacts of eight pairs of spheres. Concentric spheres have the normal +x."""
    d = vector(place)
    zero = full(d[0], 0)
    origin, x_axis = (zero, zero, zero), (full(zero, 1), zero, zero)
    return round_contact(origin, d, load(place, FIRST), load(place, SECOND), x_axis, margin, pairs, contact, tags)
