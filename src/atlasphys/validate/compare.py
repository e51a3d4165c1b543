"""The same scene under several solvers and settings: what each costs, and how it behaves over time."""

from __future__ import annotations

import copy
import math
import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from atlasphys.errors import DivergenceError
from atlasphys.validate.contenders import Contender
from atlasphys.validate.plots import finish, pyplot, styles

if TYPE_CHECKING:
    from atlasphys.world.world import World

SAMPLES = 500
"""A run is looked at after every step, or, if it is longer than this many steps, that many times."""

COLUMNS = {
    "complementarity": "complementarity residual, greatest [N s]",
    "cone": "friction beyond the cone, greatest [N s]",
    "depth": "deepest overlap [m]",
    "kinetic": "kinetic energy [J]",
    "gained": "total energy − that at the start [J]",
    "drift": "way of the body that is farthest from its start [m]",
}
"""What is sampled over time."""


@dataclass
class Track:
    """What a contender did with the scene."""

    contender: Contender
    dt: float
    steps: int = 0
    wall: list[float] = field(default_factory=list)
    """Seconds per step, without the first, which compiles and loads."""
    times: list[float] = field(default_factory=list)
    """Of the samples [s]."""
    columns: dict[str, list[float]] = field(default_factory=lambda: {name: [] for name in COLUMNS})
    sweeps: list[float] = field(default_factory=list)
    """Greatest complementarity residual after each sweep of one step more, taken by a copy of the world [N s]."""
    contacts: int = 0
    bodies: int = 0
    error: str = ""
    """Why it ended early, if an error ended it."""

    def row(self) -> dict[str, Any]:
        """The line of the table, in plain values."""
        worst = {
            f"worst_{name}": _greatest(self.columns[name]) for name in ("complementarity", "cone", "depth", "drift")
        }
        last = {f"last_{name}": values[-1] if values else None for name, values in self.columns.items()}
        return {
            "contender": self.contender.name,
            "dt": self.dt,
            "steps": self.steps,
            "seconds": self.steps * self.dt,
            "bodies": self.bodies,
            "contacts": self.contacts,
            "step_milliseconds": 1e3 * statistics.median(self.wall) if self.wall else None,
            **worst,
            "greatest_gain": _greatest(self.columns["gained"]),
            **last,
            "sweeps": len(self.sweeps),
            "first_sweep": self.sweeps[0] if self.sweeps else None,
            "last_sweep": self.sweeps[-1] if self.sweeps else None,
            "error": self.error,
        }


def follow(world: World, track: Track, steps: int, report: Callable[[str], None]) -> None:
    """Take steps and fill in the track, so that it holds what there is whenever this is interrupted."""
    every = max(1, math.ceil(steps / SAMPLES))
    start, first = world.bodies.position.copy(), world.energy()
    moving = world.bodies.kind == "dynamic"
    track.bodies = len(world.bodies)
    for step in range(1, steps + 1):
        began = time.perf_counter()
        try:
            world.step(track.dt)
        except DivergenceError as error:
            track.error = str(error)
            return
        if step > 1:
            track.wall.append(time.perf_counter() - began)
        track.steps = step
        if step % every == 0 or step == steps:
            residuals, energy = world.residuals(), world.energy()
            away = np.linalg.norm(world.bodies.position - start, axis=1)[moving]
            for name, value in (
                ("complementarity", _greatest(residuals.complementarity)),
                ("cone", _greatest(residuals.cone)),
                ("depth", max(_greatest(residuals.depth) or 0.0, 0.0)),
                ("kinetic", energy.kinetic),
                ("gained", energy.total - first.total),
                ("drift", _greatest(away)),
            ):
                track.columns[name].append(value or 0.0)
            track.times.append(world.time)
            track.contacts = len(world.contacts)
        report(f"{track.contender.title}: round {step} of {steps}")
    track.sweeps = residuals_of_sweeps(world, track.dt)


def residuals_of_sweeps(world: World, dt: float) -> list[float]:
    """Greatest complementarity residual after each sweep of a step that a copy of the world takes [N s]; none if it diverges."""
    other = copy.deepcopy(world)
    other.trace_solver = True
    try:
        other.step(dt)
    except DivergenceError:
        return []
    trace = other.solver_trace
    sweeps: list[float] = trace.complementarity[trace.kind != "end"].tolist()
    return sweeps


def _greatest(values: Any) -> float | None:
    return float(max(values)) if len(values) else None


def plot(path: Path, tracks: Sequence[Track], title: str) -> Path:
    """Draw the columns over time, the time per step, and how residuals change over the sweeps of a step."""
    plt = pyplot()
    look = styles([(track.contender.name, track.contender.title, False) for track in tracks])
    figure, axes = plt.subplots(2, 4, figsize=(15, 6.6))
    for panel, (name, label) in zip(axes.flat, COLUMNS.items(), strict=False):
        values = [value for track in tracks for value in track.columns[name] if value > 0]
        for track in tracks:
            panel.plot(track.times, track.columns[name], **look[track.contender.title])
        if name != "gained" and values:
            panel.set_yscale("log")
            panel.set_ylim(max(0.5 * min(values), 1e-6 * max(values)), 2 * max(values))
        elif not values and name != "gained":
            panel.text(0.5, 0.5, "none", transform=panel.transAxes, ha="center", va="center", color="gray")
        panel.set_title(label, fontsize=9)
        panel.tick_params(labelsize=8)
        panel.grid(alpha=0.25)
    panel = axes.flat[len(COLUMNS) + 1]
    for track in tracks:
        panel.plot(range(1, 1 + len(track.sweeps)), track.sweeps, marker=".", **look[track.contender.title])
    if any(value > 0 for track in tracks for value in track.sweeps):
        panel.set_yscale("log")
    panel.set_title("complementarity residual over the sweeps of a step [N s]", fontsize=9)
    panel.set_xlabel("sweep", fontsize=8)
    panel.tick_params(labelsize=8)
    panel.grid(alpha=0.25)
    panel = axes.flat[len(COLUMNS)]
    costs = [1e3 * statistics.median(track.wall) if track.wall else 0.0 for track in tracks]
    bars = panel.barh(range(len(tracks)), costs, color=[look[track.contender.title]["color"] for track in tracks])
    panel.bar_label(bars, [f" {cost:.3g} ms" for cost in costs], fontsize=8)
    panel.set_yticks([])
    panel.set_xlim(0, 1.35 * max([*costs, 1e-9]))
    panel.invert_yaxis()
    panel.set_title("time per step, median [ms]", fontsize=9)
    panel.tick_params(labelsize=8)
    return finish(figure, path, [(name, look[name]) for name in look], f"{title}: time [s]")
