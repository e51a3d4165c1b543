"""What a benchmark says: a table on the terminal, a CSV file and a plot."""

from __future__ import annotations

import csv
import math
import statistics
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from atlasphys.bench.measure import Result
from atlasphys.bench.peers import OURS, PEERS

COLORS = {"rapier": "#d95f02", "box3d": "#7570b3", "pybullet": "#1b9e77", "mujoco": "#666666", OURS: "#1f77b4"}


def summary(results: Iterable[Result]) -> dict[str, Any]:
    """Per peer, the geometric mean of its ratios over the scenes in which it and we both stood; per scene, the fastest peer that stood."""
    results = list(results)
    good = {result.scene for result in results if result.engine == OURS and result.stands}
    counted = [
        (result, result.median_ratio)
        for result in results
        if result.engine != OURS and result.scene in good and result.stands and result.median_ratio is not None
    ]
    peers: dict[str, list[float]] = {}
    fastest: dict[str, tuple[float, str]] = {}
    for result, ratio in counted:
        peers.setdefault(result.engine, []).append(ratio)
        fastest[result.scene] = min(fastest.get(result.scene, (math.inf, "")), (ratio, result.engine))
    return {
        "peers": {
            name: {"scenes": len(ratios), "mean_ratio": float(f"{statistics.geometric_mean(ratios):.4g}")}
            for name, ratios in peers.items()
        },
        "fastest_peer": {
            scene: {"engine": name, "median_ratio": float(f"{ratio:.4g}")} for scene, (ratio, name) in fastest.items()
        },
    }


def print_results(results: Sequence[Result], threads: int) -> None:
    """Print a table a scene, and below them why results do not count, and the means."""
    console = Console(highlight=False)
    console.print(
        f"ms per step, {_threads(threads)}; ratio: time against that of AtlasPhys (above 1: slower);\n"
        "drift, deepest penetration and stretch of links in mm; energy gained in % of weight × length\n"
    )
    for scene in dict.fromkeys(result.scene for result in results):
        console.print(_table(scene, [result for result in results if result.scene == scene]))
    for result in results:
        if result.fault:
            console.print(
                f"{result.scene}, {result.engine}: {result.fault}, after {result.seconds:.3g} s", markup=False
            )
    for name, mean in summary(results)["peers"].items():
        scenes = f"{mean['scenes']} scene{'s' * (mean['scenes'] > 1)}"
        console.print(f"{PEERS[name].title} takes {mean['mean_ratio']:.3g} times as long (mean of {scenes} that stood)")


def _table(scene: str, results: Sequence[Result]) -> Table:
    title = f"[bold]{scene}[/bold], {results[0].bodies} bod{'y' if results[0].bodies == 1 else 'ies'}"
    table = Table(title=title, title_justify="left", title_style="", box=SIMPLE_HEAD, pad_edge=False, padding=0)
    table.add_column("engine", width=10)
    swings = any(result.quality and result.quality.stretch is not None for result in results)
    judged = ("stretch", "energy %") if swings else ("drift", "depth")
    for name in ("median", "least", "CPU", "ratio", "of least", *judged):
        table.add_column(name, justify="right", width=8)
    table.add_column("stands", justify="right", width=7)
    ours = _ours(results, scene)
    for result in results:
        row = result.row()
        numbers = [_text(row[key]) for key in ("median_ms", "min_ms", "cpu_ms")]
        # A ratio of a wrong answer, ours or theirs, is not shown: it would be quoted.
        numbers += [_text(row[key]) if ours and result.stands else "–" for key in ("median_ratio", "min_ratio")]
        lengths = (row["stretch"],) if swings else (row["worst_drift"], row["deepest_penetration"])
        numbers += ["–" if length is None else f"{1e3 * length:.1f}" for length in lengths]
        if swings:
            numbers.append("–" if row["energy_error"] is None else f"{1e2 * row['energy_error']:+.2f}")
        verdict = "yes" if result.stands else "[red]failed[/red]" if result.failure else "[red]fell[/red]"
        table.add_row(PEERS[result.engine].title, *numbers, verdict)
    return table


def print_rows(title: str, rows: Sequence[dict[str, Any]]) -> None:
    """Print plain rows as a table."""
    table = Table(*rows[0], title=title, title_justify="left", header_style="bold", box=SIMPLE_HEAD, pad_edge=False)
    for row in rows:
        table.add_row(*(_text(value) for value in row.values()))
    Console(highlight=False).print(table, markup=False)


