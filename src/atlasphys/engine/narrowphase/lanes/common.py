"""What the bodies share: reading the pair, turning axes about, writing contact points."""

from __future__ import annotations

from typing import Any

from atlasphys.engine.simd import any_lane, full, load, select, store

FIRST, SECOND = 4, 8
"""Fields of ``place`` where the sizes of the first and the second shape begin."""


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


def write_contact(pairs: Any, contact: Any, tags: Any, normal: Any, points: Any) -> Any:
    """Write the normal and up to four points ``(used, position, depth, feature)``, of which a used one follows only
    used ones. Returns whether any lane has a point."""
    for k in range(3):
        store(contact, k, normal[k])
    store(contact, 3, 0)
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
