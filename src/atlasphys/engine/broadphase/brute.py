"""Brute force: every pair is tested. O(n²); the reference that the others are tested against."""

import numpy as np
import numpy.typing as npt

from atlasphys.engine.broadphase.filters import bounds_overlap, is_plane, may_collide, reaches_plane
from atlasphys.engine.jit import kernel
from atlasphys.engine.shapes.table import Shapes
from atlasphys.engine.state.bodies import Bodies
from atlasphys.engine.state.colliders import Colliders


@kernel
def test_all(bodies, colliders, shapes, count, pairs):
    """Write the overlapping pairs, lower row first, into ``pairs`` as far as they fit; return how many there are."""
    found = 0
    for i in range(count):
        plane_i = is_plane(colliders, shapes, i)
        for j in range(i + 1, count):
            if not may_collide(bodies, colliders, i, j):
                continue
            plane_j = is_plane(colliders, shapes, j)
            if plane_i and plane_j:
                continue
            if plane_i:
                near = reaches_plane(bodies, colliders, shapes, i, j)
            elif plane_j:
                near = reaches_plane(bodies, colliders, shapes, j, i)
            else:
                near = bounds_overlap(colliders, i, j)
            if near:
                if found < len(pairs):
                    pairs[found, 0], pairs[found, 1] = i, j
                found += 1
    return found


def find_pairs(
    bodies: Bodies, colliders: Colliders, shapes: Shapes, count: int, pairs: npt.NDArray[np.int32]
) -> tuple[npt.NDArray[np.int32], int]:
    """All pairs that may touch, ordered by (lower row, higher row): a buffer, enlarged if ``pairs`` is too small, and the number in it."""
    while (found := test_all(bodies, colliders, shapes, count, pairs)) > len(pairs):
        pairs = np.empty((2 * found, 2), np.int32)
    return pairs, found
