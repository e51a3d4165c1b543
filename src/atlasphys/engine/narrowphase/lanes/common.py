"""What the bodies share: reading the pair, turning axes about, writing contact points."""

from __future__ import annotations

from typing import Any

from atlasphys.engine.simd import absolute, any_lane, full, load, select, store, vec

FIRST, SECOND = 4, 8
"""Fields of ``place`` where the sizes of the first and the second shape begin."""

ROOM = 3
"""Field of ``contact``: see ``write_contact``."""

ASIDE = 0.1
"""How far, as a part of the radii, a segment may pass beside what it runs along and still touch it there. Larger: long
thin capsules that cross at a small angle seem to touch where they have long parted. Smaller: capsules that lie side by
side rock about one point."""


def vector(blocks: Any, first: int = 0) -> Any:
    """Three fields of a block."""
    return load(blocks, first), load(blocks, first + 1), load(blocks, first + 2)


def from_axis(is_0: Any, is_1: Any, triple: Any) -> Any:
    """A triple in cyclic order from the axis that the masks tell: ``is_0`` axis 0, ``is_1`` axis 1, neither axis 2."""
    x, y, z = triple
    return (
        select(is_0, x, select(is_1, y, z)),
        select(is_0, y, select(is_1, z, x)),
        select(is_0, z, select(is_1, x, y)),
    )


def sign(x: Any) -> Any:
    """−1 below zero, else +1."""
    return select(x < 0, full(x, -1), 1)


def clamp(x: Any, limit: Any) -> Any:
    """x, or the nearest number to it from −limit to +limit."""
    x = select(x < limit, x, limit)
    return select(x > -limit, x, -limit)


def within(start: Any, along: Any, limit: Any) -> Any:
    """The least and greatest t for which ``start + t along`` lies from −limit to +limit; the first is the greater
    where there is none."""
    # Not so small that a product with the reciprocal is no number.
    inverse = 1 / select(absolute(along) < 1e-20, 1e-20, along)
    reach, center = limit * absolute(inverse), start * inverse
    return -reach - center, reach - center


def room_of_segment(gap: Any, radii: Any, margin: Any) -> Any:
    """The room of round shapes about segments that are ``gap`` apart. The ends of what they share count by their distance along the normal, which
    is less than that of the points, as these may lie aside."""
    return gap - ASIDE * ASIDE * radii - margin


def one_or_two_points(single: Any, ends: Any, both: Any, margin: Any, rows: Any) -> Any:
    """The points of a segment's contact: its ends, with features 1 and 2, in the lanes of the mask, a single one with
    feature 0 in the others.

    Args:
        single, ends: ``position, depth``.
        rows: any integer lanes, to make more like them.
    """
    (low, low_depth), (high, high_depth) = ends
    low_first = low_depth > -margin
    position = vec.select_vec(low_first, low, high)
    depth = select(both, select(low_first, low_depth, high_depth), single[1])
    feature = select(both, select(low_first, full(rows, 1), 2), 0)
    return [
        (depth > -margin, vec.select_vec(both, position, single[0]), depth, feature),
        (both & low_first & (high_depth > -margin), high, high_depth, 2),
    ]


def write_contact(pairs: Any, contact: Any, tags: Any, normal: Any, points: Any, room: Any) -> Any:
    """Write the normal and up to four points ``(used, position, depth, feature)``, of which a used one follows only
    used ones; and by how much at least the shapes may come nearer before there are points, where there are none, up to
    round-off [m]. Returns whether any lane has a point."""
    for k in range(3):
        store(contact, k, normal[k])
    store(contact, ROOM, room)
    rows = load(pairs, 0)
    count = full(rows, 0)
    for k in range(4):
        values, feature = (0, 0, 0, 0), 0
        if k < len(points):
            used, position, depth, feature = points[k]
            values = tuple(select(used, value, 0) for value in (*position, depth))
            feature = select(used, full(rows, feature) if isinstance(feature, int) else feature, 0)
            count = count + select(used, full(rows, 1), 0)
        for i, value in enumerate(values):
            store(contact, 4 + 4 * k + i, value)
        store(tags, k, feature)
    store(tags, 4, count)
    return any_lane(count > 0)
