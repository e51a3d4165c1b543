"""The explorer's page: buttons, words, plots, and shapes that can be dragged."""

from __future__ import annotations

import math
import queue
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from html import escape
from typing import Any

import numpy as np

from atlasphys.errors import AtlasPhysError
from atlasphys.explainer import STAGES
from atlasphys.explainer.slides import page_text
from atlasphys.explainer.slides.solids import Floats
from atlasphys.explainer.slides.svg import FROM_ABOVE, FROM_THE_FRONT
from atlasphys.viewer.explorer.explorer import Explorer
from atlasphys.viewer.explorer.scene import Scene
from atlasphys.viewer.gui.plots import COLOURS
from atlasphys.viewer.gui.server import address, serve, stop

PANEL_WIDTH = 470
"""Of the panel with the words [pixels]."""

ANGLE = math.radians(40.0)
FLAT_ANGLE = math.radians(2.0)
"""Vertical angle of view, in space and in the plane: the page has no orthographic camera."""

PATIENCE = 2.0
"""Time that each slide is shown while it plays [s]."""

KEYS = "**N** next step, **B** previous, **space** play or pause, **R** restart."

HOW = (
    "**Left drag on a shape** moves it, and the engine runs anew. The handles move it along an axis and turn it. Left drag on empty space orbits, "
    "right drag pans, the wheel zooms.\n\n" + KEYS
)


