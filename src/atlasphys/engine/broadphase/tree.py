"""Tree broad phase: pairs of bodies from bounding volume hierarchies (``bvh.py``), one of the bodies that move and one of the static ones.

``find_pairs`` builds the trees from the tight bounds, finds the pairs and forgets all. ``FatTree`` builds them from fat boxes
(``fat_boxes.py``) and keeps them, and the pairs, until a body leaves its box. Planes have no bounds: each is tested against every
moving body.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from atlasphys.engine.broadphase.bvh import Tree, store_interval
from atlasphys.engine.broadphase.fat_boxes import FatBoxes, empty_fat_boxes, fatten, flag_leavers, shape_bounds
from atlasphys.engine.broadphase.filters import bounds_overlap, is_plane, reaches_plane
from atlasphys.engine.broadphase.flight import keep_meeting, longest_flight
from atlasphys.engine.broadphase.pair_list import merge_pairs, sort_pairs
from atlasphys.engine.jit import kernel
from atlasphys.engine.shapes.table import KIND, PLANE, Shapes
from atlasphys.engine.simd import LANES
from atlasphys.engine.simd.by_address import by_address
from atlasphys.engine.state.bodies import DYNAMIC, STATIC, Bodies
from atlasphys.engine.state.colliders import Colliders

REFIT_SHARE = 0.25
"""If more than this part of the moving bodies get new boxes, the tree is built anew and all pairs are found again."""

Pairs = npt.NDArray[np.int32]


@by_address
class Roles(NamedTuple):
    """What the rows of a world's colliders are to the broad phase."""

    moving: npt.NDArray[np.int32]
    """Rows of bounded colliders whose bodies may move."""
    fixed: npt.NDArray[np.int32]
    """Rows of bounded colliders of static bodies."""
    planes: npt.NDArray[np.int32]
    """Rows of planes."""
    filters: npt.NDArray[np.uint32]
    """(n, 4) body, whether it is dynamic, group, mask."""


def roles(bodies: Bodies, colliders: Colliders, shapes: Shapes, count: int) -> Roles:
    """Sort the colliders by what they are."""
    moving, fixed, planes = rows = np.empty((3, count), np.int32)
    filters = np.empty((count, 4), np.uint32)
    moves, stay, flat = sort_rows(bodies.kind, colliders, shapes.layout, rows, filters)
    return Roles(moving[:moves], fixed[:stay], planes[:flat], filters)


@kernel
def sort_rows(kind, colliders, layout, rows, filters):
    """Write the rows of moving and of fixed bounded colliders and of planes, and all filters; return how many there are of each."""
    moves = stay = flat = 0
    for i in range(len(filters)):
        body = colliders.body[i]
        filters[i, 0], filters[i, 1] = body, kind[body] == DYNAMIC
        filters[i, 2], filters[i, 3] = colliders.group[i], colliders.mask[i]
        if layout[colliders.shape[i], KIND] == PLANE:
            rows[2, flat] = i
            flat += 1
        elif kind[body] == STATIC:
            rows[1, stay] = i
            stay += 1
        else:
            rows[0, moves] = i
            moves += 1
    return moves, stay, flat


def surfaces(
    bodies: Bodies, colliders: Colliders, shapes: Shapes, planes: npt.NDArray[np.int32]
) -> npt.NDArray[np.float64]:
    """(planes, 7): the normal in world axes, a point from which the offset counts, and the offset. As ``reaches_plane`` computes them."""
    size, body = shapes.size[colliders.shape[planes]], colliders.body[planes]
    m = bodies.geometry[body]
    surface = np.empty((len(planes), 7))
    for k in range(3):
        surface[:, k] = m[:, 3 * k] * size[:, 0] + m[:, 3 * k + 1] * size[:, 1] + m[:, 3 * k + 2] * size[:, 2]
    surface[:, 3:6], surface[:, 6] = bodies.position[body], size[:, 3]
    return surface


