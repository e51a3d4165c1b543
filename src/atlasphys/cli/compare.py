"""``atlasphys compare``: one scene under several solvers and settings, side by side."""

from __future__ import annotations

import json as json_format
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from atlasphys.cli.progress import ProgressBar
from atlasphys.cli.run import MOST_STEPS, parameters_of, positive
from atlasphys.cli.validate import INTERRUPTED, make_folder
from atlasphys.errors import InvalidArgumentError

if TYPE_CHECKING:
    from atlasphys.validate.compare import Track


def compare(
    scene: str,
    /,
    *,
    solver: str | None = None,
    seconds: float | None = None,
    dt: float | None = None,
    set: Annotated[list[str] | None, Parameter(negative=())] = None,
    out: Path | None = None,
    json: Annotated[bool, Parameter(negative=())] = False,
) -> int:
    """Simulate a scene under several solvers and settings, and compare. Nothing sleeps.

    Parameters
    ----------
    scene
        Name of a scene of the library (see `atlasphys scenes`), or a scene file.
    solver
        Presets and solvers, a list with commas; settings after colons as in soft_step:substeps=8. Default: every preset and solver.
    seconds
        Time to simulate [s]. Default: the scene's.
    dt
        Time step [s]. Default: the scene's.
    set
        NAME=VALUE: a parameter of a scene of the library. May be given several times.
    out
        Folder for a page of plots and all samples.
    json
        Print one JSON object on standard output instead of the table.
    """
    from atlasphys.scene.load import load_scene
    from atlasphys.validate.compare import Track, follow, plot
    from atlasphys.validate.contenders import solvers

    contenders = solvers(solver)
    loaded = load_scene(scene, **parameters_of(set or []))
    h = loaded.dt if dt is None else positive("--dt", dt)
    steps = max(1, round((loaded.seconds if seconds is None else positive("--seconds", seconds)) / h))
    if steps > MOST_STEPS:
        raise InvalidArgumentError(f"--seconds / --dt must be at most {MOST_STEPS:,} steps (got {steps:.3g})")
    if out is not None:
        make_folder(out)
    # Resting bodies cost nothing where they sleep, which not every solver lets them.
    worlds = [loaded.build(sleeping=False, **contender.settings) for contender in contenders]
    tracks: list[Track] = []
    interrupted = False
    with ProgressBar(len(contenders)) as progress:
        try:
            for contender, world in zip(contenders, worlds, strict=True):
                tracks.append(Track(contender, h))
                progress.say(f"{loaded.name}: {contender.title}")
                follow(world, tracks[-1], steps, progress.say)
                progress.done()
        except KeyboardInterrupt:
            interrupted = True
    tracks = [track for track in tracks if track.times or track.error]
    files = []
    if out is not None and tracks:
        files = [plot(out / "compare.png", tracks, loaded.name), out / "compare.json"]
        samples = [
            track.row() | {"times": track.times, "residuals_of_sweeps": track.sweeps} | track.columns
            for track in tracks
        ]
        files[1].write_text(json_format.dumps(samples, ensure_ascii=False, indent=1) + "\n", encoding="utf-8")
    if json:
        told = {"scene": loaded.name, "interrupted": interrupted, "results": [track.row() for track in tracks]}
        print(json_format.dumps(told | {"files": [str(file) for file in files]}, ensure_ascii=False))
    elif tracks:
        _print(tracks)
        if files:
            print("written: " + ", ".join(str(file) for file in files))
    return INTERRUPTED if interrupted else int(any(track.error for track in tracks))


ROWS = {
    "step_milliseconds": ("time per step, median", 1.0, "ms"),
    "worst_complementarity": ("complementarity residual, greatest", 1.0, "N s"),
    "last_complementarity": ("  at the end", 1.0, "N s"),
    "worst_cone": ("friction beyond the cone, greatest", 1.0, "N s"),
    "worst_depth": ("deepest overlap", 1e3, "mm"),
    "last_depth": ("  at the end", 1e3, "mm"),
    "last_kinetic": ("kinetic energy at the end", 1.0, "J"),
    "last_gained": ("total energy, end − start", 1.0, "J"),
    "greatest_gain": ("  greatest", 1.0, "J"),
    "worst_drift": ("farthest from its start, a body", 1e3, "mm"),
    "last_drift": ("  at the end", 1e3, "mm"),
    "sweeps": ("sweeps of the last step", 1.0, ""),
    "first_sweep": ("  residual after the first", 1.0, "N s"),
    "last_sweep": ("  after the last", 1.0, "N s"),
    "contacts": ("contact points at the end", 1.0, ""),
    "seconds": ("simulated", 1.0, "s"),
}
"""Entry of a track's row → what it is called, factor and unit."""


def _print(tracks: list[Track]) -> None:
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.table import Table

    rows: list[dict[str, Any]] = [track.row() for track in tracks]
    table = Table(header_style="bold", box=SIMPLE_HEAD, pad_edge=False, show_edge=False)
    table.add_column("")
    table.add_column("", style="dim")
    for track in tracks:
        table.add_column(track.contender.name.replace(":", "\n"), justify="right")
    for key, (title, factor, unit) in ROWS.items():
        cells = ("–" if row[key] is None else f"{factor * row[key]:.3g}" for row in rows)
        table.add_row(title, unit, *cells)
    console = Console(highlight=False)
    console.print(table, markup=False)
    for track in tracks:
        if track.error:
            console.print(f"{track.contender.title} ended early: {track.error}", markup=False)
