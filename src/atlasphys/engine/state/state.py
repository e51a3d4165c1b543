"""Everything a world's engine remembers from step to step, and the buffers it works in.

``remember`` marks a state that is whole; ``roll_back`` returns to it. So a step that fails leaves no trace, and writes by the
user into live views are noticed: they are what differs from the remembered state.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from atlasphys.engine.constants import Tolerances, tolerances
from atlasphys.engine.jit import call, kernel
from atlasphys.engine.shapes.table import ShapeTable
from atlasphys.engine.simd.by_address import by_address
from atlasphys.engine.state.arrays import copy_rows, room_for, with_capacity
from atlasphys.engine.state.bodies import AWAKE, CHANGED, DYNAMIC, Bodies, empty_bodies
from atlasphys.engine.state.colliders import Colliders, empty_colliders
from atlasphys.engine.state.contacts import Contacts, empty_contacts
from atlasphys.engine.state.joints import WORLD, JointTable
from atlasphys.engine.state.manifolds import (
    IS_RECYCLABLE,
    PATCH_FRICTION,
    PENALTY,
    POINT_COLUMNS,
    Manifolds,
    arranged,
    empty_manifolds,
    live_rows,
)
from atlasphys.engine.state.pose import refresh


@dataclass(frozen=True, slots=True)
class Environment:
    """What acts on all bodies alike."""

    gravity: tuple[float, float, float]
    """[m/s²]"""
    length_unit: float
    """Typical size of a body [m], which scales every tolerance that is a length."""
    restitution_threshold: float
    """Approach speed below which contacts do not bounce [m/s]."""
    friction_rule: int
    """Entry of ``COMBINE_RULES`` for friction."""
    restitution_rule: int
    """Entry of ``COMBINE_RULES`` for restitution."""


@by_address
class Remembered(NamedTuple):
    """The columns that a step or a user may change, as they were."""

    position: npt.NDArray[np.float64]
    orientation: npt.NDArray[np.floating]
    motion: npt.NDArray[np.floating]


@kernel
def differing_rows(bodies, remembered, count, rows):
    """Write the rows whose state differs from the remembered one into ``rows`` and return their number. NaN differs from itself."""
    found = 0
    for i in range(count):
        same = True
        for k in range(3):
            same = same and bodies.position[i, k] == remembered.position[i, k]
        for k in range(4):
            same = same and bodies.orientation[i, k] == remembered.orientation[i, k]
        for k in range(6):
            same = same and bodies.motion[i, k] == remembered.motion[i, k]
        if not same:
            rows[found] = i
            found += 1
    return found


@kernel
def non_finite_rows(bodies, count, rows):
    """Write the rows whose state is not finite into ``rows`` and return their number."""
    found = 0
    for i in range(count):
        total = 0.0  # 0 · x is 0 for finite x and NaN for the rest
        for k in range(3):
            total += 0.0 * bodies.position[i, k]
        for k in range(4):
            total += 0.0 * bodies.orientation[i, k]
        for k in range(6):
            total += 0.0 * bodies.motion[i, k]
        if total != 0.0:
            rows[found] = i
            found += 1
    return found


@lru_cache(maxsize=64)
def tolerances_of(environment: Environment, precision: str) -> Tolerances:
    """Tolerances in a precision, given as NumPy's character for it."""
    real = np.dtype(precision).type
    return Tolerances(*(real(value) for value in tolerances(environment.length_unit)))


NO_ROWS: npt.NDArray[np.int32] = np.empty(0, np.int32)
NO_PAIRS: npt.NDArray[np.int32] = np.empty((0, 2), np.int32)


