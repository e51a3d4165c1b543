"""The world's settings, changed while it runs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from atlasphys.engine.broadphase import BROADPHASES
from atlasphys.engine.solvers import SOLVERS
from atlasphys.world.settings import NARROWPHASES

if TYPE_CHECKING:
    from atlasphys.viewer.frame import Frame
    from atlasphys.viewer.gui.page import Page

STRONGEST = 100.0
"""End of the gravity slider [m/s²]."""

CHOICES = {"position_correction": ("projection", "baumgarte")}
"""Settings of solvers that are one of some names."""


class WorldSettings:
    """The tab about the world. It follows what the world has, whoever changed it."""

    def __init__(self, page: Page) -> None:
        self._page = page
        gui = self._gui = page.server.gui
        settings = page.frame.settings
        self._gravity = gui.add_slider(
            "Gravity", -STRONGEST, 0.0, 0.01, -9.81, hint="Along the direction below [m/s²], from −100 to 0"
        )
        self._up = gui.add_vector3("Up", (0.0, 1.0, 0.0), step=0.1, hint="Gravity pulls the other way")
        self._dt = gui.add_number("Time step", float(settings["dt"]), step=0.001, hint="[s]")
        self._dt.precision = 6
        self._names = {
            "solver": gui.add_dropdown("Solver", tuple(SOLVERS), initial_value=settings["solver"]),
            "narrowphase": gui.add_dropdown("Narrow phase", NARROWPHASES, initial_value=settings["narrowphase"]),
            "broadphase": gui.add_dropdown("Broad phase", tuple(BROADPHASES), initial_value=settings["broadphase"]),
        }
        self._threads = gui.add_number("Threads", int(settings["threads"]), min=1, max=256, step=1, hint="Of soft_step")
        self._sleeping = gui.add_checkbox("Sleeping", bool(settings["sleeping"]), hint="Resting bodies are left out")
        self._folder: Any = None
        self._solver_fields: dict[str, Any] = {}
        self._shown: dict[str, Any] = {}
        self._gravity.on_update(self._set_gravity)
        self._up.on_update(self._set_gravity)
        for name, handle in (
            *self._names.items(),
            ("dt", self._dt),
            ("threads", self._threads),
            ("sleeping", self._sleeping),
        ):
            handle.on_update(lambda event, name=name: self._set(event, name))
        self._tab = gui.add_folder(None)
        self.refresh(page.frame)

    def _set(self, event: Any, name: str) -> None:
        if event.client is not None:
            value = event.target.value
            self._page.do(lambda session: session.configure(**{name: value}), event.client).add_done_callback(
                self._again
            )

    def _again(self, done: Any) -> None:
        """Show what the world has, where it refused what was entered."""
        if done.exception() is not None:
            self._shown = {}

    def _set_gravity(self, event: Any) -> None:
        up = np.array(self._up.value, float)
        length = float(np.sqrt((up**2).sum()))
        if event.client is not None and length > 0:
            gravity = tuple((self._gravity.value * up / length + 0.0).tolist())
            self._page.do(lambda session: session.configure(gravity=gravity), event.client)

    def refresh(self, frame: Frame) -> None:
        """Show the settings that the world has."""
        settings = dict(frame.settings)
        if settings == self._shown:
            return
        before, self._shown = self._shown, settings
        for name, handle in (
            *self._names.items(),
            ("dt", self._dt),
            ("threads", self._threads),
            ("sleeping", self._sleeping),
        ):
            if handle.value != settings[name]:
                handle.value = settings[name]
        if before.get("gravity") != settings["gravity"]:
            self._show_gravity(np.array(settings["gravity"]))
        self._threads.disabled = self._sleeping.disabled = settings["solver"] != "soft_step"
        if before.get("solver") != settings["solver"] or self._folder is None:
            self._build_solver(settings["solver"], settings["solver_settings"])
        for name, handle in self._solver_fields.items():
            if handle.value != settings["solver_settings"][name]:
                handle.value = settings["solver_settings"][name]

    def _show_gravity(self, gravity: Any) -> None:
        strength = float(np.sqrt((gravity**2).sum()))
        if strength > 0 and not np.allclose(
            gravity, -strength * _unit(self._up.value) * -np.sign(self._gravity.value or -1)
        ):
            self._up.value = tuple((-gravity / strength + 0.0).tolist())
        self._gravity.value = max(-STRONGEST, -round(strength, 6))

    def _build_solver(self, solver: str, values: dict[str, Any]) -> None:
        gui = self._gui
        if self._folder is not None:
            self._folder.remove()
        with self._tab:
            self._folder = gui.add_folder(f"Settings of {solver}")
        with self._folder:
            self._solver_fields = {name: self._field(name, value) for name, value in values.items()}
        for name, handle in self._solver_fields.items():
            handle.on_update(lambda event, name=name: self._set_solver(event, name))

    def _field(self, name: str, value: Any) -> Any:
        label = name.replace("_", " ").capitalize()
        if isinstance(value, bool):
            return self._gui.add_checkbox(label, value)
        if isinstance(value, str):
            return self._gui.add_dropdown(label, CHOICES[name], initial_value=value)
        field = self._gui.add_number(label, value, step=1 if isinstance(value, int) else 0.01)
        if isinstance(value, float):
            field.precision = 6
        return field

    def _set_solver(self, event: Any, name: str) -> None:
        if event.client is not None:
            value = event.target.value
            value = type(self._shown.get("solver_settings", {}).get(name, value))(value)
            self._page.do(lambda session: session.configure_solver(**{name: value}), event.client).add_done_callback(
                self._again
            )


def _unit(vector: Any) -> Any:
    array = np.array(vector, float)
    return array / (np.sqrt((array**2).sum()) or 1.0)
