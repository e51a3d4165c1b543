"""A session on a thread of its own: others queue commands and read frames."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any, Protocol, TypeVar

from atlasphys.viewer.frame import Frame
from atlasphys.viewer.meter import Beat

T = TypeVar("T")

FRAME_TIME = 1 / 31
"""Time between two frames [s], a little less than that between two drawings."""

LONGEST_IDLE = 0.5
"""How long the thread sleeps at most while time stands still [s]."""


class Model(Protocol):
    """What can be run: a session, or the replay of a recording."""

    changes: int

    def advance(self, elapsed: float) -> None:
        """Let wall time pass [s]."""

    @property
    def until_next_step(self) -> float:
        """Wall time until something is due [s]."""

    def frame(self) -> Frame:
        """The present moment."""


class Simulation:
    """Runs a model on its own thread.

    Args:
        model: from now on to be touched by commands only.
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        self.frame = model.frame()
        """The newest frame. Replaced, never changed."""
        self.busy_since: float | None = None
        """Clock at which the model was last called, None between calls: a long step, or kernels being compiled."""
        self._commands: queue.SimpleQueue[tuple[Callable[[Any], Any], Future[Any]] | None] = queue.SimpleQueue()
        self._news = threading.Condition()
        self._ended = False
        self._thread = threading.Thread(target=self._run, name="simulation", daemon=True)
        self._thread.start()

    def do(self, command: Callable[[Any], T]) -> Future[T]:
        """Queue a command, which the thread will call with the model between steps. The future holds its result or error."""
        future: Future[T] = Future()
        if self._ended:
            future.set_exception(RuntimeError("the simulation has ended"))
        else:
            self._commands.put((command, future))
        return future

    def wait_for_news(self, frame: Frame, timeout: float) -> Frame:
        """The newest frame, as soon as it is another than ``frame``, at the latest after ``timeout`` seconds."""
        with self._news:
            self._news.wait_for(lambda: self.frame is not frame or self._ended, timeout)
        return self.frame

    def end(self) -> None:
        """End the thread after the step that is being taken."""
        self._ended = True
        self._commands.put(None)
        self._thread.join(timeout=5.0)

    def _run(self) -> None:
        last, beat, shown = time.perf_counter(), Beat(FRAME_TIME), self.model.changes
        while not self._ended:
            next_frame = beat.wait(time.perf_counter()) if self.model.changes != shown else LONGEST_IDLE
            self._take_commands(max(0.0, min(next_frame, self.model.until_next_step, LONGEST_IDLE)))
            now = time.perf_counter()
            self._call(self.model.advance, now - last)
            last = now
            if self.model.changes != shown and beat.wait(time.perf_counter()) == 0:
                beat.tick(time.perf_counter())
                shown = self.model.changes
                self._publish()

    def _take_commands(self, wait: float) -> None:
        """Execute what is queued; wait for the first for so long [s]."""
        try:
            item = self._commands.get(timeout=wait) if wait > 0 else self._commands.get_nowait()
            while item is not None:
                command, future = item
                if future.set_running_or_notify_cancel():
                    try:
                        future.set_result(self._call(command, self.model))
                    except BaseException as error:  # whoever waits for the future shall see it
                        future.set_exception(error)
                item = self._commands.get_nowait()
        except queue.Empty:
            pass

    def _call(self, function: Callable[[Any], T], argument: Any) -> T:
        self.busy_since = time.monotonic()
        try:
            return function(argument)
        finally:
            self.busy_since = None

    def _publish(self) -> None:
        frame = self.model.frame()
        with self._news:
            self.frame = frame
            self._news.notify_all()