class State:
    """Tables of bodies, colliders, shapes and manifolds, and the clock.

    Bodies and colliders keep the order in which they were added; a removal closes the gap. Each body has one collider, in the row of the same number.
    """

    def __init__(self, real: npt.DTypeLike, environment: Environment) -> None:
        self.real: np.dtype[Any] = np.dtype(real)
        self.environment = environment
        self.bodies: Bodies = empty_bodies(16, real)
        self.colliders: Colliders = empty_colliders(16, real)
        self.count = 0
        self.table = ShapeTable(self.real)
        self.joints = JointTable(self.real)
        self.manifolds: Manifolds = empty_manifolds(64, real)
        self.manifold_count = 0
        self.began: npt.NDArray[np.int32] = NO_PAIRS
        self.ended: npt.NDArray[np.int32] = NO_PAIRS
        self.time = 0.0
        self.steps = 0
        self.last_h = 0.0
        self.stale = False
        """Whether columns of the bodies that follow from others are out of date."""
        self.forced = False
        """Whether forces or torques may act in the next step."""
        self.changed = False
        """Whether there may be rows with CHANGED in the column ``rest``."""
        self.slept: npt.NDArray[np.int32] = NO_ROWS
        """Rows of the bodies that fell asleep in the last step."""
        self.woke: npt.NDArray[np.int32] = NO_ROWS
        """Rows of the bodies that woke in it."""
        self._make_buffers()

    def _make_buffers(self) -> None:
        """Buffers whose content does not outlive a step."""
        self.trace: list[Any] | None = None
        """Where a solver appends what it notes of its sweeps (``solvers/residuals.py``: Sweep); None: it takes no notes."""
        capacity = len(self.bodies.kind)
        self.remembered = copy_rows(self._to_remember())
        self.workspace: Any = None
        self.row_buffer: npt.NDArray[np.int32] = np.zeros(capacity, np.int32)
        self.displacement: npt.NDArray[Any] = np.zeros((capacity, 6), self.real)
        self.spin_change: npt.NDArray[Any] = np.zeros((capacity, 3), self.real)
        self.pairs: npt.NDArray[np.int32] = np.zeros((64, 2), np.int32)
        self.contacts: Contacts = empty_contacts(64, 512, self.real)
        self.next_manifolds: Manifolds = empty_manifolds(len(self.manifolds.a), self.real)
        self.next_count = 0
        self.touched_before: npt.NDArray[np.bool_] = np.zeros(0, np.bool_)
        self.manifold_ended: npt.NDArray[np.bool_] = np.zeros(len(self.manifolds.a), np.bool_)

    @property
    def tolerances(self) -> Tolerances:
        """Tolerances in this state's precision."""
        return tolerances_of(self.environment, self.real.char)

    # Rows ------------------------------------------------------------------------------------------------------------

    def append(self) -> int:
        """Room for one more body and its collider; all zero. The caller fills the row, then calls ``refreshed``."""
        row = self.count
        self.workspace = None
        if row == len(self.bodies.kind):
            self.bodies, self.colliders = with_capacity(self.bodies, 2 * row), with_capacity(self.colliders, 2 * row)
            self.remembered = with_capacity(self.remembered, 2 * row)
            self.row_buffer = np.zeros(2 * row, np.int32)
            self.displacement = np.zeros((2 * row, 6), self.real)
            self.spin_change = np.zeros((2 * row, 3), self.real)
        for array in (*self.bodies, *self.colliders):
            array[row] = 0
        self.bodies.island[row] = AWAKE
        self.count += 1
        return row

    def refreshed(self, row: int) -> None:
        """Derive what follows from a new row's state and properties, and remember its state."""
        refresh(self.bodies, row, row + 1)
        self._remember(slice(row, row + 1))
        if self.bodies.kind[row] != DYNAMIC:
            self.bodies.rest[row], self.changed = CHANGED, True

    def take_over(self, column: str, row: int, part: slice) -> None:
        """Remember a checked change of one column, and wake the body. What else was written into the row stays noticeable."""
        self.stale = True
        self.wake(row)
        getattr(self.remembered, column)[row, part] = getattr(self.bodies, column)[row, part]

    def changes_noticed(self) -> None:
        """A step has been made since bodies were changed by hand."""
        rest = self.bodies.rest[: self.count]
        rest[rest == CHANGED] = 0
        self.changed = False

    def solver_changed(self) -> None:
        """Another solver goes on from here: friction counts for each pair as a whole, which all solvers read; penalties are forgotten."""
        table = self.manifolds = arranged(self.manifolds, live_rows(self.manifolds, self.manifold_count))
        self.manifold_count = len(table.a)
        self.next_manifolds = empty_manifolds(self.manifold_count, self.real)
        together = table.contact[:, PATCH_FRICTION : PATCH_FRICTION + 3]
        together += table.friction_impulse.reshape(-1, 4, 3).sum(axis=1)
        table.friction_impulse[:] = 0
        table.local[:, PENALTY::POINT_COLUMNS] = 0
        self.joints.forget()
        self.properties_changed()

    def wake(self, row: int | None = None) -> None:
        """Wake the island of a body, or all bodies."""
        island = self.bodies.island[: self.count]
        if row is None:
            woken = island != AWAKE
        elif self.bodies.kind[row] == DYNAMIC:
            self.bodies.rest[row] = 0
            if island[row] == AWAKE:
                return
            woken = island == island[row]
        else:  # whatever touches it, or will in the next step
            self.bodies.rest[row], self.changed = CHANGED, True
            m = self.manifolds
            live = m.count[: self.manifold_count] > 0
            a, b = m.a[: self.manifold_count][live], m.b[: self.manifold_count][live]
            joined = self.joints.linked
            a, b = np.concatenate([a, joined[:, 0]]), np.concatenate([b, joined[:, 1]])
            beside = np.concatenate([b[a == row], a[b == row]])
            woken = np.isin(island, np.setdiff1d(island[beside], [AWAKE]))
        if woken.any():
            island[woken] = AWAKE
            self.bodies.rest[: self.count][woken] = 0

    def properties_changed(self, row: int | None = None) -> None:
        """Forget what was derived from the properties of a body, or of all bodies: they have been changed."""
        self.workspace, self.stale = None, True
        self.wake(row)
        m, count = self.manifolds, self.manifold_count
        touched = slice(None) if row is None else (m.a[:count] == row) | (m.b[:count] == row)
        m.reference[:count][touched, IS_RECYCLABLE] = 0

    def remove(self, row: int) -> npt.NDArray[np.bool_]:
        """Remove a body, its collider, its manifolds and its joints, and close the gap. Returns which joints are kept, (joints before,)."""
        self.workspace = None
        self.wake(row)
        joints_kept = self.joints.remove_body(row)
        self.bodies.island[: self.count] -= self.bodies.island[: self.count] > row
        for array in (*self.bodies, *self.colliders, *self.remembered):
            array[row : self.count - 1] = array[row + 1 : self.count]
        self.count -= 1
        self.colliders.body[row : self.count] -= 1
        old, m = self.manifolds, self.manifold_count
        kept = np.flatnonzero((old.a[:m] != row) & (old.b[:m] != row))
        for column in old:
            column[: len(kept)] = column[kept]
        self.manifold_count = len(kept)
        for side in (old.a, old.b):
            side[: len(kept)] -= side[: len(kept)] > row
        self.began, self.ended = (_without(row, pairs) for pairs in (self.began, self.ended))
        self.slept, self.woke = (_without(row, rows[:, None])[:, 0] for rows in (self.slept, self.woke))
        self._drop_unused_shapes()
        return joints_kept

    def joints_changed(self, row: int) -> None:
        """A joint was made, or changed so that it acts on other bodies or in another way, or is about to be removed: its bodies wake."""
        self.workspace, self.joints.layout = None, None
        for body in self.joints.rows.body[row].tolist():
            if body != WORLD and self.bodies.kind[body] == DYNAMIC:
                self.wake(body)

    def _drop_unused_shapes(self) -> None:
        """Start the table of shapes anew once most of it is unused."""
        used = np.unique(self.colliders.shape[: self.count])
        if len(self.table) > 2 * len(used) + 64:
            shapes, fresh = self.table.shapes, ShapeTable(self.real)
            rows = np.zeros(len(shapes), np.int32)
            for row in used:
                rows[row] = fresh.row_of(shapes[row])
            self.colliders.shape[: self.count] = rows[self.colliders.shape[: self.count]]
            self.table = fresh

    # Whole or not at all ---------------------------------------------------------------------------------------------

    def written_rows(self) -> npt.NDArray[np.int32]:
        """Rows into which the user has written since the state was last remembered."""
        found = call(differing_rows, self.real.char, self.bodies, self.remembered, self.count, self.row_buffer)
        return self.row_buffer[:found].copy() if found else NO_ROWS

    def diverged_rows(self) -> npt.NDArray[np.int32]:
        """Rows whose state is no longer finite."""
        found = non_finite_rows(self.bodies, self.count, self.row_buffer)
        return self.row_buffer[:found].copy()

    def remember(self) -> None:
        """Take the present state for whole."""
        self._remember(slice(0, self.count))

    def _remember(self, rows: slice) -> None:
        for then, now in zip(self.remembered, self._to_remember(), strict=True):
            then[rows] = now[rows]

    def _to_remember(self) -> Remembered:
        return Remembered(self.bodies.position, self.bodies.orientation, self.bodies.motion)

    def roll_back(self) -> None:
        """Return to the remembered state. Manifolds need no copy: a step builds the next ones beside them."""
        for then, now in zip(self.remembered, self._to_remember(), strict=True):
            now[: self.count] = then[: self.count]
        refresh(self.bodies, 0, self.count)

    def reserve_manifolds(self, count: int) -> None:
        """Room for ``count`` manifolds in the next step's table."""
        if len(self.next_manifolds.a) < count:
            self.next_manifolds = empty_manifolds(room_for(count), self.real)
        if len(self.manifold_ended) < self.manifold_count:
            self.manifold_ended = np.zeros(len(self.manifolds.a), np.bool_)

    def complete_step(self, h: float) -> None:
        """Make the next manifolds the present ones, note which contacts began and ended, and advance the clock."""
        old, m, new, n = self.manifolds, self.manifold_count, self.next_manifolds, self.next_count
        lost = np.flatnonzero(self.manifold_ended[:m] & old.touching[:m])
        fresh = np.flatnonzero(new.touching[:n] & ~self.touched_before)
        self.ended = np.stack([old.a[lost], old.b[lost]], axis=1)
        self.began = np.stack([new.a[fresh], new.b[fresh]], axis=1)
        self.manifolds, self.manifold_count, self.next_manifolds, self.next_count = new, n, old, 0
        self.bodies.force[: self.count] = 0
        self.forced, self.joints.elapsed = False, h
        self.changes_noticed()
        self.time, self.steps, self.last_h = self.time + h, self.steps + 1, h
        self.remember()

    # Copies ----------------------------------------------------------------------------------------------------------

    def copy(self) -> State:
        """An independent copy, exact to the bit."""
        other = object.__new__(State)
        other.__dict__.update(self.__dict__)
        other.environment = replace(self.environment)
        other.bodies, other.colliders = copy_rows(self.bodies), copy_rows(self.colliders)
        other.table = self.table.copy()
        other.manifolds = arranged(self.manifolds, live_rows(self.manifolds, self.manifold_count))
        other.manifold_count = len(other.manifolds.a)
        other.joints = self.joints.copy()
        other.began, other.ended = self.began.copy(), self.ended.copy()
        other._make_buffers()
        # Writes not yet taken over stay noticeable in the copy.
        other.remembered = copy_rows(self.remembered)
        return other

    def __getstate__(self) -> dict[str, Any]:
        buffers = (
            "trace",
            "row_buffer",
            "displacement",
            "spin_change",
            "pairs",
            "contacts",
            "next_manifolds",
            "touched_before",
            "manifold_ended",
            "workspace",
        )
        kept = {name: value for name, value in self.__dict__.items() if name not in buffers}
        table = kept["manifolds"] = arranged(self.manifolds, live_rows(self.manifolds, self.manifold_count))
        return kept | {"manifold_count": len(table.a)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        for name in ("bodies", "colliders", "manifolds"):
            setattr(self, name, copy_rows(getattr(self, name)))  # unpickled arrays are not aligned
        remembered = copy_rows(self.remembered)
        self._make_buffers()
        self.remembered = remembered

    def hash(self) -> str:
        """A digest of all that decides how the world goes on, except its settings."""
        digest = hashlib.blake2b(digest_size=16)
        live = live_rows(self.manifolds, self.manifold_count)
        digest.update(np.array([self.count, len(live), self.steps], np.int64).tobytes())
        digest.update(np.array([self.time, self.last_h], np.float64).tobytes())
        n = self.count
        b, c = self.bodies, self.colliders
        # Shapes by what they are and where they are first used: their rows in the table depend on what was removed.
        shapes, used = self.table.shapes, c.shape[:n].tolist()
        order = {row: place for place, row in enumerate(dict.fromkeys(used))}
        digest.update(np.array([order[row] for row in used], np.int32).tobytes())
        for row in order:
            shape = shapes[row]
            digest.update(np.array([shape.kind, *shape.sizes]).tobytes())
            for array in shape.polyhedron or ():
                digest.update(array.tobytes())
        for array in (
            b.position,
            b.orientation,
            b.motion[:, :6],
            b.force,
            b.kind,
            b.mass,
            b.local_center,
            b.principal,
            b.response,
            b.locks,
            b.rest,
            b.island,
        ):
            digest.update(np.ascontiguousarray(array[:n]).tobytes())
        for array in (c.body, c.material, c.group, c.mask):
            digest.update(array[:n].tobytes())
        for array in self.manifolds:
            digest.update(array[live].tobytes())
        if self.joints.count:
            digest.update(self.joints.bytes())
        return digest.hexdigest()


def _without(row: int, pairs: npt.NDArray[np.int32]) -> npt.NDArray[np.int32]:
    """The pairs (or lists of any length) that do not involve a removed row, renumbered."""
    kept = pairs[(pairs != row).all(axis=1)]
    return kept - (kept > row)
