"""How fast a simulation runs."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping

WINDOW = 0.5
"""Time over which the real-time factor is taken [s]."""

SMOOTHING = 0.1
"""Weight of the newest step in the average of the stages' times."""


class Meter:
    """Averages of the last steps."""

    def __init__(self) -> None:
        self.stages: dict[str, float] = {}
        """Seconds per step and stage."""
        self._marks: deque[tuple[float, float]] = deque()

    def restart(self) -> None:
        """Forget how fast it was: the simulation was stopped or started."""
        self._marks.clear()

    def note_step(self, profile: Mapping[str, float]) -> None:
        """Take a step's profile into the average."""
        for name, seconds in profile.items():
            last = self.stages.get(name, seconds)
            self.stages[name] = last + SMOOTHING * (seconds - last)

    def note_time(self, now: float, simulated: float) -> None:
        """Note how much had been simulated by now, both in seconds."""
        if self._marks and simulated < self._marks[-1][1]:
            self._marks.clear()
        self._marks.append((now, simulated))
        while len(self._marks) > 2 and now - self._marks[0][0] > WINDOW:
            self._marks.popleft()

    @property
    def real_time_factor(self) -> float:
        """Simulated seconds per second; 0 if unknown."""
        if len(self._marks) < 2:
            return 0.0
        (first, begin), (last, end) = self._marks[0], self._marks[-1]
        return (end - begin) / (last - first) if last > first else 0.0


class Beat:
    """A clock that ticks at multiples of a period since it began, however long what is done at a tick takes; ticks that are missed by a whole period
    are left out.

    Args:
        period: time between two ticks [s].
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self._due = 0.0

    def wait(self, now: float) -> float:
        """Time until the next tick is due [s]; 0 if it is."""
        return max(0.0, self._due - now)

    def tick(self, now: float) -> None:
        """Count a tick that was due."""
        self._due = self._due + self._period if now - self._due < self._period else now + self._period
