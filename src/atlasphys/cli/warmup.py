"""``atlasphys warmup``: compile now what worlds would compile when they first need it."""

from __future__ import annotations

import json as json_format
import subprocess
import sys
import time
from typing import Annotated, Literal

from cyclopts import Parameter

from atlasphys.errors import AtlasPhysError


class WarmupError(AtlasPhysError):
    """A process that was to compile kernels has failed."""


def warmup(
    *,
    preset: Literal["default", "classic", "all"] = "default",
    precision: Literal["single", "double", "all"] = "single",
    processes: int | None = None,
    json: Annotated[bool, Parameter(negative=())] = False,
) -> int:
    """Compile the kernels that worlds need, in parallel, so that no first step has to wait.

    What is in the cache of kernels already costs no time. ``atlasphys doctor`` says where that is.

    Parameters
    ----------
    preset
        Whose kernels.
    precision
        For worlds of which precision.
    processes
        How many processes compile at the same time. Default: the number of processors.
    json
        Print one JSON object instead of a line.
    """
    from atlasphys.engine.threads import available_cpus
    from atlasphys.warmup import CLASSIC, PRECISIONS, STEP

    began = time.perf_counter()
    presets = ("default", "classic") if preset == "all" else (preset,)
    precisions = tuple(PRECISIONS) if precision == "all" else (precision,)
    first = [job for name in presets for job in {"default": STEP, "classic": CLASSIC}[name]]
    rounds = [[(job, name) for name in precisions for job in jobs] for jobs in (first, (*presets, "joints"))]
    _compile(rounds, processes or available_cpus())
    seconds = time.perf_counter() - began
    if json:
        print(json_format.dumps({"presets": presets, "precisions": precisions, "seconds": round(seconds, 1)}))
    else:
        print(f"ready in {seconds:.1f} s: {', '.join(presets)} worlds in {' and '.join(precisions)} precision")
    return 0


def _compile(rounds: list[list[tuple[str, str]]], processes: int) -> None:
    """Do the jobs of each round, some at a time, after those of the round before."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    from atlasphys.engine.ahead import command, environment

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    running: dict[tuple[str, str], subprocess.Popen[bytes]] = {}
    with Progress(*columns, console=Console(stderr=True), transient=True, disable=not sys.stderr.isatty()) as progress:
        bar = progress.add_task("compiling", total=sum(map(len, rounds)))
        try:
            for waiting in rounds:
                left = list(waiting)
                while left or running:
                    while left and len(running) < processes:
                        job, precision = left.pop(0)
                        running[job, precision] = subprocess.Popen(
                            command([job], precision),
                            stdin=subprocess.DEVNULL,
                            stdout=subprocess.DEVNULL,
                            stderr=subprocess.PIPE,
                            env=environment(),
                        )
                    progress.update(bar, description=f"compiling {', '.join(job for job, _ in running)}")
                    for key in [key for key, child in running.items() if child.poll() is not None]:
                        _check(key, running.pop(key))
                        progress.advance(bar)
                    time.sleep(0.05)
        finally:
            for child in running.values():
                child.terminate()
                child.communicate()


def _check(key: tuple[str, str], child: subprocess.Popen[bytes]) -> None:
    message = child.communicate()[1].decode(errors="replace").strip()
    if child.returncode:
        last = message.splitlines()[-1] if message else f"it ended with code {child.returncode}"
        raise WarmupError(f"compiling {key[0]!r} for {key[1]} precision failed: {last}")
