"""The progress of a run on standard error: a line that is drawn anew on a terminal, a few plain lines elsewhere."""

from __future__ import annotations

import time
from types import TracebackType
from typing import TYPE_CHECKING, Self

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn

if TYPE_CHECKING:
    from atlasphys.cli.simulation import Simulation

LONG = 0.5
"""A wait of this length deserves an explanation [s]."""


class Display:
    """Shows how far a simulation is. :meth:`refresh` is called several times a second."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._start = time.monotonic()
        self._console = Console(stderr=True)
        self._said_waiting = False
        self._progress = Progress(
            TextColumn("{task.description}"),
            BarColumn(bar_width=20),
            TextColumn("{task.fields[detail]}"),
            console=self._console,
            auto_refresh=False,
            transient=True,
        )
        self._task = self._progress.add_task("starting", total=simulation.steps, detail="")
        self._compiled_before: int | None = None

    def __enter__(self) -> Self:
        if self._console.is_terminal:
            self._progress.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._console.is_terminal:
            self._progress.stop()

    def refresh(self) -> None:
        """Show the present state."""
        now = self._simulation.progress
        waited = time.monotonic() - self._start
        if now.phase == "running":
            speed = (now.steps - 1) * self._simulation.dt / now.wall if now.wall > 0 else 0.0
            total = self._simulation.steps * self._simulation.dt
            title = f"{self._simulation.scene.name} {now.seconds:6.2f} / {total:g} s"
            detail = f"{now.bodies} bodies, {now.contacts} contacts, {speed:.3g} × real time"
        elif now.phase == "first step" and waited > LONG:
            compiled = self._compiled()
            compiling = compiled > 0 or self._compiled_before == 0
            doing = f"compiling kernels, first run only: {compiled} done" if compiling else "loading kernels"
            title, detail = f"{doing}, {waited:.0f} s", ""
            if compiling and not self._said_waiting and not self._console.is_terminal:
                self._console.print("compiling kernels: this takes a while, on the first run only", highlight=False)
                self._said_waiting = True
        else:
            title, detail = "starting", ""
        if self._console.is_terminal:
            self._progress.update(self._task, description=title, detail=detail, completed=now.steps)
            self._progress.refresh()

    def _compiled(self) -> int:
        """Number of kernels compiled and kept since the first look."""
        from atlasphys.engine.jit import cache_root

        count = sum(1 for _ in cache_root().rglob("*.nbc"))
        if self._compiled_before is None:
            self._compiled_before = count
        return count - self._compiled_before
