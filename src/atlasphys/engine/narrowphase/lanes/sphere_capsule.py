"""A sphere and a capsule: two balls, the second about the point of the capsule's segment closest to the sphere's
centre."""

from __future__ import annotations

from atlasphys.engine.narrowphase.lanes.common import FIRST, SECOND, clamp, vector
from atlasphys.engine.narrowphase.lanes.sphere_sphere import round_contact
from atlasphys.engine.simd import full, gather, load, select, simd_kernel, vec


@simd_kernel
def sphere_capsule(pairs, geometry, place, margin, contact, tags) -> bool:
    """Contacts of eight pairs of a sphere and a capsule. With the centre on the axis, the normal is square to the axis."""
    d, axis = vector(place), vec.column(gather(geometry, load(pairs, 1), 16), 1)
    t = -vec.dot(d, axis)
    end = clamp(t, load(place, SECOND + 1))
    nearest = vec.add_scaled(d, axis, end)
    # Made exactly square to the axis: at a small distance, round-off along it is a large angle.
    nearest = vec.add_scaled(nearest, axis, select(end == t, -vec.dot(nearest, axis), 0))
    zero = full(t, 0)
    square, _ = vec.tangents(axis)
    radii = load(place, FIRST), load(place, SECOND)
    return round_contact((zero, zero, zero), nearest, *radii, square, margin, pairs, contact, tags)
