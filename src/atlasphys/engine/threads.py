"""Threads that help in compiled calls: when they are made, when they sleep, what becomes of them at a fork and in the end.

A helper waits in native code for calls (``team.py``). If there has been none for a tenth of a second it goes to sleep in Python, on an event that the
next call sets; that call does not wait for it to wake. Teams belong to the process, not to worlds: one is lent for each call, and worlds that step at
the same time in several Python threads get different ones.
"""

from __future__ import annotations

import atexit
import os
import threading

import numpy as np
import numpy.typing as npt

from atlasphys.engine.jit import IS_COMPILED
from atlasphys.engine.state.arrays import aligned_zeros
from atlasphys.engine.team import CLOSED, FAILED, SYNC_LENGTH, THREADS, close_call, open_call, serve


def available_cpus() -> int:
    """Number of CPUs on which this process may run."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class Team:
    """The threads of calls: the caller and ``threads`` − 1 helpers. In ``with team as sync`` one call may be made, with that ``sync``; after it
    the team goes back to the list ``home``."""

    def __init__(self, threads: int, home: list[Team]) -> None:
        self.threads = threads if IS_COMPILED else 1
        self.sync: npt.NDArray[np.int64] = aligned_zeros((SYNC_LENGTH,), np.int64)
        self.sync[THREADS] = self.threads
        self._called = threading.Event()
        self._helpers: list[threading.Thread] = []
        self._home = home
        if self.threads > 1:
            close_call(self.sync)
            self._start()

    def _start(self) -> None:
        self.sync[CLOSED] = 1
        serve(self.sync)  # returns at once; compiles it, once for all of them
        self.sync[CLOSED] = 0
        for rank in range(1, self.threads):
            helper = threading.Thread(target=self._help, name=f"atlasphys helper {rank}", daemon=True)
            helper.start()
            self._helpers.append(helper)

    def _help(self) -> None:
        while not self.sync[CLOSED]:
            self._called.wait()
            serve(self.sync)

    def __enter__(self) -> npt.NDArray[np.int64]:
        if self.threads > 1:
            self._called.set()
            open_call(self.sync)
        else:
            self.sync[FAILED] = 0
        return self.sync

    def __exit__(self, *exception: object) -> None:
        if self.threads > 1:
            close_call(self.sync)
            self._called.clear()
        self._home.append(self)

    def close(self) -> None:
        """End the helpers. There must be no call."""
        self.sync[CLOSED] = self.sync[FAILED] = 1
        self._called.set()
        for helper in self._helpers:
            helper.join()


_idle: dict[int, list[Team]] = {}


def lend_team(threads: int) -> Team:
    """A team for one call. It has as many threads as asked for, the caller's among them, but no more than there are CPUs."""
    home = _idle.setdefault(threads, [])
    try:
        return home.pop()
    except IndexError:
        return Team(min(threads, available_cpus()), home)


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
