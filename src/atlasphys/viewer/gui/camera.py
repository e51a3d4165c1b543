"""Where each page looks from: presets, projection, close-up, sensitivity of the mouse, and balls shot from there.

Orbiting, panning, zooming and flying with W A S D Q E are the page's own. It has no orthographic camera, so a far one with a very small angle of view
stands in for it. Its mouse speeds are not open to the server; a snippet in the page sets them.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from atlasphys.viewer.frame import Frame
from atlasphys.viewer.viewpoint import FIELD_OF_VIEW, view_from

if TYPE_CHECKING:
    from atlasphys.viewer.gui.page import Page

ANGLE = math.radians(FIELD_OF_VIEW)

NARROW = 0.02
"""Angle of view of what stands in for an orthographic camera [rad]. Smaller: more parallel, and rounder errors of single precision."""

BALL_RADIUS, BALL_SPEED = 0.35, 20.0
"""Of a ball that is shot, the radius in widths of a typical body, the speed in m/s."""

CLOSE = 5.0
"""Distance of a close-up, in widths of the body."""

SNIPPET = """<img src="data:," style="display:none" onerror="(function set() {
  const c = window.__viserMutable && window.__viserMutable.cameraControl;
  if (!c) { setTimeout(set, 200); return; }
  c.azimuthRotateSpeed = c.polarRotateSpeed = SPEED; c.truckSpeed = 2 * SPEED; c.dollySpeed = 0.3 * SPEED; })()">"""


