"""Compiling kernels in other processes while this one compiles others, the first time of all.

Numba compiles one kernel at a time. A world's first step needs some 20 s of compiling if the kernel cache is empty, most of it for a few large
kernels that do not depend on each other. ``start`` has child processes compile some of them into the cache, where this process finds them; for
the default step as soon as a world has a body. What a child does is a job of ``atlasphys.warmup``.
"""

from __future__ import annotations

import atexit
import os
import subprocess
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from atlasphys.engine.jit import IS_COMPILED, is_compiled

PACKAGES = Path(__file__).parents[2]

_children: list[subprocess.Popen[bytes]] = []
_started: set[tuple[str, str]] = set()


def command(jobs: list[str], precision: str) -> list[str]:
    """What runs jobs for worlds of a precision in a process of its own."""
    return [sys.executable, "-m", "atlasphys.warmup", precision, *jobs]


def environment() -> dict[str, str]:
    """The environment in which a child finds this package."""
    path = os.environ.get("PYTHONPATH")
    return os.environ | {"PYTHONPATH": os.pathsep.join([str(PACKAGES), *([path] if path else [])])}


def start(jobs: Mapping[str, Callable[..., Any]], precision: str) -> None:
    """Start compiling kernels that the cache does not hold, unless that has been done.

    Args:
        jobs: by name of the job, the kernel that it compiles; the longest first.
        precision: ``"single"`` or ``"double"``.
    """
    missing = [job for job, kernel in jobs.items() if (job, precision) not in _started and not is_compiled(kernel)]
    _started.update((job, precision) for job in jobs)
    spare = (os.cpu_count() or 1) - 1
    if not IS_COMPILED or not sys.executable or getattr(sys, "frozen", False):
        return
    quiet = subprocess.DEVNULL
    shares = [missing[first::spare] for first in range(min(spare, len(missing)))]
    _children.extend(
        subprocess.Popen(command(share, precision), stdin=quiet, stdout=quiet, stderr=quiet, env=environment())
        for share in shares
    )


@atexit.register
def _end() -> None:
    """Nobody waits any more."""
    for child in _children:
        child.terminate()
    wait()


def wait() -> None:
    """Wait for the children. What one has not managed, this process compiles when it needs it."""
    while _children:
        _children[0].wait()
        _children.pop(0)
