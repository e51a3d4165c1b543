"""The page in the browser: its server, what is selected and shown, and the thread that draws frames."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any

from atlasphys.errors import AtlasPhysError
from atlasphys.viewer.frame import Frame
from atlasphys.viewer.gui.camera import Cameras
from atlasphys.viewer.gui.close_up import CloseUps
from atlasphys.viewer.gui.joints import Joints
from atlasphys.viewer.gui.look import Look
from atlasphys.viewer.gui.objects import Objects
from atlasphys.viewer.gui.plots import Plots
from atlasphys.viewer.gui.scenes import Scenes
from atlasphys.viewer.gui.server import address, serve, stop
from atlasphys.viewer.gui.shortcuts import add_shortcuts
from atlasphys.viewer.gui.show import Show
from atlasphys.viewer.gui.stage import Stage
from atlasphys.viewer.gui.timeline import Timeline
from atlasphys.viewer.gui.transport import Transport
from atlasphys.viewer.gui.world import WorldSettings
from atlasphys.viewer.meter import Beat
from atlasphys.viewer.simulation import Model, Simulation

FRAME_TIME = 1 / 30
"""Time between two drawings [s]."""

PANEL_WIDTH = 450
"""Of the panel beside the scene [pixels]."""

REFRESH_TIME = 0.2
"""Time between two refreshes of numbers and plots [s]."""


@dataclass
class Shown:
    """What is drawn beside the bodies."""

    plane: bool = True
    grid: bool = True
    axes: bool = False
    velocity: bool = False
    force: bool = False
    impulse: bool = False
    contacts: bool = False
    normals: bool = False
    boxes: bool = False
    joints: bool = True
    islands: bool = False
    sleeping: bool = True
    centers: bool = False
    shadows: bool = True
    plots: bool = True
    arrow_size: float = 1.0

    @property
    def needs_contacts(self) -> bool:
        """Whether something is drawn from contact points."""
        return self.impulse or self.contacts or self.normals or self.islands


class Page:
    """A page that shows a model, at :attr:`url`, until :meth:`close`.

    Args:
        model: a session or a replay. The page alone may use it from now on, by :meth:`do`.
        port: port to be served at; None: 8080, or the next that is free; 0: any.
        shown: what is drawn beside the bodies at first.
        dark: whether colours are dark at first.

    Raises:
        MissingExtraError: viser is not installed.
        InvalidArgumentError: the port is in use.
    """

    def __init__(
        self, model: Model, *, port: int | None = None, shown: Shown | None = None, dark: bool = False
    ) -> None:
        self.server = serve(port)
        self.is_replay = not hasattr(model, "world")
        self.shown = shown or Shown()
        self.selected: int | None = None
        """Id of the selected body."""
        self.selected_before: int | None = None
        """Id of the body that was selected before it."""
        self.selected_joint: int | None = None
        """Id of the selected joint."""
        self.dark = dark
        self.simulation = Simulation(model)
        self._dirty = True
        self._ended = threading.Event()
        self.frames_drawn = 0
        self.server.gui.main_panel.set_width(PANEL_WIDTH)
        self.server.gui.main_panel.dock_right()
        with self.server.atomic():
            self.look = Look(self)
            self.apply_theme()
            self.stage = Stage(self)
            self.cameras = Cameras(self)
            self.close_ups = CloseUps(self)
            self.transport = Timeline(self) if self.is_replay else Transport(self)
            tabs = self.server.gui.add_tab_group()
            self.parts: list[Any] = [self.transport, self.look]
            with tabs.add_tab("Objects"):
                self.objects = Objects(self)
                self.parts.append(self.objects)
            if not self.is_replay:
                with tabs.add_tab("Joints"):
                    self.joints = Joints(self)
                    self.parts.append(self.joints)
                with tabs.add_tab("World"):
                    self.parts.append(WorldSettings(self))
            with tabs.add_tab("Show"):
                self.show = Show(self)
            with tabs.add_tab("Camera"):
                self.cameras.add_controls()
            if not self.is_replay:
                with tabs.add_tab("Plots"):
                    self.parts.append(Plots(self))
                with tabs.add_tab("Scene"):
                    Scenes(self)
            with tabs.add_tab("Help"):
                add_shortcuts(self)
        self.server.on_client_connect(lambda client: self.redraw())
        self.update_wanted()
        self._painter = threading.Thread(target=self._paint, name="painter", daemon=True)
        self._painter.start()

    @property
    def url(self) -> str:
        """Address of the page."""
        return address(self.server)

    @property
    def frame(self) -> Frame:
        """The newest frame."""
        return self.simulation.frame

    # What parts call -------------------------------------------------------------------------------------------------

    def do(self, command: Callable[[Any], Any], client: Any = None) -> Future[Any]:
        """Queue a command for the model. If it is refused, the reason is shown to the client, or to all."""
        future = self.simulation.do(command)
        future.add_done_callback(lambda done: self._report(done, client))
        return future

    def _report(self, done: Future[Any], client: Any) -> None:
        error = None if done.cancelled() else done.exception()
        if error is not None and not self._ended.is_set():
            self.say("Refused" if isinstance(error, AtlasPhysError) else "Failed", str(error) or repr(error), client)

    def say(self, title: str, text: str, client: Any = None) -> None:
        """Show a notice to a client, or to all."""
        for one in self.server.get_clients().values() if client is None else (client,):
            one.add_notification(title, text, color="red", auto_close_seconds=8.0)

    def select(self, identity: int | None) -> None:
        """Select a body, or none."""
        if identity != self.selected:
            self.selected_before = None if identity is None else self.selected
        self.selected = identity
        self.update_wanted()
        self.redraw()

    def select_joint(self, identity: int | None) -> None:
        """Select a joint, or none."""
        self.selected_joint = identity

        def want(model: Any) -> None:
            model.joint_wanted = identity
            model.changes += 1

        self.do(want)
        self.redraw()

    def redraw(self) -> None:
        """Draw again, though the frame is the same."""
        self._dirty = True

    def update_wanted(self) -> None:
        """Tell the model what frames must hold."""
        contacts, totals = self.shown.needs_contacts or self.selected is not None, self.shown.plots
        selected = self.selected

        def want(model: Any) -> None:
            model.contacts_wanted, model.totals_wanted, model.body_wanted = contacts, totals, selected
            model.changes += 1

        self.do(want)

    def apply_theme(self) -> None:
        """Dark or light."""
        self.server.gui.configure_theme(
            dark_mode=self.dark, show_logo=False, show_share_button=False, brand_color=(54, 104, 176)
        )
        self.look.apply_theme()

    def close(self) -> None:
        """Stop serving, and end the threads."""
        if not self._ended.is_set():
            self._ended.set()
            self.close_ups.close()
            self._painter.join(timeout=5.0)
            self.simulation.end()
            stop(self.server)

    # Drawing ---------------------------------------------------------------------------------------------------------

    def _paint(self) -> None:
        drawn: Frame | None = None
        refreshed, beat = 0.0, Beat(FRAME_TIME)
        while not self._ended.wait(beat.wait(time.perf_counter())):
            start = time.perf_counter()
            frame = self.simulation.frame if self._dirty else self.simulation.wait_for_news(drawn or self.frame, 0.1)
            if frame is not drawn or self._dirty:
                beat.tick(start)
                self._dirty = False
                with self.server.atomic():
                    self.stage.draw(frame)
                    self.cameras.follow(frame)
                drawn = frame
                self.frames_drawn += 1
            if start - refreshed >= REFRESH_TIME:
                refreshed = start
                with self.server.atomic():
                    for part in self.parts:
                        part.refresh(frame)
