"""A linear bounding volume hierarchy, eight boxes wide.

Boxes are sorted along a Hilbert curve (I. Kamel and C. Faloutsos, "On packing R-trees", 1993; C. Lauterbach et al., "Fast BVH
Construction on GPUs", 2009). Each eight neighbours make a block; the boxes around eight blocks make a block of the next level, and so on
up to a single block. So the tree needs no pointers: the box in lane k of block b is that of block 8 b + k, one level below. One vector
test tells which of a block's eight boxes a given box overlaps.

Boxes are single precision, rounded outwards: rows of (lower x, y, z, upper x, y, z, two unused). An empty box has lower +∞ and
upper −∞ and overlaps nothing; there is one behind the last row, and blocks that are not full are filled up with it.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from atlasphys.engine.jit import kernel, routine
from atlasphys.engine.simd import LANES, gather, load, simd_kernel, store
from atlasphys.engine.trace import TRACED, note

LARGEST = 3e38
"""Coordinates are cut off here [m], so that they are finite in single precision."""

CURVE_CELLS = 1 << 20
"""The curve's lattice reaches that many cells from its centre along each axis. What lies beyond counts as lying at its border: one
body far away does not make the cells coarse for the others."""

STACK = 128
"""Blocks that wait to be visited: at most seven for each level, of which there are at most eleven."""

LANE_OF_BIT = np.zeros(129, np.int64)
LANE_OF_BIT[2 ** np.arange(LANES)] = np.arange(LANES)
"""Lane whose bit alone is set."""


def _hilbert_states() -> npt.NDArray[np.int64]:
    """(24, 8): for each orientation of the curve in a cube and each octant of it, 8 · the orientation in the octant + the octant's place
    on the curve. An orientation is 3 · the corner where the curve enters + the axis along which it leaves; bit k of a corner or octant
    is its side along axis k (C. H. Hamilton, "Compact Hilbert indices", 2006, section 2)."""

    def turned(bits: int, by: int) -> int:
        return (bits << by % 3 | bits >> (3 - by % 3)) & 7

    gray = [place ^ place >> 1 for place in range(8)]
    entry = [0, 0, 0, 3, 3, 6, 6, 5]  # of the octant in each place, and the axis along which it is left
    axis = [0, 1, 1, 2, 2, 1, 1, 0]
    states = np.empty((24, 8), np.int64)
    for e in range(8):
        for d in range(3):
            for octant in range(8):
                place = gray.index(turned(octant ^ e, 2 - d))
                inner = 3 * (e ^ turned(entry[place], d + 1)) + (d + axis[place] + 1) % 3
                states[3 * e + d, octant] = 8 * inner + place
    return states


HILBERT = _hilbert_states()


@routine
def store_interval(boxes, row, axis, lower, upper):
    """Write a box's extent along an axis, given in double precision, rounded outwards; an empty one unless it is finite."""
    low = np.float32(min(max(lower, -LARGEST), LARGEST))
    high = np.float32(min(max(upper, -LARGEST), LARGEST))
    # Rounding to nearest is wrong by half a unit in the last place at most, and by less than 1e-37 near 0.
    unit, least = np.float32(2.0**-23), np.float32(1e-37)
    finite = (upper - upper) + (lower - lower) == 0
    boxes[row, axis] = low - abs(low) * unit - least if finite else np.float32(np.inf)
    boxes[row, 3 + axis] = high + abs(high) * unit + least if finite else np.float32(-np.inf)


@kernel
def write_keys(boxes, rows, center, cell, keys):
    """The key of each box's centre, its place on the curve; returns how many bits keys have. Lattice coordinates count from the least, so
    that they are few."""
    least_x = least_y = least_z = np.int64(2 * CURVE_CELLS)
    for s in range(len(rows)):
        row, packed = rows[s], np.int64(0)
        for k in range(3):
            place = (0.5 * boxes[row, k] + 0.5 * boxes[row, 3 + k] - center[k]) / cell
            if not place > -CURVE_CELLS:  # NaN, of an empty box, also
                place = -float(CURVE_CELLS)
            packed = (packed << 21) | np.int64(min(place, CURVE_CELLS - 1.0) + CURVE_CELLS)
        keys[s] = packed
        least_x, least_y = min(least_x, packed >> 42), min(least_y, (packed >> 21) & 0x1FFFFF)
        least_z = min(least_z, packed & 0x1FFFFF)
    least = (least_x << 42) | (least_y << 21) | least_z
    used = np.int64(0)
    for s in range(len(rows)):
        keys[s] -= least  # all three at once: none borrows from the next
        used |= (keys[s] >> 42) | (keys[s] >> 21) | keys[s]
    used &= 0x1FFFFF
    levels = 0
    while used >> levels:
        levels += 1
    for s in range(len(rows)):
        packed, place, state = keys[s], np.int64(0), np.int64(0)
        for level in range(levels - 1, -1, -1):
            cell_bits = packed >> level
            octant = (cell_bits >> 42 & 1) | (cell_bits >> 20 & 2) | (cell_bits << 2 & 4)
            entry = HILBERT[state, octant]
            place, state = (place << 3) | (entry & 7), entry >> 3
        keys[s] = place
    return 3 * levels


