"""Dialogs that add a body or change one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from atlasphys.scene.schema import SHAPES
from atlasphys.viewer.colours import PALETTE
from atlasphys.viewer.gui.forms import Dialog, Form
from atlasphys.viewer.overlays import world_box

if TYPE_CHECKING:
    from atlasphys.viewer.gui.page import Page

LABELS = {
    "box": "box (cube, rectangular prism)",
    "convex_hull": "convex hull",
    "pyramid": "pyramid (square, pentagonal, …)",
}
KINDS = ("dynamic", "static", "kinematic")
PATIENCE = 60.0
"""How long a dialog waits for the world to answer [s]; the first step of all compiles kernels."""


def quick_body(what: str, top: Any) -> dict[str, Any]:
    """A cube or a sphere somewhat above the top of what is there, a little aside so that it does not balance."""
    height = float(top[1]) + 1.0 if np.isfinite(top[1]) else 5.0
    shape = {"type": "box", "size": (1.0, 1.0, 1.0)} if what == "cube" else {"type": "sphere", "radius": 0.5}
    middle = {"position": (0.05, height + 0.5, 0.03)}
    return {"shape": shape, **middle, "restitution": 0.2}


def add_dialog(page: Page, client: Any) -> None:
    """Ask for a body and add it."""
    labels = {LABELS.get(name, name.replace("_", " ")): name for name in ("box", "sphere", *SHAPES) if name in SHAPES}
    with Dialog(client, "Add an object") as dialog:
        gui = dialog.gui
        shape = gui.add_dropdown("Shape", tuple(labels), initial_value=next(iter(labels)))
        folder = gui.add_folder("Sizes [m]")
        sizes = _sizes(gui, folder, labels[shape.value])
        form = Form(gui)
        form.text("name", "Name", "", "May be left empty")
        form.choice("kind", "Kind", KINDS, "dynamic", "Moved by forces; fixed; or moved only by its own velocity")
        above = quick_body("cube", world_box(page.frame)[1])["position"]
        form.vector("position", "Position", above, "[m]; at first above everything")
        form.rotation("orientation", "Rotation")
        form.vector("velocity", "Velocity", (0.0, 0.0, 0.0), "[m/s]")
        form.vector("angular_velocity", "Spin", (0.0, 0.0, 0.0), "Angular velocity [rad/s]")
        form.choice("measure", "Given", ("density", "mass"), "density", "Which of the two the number below is")
        form.number("amount", "kg/m³ or kg", 1000.0, step=10.0)
        form.number("friction", "Friction", 0.5, "Coefficient of Coulomb friction, 0 or more")
        form.number("restitution", "Restitution", 0.2, "0 does not bounce, 1 loses nothing")
        form.number("rolling_friction", "Rolling friction", 0.0, "Lever arm [m]", step=0.01)
        colour = PALETTE[np.random.default_rng().integers(len(PALETTE))].tolist()
        form.colour("color", "Colour", tuple(colour))

        def rebuild(_: Any) -> None:
            nonlocal sizes, folder
            old = folder
            folder = gui.add_folder("Sizes [m]", order=old.order)
            sizes = _sizes(gui, folder, labels[shape.value])
            old.remove()

        def rebuild_in_dialog(event: Any) -> None:
            with dialog:
                rebuild(event)

        shape.on_update(rebuild_in_dialog)

        def add() -> None:
            entry = new_entry(labels[shape.value], sizes.values(), form.values())
            page.select(page.simulation.do(lambda session: session.add(entry)).result(PATIENCE))

        dialog.buttons("Add", add)


def _sizes(gui: Any, folder: Any, kind: str) -> Form:
    with folder:
        form = Form(gui)
        for name, field in SHAPES[kind].model_fields.items():
            if name != "type":
                form.from_schema(name, field)
    return form


def new_entry(kind: str, sizes: dict[str, Any], values: dict[str, Any]) -> dict[str, Any]:
    """What the fields of the dialog say, as a body of a scene file. What is left as it was is left out."""
    entry: dict[str, Any] = {"shape": {"type": kind, **sizes}}
    values = dict(values)
    measure, amount = values.pop("measure"), values.pop("amount")
    if kind == "plane":  # a plane is static and has no mass
        values.pop("kind")
    elif values["kind"] == "dynamic":
        entry[measure] = amount
    moving = {name for name in ("velocity", "angular_velocity") if not any(values[name])}
    return entry | {name: value for name, value in values.items() if name not in moving and value != ""}


def edit_dialog(page: Page, client: Any, identity: int) -> None:
    """Change what can be changed of a body."""

    def read(session: Any) -> dict[str, Any]:
        body = session.body(identity)
        names = ("position", "orientation", "velocity", "angular_velocity", *NUMBERS, "locks", "kind")
        return {name: getattr(body, name) for name in names}

    now = page.do(read, client).result(PATIENCE)
    row = page.frame.table.row(identity)
    title = page.frame.table.entries[row].label if row is not None else "body"
    with Dialog(client, f"Edit {title}") as dialog:
        form = Form(dialog.gui)
        form.vector("position", "Position", now["position"], "[m]")
        form.rotation("orientation", "Rotation", now["orientation"])
        if now["kind"] != "static":
            form.vector("velocity", "Velocity", now["velocity"], "[m/s]")
            form.vector("angular_velocity", "Spin", now["angular_velocity"], "Angular velocity [rad/s]")
        for name, hint in NUMBERS.items():
            form.number(name, name.replace("_", " ").capitalize(), now[name], hint)
        form.text(
            "locks",
            "Locked axes",
            ", ".join(now["locks"]),
            "Out of x, y, z, rx, ry, rz: along or about them it cannot move",
        )
        shown = form.values()

        def apply() -> None:
            values = {name: value for name, value in form.values().items() if value != shown[name]}
            if "locks" in values:
                values["locks"] = tuple(values["locks"].replace(",", " ").split())
            page.simulation.do(lambda session: session.edit(identity, values)).result(PATIENCE)

        dialog.buttons("Apply", apply)


NUMBERS = {
    "friction": "Coefficient of Coulomb friction",
    "restitution": "0 does not bounce, 1 loses nothing",
    "rolling_friction": "Lever arm [m]",
    "torsional_friction": "Lever arm [m]",
    "linear_damping": "Rate at which velocity decays [1/s]",
    "angular_damping": "Rate at which rotation decays [1/s]",
    "gravity_scale": "Factor on the world's gravity",
}
"""Numbers of a body that can be changed, and what they mean."""
