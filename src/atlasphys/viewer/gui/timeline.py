"""The controls of a recording."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from atlasphys.viewer.frame import Frame
    from atlasphys.viewer.gui.page import Page


class Timeline:
    """Play, pause, scrub, loop."""

    def __init__(self, page: Page) -> None:
        self._page = page
        gui = page.server.gui
        self._status = gui.add_html("")
        buttons = gui.add_button_group(
            "Recording", ("Play", "Pause", "Step", "Back", "Start"), hint="Space, N, B, R on the keyboard"
        )
        commands = {
            "Play": lambda replay: replay.start(),
            "Pause": lambda replay: replay.stop(),
            "Step": lambda replay: replay.step(1),
            "Back": lambda replay: replay.step(-1),
            "Start": lambda replay: replay.seek(0),
        }
        buttons.on_click(lambda event: page.do(commands[event.target.value], event.client))
        last = max(1, page.simulation.model.last_step)  # type: ignore[attr-defined]
        self._slider = gui.add_slider("Timeline", 0, last, 1, 0, hint="Recorded step")
        self._slider.on_update(self._scrub)
        self._speed = gui.add_number("Speed", 1.0, min=0.01, max=100.0, step=0.1, hint="Recorded seconds per second")
        self._speed.on_update(self._set_speed)
        self._loop = gui.add_checkbox("Loop", True)
        self._loop.on_update(self._set_loop)

    def _scrub(self, event: Any) -> None:
        if event.client is not None:
            step = int(event.target.value)
            self._page.do(lambda replay: replay.seek(step), event.client)

    def _set_speed(self, event: Any) -> None:
        if event.client is not None:
            factor = float(event.target.value)
            self._page.do(lambda replay: replay.set_speed(factor), event.client)

    def _set_loop(self, event: Any) -> None:
        value = bool(event.target.value)
        self._page.do(lambda replay: setattr(replay, "loop", value), event.client)

    def toggle(self, client: Any = None) -> None:
        """Play if paused, else pause."""
        self._page.do(lambda replay: replay.stop() if replay.running else replay.start(), client)

    def refresh(self, frame: Frame) -> None:
        """Show the clock."""
        from atlasphys.viewer.gui.transport import status

        self._status.content = status(frame, "", self._page.dark)
        if self._slider.value != frame.steps:
            self._slider.value = frame.steps