@kernel
def sort_by_digit(keys, values, shift, starts, sorted_keys, sorted_values):
    """Sort by the eight bits of the keys from ``shift`` on, keeping the order of equals."""
    starts[:] = 0
    for s in range(len(keys)):
        starts[(keys[s] >> shift) & 255] += 1
    total = 0
    for digit in range(256):
        here = starts[digit]
        starts[digit] = total
        total += here
    for s in range(len(keys)):
        key = keys[s]
        digit = (key >> shift) & 255
        place = starts[digit]
        starts[digit] = place + 1
        sorted_keys[place], sorted_values[place] = key, values[s]


@simd_kernel
def read_leaf(block, boxes, leaf_rows, nodes):
    """The boxes of a leaf block's eight rows."""
    columns = gather(boxes, load(leaf_rows, block))
    for k in range(6):
        store(nodes, block, k, columns[k])


@kernel
def refit(boxes, leaf_rows, first, nodes):
    """All boxes of the tree, from the leaves up."""
    for block in range(len(leaf_rows)):
        read_leaf(block, boxes, leaf_rows, nodes)
    for level in range(1, len(first) - 1):
        below, here = first[level - 1], first[level]
        children = here - below
        for child in range(LANES * (first[level + 1] - here)):
            block, lane = here + child // LANES, child % LANES
            for k in range(3):
                low, high = np.float32(np.inf), np.float32(-np.inf)
                if child < children:
                    for j in range(LANES):
                        low = min(low, nodes[below + child, k, j])
                        high = max(high, nodes[below + child, 3 + k, j])
                nodes[block, k, lane], nodes[block, 3 + k, lane] = low, high


@simd_kernel
def overlapping(block, nodes, x0, y0, z0, x1, y1, z1) -> int:
    """Which of a block's boxes overlap or touch a given one."""
    along_x = (load(nodes, block, 0) <= x1) & (load(nodes, block, 3) >= x0)
    along_y = (load(nodes, block, 1) <= y1) & (load(nodes, block, 4) >= y0)
    along_z = (load(nodes, block, 2) <= z1) & (load(nodes, block, 5) >= z0)
    return along_x & along_y & along_z


@kernel
def query(nodes, leaf_rows, other_nodes, other_rows, first, same, partial, changed, filters, stack, pairs):
    """Write the pairs of overlapping boxes of a tree and another (or, if ``same``, itself) into ``pairs`` as far as they fit, the lower
    row first, in no order; return how many there are.

    Eight boxes go down the other tree together, as the box around them, and part at its leaves. If ``partial``, only
    the pairs of boxes of the first tree are found whose rows are flagged in ``changed``.
    """
    found, levels = 0, len(first) - 1
    for leaf in range(len(leaf_rows)):
        active = 255
        if partial:
            active = 0
            for k in range(LANES):
                if changed[leaf_rows[leaf, k]]:
                    active |= 1 << k
            if active == 0:
                continue
        x0 = y0 = z0 = np.float32(np.inf)
        x1 = y1 = z1 = np.float32(-np.inf)
        for k in range(LANES):
            if active & (1 << k):
                x0, x1 = min(x0, nodes[leaf, 0, k]), max(x1, nodes[leaf, 3, k])
                y0, y1 = min(y0, nodes[leaf, 1, k]), max(y1, nodes[leaf, 4, k])
                z0, z1 = min(z0, nodes[leaf, 2, k]), max(z1, nodes[leaf, 5, k])
        level, block, waiting = levels - 1, 0, 0
        while True:
            hits = overlapping(first[level] + block, other_nodes, x0, y0, z0, x1, y1, z1)
            if TRACED:
                note("tree.visit", leaf=leaf, level=level, block=block, hits=hits)
            while hits:
                bit = hits & -hits
                hits ^= bit
                lane = LANE_OF_BIT[bit]
                child = LANES * block + lane
                if level > 0:
                    # Of all pairs of blocks of one tree, those are visited whose second block does not come first.
                    if not same or partial or (child + 1) << (3 * (level - 1)) > leaf:
                        stack[waiting] = (child << 8) | (level - 1)
                        waiting += 1
                    continue
                mates = active & overlapping(
                    leaf,
                    nodes,
                    other_nodes[block, 0, lane],
                    other_nodes[block, 1, lane],
                    other_nodes[block, 2, lane],
                    other_nodes[block, 3, lane],
                    other_nodes[block, 4, lane],
                    other_nodes[block, 5, lane],
                )
                if same and not partial and block == leaf:
                    mates &= bit - 1
                j = other_rows[block, lane]
                body, dynamic, group, mask = filters[j, 0], filters[j, 1], filters[j, 2], filters[j, 3]
                while mates:
                    bit = mates & -mates
                    mates ^= bit
                    i = leaf_rows[leaf, LANE_OF_BIT[bit]]
                    if same and partial and changed[j] and j <= i:
                        continue  # found from the other side
                    # Which may collide at all, as ``filters.may_collide`` says it.
                    admitted = filters[i, 3] & group != 0 and mask & filters[i, 2] != 0
                    if TRACED:
                        note("tree.pair", i=min(i, j), j=max(i, j), leaf=leaf, block=block)
                    if admitted and (filters[i, 1] | dynamic) != 0 and filters[i, 0] != body:
                        if found < len(pairs):
                            pairs[found, 0], pairs[found, 1] = min(i, j), max(i, j)
                        found += 1
            if waiting == 0:
                break
            waiting -= 1
            level, block = int(stack[waiting] & 255), int(stack[waiting] >> 8)
    return found


