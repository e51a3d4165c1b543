"""The list of joints, what is known of the selected one, and what can be done to it."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING, Any

from atlasphys.viewer.frame import Frame
from atlasphys.viewer.gui.joint_dialog import edit_joint_dialog, join_dialog
from atlasphys.viewer.joints import JointTable

if TYPE_CHECKING:
    from atlasphys.viewer.gui.page import Page

NONE = "(none)"

MOST_LISTED = 500
"""Most joints in the list at once; a filter finds the others."""


class Joints:
    """The tab about joints."""

    def __init__(self, page: Page) -> None:
        self._page = page
        gui = page.server.gui
        self._filter = gui.add_text(
            "Find joint", "", hint="Only joints whose kind, name or bodies hold this are listed"
        )
        self._list = gui.add_dropdown("Selected joint", (NONE,), hint="Or click on a joint's line")
        self._info = gui.add_html("")
        self._table: JointTable | None = None
        self._ids: dict[str, int] = {}
        self._filter.on_update(lambda event: self._fill(page.frame))
        self._list.on_update(self._selected)
        buttons = gui.add_button_group("Joint", ("Edit joint…", "Remove joint"))
        buttons.on_click(lambda event: self.act(event.target.value, event.client))
        gui.add_divider()
        gui.add_button("Join two bodies…", color="blue", hint="U on the keyboard").on_click(
            lambda event: join_dialog(page, event.client)
        )

    def act(self, what: str, client: Any) -> None:
        """Edit or remove the selected joint."""
        page, identity = self._page, self._page.selected_joint
        if identity is None:
            page.say("No joint is selected", "Click on a joint's line, or choose one from the list.", client)
        elif what == "Edit joint…":
            edit_joint_dialog(page, client, identity)
        else:
            page.do(lambda session: session.remove_joint(identity), client)

    def _selected(self, event: Any) -> None:
        if event.client is not None:
            self._page.select_joint(self._ids.get(event.target.value))

    def refresh(self, frame: Frame) -> None:
        """Show the joints there are and the state of the selected one."""
        page, now = self._page, frame.joints
        if now is None:
            return
        row = now.table.row(page.selected_joint)
        if now.table is not self._table:
            self._table = now.table
            if page.selected_joint is not None and row is None:
                page.select_joint(None)
            self._fill(frame)
        label = NONE if row is None else now.table.entries[row].label
        if row is not None and label not in self._ids:
            self._ids[label] = now.table.entries[row].id
            self._list.options = (*self._list.options, label)
        if self._list.value != label:
            self._list.value = label
        self._info.content = describe_joint(frame)

    def _fill(self, frame: Frame) -> None:
        wanted = self._filter.value.strip().lower()
        entries = [] if frame.joints is None else frame.joints.table.entries
        listed = [entry for entry in entries if wanted in entry.label.lower()][:MOST_LISTED]
        self._ids = {entry.label: entry.id for entry in listed}
        self._list.options = (NONE, *self._ids)


LENGTHS = ("translation", "length", "x", "y", "z")
"""Coordinates that are lengths; the others are angles."""


def describe_joint(frame: Frame) -> str:
    """The state of the joint that frames were asked for, as HTML."""
    style = "font-size:0.82em;line-height:1.4;padding:0.2em 0.9em"
    now = frame.joints
    if now is None or len(now.table) == 0:
        return f"<div style='{style}'>This world has no joints.</div>"
    state = now.selected
    row = None if state is None else now.table.row(state.id)
    if state is None or row is None:
        return f"<div style='{style}'>{len(now.table)} joints, {int(now.acts.sum())} act. None is selected.</div>"
    acts = "broken" if state.broken else "enabled" if state.enabled else "disabled"
    rows = [("kind", now.table.entries[row].kind), ("a", state.ends[0]), ("b", state.ends[1]), ("state", acts)]
    for name, (value, rate) in state.coordinates.items():
        unit = "m" if name in LENGTHS else "rad"
        rows.append((name, f"{value:.4f} {unit}, at {rate:.4g} {unit}/s"))
    rows += [
        ("anchors apart", f"{1000 * state.apart:.4g} mm"),
        ("force on b", _vector(state.force, "N")),
        ("torque on b", _vector(state.torque, "N m")),
        ("of motors", f"{state.motor_force:.4g} N or N m"),
    ]
    cells = "".join(
        f"<tr><td style='opacity:0.65;padding-right:0.7em;vertical-align:top'>{name}</td><td>{html.escape(text)}</td></tr>"
        for name, text in rows
    )
    return f"<div style='{style}'><table>{cells}</table></div>"


def _vector(vector: Any, unit: str) -> str:
    return "(" + ", ".join(f"{c:.4g}" for c in vector) + f") {unit}"
