"""Switches for what is drawn beside the bodies."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from atlasphys.viewer.gui.page import Page

SWITCHES = {
    "plane": ("Plane", "The ground and other planes"),
    "grid": ("Grid", "Lines on the planes"),
    "axes": ("Coordinate axes", "x red, y green, z blue"),
    "velocity": ("Velocity arrows", "Blue; 0.25 m for each m/s"),
    "force": (
        "m × a arrows",
        "Mass times acceleration, green; as long as a body is wide where it is the typical weight",
    ),
    "impulse": ("Impulse arrows", "Of contacts, red; on each body, from each contact point"),
    "contacts": ("Contact points", "Orange"),
    "normals": ("Contact normals", "Violet; from body a to body b"),
    "boxes": ("Bounding boxes", "Of the first 600 bodies"),
    "joints": (
        "Joints",
        "Cyan from centres to anchors; orange from anchor to anchor; magenta axes; grey: disabled or broken",
    ),
    "islands": ("Islands by colour", "Bodies that touch one another have one colour"),
    "sleeping": ("Mark sleeping", "Sleeping bodies turn grey"),
    "centers": ("Centres of mass", "Black"),
    "shadows": ("Shadows", "Switch them off on a slow computer"),
}
OF_CONTACTS = ("impulse", "contacts", "normals", "islands")


class Show:
    """The switches. A recording without joints, or without contacts, has none of theirs."""

    def __init__(self, page: Page) -> None:
        self._page = page
        gui = page.server.gui
        self.switches: dict[str, Any] = {}
        lacking: tuple[str, ...] = ()
        if page.is_replay:
            recording: Any = page.simulation.model
            lacking = ("sleeping",) if recording.has_contacts else ("sleeping", *OF_CONTACTS)
            if not recording.has_joints:
                lacking = ("joints", *lacking)
        for name, (label, hint) in SWITCHES.items():
            if name in lacking:
                continue
            box = gui.add_checkbox(label, getattr(page.shown, name), hint=hint)
            box.on_update(lambda event, name=name: self._set(name, event.target.value))
            self.switches[name] = box
        size = gui.add_slider("Arrow size", 0.1, 5.0, 0.1, page.shown.arrow_size)
        size.on_update(lambda event: self._set("arrow_size", event.target.value))
        dark = gui.add_checkbox("Dark", page.dark)
        dark.on_update(lambda event: self._set_dark(event.target.value))
        self.switches["dark"] = dark

    def toggle(self, name: str) -> None:
        """Turn a switch."""
        if name in self.switches:
            self.switches[name].value = not self.switches[name].value

    def _set(self, name: str, value: Any) -> None:
        setattr(self._page.shown, name, value)
        self._page.update_wanted()
        self._page.redraw()

    def _set_dark(self, value: bool) -> None:
        self._page.dark = value
        self._page.apply_theme()
        self._page.redraw()
