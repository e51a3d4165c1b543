"""Going back in time: whole states of the last seconds, and exact repetition of the steps since."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from atlasphys.world.snapshot import Snapshot
from atlasphys.world.world import World

INTERVAL = 10
"""Steps between two snapshots. Fewer: faster steps back and more memory."""

MOST_SNAPSHOTS = 200
MOST_BYTES = 400e6
"""Bounds of what is kept. The oldest go first."""

BYTES_A_BODY, BYTES_A_CONTACT = 900, 700
"""Size of a snapshot, about."""


class _Entry(NamedTuple):
    steps: int
    dt: float
    snapshot: Snapshot
    size: float


class History:
    """Snapshots of a world, every tenth step and wherever it was changed by hand between steps.

    A step back restores the nearest snapshot before and repeats the steps since, which gives the same bits.
    """

    def __init__(self) -> None:
        self._entries: deque[_Entry] = deque()
        self._size = 0.0

    def __len__(self) -> int:
        return len(self._entries)

    def clear(self) -> None:
        """Forget everything: another world goes on from here."""
        self._entries.clear()
        self._size = 0.0

    def before_step(self, world: World, dt: float, changed: bool) -> None:
        """Keep the state if it is time to, or if it cannot be had by repeating steps because it was ``changed`` by hand."""
        last = self._entries[-1] if self._entries else None
        if last and not changed and last.dt == dt and world.steps - last.steps < INTERVAL:
            return
        size = 1e4 + BYTES_A_BODY * len(world.bodies) + BYTES_A_CONTACT * world.contact_count
        if last and last.steps == world.steps:
            self._size -= self._entries.pop().size
        self._entries.append(_Entry(world.steps, dt, world.snapshot(), size))
        self._size += size
        while len(self._entries) > 1 and (len(self._entries) > MOST_SNAPSHOTS or self._size > MOST_BYTES):
            self._size -= self._entries.popleft().size

    def step_back(self, world: World) -> float | None:
        """Bring the world to the state before its last step. Returns that step's length [s], or None if that is too long ago."""
        while self._entries and self._entries[-1].steps >= world.steps:
            self._size -= self._entries.pop().size
        if not self._entries:
            return None
        entry, target = self._entries[-1], world.steps - 1
        world.restore(entry.snapshot)
        for _ in range(target - entry.steps):
            world.step(entry.dt)
        return entry.dt
