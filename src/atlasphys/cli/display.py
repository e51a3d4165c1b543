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
        self._seen_steps, self._seen_at = 0, time.monotonic()
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

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._console.is_terminal:
            self._progress.stop()

    def refresh(self) -> None:
        """Show the present state."""
        now, simulation = self._simulation.progress, self._simulation
        if now.steps != self._seen_steps:
            self._seen_steps, self._seen_at = now.steps, time.monotonic()
        waited = time.monotonic() - self._seen_at
        usual = now.wall / now.steps if now.steps else 0.0
        if waited > LONG + 5 * usual and now.phase != "starting" and (waiting := self._waiting(waited)):
            title, detail = waiting, ""
        elif now.phase == "running":
            speed = (now.steps - 1) * simulation.dt / now.wall if now.wall > 0 else 0.0
            title = f"{simulation.scene.name} {now.seconds:6.2f} / {simulation.steps * simulation.dt:g} s"
            detail = f"{now.bodies} bodies, {now.contacts} contacts, {speed:.3g} × real time"
        else:
            title, detail = "starting", ""
        if self._console.is_terminal:
            self._progress.update(self._task, description=title, detail=detail, completed=now.steps)
            self._progress.refresh()

    def _waiting(self, waited: float) -> str:
        """What a long step is waiting for; empty if unknown. Kernels are compiled when they are first needed."""
        compiled = self._compiled()
        if compiled or self._compiled_before == 0:
            if not self._said_waiting and not self._console.is_terminal:
                self._console.print(
                    "compiling kernels: up to a minute, once for each kind of shape",
                    highlight=False,
                )
                self._said_waiting = True
            return f"compiling kernels, once for each kind of shape and setting: {compiled} done, {waited:.0f} s"
        return f"loading kernels, {waited:.0f} s" if self._simulation.progress.steps == 0 else ""

    def _compiled(self) -> int:
        """Number of kernels compiled and kept since the first look."""
        from atlasphys.engine.jit import cache_root

        count = sum(1 for _ in cache_root().rglob("*.nbc"))
        if self._compiled_before is None:
            self._compiled_before = count
        return count - self._compiled_before
