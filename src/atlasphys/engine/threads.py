"""Threads that help in compiled calls: when they are made, when they sleep, what becomes of them at a fork and in the end.

``leased_team(threads)`` lends a team to one call at a time; worlds that step at the same time in several Python threads have teams of their own, others
share one. A helper waits in native code for calls (``team.py``). If there has been none for a tenth of a second it goes to sleep in
Python, on an event that the next call sets; that call does not wait for it to wake.
"""

from __future__ import annotations

import atexit
import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import numpy.typing as npt

from atlasphys.engine.jit import IS_COMPILED
from atlasphys.engine.state.arrays import aligned_zeros
from atlasphys.engine.team import ABSENT, CLOSED, FAILED, PRESENT, SYNC_LENGTH, THREADS, close_call, open_call, serve


def empty_sync(threads: int) -> npt.NDArray[np.int64]:
    """The ``sync`` of a team that has no call."""
    sync = aligned_zeros((SYNC_LENGTH,), np.int64)
    sync[THREADS], sync[PRESENT] = threads, ABSENT
    return sync


class Team:
    """A number of helpers, and the memory by which they and the leader keep in step."""

    def __init__(self, threads: int) -> None:
        self.threads = threads if IS_COMPILED else 1
        self.sync = empty_sync(self.threads)
        self._called = threading.Event()
        self._helpers = [
            threading.Thread(target=self._help, name=f"atlasphys helper {rank}", daemon=True) for rank in range(1, self.threads)
        ]
        if self._helpers:
            closed = empty_sync(1)
            closed[CLOSED] = 1
            serve(closed)  # compiles it, once
        for helper in self._helpers:
            helper.start()

    def _help(self) -> None:
        while not self.sync[CLOSED]:
            self._called.wait()
            serve(self.sync)

    @contextmanager
    def call(self) -> Iterator[npt.NDArray[np.int64]]:
        """The time of one call, which is given the ``sync``. Helpers that are asleep wake, and may sleep again after it."""
        if self.threads == 1:
            self.sync[FAILED] = 0
            yield self.sync
            return
        self._called.set()
        open_call(self.sync)
        try:
            yield self.sync
        finally:
            close_call(self.sync)
            self._called.clear()

    def close(self) -> None:
        """End the helpers. The team must not be in a call."""
        self.sync[CLOSED] = self.sync[FAILED] = 1
        self._called.set()
        for helper in self._helpers:
            helper.join()


_idle: dict[int, list[Team]] = {}


@contextmanager
def leased_team(threads: int) -> Iterator[Team]:
    """A team of so many threads, the caller's among them, for calls one after the other."""
    teams = _idle.setdefault(threads, [])
    try:
        team = teams.pop()
    except IndexError:
        team = Team(threads)
    try:
        yield team
    finally:
        teams.append(team)


def _forget() -> None:
    """In a child process that a fork has made, no thread lives but the one that forked."""
    _idle.clear()


def _close_all() -> None:
    for teams in _idle.values():
        while teams:
            teams.pop().close()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)
atexit.register(_close_all)