class Page:
    """A page that shows an explorer, at :attr:`url`, until :meth:`close`.

    Args:
        explorer: the page alone may use it from now on, by :meth:`do`.
        port: port to be served at; None: 8080, or the next that is free; 0: any.

    Raises:
        MissingExtraError: viser is not installed.
        InvalidArgumentError: the port is in use.
    """

    def __init__(self, explorer: Explorer, *, port: int | None = None) -> None:
        self.server = serve(port)
        self.explorer = explorer
        self.playing = False
        self.patience = PATIENCE
        self.wants_plane = True
        """Whether a run that stays in a plane is drawn as a figure in the plane."""
        self._due = 0.0
        self._drawn = -1
        self._commands: queue.SimpleQueue[tuple[Callable[[Explorer], Any], Future[Any]] | None] = queue.SimpleQueue()
        self._dragged: dict[int, tuple[Floats, Floats]] = {}
        self._grabbed: dict[int, tuple[Floats, Floats, Floats]] = {}
        self._held = False
        self._bound: dict[int, Any] = {}
        self._was_flat = False
        self._plots: list[Any] = []
        gui = self.server.gui
        gui.configure_theme(dark_mode=False, show_logo=False, show_share_button=False, brand_color=(54, 104, 176))
        gui.set_panel_label("Algorithm explorer")
        gui.main_panel.set_width(PANEL_WIDTH)
        gui.main_panel.dock_right()
        with self.server.atomic():
            self.scene = Scene(self.server, explorer)
            self._add_controls()
            self._add_handles()
            self._bind_bodies()
            self._add_keys()
            self.draw()
        self._place_first_camera()
        self.server.on_client_connect(self._connected)
        self._thread = threading.Thread(target=self._run, name="explorer", daemon=True)
        self._thread.start()

    @property
    def url(self) -> str:
        """Address of the page."""
        return address(self.server)

    def do(self, command: Callable[[Explorer], Any], client: Any = None) -> Future[Any]:
        """Queue a command for the explorer. What the world refuses is said on the page."""
        future: Future[Any] = Future()
        future.add_done_callback(lambda done: self._report(done, client))
        self._commands.put((command, future))
        return future

    def close(self) -> None:
        """Stop serving, and end the thread."""
        if self._thread.is_alive():
            self._commands.put(None)
            self._thread.join(timeout=10.0)
            stop(self.server)

    # What there is to press ------------------------------------------------------------------------------------------

    def _add_controls(self) -> None:
        gui, explorer = self.server.gui, self.explorer
        self._heading = gui.add_html("")
        self._stage = gui.add_dropdown("Stage", STAGES, initial_value=explorer.stage)
        self._stage.on_update(lambda event: self._chosen(event.target.value, event.client))
        next_ = gui.add_button("Next step", hint="N on the keyboard")
        next_.on_click(lambda event: self._by_hand(Explorer.next))
        buttons = gui.add_button_group("Run", ("Previous", "Play", "Restart"))
        buttons.on_click(lambda event: self._pressed(event.target.value))
        self._number = gui.add_slider("Slide", 1, 2, 1, 1)
        self._number.on_update(lambda event: self._slid(event.target.value))
        self._words = gui.add_html("")
        self._charts = gui.add_folder("Plots", visible=False)
        with gui.add_folder("Look", expand_by_default=False):
            self._plane = gui.add_checkbox(
                "In the plane", True, hint="Draw GJK of flat prisms as a figure in the plane (2D)"
            )
            self._plane.on_update(lambda event: self._set_plane(event.target.value))
            handles = gui.add_checkbox("Handles", False, hint="Arrows and rings that move and turn the shapes")
            handles.on_update(lambda event: self._show_handles(event.target.value))
            speed = gui.add_slider("Seconds a step", 0.2, 6.0, 0.1, PATIENCE)
            speed.on_update(lambda event: setattr(self, "patience", float(event.target.value)))
            gui.add_button("Put the shapes back").on_click(lambda event: self.do(Explorer.put_back, event.client))
            gui.add_button("Show all of it", hint="The camera to where it was").on_click(
                lambda event: self._show_all(event.client)
            )
        gui.add_markdown(HOW)

    def _add_keys(self) -> None:
        for key, label, action in (
            ("N", "Next step", lambda: self._by_hand(Explorer.next)),
            ("B", "Previous step", lambda: self._by_hand(Explorer.previous)),
            ("space", "Play or pause", self.play_or_pause),
            ("R", "Restart", lambda: self._by_hand(Explorer.restart)),
        ):
            command = self.server.gui.add_command(label, hotkey=key)
            command.on_trigger(lambda event, action=action: action())

    def _pressed(self, name: str) -> None:
        if name == "Play":
            self.play_or_pause()
        else:
            self._by_hand(Explorer.previous if name == "Previous" else Explorer.restart)

    def _by_hand(self, command: Callable[[Explorer], Any]) -> None:
        self.playing = False
        self.do(command)

    def play_or_pause(self) -> None:
        """Play from here, from the beginning if this is the end, or pause."""

        def turn(explorer: Explorer) -> None:
            self.playing = not self.playing
            if self.playing and explorer.is_at_end:
                explorer.restart()
            self._due = time.monotonic() + self.patience
            explorer.changes += 1

        self.do(turn)

    def _slid(self, number: int) -> None:
        if number - 1 != self.explorer.index:
            self._by_hand(lambda explorer: explorer.go(number - 1))

    def _chosen(self, stage: str, client: Any) -> None:
        if stage != self.explorer.stage:
            self.playing = False

            def show(explorer: Explorer) -> None:
                explorer.show(stage)
                self._fit(explorer)

            self.do(show, client)

    def _show_all(self, client: Any) -> None:
        self.do(self._fit, client)

    def _fit(self, explorer: Explorer) -> None:
        self.scene.fit(explorer)
        explorer.changes += 1
        for client in self.server.get_clients().values():
            self._place_camera(client)

    def _set_plane(self, value: bool) -> None:
        self.wants_plane = value
        if value and not self.explorer.pair.is_flat:
            self._say(
                "In space",
                "This pair is no pair of flat prisms along z, so it has no figure in the plane; the scene polygons has.",
                None,
            )
        self.do(lambda explorer: explorer.go(explorer.index))

    # Shapes that are moved -------------------------------------------------------------------------------------------

    def _bind_bodies(self) -> None:
        """Have the shapes' meshes answer the mouse, once they are made anew."""
        for which, (_, handles) in enumerate(self.scene.bodies):
            if self._bound.get(which) is not handles[0] and self.explorer.can_move(which):
                handles[0].on_drag("left")(self._drag_of(which))
                self._bound[which] = handles[0]

    def _drag_of(self, which: int) -> Callable[[Any], Any]:
        async def dragged(event: Any) -> None:  # a coroutine, so that the phases come in order
            if event.phase == "start":
                position, orientation = self.explorer.pose(which)
                self._grabbed[which] = (np.array(event.start_position), position, orientation)
            start, position, orientation = self._grabbed[which]
            self.put(which, position + (np.array(event.end_position) - start), orientation)

        return dragged

    def put(self, which: int, position: Floats, orientation: Floats) -> None:
        """Move A (0) or B (1), as soon as the engine is done with the place before."""
        if self.explorer.pair.is_flat and self.wants_plane:
            before, _ = self.explorer.pose(which)
            position = np.array((position[0], position[1], before[2]))
            w, z = orientation[0], orientation[3]
            orientation = np.array((w, 0.0, 0.0, z)) / math.hypot(w, z)
        waiting = bool(self._dragged)
        self._dragged[which] = (position, orientation)
        if not waiting:
            self.do(self._follow)

    def _follow(self, explorer: Explorer) -> None:
        poses, self._dragged = self._dragged, {}
        explorer.move(poses)

    def _add_handles(self) -> None:
        self._gizmos = []
        for which, name in enumerate("ab"):
            gizmo = self.server.scene.add_transform_controls(
                f"/shapes/handles_{name}",
                0.6 * self.explorer.pair.size,
                depth_test=False,
                disable_sliders=True,
                visible=False,
            )

            async def turned(event: Any, which: int = which) -> None:
                self._held = event.phase != "end"
                place = np.array(event.target.position) + self.scene.middles[0]
                self.put(which, place, np.array(event.target.wxyz))

            gizmo.on_update(turned)
            self._gizmos.append(gizmo)

    def _show_handles(self, value: bool) -> None:
        for which, gizmo in enumerate(self._gizmos):
            gizmo.visible = value and self.explorer.can_move(which)

    # Cameras ---------------------------------------------------------------------------------------------------------

    @property
    def is_flat(self) -> bool:
        """Whether the present figure lies in the plane."""
        return self.wants_plane and self.explorer.stage == "gjk" and self.explorer.pair.is_flat

    def _place_first_camera(self) -> None:
        camera = self.server.initial_camera
        position = self._eye(1.2)
        camera.position, camera.look_at = tuple(position), (0.0, 0.0, 0.0)
        camera.fov = FLAT_ANGLE if self.is_flat else ANGLE
        camera.near, camera.far = 0.01 * float(np.linalg.norm(position)), 10 * float(np.linalg.norm(position))

    def _eye(self, aspect: float) -> Floats:
        """Where a camera of such an aspect ratio sees both scenes."""
        beside = any(slide.beside for slide in self.explorer.slides)
        angle = FLAT_ANGLE if self.is_flat else ANGLE
        reach = self.scene.radius * max(1.2, (2.1 if beside else 1.2) / max(aspect, 0.3))
        towards = np.array(FROM_THE_FRONT if self.is_flat else FROM_ABOVE)
        eye: Floats = towards / np.linalg.norm(towards) * reach / math.tan(angle / 2)
        return eye

    def _place_camera(self, client: Any) -> None:
        eye = self._eye(client.camera.aspect)
        distance = float(np.linalg.norm(eye))
        with client.atomic():
            client.camera.fov = FLAT_ANGLE if self.is_flat else ANGLE
            client.camera.max_orbit_distance = float("inf")
            client.camera.near, client.camera.far = 0.01 * distance, 10 * distance
            client.camera.position, client.camera.look_at = tuple(eye), (0.0, 0.0, 0.0)

    def _connected(self, client: Any) -> None:
        self._place_camera(client)
        aspect = 0.0

        def moved(camera: Any) -> None:
            nonlocal aspect
            if (
                abs(camera.aspect - aspect) > 0.02 * aspect
            ):  # the window, or the panel beside the picture, has another size
                aspect = camera.aspect
                self._place_camera(client)
            self._turn(camera)

        client.camera.on_update(moved)

    def _turn(self, camera: Any) -> None:
        """Keep the two scenes beside each other as this camera sees them."""
        forward = np.array(camera.look_at) - camera.position
        right = np.cross(forward, (0.0, 1.0, 0.0))
        if np.linalg.norm(right) > 1e-6 * np.linalg.norm(forward):
            right /= np.linalg.norm(right)
            up = np.cross(right, forward)
            with self.server.atomic():
                self.scene.arrange(right, up / np.linalg.norm(up), self.explorer)

    # Drawing ---------------------------------------------------------------------------------------------------------

    def draw(self) -> None:
        """Show the explorer's slide."""
        explorer = self.explorer
        self._drawn = explorer.changes
        slide, flat = explorer.slide, self.is_flat
        if flat != self._was_flat:
            self._was_flat = flat
            for client in self.server.get_clients().values():
                self._place_camera(client)
        self.scene.draw(explorer, flat)
        self._bind_bodies()
        for which, gizmo in enumerate(self._gizmos):
            if not self._held:
                position, orientation = explorer.pose(which)
                gizmo.position, gizmo.wxyz = tuple(position - self.scene.middles[0]), tuple(orientation)
        self._heading.content = (
            f'<div style="padding:0.4em 0.9em 0;font-size:0.85em;color:#4a525c">{escape(explorer.heading)}</div>'
        )
        if self._stage.value != explorer.stage:
            self._stage.value = explorer.stage
        number, count = explorer.index + 1, len(explorer.slides)
        if self._number.max != max(count, 2):
            self._number.max = max(count, 2)
        if self._number.value != number:
            self._number.value = number
        self._number.disabled = count == 1
        remark = explorer.slides.remark if explorer.index == 0 else ""
        said = f'<p style="color:#69727d;font-size:0.85em">{escape(remark)}</p>' if remark else ""
        state = " · playing" if self.playing else ""
        self._words.content = (
            f'<div id="slide" style="padding:0 0.9em;font-size:0.92em;line-height:1.45">'
            f'<div style="color:#69727d;font-size:0.85em">{number} of {count}{state}</div>'
            f'<h3 id="title" style="margin:0.1em 0 0.3em;font-size:1.15em">{escape(slide.title)}</h3>{said}{page_text(slide)}</div>'
        )
        self._draw_charts()

    def _draw_charts(self) -> None:
        charts = self.explorer.slide.charts
        self._charts.visible = bool(charts)
        kept = [chart.title for chart in charts] == [plot.title for plot in self._plots] and all(
            len(plot.data) == len(chart.curves) + 1 for plot, chart in zip(self._plots, charts, strict=True)
        )
        if charts and not kept:
            for plot in self._plots:
                plot.remove()
            with self._charts:
                self._plots = [self._plot(chart.title, tuple(chart.curves)) for chart in charts]
        for plot, chart in zip(self._plots, charts, strict=False):
            plot.data = (np.array(chart.across), *(np.array(curve) for curve in chart.curves.values()))

    def _plot(self, title: str, names: tuple[str, ...]) -> Any:
        start = np.zeros(1)
        curves = (
            {"label": name, "stroke": colour, "width": 2} for name, colour in zip(names, COLOURS * 4, strict=False)
        )
        return self.server.gui.add_uplot(
            (start, *(start for _ in names)), ({}, *curves), title=title, axes=({"size": 28}, {"size": 78}),
            scales={"x": {"time": False}}, legend={"show": True}, height=200,
        )  # fmt: skip

    # The thread ------------------------------------------------------------------------------------------------------

    def _run(self) -> None:
        while True:
            wait = max(0.0, self._due - time.monotonic()) if self.playing else None
            try:
                item = self._commands.get(timeout=wait)
            except queue.Empty:
                item = self._go_on, Future()
            if item is None:
                return
            command, future = item
            try:
                future.set_result(command(self.explorer))
            except BaseException as error:  # whoever waits for the future shall see it
                future.set_exception(error)
            if self.explorer.changes != self._drawn and self._commands.empty():
                with self.server.atomic():
                    self.draw()

    def _go_on(self, explorer: Explorer) -> None:
        explorer.next()
        self._due = time.monotonic() + self.patience
        if explorer.is_at_end:
            self.playing = False

    def _report(self, done: Future[Any], client: Any) -> None:
        error = done.exception()
        if error is not None:
            self._say("Refused" if isinstance(error, AtlasPhysError) else "Failed", str(error) or repr(error), client)

    def _say(self, title: str, text: str, client: Any) -> None:
        for one in self.server.get_clients().values() if client is None else (client,):
            one.add_notification(title, text, color="red", auto_close_seconds=8.0)
