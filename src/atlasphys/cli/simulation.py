"""A scene run in a thread of its own, so that Ctrl-C and the display need not wait for a step or for the compiler."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from atlasphys.record.write import Recorder
    from atlasphys.scene.scene import Scene
    from atlasphys.world.world import World

IN_PLACE, FELL = 0.05, 0.25
"""A body counts as in place if it is nearer to where it began, as fallen if it sank by more [m, times length_unit]."""

AT_REST = 0.05
"""A body counts as at rest if it is slower than this [m/s, times length_unit] and turns more slowly than this [rad/s]."""


@dataclass
class Progress:
    """How far the run is; written by its thread and read by the display."""

    phase: str = "starting"
    """``starting`` (imports), ``first step`` (kernels are compiled or loaded), ``running`` or ``done``."""
    steps: int = 0
    contacts: int = 0
    bodies: int = 0
    seconds: float = 0.0
    """Simulated time [s]."""
    running_since: float = 0.0
    """Clock at the end of the first step, in which kernels are compiled or loaded [s]."""
    wall: float = 0.0
    """Time taken by the steps after the first [s]."""


@dataclass
class Start:
    """The state before the first step, to compare the end with."""

    position: npt.NDArray[np.float64]
    energy: Any


class Simulation(threading.Thread):
    """Builds a scene's world, then takes steps until they are all done or ``stop`` is set.

    Args:
        scene: the scene.
        steps: number of steps.
        dt: length of a step [s].
        settings: arguments of the world that replace the scene's.
        record: file for the recording, if there shall be one.
        record_contacts: whether it shall hold contact points.
    """

    def __init__(
        self,
        scene: Scene,
        steps: int,
        dt: float,
        settings: dict[str, Any],
        record: Path | None,
        *,
        record_contacts: bool = False,
    ) -> None:
        super().__init__(name="simulation", daemon=True)
        self.scene, self.steps, self.dt, self.settings, self.record_path = scene, steps, dt, settings, record
        self.record_contacts = record_contacts
        self.stop = threading.Event()
        self.progress = Progress()
        self.error: BaseException | None = None
        self.world: World | None = None
        self.recorder: Recorder | None = None
        self.begin: Start | None = None
        self.profile: dict[str, float] = {}
        self.deepest: dict[str, Any] | None = None
        self._recorder_lock = threading.Lock()

    def run(self) -> None:
        """What the thread does."""
        try:
            self._simulate()
        except BaseException as error:
            self.error = error
        try:
            self.close_recording()
        except BaseException as error:
            self.error = self.error or error
        self.progress.phase = "done"

    def close_recording(self) -> None:
        """Write what is left of the recording and close it; nothing is recorded afterwards. Safe during a step."""
        with self._recorder_lock:
            if self.recorder is not None:
                self.recorder.close()

    def _simulate(self) -> None:
        from atlasphys.record.write import Recorder

        self.progress.phase = "first step"
        world = self.world = self.scene.build(**self.settings)
        self.progress.bodies = len(world.bodies)
        self.begin = Start(world.bodies.position.copy(), world.energy())
        if self.record_path is not None:
            self.recorder = Recorder(self.record_path, world, self.scene, contacts=self.record_contacts)
        for step in range(self.steps):
            if self.stop.is_set():
                return
            world.step(self.dt)
            if not self._record():
                return
            contacts = world.contacts
            self._note_deepest(contacts)
            self.progress.steps, self.progress.contacts, self.progress.seconds = step + 1, len(contacts), world.time
            now = time.perf_counter()
            if step == 0:
                self.progress.running_since, self.progress.phase = now, "running"
            else:
                for stage, seconds in world.profile.items():
                    self.profile[stage] = self.profile.get(stage, 0.0) + seconds
                self.progress.wall = now - self.progress.running_since

    def _record(self) -> bool:
        """Record the step; False if the run has been stopped meanwhile and the recording closed."""
        with self._recorder_lock:
            if self.stop.is_set() and self.recorder is not None and self.recorder.closed:
                return False
            if self.recorder is not None:
                self.recorder.record()
        return True

    def _note_deepest(self, contacts: Any) -> None:
        if len(contacts) == 0:
            return
        row = int(contacts.depth.argmax())
        depth = float(contacts.depth[row])
        if self.world and (self.deepest is None or depth > self.deepest["depth"]):
            pair = (int(contacts.body_a[row]), int(contacts.body_b[row]))
            self.deepest = {"depth": depth, "bodies": [self.name_of(body) for body in pair], "time": self.world.time}

    def name_of(self, row: int) -> str:
        """A body's name, or its number where it has none."""
        return (self.world.bodies[row].name if self.world else None) or f"body {row}"


