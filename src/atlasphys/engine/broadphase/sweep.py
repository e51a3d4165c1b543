"""Sweep and prune: bounds sorted along one axis, each tested against those that begin before it ends.

The axis is the one along which the bodies are spread widest. O(n log n) plus the pairs that overlap along that axis.
(D. Baraff, "Dynamic Simulation of Non-penetrating Rigid Bodies", 1992; J. Cohen et al., "I-COLLIDE", 1995.)
Planes have no bounds: each is tested against every body.
"""

import numpy as np
import numpy.typing as npt

from atlasphys.engine.broadphase.filters import bounds_overlap, may_collide, reaches_plane
from atlasphys.engine.jit import kernel
from atlasphys.engine.shapes.table import KIND, PLANE, Shapes
from atlasphys.engine.state.bodies import Bodies
from atlasphys.engine.state.colliders import Colliders
from atlasphys.engine.trace import TRACED, note


@kernel
def sweep(bodies, colliders, shapes, order, axis, planes, keys):
    """Write the key (lower row · 2³² + higher row) of each overlapping pair into ``keys`` as far as they fit; return how many there are.

    ``order`` holds the rows of the bounded colliders by ascending lower bound along ``axis``, ``planes`` the rows of the planes.
    """
    found = 0
    for s in range(len(order)):
        i = order[s]
        end = colliders.upper[i, axis]
        for t in range(s + 1, len(order)):
            j = order[t]
            if colliders.lower[j, axis] > end:
                if TRACED:
                    note("sweep.stop", i=i, j=j, axis=axis, end=end, begin=colliders.lower[j, axis])
                break
            if bounds_overlap(colliders, i, j) and may_collide(bodies, colliders, i, j):
                if found < len(keys):
                    keys[found] = (np.int64(min(i, j)) << 32) + np.int64(max(i, j))
                found += 1
        for plane in planes:
            if may_collide(bodies, colliders, i, plane) and reaches_plane(bodies, colliders, shapes, plane, i):
                if found < len(keys):
                    keys[found] = (np.int64(min(i, plane)) << 32) + np.int64(max(i, plane))
                found += 1
    return found


def find_pairs(
    bodies: Bodies, colliders: Colliders, shapes: Shapes, count: int, pairs: npt.NDArray[np.int32]
) -> tuple[npt.NDArray[np.int32], int]:
    """All pairs that may touch, ordered by (lower row, higher row): a buffer, enlarged if ``pairs`` is too small, and the number in it."""
    is_plane = shapes.layout[colliders.shape[:count], KIND] == PLANE
    planes = np.flatnonzero(is_plane)
    bounded = np.flatnonzero(~is_plane)
    lower = colliders.lower[bounded]
    if len(bounded) == 0:
        return pairs, 0
    axis = int(np.argmax(np.ptp(lower, axis=0)))
    order = bounded[np.argsort(lower[:, axis], kind="stable")]
    keys = np.empty(len(pairs), np.int64)
    while (found := sweep(bodies, colliders, shapes, order, axis, planes, keys)) > len(keys):
        keys = np.empty(2 * found, np.int64)
    if len(pairs) < len(keys):
        pairs = np.empty((len(keys), 2), np.int32)
    keys = np.sort(keys[:found])
    pairs[:found, 0], pairs[:found, 1] = keys >> 32, keys & 0xFFFFFFFF
    return pairs, found
