"""``atlasphys run``: simulate a scene, show how far it is, and say what came of it."""

from __future__ import annotations

import json as json_format
import math
import os
import signal
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from atlasphys.errors import AtlasPhysError, InvalidArgumentError, SceneError

if TYPE_CHECKING:
    from atlasphys.cli.simulation import Simulation

REFRESH = 0.1
"""Time between two pictures of the progress [s]."""

GRACE = 0.02
"""How long Ctrl-C waits for the step that is being taken, so that the summary can be complete [s]."""

MOST_STEPS = 10**9


def run(
    scene: str,
    /,
    *,
    seconds: float | None = None,
    dt: float | None = None,
    preset: str | None = None,
    solver: str | None = None,
    threads: int | None = None,
    set: Annotated[list[str] | None, Parameter(negative=())] = None,
    record: Path | None = None,
    record_contacts: Annotated[bool, Parameter(negative=())] = False,
    json: Annotated[bool, Parameter(negative=())] = False,
) -> int:
    """Simulate a scene and summarise what came of it.

    Parameters
    ----------
    scene
        Name of a scene of the library (see `atlasphys scenes`), or a scene file.
    seconds
        Time to simulate [s]. Default: the scene's.
    dt
        Time step [s]. Default: the scene's.
    preset
        Named choice of algorithms, such as classic.
    solver
        Name of the solver.
    threads
        Number of threads.
    set
        NAME=VALUE: a parameter of a scene of the library. May be given several times.
    record
        File for a recording (HDF5).
    record_contacts
        Record contact points too, for the viewer to show.
    json
        Print one JSON object on standard output instead of the table.
    """
    from atlasphys.cli.simulation import Simulation, summarize
    from atlasphys.scene.load import load_scene

    loaded = load_scene(scene, **parameters_of(set or []))
    step = loaded.dt if dt is None else positive("--dt", dt)
    length = loaded.seconds if seconds is None else positive("--seconds", seconds)
    if length / step > MOST_STEPS:
        raise InvalidArgumentError(f"--seconds / --dt must be at most {MOST_STEPS:,} steps (got {length / step:.3g})")
    given = {"preset": preset, "solver": solver, "threads": threads}
    settings = {name: value for name, value in given.items() if value is not None}
    if record_contacts and record is None:
        raise InvalidArgumentError("--record-contacts needs --record FILE")
    simulation = Simulation(
        loaded, max(1, round(length / step)), step, settings, record, record_contacts=record_contacts
    )
    interrupted = _follow(simulation)
    if isinstance(simulation.error, InvalidArgumentError | SceneError) and not simulation.progress.steps:
        raise simulation.error
    summary = summarize(simulation, interrupted=interrupted)
    if simulation.error is None or isinstance(simulation.error, AtlasPhysError):
        if json:
            print(json_format.dumps(summary, ensure_ascii=False))
        else:
            from atlasphys.cli.summary import print_summary

            print_summary(summary)
    sys.stdout.flush()
    if interrupted:
        # The simulation's thread may be inside a step or the compiler, for which the interpreter's own exit would wait.
        os._exit(130)
    if simulation.error is not None:
        raise simulation.error
    return 0


def _follow(simulation: Simulation) -> bool:
    """Run the simulation to its end, showing the progress on standard error; True if it was stopped by Ctrl-C."""
    from atlasphys.cli.display import Display

    with Display(simulation) as display:
        try:
            simulation.start()
            while simulation.is_alive():
                simulation.join(REFRESH)
                display.refresh()
        except KeyboardInterrupt:
            signal.signal(signal.SIGINT, signal.SIG_IGN)  # once is enough
            simulation.stop.set()
            simulation.join(GRACE)
            simulation.close_recording()
            return True
    return False


def parameters_of(words: list[str]) -> dict[str, str]:
    """``NAME=VALUE`` words as a mapping."""
    parameters: dict[str, str] = {}
    for word in words:
        name, equals, value = word.partition("=")
        if not equals or not name.isidentifier():
            raise InvalidArgumentError(f"--set takes NAME=VALUE (got {word!r})")
        if name in parameters:
            raise InvalidArgumentError(f"--set {name} is given twice")
        parameters[name] = value
    return parameters


def positive(name: str, value: float) -> float:
    """A number of seconds greater than 0, which an option of this name gave."""
    if not (math.isfinite(value) and value > 0):
        raise InvalidArgumentError(f"{name} must be a number of seconds greater than 0 (got {value:g})")
    return value
