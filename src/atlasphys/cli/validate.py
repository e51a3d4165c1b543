"""``atlasphys validate``: physics with known answers, for every solver, and for other engines beside them."""

from __future__ import annotations

import json as json_format
import math
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from atlasphys.cli.progress import ProgressBar
from atlasphys.errors import InvalidArgumentError

if TYPE_CHECKING:
    from atlasphys.validate.contenders import Contender
    from atlasphys.validate.runner import Job, Outcome

INTERRUPTED = 130


def validate(
    *cases: str,
    solver: str | None = None,
    dt: str | None = None,
    against: str = "none",
    out: Path | None = None,
    markdown: Annotated[bool, Parameter(negative=())] = False,
    json: Annotated[bool, Parameter(negative=())] = False,
) -> int:
    """Run cases whose answers are known and compare.

    Parameters
    ----------
    cases
        Numbers of cases, or parts of their names. Default: all.
    solver
        Presets and solvers, a list with commas; settings after colons as in soft_step:substeps=8. Default: every preset and solver.
    dt
        Steps [s], a list with commas; fractions such as 1/240 too. Default: 4, 2 and 1 times each case's own.
    against
        Other engines: a list with commas of rapier, box3d, pybullet, mujoco; or none.
    out
        Folder for a report with plots and all results.
    markdown
        Print the table as Markdown.
    json
        Print one JSON object on standard output instead of the table.
    """
    from atlasphys.bench import peers
    from atlasphys.validate import contenders, report, runner

    if markdown and json:
        raise InvalidArgumentError("give one of --markdown and --json")
    chosen = runner.chosen_cases(cases)
    steps = _steps(dt)
    entries = contenders.solvers(solver)
    entries += [contenders.peer(name, peers.PEERS[name].title) for name in peers.chosen(against)]
    if out is not None:
        make_folder(out)
    outcomes, interrupted = _run(runner.plan(chosen, entries, steps))
    if not outcomes:
        return INTERRUPTED
    files: list[Path] = []
    if out is not None:
        files, stopped = _write(out, outcomes, entries, interrupted)
        interrupted = interrupted or stopped
    if json:
        told = runner.as_json(outcomes, interrupted=interrupted) | {"files": [str(file) for file in files]}
        print(json_format.dumps(told, ensure_ascii=False))
    elif markdown:
        print(report.markdown(outcomes), end="")
    else:
        report.print_table(outcomes)
        if files:
            print("written: " + ", ".join(str(file) for file in files))
    return INTERRUPTED if interrupted else 0


def _run(jobs: list[Job]) -> tuple[list[Outcome], bool]:
    """Run jobs until they are done or Ctrl-C is pressed."""
    from atlasphys.validate import runner

    outcomes: list[Outcome] = []
    with ProgressBar(len(jobs)) as progress:
        try:
            for job in jobs:
                progress.say(f"{job.case.number} {job.case.name}: {job.contender.title}, dt {job.dt:.3g} s")
                outcomes.append(runner.run(job))
                progress.done()
        except KeyboardInterrupt:
            return outcomes, True
    return outcomes, False


def _write(out: Path, outcomes: list[Outcome], entries: list[Contender], interrupted: bool) -> tuple[list[Path], bool]:
    """Write the report; what Ctrl-C leaves time for."""
    from atlasphys.validate import plots, report, runner

    data = out / "results.json"
    data.write_text(
        json_format.dumps(runner.as_json(outcomes, interrupted=interrupted), ensure_ascii=False, indent=1) + "\n",
        encoding="utf-8",
    )
    pictures: list[tuple[str, Path]] = []
    stopped = False
    try:
        if (picture := plots.plot_errors(out / "errors.png", outcomes)) is not None:
            pictures.append(("Errors against dt", picture))
        if not interrupted:
            names = {outcome.case.number: outcome.case.name for outcome in outcomes}
            looks = [(entry.name, entry.title, entry.is_peer) for entry in entries]
            picture = plots.plot_trajectories(out / "trajectories.png", runner.trajectories(outcomes), names, looks)
            if picture is not None:
                pictures.append(("Trajectories", picture))
    except KeyboardInterrupt:
        stopped = True
    return [report.write_report(out, outcomes, pictures), *(path for _, path in pictures), data], stopped


def make_folder(out: Path) -> None:
    """Make the folder for what is drawn and written.

    Raises:
        InvalidArgumentError: it cannot be made.
        MissingExtraError: matplotlib is not installed.
    """
    from atlasphys.bench.peers import require

    require("matplotlib", "the plots of --out")
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InvalidArgumentError(f"--out {out} cannot be a folder: {error.strerror}") from None


def _steps(words: str | None) -> list[float]:
    """Time steps from a list with commas."""
    steps = []
    for word in words.split(",") if words is not None else ():
        try:
            step = float(Fraction(word.strip()))
        except (ValueError, ZeroDivisionError):
            raise InvalidArgumentError(
                f"--dt takes numbers of seconds with commas, 1/240,0.01 (got {word!r})"
            ) from None
        if not (math.isfinite(step) and 1e-7 <= step <= 1.0):
            raise InvalidArgumentError(f"--dt must be from 1e-07 to 1 s (got {step:g})")
        steps.append(step)
    return list(dict.fromkeys(steps))