class Cameras:
    """The cameras of all pages that are open."""

    def __init__(self, page: Page) -> None:
        self._page = page
        self._closed_up: dict[int, tuple[int, Any, tuple[Any, Any]]] = {}
        self._orthographic: set[int] = set()
        self._fit_serial: object = None
        server = page.server
        server.scene.set_up_direction("+y")
        self._begin_with(page.frame)
        server.initial_camera.fov = ANGLE
        server.initial_camera.far = 5000.0
        server.on_client_disconnect(lambda client: self._forget(client.client_id))

    def _begin_with(self, frame: Frame) -> None:
        """Let pages that are opened from now on see everything."""
        start = view_from("oblique", frame)
        camera = self._page.server.initial_camera
        camera.position, camera.look_at = tuple(start.position), tuple(start.look_at)

    def add_controls(self) -> None:
        """The tab about cameras."""
        page, gui = self._page, self._page.server.gui
        view = gui.add_button_group("View", ("Oblique", "Front", "Top"))
        side = gui.add_button_group("", ("Left", "Right", "Back"))
        for group in (view, side):
            group.on_click(lambda event: self.look(event.client, event.target.value.lower()))
        self._projection = gui.add_button_group("Projection", ("Perspective", "Orthographic"))
        self._projection.on_click(lambda event: self.project(event.client, event.target.value == "Orthographic"))
        sensitivity = gui.add_slider("Mouse sensitivity", 0.1, 3.0, 0.1, 1.0, hint="Of orbiting, panning and zooming")
        self._snippet = gui.add_html("")
        sensitivity.on_update(lambda event: self._set_sensitivity(event.target.value))
        if not page.is_replay:
            gui.add_button("Shoot a ball from here", hint="T on the keyboard").on_click(
                lambda event: self.shoot(event.client)
            )
        gui.add_markdown(
            "**Left drag** on empty space orbits, **right drag** pans, **wheel** zooms, **W A S D Q E** fly, **arrow keys** turn."
            + ("" if page.is_replay else " **Left drag** on a body pulls it; let go to throw it.")
        )

    def add_close_up_buttons(self) -> None:
        """The buttons of the close-ups."""
        page = self._page
        buttons = page.server.gui.add_button_group(
            "Close-up",
            ("In a window", "With the camera"),
            hint="Follow the selected body, or no longer; K and F on the keyboard",
        )
        buttons.on_click(
            lambda event: (page.close_ups.toggle if event.target.value == "In a window" else self.toggle_close_up)(
                event.client
            )
        )

    def look(self, client: Any, direction: str) -> None:
        """Put a client's camera where it sees everything from a side."""
        view = view_from(direction, self._page.frame)
        self._place(client, view.position, view.look_at)

    def fit_when_shown(self) -> None:
        """Let all cameras see everything once the new scene is drawn."""
        self._fit_serial = self._page.frame.table

    def _place(self, client: Any, position: Any, target: Any) -> None:
        camera = client.camera
        if client.client_id in self._orthographic:
            position = target + (position - target) * _stretch()
        with client.atomic():
            camera.position = tuple(position)
            camera.look_at = tuple(target)

    # Projection ------------------------------------------------------------------------------------------------------

    def toggle_projection(self, client: Any) -> None:
        """Perspective if orthographic, else the other way."""
        self.project(client, client.client_id not in self._orthographic)

    def project(self, client: Any, orthographic: bool) -> None:
        """Switch a client's camera between perspective and orthographic; what is at the target keeps its size."""
        is_now = client.client_id in self._orthographic
        if is_now == orthographic:
            return
        camera = client.camera
        target, arm = np.array(camera.look_at), np.array(camera.position) - camera.look_at
        arm = arm * _stretch() if orthographic else arm / _stretch()
        distance = float(np.sqrt((arm**2).sum()))
        with client.atomic():
            camera.max_orbit_distance = float("inf")
            camera.fov = NARROW if orthographic else ANGLE
            camera.near = 0.1 * distance if orthographic else 0.01
            camera.far = 4.0 * distance if orthographic else 5000.0
            camera.position = tuple(target + arm)
            camera.look_at = tuple(target)
        (self._orthographic.add if orthographic else self._orthographic.discard)(client.client_id)

    # Close-up --------------------------------------------------------------------------------------------------------

    def toggle_close_up(self, client: Any) -> None:
        """Go near the selected body and follow it, or return."""
        before = self._closed_up.pop(client.client_id, None)
        if before is not None:
            self._place(client, *before[2])
            return
        frame = self._page.frame
        row = frame.table.row(self._page.selected)
        if row is None:
            self._page.say("Nothing is selected", "Click on a body, or choose one from the list.", client)
            return
        camera, shape = client.camera, frame.table.entries[row].shape
        home = (np.array(camera.position), np.array(camera.look_at))
        arm = home[0] - home[1]
        width = float(np.cbrt(shape.volume)) if np.isfinite(shape.volume) else self._page.stage.scale.width
        place = np.array(frame.position[row])
        self._place(client, place + CLOSE * width * arm / np.sqrt((arm**2).sum()), place)
        self._closed_up[client.client_id] = (frame.table.entries[row].id, place, home)

    def follow(self, frame: Frame) -> None:
        """Move cameras along with the bodies that they follow. The page's thread calls it."""
        clients = self._page.server.get_clients()
        if self._fit_serial is not None and frame.table is not self._fit_serial:
            self._fit_serial = None
            self._closed_up.clear()
            self._begin_with(frame)
            for client in clients.values():
                self.look(client, "oblique")
        for number, (identity, last, home) in list(self._closed_up.items()):
            client, row = clients.get(number), frame.table.row(identity)
            if client is None or row is None:
                self._closed_up.pop(number, None)
                continue
            place = np.array(frame.position[row])
            if np.abs(place - last).max() > 1e-4 and np.isfinite(place).all():
                camera = client.camera  # what it tells is a little old, but its arm stays right
                arm = np.array(camera.position) - camera.look_at
                camera.position = tuple(place + arm)
                camera.look_at = tuple(place)
                self._closed_up[number] = (identity, place, home)

    def _forget(self, number: int) -> None:
        self._closed_up.pop(number, None)
        self._orthographic.discard(number)

    # Mouse, and balls ------------------------------------------------------------------------------------------------

    def _set_sensitivity(self, value: float) -> None:
        self._snippet.content = SNIPPET.replace("SPEED", f"{value:g}")

    def shoot(self, client: Any) -> None:
        """Shoot a ball from a client's camera to what it looks at."""
        camera, width = client.camera, self._page.stage.scale.width
        direction = np.array(camera.look_at) - camera.position
        distance = float(np.sqrt((direction**2).sum()))
        direction = direction / distance
        start = (
            camera.position
            + (1.0 if client.client_id not in self._orthographic else distance * (1 - 1 / _stretch())) * direction
        )
        entry = {
            "shape": {"type": "sphere", "radius": BALL_RADIUS * width},
            "position": tuple(start.tolist()),
            "velocity": tuple((BALL_SPEED * direction).tolist()),
            "density": 4000.0,
            "restitution": 0.3,
        }
        self._page.do(lambda session: session.add(entry), client)


def _stretch() -> float:
    """How much farther the stand-in for an orthographic camera is."""
    return math.tan(ANGLE / 2) / math.tan(NARROW / 2)
