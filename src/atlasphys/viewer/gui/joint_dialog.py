"""Dialogs that make a joint or change one: a field for each of its settings, which may be left empty where there may be none."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np

from atlasphys.engine.joints.kinds.kind import JointKind
from atlasphys.scene.joints import KINDS
from atlasphys.viewer.frame import Frame
from atlasphys.viewer.gui.body_dialogs import PATIENCE
from atlasphys.viewer.gui.forms import Dialog, Form
from atlasphys.viewer.gui.joint_fields import Reader, label_of, setting_fields
from atlasphys.viewer.overlays import centers

if TYPE_CHECKING:
    from atlasphys.viewer.gui.page import Page

WORLD = "(the world)"

MOST_LISTED = 500
"""Most bodies that the dialog lists; the selected ones are always among them."""


def edit_joint_dialog(page: Page, client: Any, identity: int) -> None:
    """Change what can be changed of a joint."""

    def read(session: Any) -> tuple[Any, bool, bool]:
        joint = session.joint(identity)
        return joint.settings, joint.enabled, joint.broken

    settings, enabled, broken = page.do(read, client).result(PATIENCE)
    with Dialog(client, f"Edit {type(settings).__name__}") as dialog:
        form = Form(dialog.gui)
        form.flag("enabled", "Enabled", enabled, "Whether the joint acts")
        if broken:
            form.flag("broken", "Broken", broken, "Uncheck to mend it")
        readers = setting_fields(form, type(settings), settings)
        shown = form.values()

        def apply() -> None:
            entered = form.values()
            changes = {name: entered[name] for name in ("enabled", "broken") if entered.get(name) != shown.get(name)}
            changes |= _changed(readers, entered, shown)
            page.simulation.do(lambda session: session.edit_joint(identity, changes)).result(PATIENCE)

        dialog.buttons("Apply", apply)


def _changed(readers: dict[str, Reader], entered: dict[str, Any], shown: dict[str, Any]) -> dict[str, Any]:
    """The settings whose fields say something else than at first."""
    return {
        name: reader(entered)
        for name, reader in readers.items()
        if any(entered[key] != shown[key] for key in entered if key.split(".")[0] == name)
    }


BODIES_AXES = "In {}'s own axes, from its position; in the world, if that is the world [m]"
PLACES: dict[str, tuple[str, tuple[float, float, float] | None]] = {
    "anchor": ("The point that they share, in the world [m]", None),
    "axis": ("Direction in the world", (0.0, 0.0, 1.0)),
    "axis_b": ("Direction in the world, at right angles to the axis", (0.0, 1.0, 0.0)),
    "axis_a": ("That a turns about, in the world", (0.0, 0.0, 1.0)),
    "axle": ("That the wheel turns about, in the world", (0.0, 0.0, 1.0)),
    "direction": ("That the rack moves in, in the world", (1.0, 0.0, 0.0)),
    "ground_a": ("What a hangs from, in the world [m]", None),
    "ground_b": ("What b hangs from, in the world [m]", None),
    "anchor_a": (BODIES_AXES.format("a"), (0.0, 0.0, 0.0)),
    "anchor_b": (BODIES_AXES.format("b"), (0.0, 0.0, 0.0)),
}
"""Where joints are: what each field means, and what it says at first; None: something near the bodies."""

PLACES_OF = {
    "ball": ("anchor", "axis"), "hinge": ("anchor", "axis"), "slider": ("anchor", "axis"), "fixed": ("anchor",),
    "distance": ("anchor_a", "anchor_b"), "spring": ("anchor_a", "anchor_b"), "universal": ("anchor", "axis", "axis_b"),
    "wheel": ("anchor", "axis", "axle"), "six_dof": ("anchor", "axis"), "gear": ("axis_a", "axis_b"),
    "rack_pinion": ("axis", "direction"), "pulley": ("ground_a", "ground_b", "anchor_a", "anchor_b"), "target": ("anchor_b",),
}  # fmt: skip
"""Which of them each kind of joint has."""

FIRST_AXIS = {
    "slider": (1.0, 0.0, 0.0),
    "six_dof": (1.0, 0.0, 0.0),
    "universal": (1.0, 0.0, 0.0),
    "wheel": (0.0, 1.0, 0.0),
}
GEARS = {"axis_b": (0.0, 0.0, 1.0)}


def join_dialog(page: Page, client: Any) -> None:
    """Ask for a joint and make it. The bodies are at first the one selected before the present one, or the world, and that."""
    frame = page.frame
    ids = _choices(frame, page.selected_before, page.selected)
    first_a = _label(frame, page.selected_before)
    first_b = _label(frame, page.selected)
    with Dialog(client, "Join") as dialog:
        gui = dialog.gui
        titles = {kind.__name__: kind for kind in KINDS}
        chosen = gui.add_dropdown("Kind", tuple(titles), initial_value="Hinge", hint="docs/joints.md describes them")
        end_a = gui.add_dropdown(
            "Body a", tuple(ids), initial_value=first_a, hint="Or select two bodies, one after the other, before"
        )
        end_b = gui.add_dropdown("Body b", tuple(ids), initial_value=first_b, hint="What is selected")
        name = gui.add_text("Joint name", "", hint="May be left empty")
        folder = gui.add_folder(None)
        fields = _JointFields(gui, folder, frame, titles["Hinge"], ids[first_a], ids[first_b])

        def rebuild(_: Any) -> None:
            nonlocal fields, folder
            with dialog:
                old, before = folder, fields
                folder = gui.add_folder(None, order=old.order)
                kind = titles[chosen.value]
                fields = _JointFields(gui, folder, page.frame, kind, ids[end_a.value], ids[end_b.value])
                if kind is before.kind:
                    fields.keep(before)
                old.remove()

        for field in (chosen, end_a, end_b):
            field.on_update(rebuild)

        def join() -> None:
            kind, settings, ends = fields.kind, fields.settings(), (ids[end_a.value], ids[end_b.value])
            called = name.value.strip()
            future = page.simulation.do(lambda session: session.join(kind, *ends, name=called, **settings))
            page.select_joint(future.result(PATIENCE))

        dialog.buttons("Join", join)


class _JointFields:
    """Fields of the place and the settings of a new joint."""

    def __init__(
        self, gui: Any, folder: Any, frame: Frame, kind: type[JointKind], a: int | None, b: int | None
    ) -> None:
        self.kind = kind
        self._form = Form(gui)
        defaults = {field.name: _default(field) for field in dataclasses.fields(kind)}
        near = _near(frame, a, b)
        if kind.type == "target":
            defaults["target"] = near["ground_b"]
        with folder:
            for name in PLACES_OF[kind.type]:
                hint, value = PLACES[name]
                if name == "axis":
                    value = FIRST_AXIS.get(kind.type, value)
                elif kind.type == "gear":
                    value = GEARS.get(name, value)
                elif a is None and name == "anchor_a":
                    value = near["ground_b"]
                self._form.vector(name, label_of(name), near[name] if value is None else value, hint)
            self._readers = setting_fields(self._form, kind, defaults)
        self._shown = self._form.values()

    def settings(self) -> dict[str, Any]:
        """What they say; what was left as it was is left out, but for places.

        Raises:
            InvalidArgumentError: a text does not say what it should.
        """
        entered = self._form.values()
        settings = {name: entered[name] for name in PLACES_OF[self.kind.type]}
        if self.kind.type == "target":
            settings["target"] = entered["target"]
        return settings | _changed(self._readers, entered, self._shown)

    def keep(self, before: _JointFields) -> None:
        """Take over what was entered in other fields of the same kind."""
        entered = before._form.values()
        for name, handle in self._form.handles.items():
            if entered[name] != before._shown[name]:
                handle.value = before._form.handles[name].value


def _default(field: Any) -> Any:
    return (
        field.default
        if field.default is not dataclasses.MISSING
        else field.default_factory()
        if callable(field.default_factory)
        else None
    )


def _near(frame: Frame, a: int | None, b: int | None) -> dict[str, Any]:
    """Places for a joint of two bodies: between them, and above each."""
    rows = [frame.table.row(end) for end in (a, b)]
    places = [np.zeros(3) if row is None else centers(frame)[row].astype(np.float64) for row in rows]
    volumes = [1.0 if row is None else frame.table.entries[row].shape.volume for row in rows]
    widths = [float(np.cbrt(volume)) if np.isfinite(volume) else 1.0 for volume in volumes]
    known = [place for place, row in zip(places, rows, strict=True) if row is not None]
    above = [place + (0.0, 2.5 * width, 0.0) for place, width in zip(places, widths, strict=True)]
    return {"anchor": sum(known) / len(known) if known else np.zeros(3), "ground_a": above[0], "ground_b": above[1]}


def _label(frame: Frame, identity: int | None) -> str:
    row = frame.table.row(identity)
    return WORLD if row is None else f"{row}: {frame.table.entries[row].label}"


def _choices(frame: Frame, *selected: int | None) -> dict[str, int | None]:
    """Ids of the bodies that can be chosen, by label."""
    ids = frame.table.ids[:MOST_LISTED].tolist()
    ids += [one for one in selected if one is not None and one not in ids and frame.table.row(one) is not None]
    return {WORLD: None} | {_label(frame, identity): identity for identity in ids}
