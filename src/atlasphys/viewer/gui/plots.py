"""Plots that run along."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Any

import numpy as np

from atlasphys.engine.step import STAGES

if TYPE_CHECKING:
    from atlasphys.viewer.frame import Frame
    from atlasphys.viewer.gui.page import Page

SAMPLES = 300
"""Points of a curve: at five a second, a minute."""

COLOURS = ("#4e79a7", "#f28e2b", "#59a14f", "#e15759", "#76b7b2", "#b07aa1", "#9c755f")
HEIGHT = 170

CURVES = {
    "Energy [J]": ("kinetic", "potential", "total"),
    "Momentum [kg m/s]": ("x", "y", "z"),
    "Contact points": ("contacts",),
    "Time per stage [ms]": STAGES,
}


class Plots:
    """Energy by kind, momentum, contact count and time per stage against simulated time."""

    def __init__(self, page: Page) -> None:
        self._page = page
        gui = page.server.gui
        on = gui.add_checkbox("Plots run along", page.shown.plots, hint="They take about a percent of a processor")
        on.on_update(lambda event: self._switch(event.target.value))
        self._samples: deque[tuple[float, ...]] = deque(maxlen=SAMPLES)
        start = np.zeros(1)
        self._plots = {
            title: gui.add_uplot(
                (start, *(start for _ in names)),
                (
                    {},
                    *(
                        {"label": name, "stroke": colour, "width": 1.5}
                        for name, colour in zip(names, COLOURS, strict=False)
                    ),
                ),
                title=title,
                axes=({"size": 28}, {"size": 78}),
                scales={"x": {"time": False}},
                legend={"show": len(names) > 1},
                height=HEIGHT + (25 if len(names) < 4 else 50),
            )
            for title, names in CURVES.items()
        }

    def _switch(self, value: bool) -> None:
        self._page.shown.plots = value
        self._page.update_wanted()

    def refresh(self, frame: Frame) -> None:
        """Take a sample and draw, if time has passed."""
        if frame.energy is None or frame.momentum is None or not self._page.shown.plots:
            return
        if self._samples and frame.time == self._samples[-1][0]:
            return
        while self._samples and self._samples[-1][0] >= frame.time:  # stepped back, or another world
            self._samples.pop()
        stages = (1e3 * frame.stages.get(name, 0.0) for name in STAGES)
        self._samples.append(
            (frame.time, *frame.energy, sum(frame.energy), *frame.momentum.tolist(), frame.contact_count, *stages)
        )
        columns = np.array(self._samples).T
        first = 1
        for title, names in CURVES.items():
            data: tuple[Any, ...] = (columns[0], *columns[first : first + len(names)])
            first += len(names)
            self._plots[title].data = data
