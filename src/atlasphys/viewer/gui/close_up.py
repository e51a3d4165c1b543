"""A small window that follows the selected body, while the page's own camera stays.

The browser draws its picture, at a modest rate and only when something has changed; the server passes it on to the window.
"""

from __future__ import annotations

import contextlib
import html
import threading
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial.transform import Rotation

from atlasphys.viewer.colours import BACKGROUND
from atlasphys.viewer.frame import Frame

if TYPE_CHECKING:
    from atlasphys.viewer.gui.page import Page

SIZE = (210, 320)
"""Height and width of the picture [pixels]."""

RATE = 8.0
"""Most pictures a second."""

ANGLE = 0.7
"""Angle of view [rad]."""

DISTANCE = 4.5
"""Of the camera at first, in widths of the body."""

PATIENCE = 5.0
"""How long a browser may take for a picture [s]; one in a hidden tab takes forever."""


class CloseUps:
    """The close-up windows of all pages that are open; at first there are none."""

    def __init__(self, page: Page) -> None:
        self._page = page
        self._windows: dict[int, Window] = {}
        page.server.on_client_disconnect(lambda client: self._close(client.client_id))

    def toggle(self, client: Any) -> None:
        """Open a client's window, or close it."""
        if not self._close(client.client_id):
            self._windows[client.client_id] = Window(self._page, client, self.toggle)

    def close(self) -> None:
        """Close all."""
        for number in list(self._windows):
            self._close(number)

    def _close(self, number: int) -> bool:
        window = self._windows.pop(number, None)
        if window is not None:
            window.close()
        return window is not None


class Window:
    """A client's window, with a thread that keeps it up to date."""

    def __init__(self, page: Page, client: Any, on_close: Any) -> None:
        self._page, self._client = page, client
        self._closed = threading.Event()
        self.pictures = 0
        """How many have been shown."""
        gui = client.gui
        self._panel = gui.add_panel()
        with self._panel.add_tab("Close-up"):
            self._title = gui.add_html("")
            self._image = gui.add_image(
                np.full((*SIZE, 3), BACKGROUND[page.dark], np.uint8), format="jpeg", jpeg_quality=85
            )
            self._distance = gui.add_slider("Distance", 1.5, 15.0, 0.5, DISTANCE, hint="In widths of the body")
            gui.add_button("Close this window", hint="K on the keyboard").on_click(lambda event: on_close(event.client))
        self._panel.float(x=15, y=-15, width=SIZE[1] + 30)
        threading.Thread(target=self._run, name="close-up", daemon=True).start()

    def close(self) -> None:
        """Take the window away."""
        self._closed.set()
        with contextlib.suppress(RuntimeError):  # it goes with the client
            self._panel.remove()

    def _run(self) -> None:
        before: object = None
        shown: object = None
        while not self._closed.wait(1 / RATE):
            try:
                # What has changed may reach the browser after it was asked for a picture, so a last one is taken once nothing changes.
                before, shown = shown, self._refresh(before, shown)
            except TimeoutError:
                continue
            except (RuntimeError, ValueError, OSError):  # the client has gone, or sent no picture
                if self._closed.wait(1.0) or self._client.client_id not in self._page.server.get_clients():
                    return

    def _refresh(self, before: object, shown: object) -> object:
        """Show a new picture unless nothing has changed since the last two; returns what it depends on."""
        page, frame, camera = self._page, self._page.frame, self._client.camera
        arm = np.array(camera.position) - camera.look_at
        now = (page.frames_drawn, page.selected, page.dark, self._distance.value, arm.round(6).tobytes())
        if now == shown == before:
            return now
        row = frame.table.row(page.selected)
        if row is None or not np.isfinite(frame.position[row]).all():
            self._title.content = _line("Click on a body, or choose one from the list.")
            self._image.visible = False
            return now
        place, wxyz = viewpoint(frame, row, arm, self._distance.value, page.stage.scale.width)
        height, width = SIZE
        picture = self._client.get_render(
            height,
            width,
            wxyz=wxyz,
            position=place,
            fov=ANGLE,
            timeout=PATIENCE,
            transport_format="png" if page.dark else "jpeg",
        )
        if self._closed.is_set() or picture.size == 0:
            return shown
        self._title.content = _line(frame.table.entries[row].label)
        self._image.image = over(picture, BACKGROUND[page.dark])
        self._image.visible = True
        self.pictures += 1
        return now


def viewpoint(frame: Frame, row: int, arm: Any, distance: float, typical: float) -> tuple[Any, Any]:
    """Where a camera is that sees a body from the direction ``arm``, and its orientation: x to the right, y down, z ahead.

    Args:
        frame: what is seen.
        row: the body's.
        arm: (3,) from the body towards the camera.
        distance: in widths of the body.
        typical: width for what has none, a plane [m].

    Returns:
        (3,) position [m] and (4,) unit quaternion (w, x, y, z).
    """
    volume = frame.table.entries[row].shape.volume
    width = float(np.cbrt(volume)) if np.isfinite(volume) else typical
    ahead = -np.asarray(arm, np.float64) / (np.sqrt((arm**2).sum()) or 1.0)
    right = np.cross(ahead, (0.0, 1.0, 0.0) if abs(ahead[1]) < 0.999 else (0.0, 0.0, -1.0))
    right /= np.sqrt((right**2).sum())
    axes = np.stack([right, np.cross(ahead, right), ahead], axis=1)
    place = np.asarray(frame.position[row], np.float64) - distance * width * ahead
    return place, Rotation.from_matrix(axes).as_quat()[[3, 0, 1, 2]]


def over(picture: Any, background: tuple[int, int, int]) -> Any:
    """A picture without transparency, over a colour."""
    if picture.shape[2] == 3:
        return picture
    share = picture[:, :, 3:].astype(np.float32) / 255
    return (share * picture[:, :, :3] + (1 - share) * np.array(background, np.float32)).astype(np.uint8)


def _line(text: str) -> str:
    return f"<div style='font-size:0.85em;padding:0.2em 1em'>{html.escape(text)}</div>"
