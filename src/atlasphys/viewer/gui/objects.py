"""The list of bodies, what is known of the selected one, and what can be done to it."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING, Any

import numpy as np

from atlasphys.viewer.frame import Frame, Table
from atlasphys.viewer.gui.body_dialogs import add_dialog, edit_dialog, quick_body
from atlasphys.viewer.overlays import centers, world_box

if TYPE_CHECKING:
    from atlasphys.viewer.gui.page import Page

NONE = "(none)"

MOST_LISTED = 500
"""Most bodies in the list at once; a filter finds the others."""


class Objects:
    """The tab about bodies."""

    def __init__(self, page: Page) -> None:
        self._page = page
        gui = page.server.gui
        self._filter = gui.add_text("Find", "", hint="Only bodies whose name holds this are listed")
        self._list = gui.add_dropdown("Selected", (NONE,), hint="Or click on a body")
        self._info = gui.add_html("")
        self._table: Table | None = None
        self._ids: dict[str, int] = {}
        self._filter.on_update(lambda event: self._fill(page.frame))
        self._list.on_update(self._selected)
        page.cameras.add_close_up_buttons()
        if not page.is_replay:
            self._add_actions(gui)

    def _add_actions(self, gui: Any) -> None:
        page = self._page
        one = gui.add_button_group("Selected body", ("Edit…", "Duplicate", "Delete"))
        one.on_click(lambda event: self.act(event.target.value, event.client))
        gui.add_divider()
        gui.add_button("Add an object…", color="blue").on_click(lambda event: add_dialog(page, event.client))
        quick = gui.add_button_group("Quick", ("Add a cube", "Add a sphere"))
        quick.on_click(lambda event: self.quick_add(event.target.value.split()[-1], event.client))
        gui.add_button("Clear: delete all but planes", color="gray").on_click(
            lambda event: page.do(lambda session: session.clear(), event.client)
        )

    def act(self, what: str, client: Any) -> None:
        """Edit, duplicate or delete the selected body."""
        page, identity = self._page, self._page.selected
        if identity is None:
            page.say("Nothing is selected", "Click on a body, or choose one from the list.", client)
        elif what == "Edit…":
            edit_dialog(page, client, identity)
        elif what == "Duplicate":
            page.do(lambda session: session.duplicate(identity), client).add_done_callback(self._select_new)
        elif what == "Delete":
            page.do(lambda session: session.remove(identity), client)

    def quick_add(self, what: str, client: Any = None) -> None:
        """Add a cube or a sphere above all there is."""
        frame = self._page.frame
        entry = quick_body(what, world_box(frame)[1])
        self._page.do(lambda session: session.add(entry), client).add_done_callback(self._select_new)

    def _select_new(self, done: Any) -> None:
        if done.exception() is None:
            self._page.select(done.result())

    def _selected(self, event: Any) -> None:
        if event.client is not None:
            self._page.select(self._ids.get(event.target.value))

    def refresh(self, frame: Frame) -> None:
        """Show the bodies there are and the state of the selected one."""
        page = self._page
        if frame.table is not self._table:
            self._table = frame.table
            if (
                page.selected is not None
                and frame.table.row(page.selected) is None
                and page.selected not in page.frame.table.ids
            ):
                page.select(None)
            self._fill(frame)
        row = frame.table.row(page.selected)
        label = NONE if row is None else self._label(frame.table, row)
        if label not in self._ids and label != NONE:
            self._ids[label] = frame.table.entries[row].id  # type: ignore[index]
            self._list.options = (*self._list.options, label)
        if self._list.value != label:
            self._list.value = label
        self._info.content = describe(frame, row) + selected_joint(frame, page.selected_joint)

    def _label(self, table: Table, row: int) -> str:
        return f"{row}: {table.entries[row].label}"

    def _fill(self, frame: Frame) -> None:
        wanted = self._filter.value.strip().lower()
        labels = [self._label(frame.table, row) for row in range(len(frame.table))]
        listed = [
            (label, entry.id)
            for label, entry in zip(labels, frame.table.entries, strict=True)
            if wanted in label.lower()
        ]
        self._ids = dict(listed[:MOST_LISTED])
        self._list.options = (NONE, *self._ids)


def selected_joint(frame: Frame, identity: int | None) -> str:
    """Which joint is selected, as HTML: a click may have chosen it while another tab is open."""
    row = None if frame.joints is None else frame.joints.table.row(identity)
    if frame.joints is None or row is None:
        return ""
    label = html.escape(frame.joints.table.entries[row].label)
    return f"<div style='font-size:0.82em;padding:0.2em 0.9em'><b>Selected joint</b> {label}</div>"


def describe(frame: Frame, row: int | None) -> str:
    """The state of a body as HTML."""
    if row is None:
        return "<div style='font-size:0.85em;padding:0.2em 1em'>Nothing is selected.</div>"
    entry = frame.table.entries[row]
    if np.isnan(frame.position[row, 0]):
        rows = [("state", "not in the world at this time")]
    else:
        rows = [("shape", repr(entry.shape)), ("kind", entry.kind), ("position", _vector(frame.position[row], "m"))]
        rows += [("orientation", "(" + ", ".join(f"{c:.4f}" for c in frame.orientation[row]) + ")")]
    if entry.kind != "static" and len(rows) > 1:
        speed = float(np.sqrt((frame.velocity[row].astype(float) ** 2).sum()))
        rows += [
            ("velocity", _vector(frame.velocity[row], "m/s")),
            ("speed", f"{speed:.4g} m/s"),
            ("angular velocity", _vector(frame.angular_velocity[row], "rad/s")),
            ("acceleration", _vector(frame.acceleration[row], "m/s²")),
        ]
    if entry.kind == "dynamic" and len(rows) > 1:
        height = -float(frame.gravity @ centers(frame)[row])
        rows += [
            ("mass", f"{entry.mass:.6g} kg"),
            _kinetic(frame, entry.id, 0.5 * entry.mass * speed**2),
            ("potential energy", f"{entry.mass * height:.5g} J"),
            ("asleep", "yes" if frame.asleep[row] else "no"),
        ]
    if frame.contacts is not None and len(rows) > 1:
        contacts = frame.contacts
        own = contacts[(contacts["body_a"] == row) | (contacts["body_b"] == row)]
        others = {int(b if a == row else a) for a, b in zip(own["body_a"], own["body_b"], strict=True)}
        names = ", ".join(frame.table.entries[other].label for other in sorted(others)[:4])
        with_whom = f" with {names}{', …' if len(others) > 4 else ''}" if others else ""
        rows.append(("contacts", f"{len(own)} points{with_whom}"))
        rows.append(("contact force", f"{own['normal_impulse'].sum() / frame.dt:.5g} N along the normals"))
    cells = "".join(
        f"<tr><td style='opacity:0.65;padding-right:0.7em;vertical-align:top'>{name}</td><td>{html.escape(text)}</td></tr>"
        for name, text in rows
    )
    title = f"<b>{html.escape(entry.label)}</b>"
    return f"<div style='font-size:0.82em;line-height:1.4;padding:0.2em 0.9em'>{title}<table>{cells}</table></div>"


def _kinetic(frame: Frame, identity: int, linear: float) -> tuple[str, str]:
    """The kinetic energy with that of the rotation, if it is known."""
    if frame.kinetic is None or frame.kinetic[0] != identity:
        return "kinetic energy (linear)", f"{linear:.5g} J"
    return "kinetic energy", f"{frame.kinetic[1]:.5g} J, {frame.kinetic[1] - linear:.3g} J of it rotation"


def _vector(vector: Any, unit: str) -> str:
    return "(" + ", ".join(f"{c:.4g}" for c in vector) + f") {unit}"
