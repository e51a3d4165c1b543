"""``atlasphys bench``: speed against other engines on the same scenes; wrong answers do not count."""

from __future__ import annotations

import json as json_format
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from atlasphys.cli.progress import ProgressBar
from atlasphys.errors import InvalidArgumentError

if TYPE_CHECKING:
    from atlasphys.bench.measure import Plan, Result

SIZES = (1000, 3000, 10_000, 30_000, 100_000)
"""Numbers of bodies of ``--scaling``."""


def bench(
    *scenes: str,
    against: str | None = None,
    threads: int = 1,
    preset: str | None = None,
    rounds: int = 20,
    steps: int | None = None,
    settle: float | None = None,
    seconds: float | None = None,
    patience: float = 300.0,
    scaling: Annotated[bool, Parameter(negative=())] = False,
    memory: Annotated[bool, Parameter(negative=())] = False,
    out: Path = Path("benchmarks"),
    json: Annotated[bool, Parameter(negative=())] = False,
) -> int:
    """Measure milliseconds per step on standard scenes, against other engines.

    Each engine runs in a process of its own; they take turns. Writes a table, a CSV file and a plot.

    Parameters
    ----------
    scenes
        Names of benchmark scenes; pile_N and falling_N take any number of bodies. Default: all but those two.
    against
        Engines to compare with: a list with commas of rapier, box3d, pybullet, mujoco; or none. Default: all.
    threads
        Number of threads of each engine that has them.
    preset
        AtlasPhys's preset. Default: that of a default world.
    rounds
        Number of turns of each engine.
    steps
        Steps of a turn. Default: those of about 0.2 s.
    settle
        Simulated time before measuring [s]. Default: the scene's.
    seconds
        Simulated time at which a scene is judged [s]. Default: the scene's.
    patience
        Wall time after which an engine that does not answer or has not settled is given up [s].
    scaling
        Measure time per body from 1000 to 100000 bodies instead.
    memory
        Measure memory per body instead.
    out
        Folder for the CSV file and the plot.
    json
        Print one JSON object on standard output instead of the table.
    """
    from atlasphys.bench import peers
    from atlasphys.bench.measure import Plan
    from atlasphys.bench.scenes import FAMILIES, SCENES, make

    for name, value in (("--threads", threads), ("--rounds", rounds), ("--steps", steps)):
        if value is not None and value < 1:
            raise InvalidArgumentError(f"{name} must be at least 1 (got {value})")
    for name, length in (("--settle", settle), ("--seconds", seconds), ("--patience", patience)):
        if length is not None and not (math.isfinite(length) and length > 0):
            raise InvalidArgumentError(f"{name} must be a number of seconds greater than 0 (got {length:g})")
    if (scaling and memory) or (scenes and (scaling or memory)):
        raise InvalidArgumentError("--scaling and --memory have scenes of their own: give one of them, or scenes")
    scaled = [f"{family}_{count}" for family in FAMILIES for count in SIZES]
    chosen = scaled if scaling else list(dict.fromkeys(scenes)) or list(SCENES)
    for scene in () if scaling else chosen:
        make(scene)
    engines = [peers.OURS, *peers.chosen(against)]
    if not memory:
        peers.require("matplotlib", "the plot")
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InvalidArgumentError(f"--out {out} cannot be a folder: {error.strerror}") from None
    plan = Plan(threads, preset, rounds, steps=steps, settle=settle, seconds=seconds, patience=patience)
    stem = "scaling" if scaling else "memory" if memory else "bench"
    path = out / (stem if threads == 1 else f"{stem}_{threads}_threads")
    if memory:
        return _memory(engines, plan, path, json)
    return _speed(chosen, engines, plan, path, json, scaling)


def _speed(scenes: list[str], engines: list[str], plan: Plan, path: Path, json: bool, scaling: bool) -> int:
    from atlasphys.bench import report
    from atlasphys.bench.measure import as_json, measure
    from atlasphys.bench.scenes import make

    results: list[Result] = []
    with ProgressBar(len(scenes)) as progress:
        for name in scenes:
            results += measure(make(name), engines, plan, progress.say)
            progress.done()
    files = [report.write_csv(path.with_suffix(".csv"), [result.row() for result in results])]
    picture = path.with_suffix(".png")
    if scaling:
        files.append(report.plot_scaling(picture, results))
    else:
        files.append(report.plot_ratios(picture, results, plan.threads))
    if json:
        told = {"results": [as_json(result) for result in results], "summary": report.summary(results)}
        _print_json(plan, told, files)
    else:
        report.print_results(results, plan.threads)
        _print_files(files)
    return 0


def _memory(engines: list[str], plan: Plan, path: Path, json: bool) -> int:
    from atlasphys.bench import report
    from atlasphys.bench.measure import memory

    with ProgressBar(len(engines)) as progress:
        rows = memory(engines, plan, progress.say)
    files = [report.write_csv(path.with_suffix(".csv"), rows)]
    if json:
        _print_json(plan, {"results": rows}, files)
    else:
        report.print_rows("memory beyond that of a small pile", rows)
        _print_files(files)
    return 0


def _print_json(plan: Plan, told: dict[str, Any], files: list[Path]) -> None:
    import os
    import platform
    from dataclasses import asdict

    from atlasphys.bench.scenes import DT

    machine = {"system": platform.system(), "processor": platform.machine(), "processors": os.cpu_count()}
    head = {"machine": machine, "python": platform.python_version(), "dt": DT, "plan": asdict(plan)}
    print(json_format.dumps(head | told | {"files": [str(file) for file in files]}, ensure_ascii=False))


def _print_files(files: list[Path]) -> None:
    print("written: " + ", ".join(str(file) for file in files))
