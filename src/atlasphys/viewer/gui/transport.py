"""Start, stop, step, and how fast it goes."""

from __future__ import annotations

import html
import time
from typing import TYPE_CHECKING, Any

from atlasphys.viewer.session import FASTEST, SLOWEST, Session

if TYPE_CHECKING:
    from atlasphys.viewer.frame import Frame
    from atlasphys.viewer.gui.page import Page

LONG = 1.0
"""A step that takes this long is explained [s]."""


SHARE = 0.02
"""Stages that take less of a step are not named."""


class Transport:
    """The buttons of a live world, and its clock."""

    def __init__(self, page: Page) -> None:
        self._page = page
        gui = page.server.gui
        self._status = gui.add_html("")
        self._buttons = gui.add_button_group(
            "Time", ("Start", "Stop", "Step", "Back", "Reset"), hint="Space, N, B, R on the keyboard"
        )
        self._speed = gui.add_number(
            "Speed", 1.0, min=SLOWEST, max=FASTEST, step=0.1, hint="Simulated seconds per second"
        )
        commands = {
            "Start": Session.start, "Stop": Session.stop, "Step": Session.step, "Back": Session.step_back, "Reset": Session.reset,
        }  # fmt: skip
        self._buttons.on_click(lambda event: page.do(commands[event.target.value], event.client))
        self._speed.on_update(self._set_speed)
        self._error = ""

    def _set_speed(self, event: Any) -> None:
        if event.client is not None:
            factor = float(event.target.value)
            self._page.do(lambda session: session.set_speed(factor), event.client)

    def toggle(self, client: Any = None) -> None:
        """Start if stopped, else stop."""
        self._page.do(lambda session: session.stop() if session.running else session.start(), client)

    def refresh(self, frame: Frame) -> None:
        """Show clock, speed and errors."""
        self._status.content = status(frame, self._waiting(), self._page.dark)
        if frame.error != self._error:
            self._error = frame.error
            if frame.error:
                self._page.say("The simulation stopped", frame.error)
        if frame.settings["speed"] != self._speed.value:
            self._speed.value = frame.settings["speed"]

    def _waiting(self) -> str:
        since = self._page.simulation.busy_since
        if since is None or (seconds := time.monotonic() - since) < LONG:
            return ""
        return f"computing for {seconds:.0f} s: the first steps compile kernels, once for each kind of shape and solver"


def status(frame: Frame, waiting: str, dark: bool = False) -> str:
    """The clock as HTML."""
    total = sum(frame.stages.values())
    large = [(name, 1e3 * seconds) for name, seconds in frame.stages.items() if seconds > max(5e-6, SHARE * total)]
    stages = ", ".join(f"{name} {milliseconds:.2f}" for name, milliseconds in large)
    state = "running" if frame.running else "stopped"
    factor = f" at {frame.real_time_factor:.2f} × real time" if frame.running else ""
    asleep = int(frame.asleep.sum())
    lines = [
        f"<b style='font-size:1.25em'>{frame.time:.3f} s</b> &nbsp; step {frame.steps}, {state}{factor}",
        f"<b>{html.escape(frame.title)}</b>: {len(frame.table)} bodies"
        + (f" ({asleep} asleep)" if asleep else "")
        + f", {frame.contact_count} contact points",
    ]
    if not frame.is_recorded:
        lines.append(f"{1e3 * total:.2f} ms a step" + (f": {stages}" if stages else ""))
    if waiting:
        lines.append(f"<i>{waiting}</i>")
    if frame.error:
        colour = "#ff8a80" if dark else "#c62828"
        lines.append(f"<span style='color:{colour}'><b>Stopped:</b> {html.escape(frame.error)}</span>")
    body = "<br>".join(lines)
    return f"<div style='font-size:0.82em;line-height:1.45;padding:0.3em 0.9em 0.2em'>{body}</div>"
