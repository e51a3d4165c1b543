"""Pictures of a validation: errors against dt, and trajectories beside the exact curves."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from atlasphys.validate.case import Curve
from atlasphys.validate.report import Grid
from atlasphys.validate.runner import Outcome

COLORS = ("#1f77b4", "#e6550d", "#2ca02c", "#c51b8a", "#8c6d31", "#17a2b8")
PEER_COLORS = {"rapier": "#d95f02", "box3d": "#7570b3", "pybullet": "#1b9e77", "mujoco": "#666666"}
COLUMNS = 4
LEAST_SHARE, GREATEST_SHARE = 1e-4, 1e3
"""Errors beyond these shares of their tolerance are drawn as these."""


def pyplot() -> Any:
    """matplotlib's, drawing into files."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot

    return matplotlib.pyplot


def styles(names: Sequence[tuple[str, str, bool]]) -> dict[str, dict[str, Any]]:
    """Line styles by title, from names, titles and whether they are peers: peers are dashed, and of ours those drawn first are wider, so that
    lines that coincide are seen."""
    own = [title for _, title, is_peer in names if not is_peer]
    return {
        title: {"color": PEER_COLORS.get(name, "black"), "linestyle": "--", "linewidth": 1.0}
        if is_peer
        else {
            "color": COLORS[own.index(title) % len(COLORS)],
            "linestyle": "-",
            "linewidth": max(3.0 - own.index(title), 1.0),
        }
        for name, title, is_peer in names
    }


def plot_errors(path: Path, outcomes: Sequence[Outcome]) -> Path | None:
    """Draw each case's greatest error, as a share of its tolerance, against dt; None if no case has two steps."""
    grid = Grid(outcomes)
    panels = []
    for case in grid.cases:
        lines = {}
        for contender in grid.contenders:
            points = sorted(
                (o.dt, o.result.score)
                for o in outcomes
                if o.case.number == case.number and o.contender.name == contender.name and o.result
            )
            if points:
                lines[contender.title] = points
        if any(len(points) > 1 for points in lines.values()):
            panels.append((case, lines))
    if not panels:
        return None
    look = styles([(c.name, c.title, c.is_peer) for c in grid.contenders])
    rows = math.ceil(len(panels) / COLUMNS)
    plt = pyplot()
    figure, axes = plt.subplots(rows, COLUMNS, figsize=(3.2 * COLUMNS, 2.4 * rows + 0.8), squeeze=False)
    for panel in axes.flat[len(panels) :]:
        panel.set_visible(False)
    for panel, (case, lines) in zip(axes.flat, panels, strict=False):
        for title, points in lines.items():
            dts, scores = np.array(points).T
            panel.plot(
                dts, scores.clip(LEAST_SHARE, GREATEST_SHARE), marker="o", markersize=3, label=title, **look[title]
            )
        panel.axhline(1, color="black", linewidth=0.8)
        panel.axvline(case.dt, color="black", linewidth=0.8, linestyle=":")
        panel.set_xscale("log", base=2)
        panel.set_yscale("log")
        low, high = panel.get_ylim()
        panel.set_ylim(min(low, 0.3), max(high, 3))
        ticks = sorted({dt for points in lines.values() for dt, _ in points})
        panel.set_xticks(ticks, [_step(dt) for dt in ticks])
        panel.xaxis.set_minor_locator(plt.NullLocator())
        panel.set_title(f"{case.number} {case.name}", fontsize=9)
        panel.tick_params(labelsize=7)
        panel.grid(which="major", alpha=0.25)
    for panel in axes[:, 0]:
        panel.set_ylabel("error / tolerance", fontsize=8)
    return finish(
        figure,
        path,
        [(title, look[title]) for title in look],
        f"step [s]; dotted: the case's own, where it is judged; drawn from {LEAST_SHARE:g} to {GREATEST_SHARE:g} of the tolerance",
    )


def plot_trajectories(
    path: Path,
    curves: Mapping[int, Mapping[str, Curve]],
    names: Mapping[int, str],
    contenders: Sequence[tuple[str, str, bool]],
) -> Path | None:
    """Draw quantities over time beside the exact curves, and below what they are off by; None if there are none."""
    if not curves:
        return None
    look = styles(contenders)
    columns = min(COLUMNS, len(curves))
    rows = math.ceil(len(curves) / columns)
    plt = pyplot()
    figure = plt.figure(figsize=(3.6 * columns, 3.6 * rows + 0.8))
    cells = figure.add_gridspec(rows, columns)
    for place, (number, found) in enumerate(curves.items()):
        upper, lower = cells[divmod(place, columns)].subgridspec(2, 1, height_ratios=[2, 1]).subplots(sharex=True)
        for title, curve in found.items():
            upper.plot(curve.times, curve.found, **look[title])
            lower.plot(curve.times, curve.found - curve.exact, **look[title])
        exact = next(iter(found.values()))
        upper.plot(exact.times, exact.exact, color="black", linestyle=(0, (1, 3)), linewidth=1.6)
        spread = max(float(np.ptp(exact.exact)), 1e-12)
        upper.set_ylim(exact.exact.min() - 0.15 * spread, exact.exact.max() + 0.15 * spread)
        upper.set_title(f"{number} {names[number]}\n{exact.quantity}", fontsize=9)
        lower.axhline(0, color="black", linewidth=0.8)
        lower.set_yscale("symlog", linthresh=1e-3 * spread)
        lower.set_ylim(-2 * spread, 2 * spread)
        lower.set_yticks([-spread, -1e-2 * spread, 0, 1e-2 * spread, spread], ["−100 %", "−1 %", "0", "1 %", "100 %"])
        lower.yaxis.set_minor_locator(plt.NullLocator())
        for panel in (upper, lower):
            panel.tick_params(labelsize=7)
            panel.grid(alpha=0.25)
    handles = [(title, look[title]) for title in look]
    handles.append(("exact", {"color": "black", "linestyle": (0, (1, 3)), "linewidth": 1.6}))
    return finish(figure, path, handles, "time [s]; below each: found − exact, as a share of the curve's range")


def finish(figure: Any, path: Path, handles: Sequence[tuple[str, Mapping[str, Any]]], label: str) -> Path:
    """Add a legend from titles and line styles, and a label below, and save."""
    plt = pyplot()
    lines = [plt.Line2D([], [], **style) for _, style in handles]
    titles = [title for title, _ in handles]
    figure.set_layout_engine("constrained")
    figure.legend(lines, titles, loc="outside upper center", ncols=min(len(lines), 7), frameon=False, fontsize=9)
    figure.supxlabel(label, fontsize=9)
    figure.savefig(path, dpi=100)
    plt.close(figure)
    return path


def _step(dt: float) -> str:
    """A step as the fraction that it is, if it is one."""
    steps = round(1 / dt)
    return f"1/{steps}" if steps < 100_000 and math.isclose(steps * dt, 1, rel_tol=1e-6) else f"{dt:.2g}"