def summarize(simulation: Simulation, *, interrupted: bool) -> dict[str, Any]:
    """What came of a run, in plain values: what ``atlasphys run --json`` prints.

    While a step is being taken, the world cannot be read, and what depends on it is left out.
    """
    progress, world, begin = simulation.progress, simulation.world, simulation.begin
    wall, measured = progress.wall, progress.steps - 1
    summary: dict[str, Any] = {
        "scene": simulation.scene.name,
        "interrupted": interrupted,
        "error": str(simulation.error) if simulation.error else None,
        "dt": simulation.dt,
        "steps": progress.steps,
        "seconds": progress.seconds,
        "bodies": progress.bodies,
        "contacts": progress.contacts,
        "wall_seconds": wall,
        "speed": measured * simulation.dt / wall if wall > 0 else None,
        "stage_milliseconds": {stage: 1e3 * seconds / measured for stage, seconds in simulation.profile.items()},
        "deepest_contact": simulation.deepest,
    }
    if simulation.recorder is not None:
        summary["recording"] = {"path": str(simulation.recorder.path), "steps": simulation.recorder.steps}
    if simulation.is_alive() or world is None or begin is None:
        return summary
    energy = world.energy()
    summary["settings"] = {name: getattr(world, name) for name in ("solver", "narrowphase", "broadphase", "precision")}
    summary["energy"] = {
        name: {"start": getattr(begin.energy, name), "end": getattr(energy, name)}
        for name in ("kinetic", "potential", "total")
    }
    return summary | _what_stood(simulation, world, begin) | {"state_hash": world.state_hash()}


def _what_stood(simulation: Simulation, world: World, begin: Start) -> dict[str, Any]:
    bodies, unit = world.bodies, world.length_unit
    dynamic = np.flatnonzero(bodies.kind == "dynamic")
    shift = (bodies.position - begin.position)[dynamic]
    size = np.sqrt((world.gravity**2).sum())
    down = world.gravity / size if size > 0 else np.zeros(3)
    distance = np.sqrt((shift**2).sum(axis=1))
    drop = (shift * down).sum(axis=1)
    speed = np.sqrt((bodies.velocity[dynamic].astype(np.float64) ** 2).sum(axis=1))
    turning = np.sqrt((bodies.angular_velocity[dynamic].astype(np.float64) ** 2).sum(axis=1))
    fallen = np.flatnonzero(drop > FELL * unit)
    farthest = int(distance.argmax()) if len(dynamic) else None
    return {
        "dynamic_bodies": len(dynamic),
        "in_place": int((distance < IN_PLACE * unit).sum()),
        "fell": len(fallen),
        "fallen": [
            simulation.name_of(int(dynamic[row])) for row in fallen[np.argsort(-drop[fallen], kind="stable")][:5]
        ],
        "at_rest": int(((speed < AT_REST * unit) & (turning < AT_REST)).sum()),
        "farthest": None
        if farthest is None
        else {"body": simulation.name_of(int(dynamic[farthest])), "distance": float(distance[farthest])},
        "length_unit": unit,
    }