class Tree:
    """A tree over some rows of a table of boxes (n + 1, 8), whose last is empty."""

    def __init__(self) -> None:
        self.rows: npt.NDArray[np.int32] = np.empty(0, np.int32)
        self._stack = np.empty(STACK, np.int64)

    def build(self, boxes: npt.NDArray[np.float32], rows: npt.NDArray[np.int32]) -> None:
        """Make the tree anew, of the boxes of ``rows``."""
        n = len(rows)
        self.rows = rows
        if n == 0:
            return
        sizes = [-(-n // LANES)]
        while sizes[-1] > 1:
            sizes.append(-(-sizes[-1] // LANES))
        self.first = np.cumsum([0, *sizes])
        self.nodes = np.empty((self.first[-1], 6, LANES), np.float32)
        center, cell = _lattice(boxes[rows[:: n // 256 + 1]])
        keys, sorted_keys = np.empty((2, n), np.int64)
        order, sorted_order = np.array([rows, rows])
        starts = np.empty(256, np.int64)
        for shift in range(0, write_keys(boxes, rows, center, cell, keys), 8):
            sort_by_digit(keys, order, shift, starts, sorted_keys, sorted_order)
            keys, sorted_keys, order, sorted_order = sorted_keys, keys, sorted_order, order
        self.leaf_rows = np.full((sizes[0], LANES), len(boxes) - 1, np.int32)
        self.leaf_rows.reshape(-1)[:n] = order
        self.refit(boxes)

    def refit(self, boxes: npt.NDArray[np.float32]) -> None:
        """Take over changed boxes of the same rows; the order along the curve stays as it is."""
        if len(self.rows):
            refit(boxes, self.leaf_rows, self.first, self.nodes)

    def query(
        self,
        other: Tree,
        partial: bool,
        changed: npt.NDArray[np.uint8],
        filters: npt.NDArray[np.uint32],
        pairs: npt.NDArray[np.int32],
    ) -> int:
        """Pairs of a box of this tree and one of another or the same, as the kernel ``query`` says."""
        if not len(self.rows) or not len(other.rows):
            return 0
        return query(
            self.nodes,
            self.leaf_rows,
            other.nodes,
            other.leaf_rows,
            other.first,
            self is other,
            partial,
            changed,
            filters,
            self._stack,
            pairs,
        )


def _lattice(sample: npt.NDArray[np.float32]) -> tuple[npt.NDArray[np.float64], float]:
    """Centre and cell of the curve's lattice, from some of the boxes: amid them, and as wide as the smaller ones."""
    columns = sample[sample[:, 0] <= sample[:, 3], :6].T.astype(np.float64, order="C")  # NumPy is slow along short axes
    lower, upper = columns[:3], columns[3:6]
    count = lower.shape[1]
    if count == 0:
        return np.zeros(3), 1.0
    middle = np.sort(0.5 * (lower + upper), axis=1)[:, count // 2]
    size = np.sort((upper - lower).max(axis=0))[count // 10]
    return middle.copy(), max(float(size), 1e-30)
