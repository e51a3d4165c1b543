"""The progress of a measurement in pieces, on standard error."""

from __future__ import annotations


class ProgressBar:
    """Where the measurement is, on standard error: a bar on a terminal, elsewhere a line for all but the rounds."""

    def __init__(self, total: int) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

        console = Console(stderr=True)
        columns = (TextColumn("{task.description}"), BarColumn(bar_width=20), TimeElapsedColumn())
        self._progress = Progress(*columns, console=console, transient=True, disable=not console.is_terminal)
        self._task = self._progress.add_task("starting", total=total)
        self._console = console

    def say(self, text: str) -> None:
        """Show what is being done."""
        if self._console.is_terminal:
            self._progress.update(self._task, description=text)
        elif " round " not in text:
            self._console.print(text, highlight=False)

    def done(self) -> None:
        """Note that one of the pieces is done."""
        self._progress.advance(self._task)

    def __enter__(self) -> ProgressBar:
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()