def write_csv(path: Path, rows: Sequence[dict[str, Any]]) -> Path:
    """Write rows; what is not known is left empty."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    return path


def plot_ratios(path: Path, results: Sequence[Result], threads: int) -> Path:
    """Draw how much longer each peer takes than AtlasPhys, a bar each on a logarithmic scale; hollow where either is wrong."""
    pyplot = _pyplot()
    scenes = list(dict.fromkeys(result.scene for result in results))
    engines = [name for name in PEERS if name != OURS and any(result.engine == name for result in results)]
    found = {(result.scene, result.engine): result for result in results}
    height = 0.8 / max(1, len(engines))
    figure, axes = pyplot.subplots(figsize=(9, 1.4 + len(scenes) * (0.25 + 0.22 * max(1, len(engines)))))
    for k, name in enumerate(engines):
        for row, scene in enumerate(scenes):
            result, ours = found.get((scene, name)), _ours(results, scene)
            y = row - 0.4 + (k + 0.5) * height
            if result is None:
                continue
            ratio = result.median_ratio
            if ratio is None:
                axes.text(1.0, y, " failed", va="center", fontsize=7, color=COLORS[name])
                continue
            hollow = {"color": "white", "edgecolor": COLORS[name], "hatch": "////"}
            style = {"color": COLORS[name]} if ours and result.stands else hollow
            axes.barh(y, ratio - 1, left=1, height=0.9 * height, **style)
            words = (f"{ratio:.2g}" if ratio < 99.5 else f"{ratio:.0f}") + " fell" * (not result.stands)
            outward = ratio >= 1
            axes.text(ratio, y, f" {words} ", va="center", ha="left" if outward else "right", fontsize=7, color="black")
    axes.set_xscale("log")
    ratios = [result.median_ratio for result in results if result.median_ratio]
    axes.set_xlim(min([0.5, *(0.5 * ratio for ratio in ratios)]), max([2.0, *(2.5 * ratio for ratio in ratios)]))
    axes.axvline(1, color=COLORS[OURS], linewidth=1.5)
    axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.set_yticks(range(len(scenes)), [_label(results, scene) for scene in scenes])
    axes.set_ylim(len(scenes) - 0.4, -0.6)
    axes.set_xlabel(f"time per step against AtlasPhys ({_threads(threads)}); right of the line AtlasPhys is faster")
    axes.grid(axis="x", which="major", alpha=0.3)
    axes.set_axisbelow(True)
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    axes.tick_params(axis="y", length=0)
    if engines:
        handles = [pyplot.Rectangle((0, 0), 1, 1, color=COLORS[name]) for name in engines]
        labels = [f"{PEERS[name].title} {_version(results, name)}" for name in engines]
        figure.legend(handles, labels, loc="upper center", ncols=len(engines), frameon=False)
    figure.tight_layout(rect=(0, 0, 1, 1 - 0.35 / figure.get_figheight()))
    return _save(figure, path)


def plot_scaling(path: Path, results: Sequence[Result]) -> Path:
    """Draw time per body over the number of bodies, a panel for each kind of scene; answers that are wrong have hollow marks."""
    pyplot = _pyplot()
    families = list(dict.fromkeys(result.scene.rpartition("_")[0] for result in results))
    figure, panels = pyplot.subplots(1, len(families), figsize=(5 * len(families), 4), squeeze=False, sharey=True)
    for axes, family in zip(panels[0], families, strict=True):
        for name in PEERS:
            line = [
                (result.bodies, 1e6 * statistics.median(result.wall) / result.bodies, result.stands)
                for result in results
                if result.engine == name and result.wall and result.scene.rpartition("_")[0] == family
            ]
            if line:
                bodies, times, stands = zip(*line, strict=True)
                axes.plot(bodies, times, color=COLORS[name], label=PEERS[name].title)
                faces = [COLORS[name] if good else "white" for good in stands]
                axes.scatter(bodies, times, c=faces, edgecolors=COLORS[name], zorder=3)
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.xaxis.set_major_formatter(lambda value, _: f"{value:,.0f}")
        axes.xaxis.set_minor_formatter(lambda value, _: "")
        axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
        axes.yaxis.set_minor_formatter(lambda value, _: "")
        axes.set_title(family)
        axes.set_xlabel("bodies")
        axes.grid(which="both", alpha=0.2)
    panels[0][0].set_ylabel("µs per step and body")
    panels[0][0].legend(frameon=False)
    figure.tight_layout()
    return _save(figure, path)


def _pyplot() -> Any:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as pyplot

    return pyplot


def _save(figure: Any, path: Path) -> Path:
    figure.savefig(path, dpi=150)
    _pyplot().close(figure)
    return path


def _ours(results: Sequence[Result], scene: str) -> bool:
    """Whether AtlasPhys's answer to a scene counts."""
    return any(result.stands for result in results if result.scene == scene and result.engine == OURS)


def _label(results: Sequence[Result], scene: str) -> str:
    """A scene with the time that AtlasPhys takes."""
    for result in results:
        if result.scene == scene and result.engine == OURS and result.wall:
            fell = "" if result.stands else ", AtlasPhys fell"
            return f"{scene}\n{1e3 * statistics.median(result.wall):.3g} ms{fell}"
    return scene


def _version(results: Sequence[Result], name: str) -> str:
    return next(result.version for result in results if result.engine == name)


def _threads(count: int) -> str:
    return f"{count} thread{'s' * (count > 1)}"


def _text(value: Any) -> str:
    if value is None:
        return "–"
    return f"{value:.3g}" if isinstance(value, float) else str(value)