@kernel
def pairs_with_planes(boxes, rows, partial, changed, planes, surface, filters, found, pairs):
    """Append the pairs of a plane and a box that reaches below its surface to the ``found`` ones; return how many there are then."""
    for s in range(len(rows)):
        i = rows[s]
        if (partial and not changed[i]) or not boxes[i, 0] <= boxes[i, 3]:
            continue
        for p in range(len(planes)):
            plane, height = planes[p], 0.0
            for k in range(3):
                n = surface[p, k]
                corner = boxes[i, k] if n > 0 else boxes[i, 3 + k]
                height += n * (corner - surface[p, 3 + k]) if n != 0 else 0.0
            admitted = (filters[i, 3] & filters[plane, 2]) != 0 and (filters[plane, 3] & filters[i, 2]) != 0
            if height <= surface[p, 6] and admitted and filters[i, 1] != 0:
                if found < len(pairs):
                    pairs[found, 0], pairs[found, 1] = min(i, plane), max(i, plane)
                found += 1
    return found


class PairFinder:
    """The trees of moving and of fixed boxes, and the buffers that finding pairs needs."""

    def __init__(self) -> None:
        self.moving, self.fixed = Tree(), Tree()
        self._found: Pairs = np.empty((64, 2), np.int32)

    def reserve(self, count: int) -> None:
        """Room for the pairs that so many bodies may be expected to have; more is made as needed."""
        if len(self._found) < 16 * count:
            self._found = np.empty((16 * count, 2), np.int32)

    def sorted_pairs(
        self,
        boxes: npt.NDArray[np.float32],
        parts: Roles,
        surface: npt.NDArray[np.float64],
        partial: bool,
        changed: npt.NDArray[np.uint8],
        buffer: Pairs,
        fat: FatBoxes | None = None,
    ) -> tuple[Pairs, int]:
        """The pairs that overlap and may collide, in order; if ``partial``, those with a moving box that is flagged in ``changed``:
        the buffer, enlarged if it is too small, and their number. If the boxes are what ``fat`` ones sweep, only pairs of those that may meet."""
        while True:
            pairs = self._found
            total = self.moving.query(self.moving, partial, changed, parts.filters, pairs)
            total += self.moving.query(self.fixed, partial, changed, parts.filters, pairs[total:])
            total = pairs_with_planes(
                boxes, parts.moving, partial, changed, parts.planes, surface, parts.filters, total, pairs
            )
            if total <= len(pairs):
                break
            self._found = np.empty((total + total // 4, 2), np.int32)
        if fat is not None:
            total = keep_meeting(pairs[:total], fat)
        if len(buffer) < total:
            buffer = np.empty((len(self._found), 2), np.int32)
        places = np.empty((2, len(parts.filters)), np.int64)
        sort_pairs(pairs[:total], places[0], places[1], np.empty(total, np.int32), buffer)
        return buffer, total


@kernel
def tight_boxes(lower, upper, count, boxes):
    """The bounds as boxes of the tree."""
    for i in range(count):
        for k in range(3):
            store_interval(boxes, i, k, lower[i, k], upper[i, k])


@kernel
def keep_exact(bodies, colliders, shapes, pairs):
    """Move those pairs whose bounds overlap in double precision to the front; return how many there are."""
    found = 0
    for p in range(len(pairs)):
        i, j = pairs[p, 0], pairs[p, 1]
        if is_plane(colliders, shapes, i):
            near = reaches_plane(bodies, colliders, shapes, i, j)
        elif is_plane(colliders, shapes, j):
            near = reaches_plane(bodies, colliders, shapes, j, i)
        else:
            near = bounds_overlap(colliders, i, j)
        if near:
            pairs[found, 0], pairs[found, 1] = i, j
            found += 1
    return found


def find_pairs(bodies: Bodies, colliders: Colliders, shapes: Shapes, count: int, pairs: Pairs) -> tuple[Pairs, int]:
    """All pairs that may touch, ordered by (lower row, higher row): a buffer, enlarged if ``pairs`` is too small, and the number in it."""
    parts, finder = roles(bodies, colliders, shapes, count), PairFinder()
    finder.reserve(count)
    boxes = np.empty((count + 1, 8), np.float32)
    tight_boxes(colliders.lower, colliders.upper, count, boxes)
    boxes[count, :3], boxes[count, 3:] = np.inf, -np.inf
    finder.moving.build(boxes, parts.moving)
    finder.fixed.build(boxes, parts.fixed)
    surface = surfaces(bodies, colliders, shapes, parts.planes)
    pairs, found = finder.sorted_pairs(boxes, parts, surface, False, np.empty(0, np.uint8), pairs)
    return pairs, keep_exact(bodies, colliders, shapes, pairs[:found])


class FatTree:
    """The persistent broad phase: candidate pairs that hold until a body leaves its fat box.

    Derived state: which pairs touch does not depend on it, only which are looked at.

    Args:
        real: the world's precision, float32 or float64.
        fattening: room that a fat box leaves all round its body [m]; more than 0.

    Attributes:
        pairs: (p, 2) int32, the candidate pairs, lower row first, in order; a view, good until the next update. Every pair of bodies whose
            bounds overlap is among them, as long as no body has left its fat box.
        rows: (blocks, 8) int32, the rows of the moving bodies, eight a block, filled up with the last; for ``has_left``.
        fat: the boxes; for ``has_left``.
    """

    def __init__(self, real: npt.DTypeLike, fattening: float) -> None:
        self._real = np.dtype(real)
        self._fattening = float(fattening)
        self._finder = PairFinder()
        self._front: Pairs = np.empty((64, 2), np.int32)
        self._back: Pairs = np.empty((64, 2), np.int32)
        self._fresh: Pairs = np.empty((64, 2), np.int32)
        self._changed: npt.NDArray[np.uint8] = np.zeros(1, np.uint8)
        self._surface: npt.NDArray[np.float64] = np.empty((0, 7))
        self._refitted = self._in_flight = 0
        self.invalidate()

    def invalidate(self) -> None:
        """Forget all: bodies were added or removed, or a kind, shape, mask or group was changed."""
        self._count = -1
        self.pairs: Pairs = np.empty((0, 2), np.int32)
        self.rows: npt.NDArray[np.int32] = np.empty((0, LANES), np.int32)
        self.fat: FatBoxes = empty_fat_boxes(0, self._real)

    def update(
        self,
        bodies: Bodies,
        colliders: Colliders,
        shapes: Shapes,
        count: int,
        h: float,
        margin: float,
        flying: npt.NDArray[np.uint8],
        gravity: tuple[float, float, float],
    ) -> bool:
        """Give new fat boxes to bodies that have left theirs, static ones too, and find the pairs that come and go with that.

        Args:
            bodies: the table of bodies, whose ``center`` and ``geometry`` are up to date.
            colliders: the table of colliders.
            shapes: the table of shapes.
            count: number of bodies and colliders.
            h: time step [s], for the room that fat boxes have for motion.
            margin: what is added to the bounds all round [m].
            flying: (count,) 1 for bodies that are expected to go on as they move, or fall, else 0.
            gravity: the acceleration with which they fall [m/s²].

        Returns:
            Whether the list of pairs may have changed.
        """
        started = count != self._count
        if started:
            self._start(bodies, colliders, shapes, count)
        moving, fixed = self.parts.moving, self.parts.fixed
        h, margin, near = float(h), float(margin), 0.5 * self._fattening
        number = max(len(moving), 1)
        longest = longest_flight(int(flying[moving].sum()) / number, len(self.pairs) / number, h)

        def flag(rows: npt.NDArray[np.int32], count: int) -> tuple[int, int]:
            """How many of the bodies left their boxes, and how many are flagged for new ones."""
            return flag_leavers(
                rows, count, bodies.center, bodies.geometry, bodies.motion, self.fat, near, 0.5 * longest, margin,
                self._offset, self._room, self._changed,
            )  # fmt: skip

        def renew_boxes(rows: npt.NDArray[np.int32]) -> int:
            """Give new boxes to those that are flagged. Returns how many boxes move."""
            return fatten(rows, self._changed, flying, longest, bodies, gravity, h, margin, self._fattening, self.fat)

        if started:
            self._changed[:] = 1
            self._in_flight = renew_boxes(moving)
            renew_boxes(fixed)
            self._find_all(static=True)
            return True
        surface = surfaces(bodies, colliders, shapes, self.parts.planes)
        static = not np.array_equal(surface, self._surface, equal_nan=True)
        self._surface = surface
        if flag(self._fixed_rows, len(fixed))[0]:
            static = True
            renew_boxes(fixed)
        left, flagged = flag(self.rows, len(moving))
        if not left and not static:
            return False
        self._in_flight = renew_boxes(moving)
        self.fat.clock[0] = 0
        self._refitted += flagged
        if static or flagged > REFIT_SHARE * len(moving):
            self._find_all(static)
        else:
            self._find_changed()
        return True

    def _start(self, bodies: Bodies, colliders: Colliders, shapes: Shapes, count: int) -> None:
        """Take up the bodies anew."""
        self._count = count
        self.parts = roles(bodies, colliders, shapes, count)
        self.rows, self._fixed_rows = in_blocks(self.parts.moving), in_blocks(self.parts.fixed)
        self.fat = empty_fat_boxes(count, self._real)
        self.fat.bound[:] = shape_bounds(shapes, colliders.shape[:count], bodies.local_center[:count])
        self._surface = surfaces(bodies, colliders, shapes, self.parts.planes)
        self._finder.reserve(count)
        self._changed = np.zeros(count + 1, np.uint8)
        self._offset = np.zeros((6, LANES), self._real)
        self._room = np.zeros((max(len(self.rows), len(self._fixed_rows)), LANES), self._real)
        self._refitted = 0

    def _flights(self) -> FatBoxes | None:
        """The boxes, if some of them move."""
        return self.fat if self._in_flight else None

    def _find_all(self, static: bool) -> None:
        """Build the trees anew, that of static bodies only if asked to, and find all pairs."""
        self._finder.moving.build(self.fat.boxes, self.parts.moving)
        if static:
            self._finder.fixed.build(self.fat.boxes, self.parts.fixed)
        self._refitted = 0
        self._front, found = self._finder.sorted_pairs(
            self.fat.boxes, self.parts, self._surface, False, self._changed, self._front, self._flights()
        )
        self.pairs = self._front[:found]
        self._changed[:] = 0

    def _find_changed(self) -> None:
        """Find the pairs of flagged bodies anew and keep those of the others."""
        boxes, parts, finder, old = self.fat.boxes, self.parts, self._finder, self.pairs
        if self._refitted > len(parts.moving):  # the order along the curve is out of date
            finder.moving.build(boxes, parts.moving)
            self._refitted = 0
        else:
            finder.moving.refit(boxes)
        self._fresh, fresh = finder.sorted_pairs(
            boxes, parts, self._surface, True, self._changed, self._fresh, self._flights()
        )
        needed = len(old) + fresh
        if len(self._back) < needed:
            self._back = np.empty((needed + needed // 4, 2), np.int32)
        found = merge_pairs(old, self._fresh[:fresh], self._changed, self._back)
        self._front, self._back = self._back, self._front
        self.pairs = self._front[:found]
        self._changed[:] = 0


def in_blocks(rows: npt.NDArray[np.int32]) -> npt.NDArray[np.int32]:
    """Rows in blocks of eight, filled up with the last."""
    padding = -len(rows) % LANES
    return np.concatenate([rows, np.repeat(rows[-1:], padding)]).reshape(-1, LANES)
