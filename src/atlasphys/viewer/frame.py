"""What a session shows at one moment, as plain values that other threads may keep."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from atlasphys.engine.shapes.plane import Plane
from atlasphys.engine.shapes.shape import Shape
from atlasphys.viewer.joints import JointsNow

Array = npt.NDArray[Any]


class Entry(NamedTuple):
    """What does not move of a body."""

    id: int
    name: str | None
    shape: Shape
    kind: str
    color: tuple[float, float, float] | None
    mass: float
    """[kg]; infinite unless dynamic."""

    @property
    def label(self) -> str:
        """The name, or the shape and a number that no other body of the world has."""
        return self.name or f"{type(self.shape).__name__.lower()} {self.id & 0xFFFFFFFF}"


class Table:
    """The bodies of a frame, a row each. Frames share one until the set of bodies changes."""

    def __init__(self, entries: tuple[Entry, ...]) -> None:
        self.entries = entries
        self.ids: npt.NDArray[np.int64] = np.array([entry.id for entry in entries], np.int64)
        self.mass: npt.NDArray[np.float64] = np.array([entry.mass for entry in entries], np.float64)
        self.is_dynamic: npt.NDArray[np.bool_] = np.array([entry.kind == "dynamic" for entry in entries], np.bool_)
        self.is_plane: npt.NDArray[np.bool_] = np.array([isinstance(e.shape, Plane) for e in entries], np.bool_)
        centers = [(0.0, 0.0, 0.0) if isinstance(e.shape, Plane) else e.shape.center_of_mass for e in entries]
        self.center: npt.NDArray[np.float64] = np.array(centers, np.float64).reshape(-1, 3)
        """(n, 3) centres of mass in the bodies' own frames [m]."""
        self._rows = {entry.id: row for row, entry in enumerate(entries)}

    def __len__(self) -> int:
        return len(self.entries)

    def row(self, identity: int | None) -> int | None:
        """The row of a body, or None if it is not there."""
        return None if identity is None else self._rows.get(identity)


@dataclass(frozen=True)
class Frame:
    """A moment of a world or of a recording. Arrays have a row for each entry of ``table`` and are not written to."""

    table: Table
    time: float
    """Simulated time [s]."""
    steps: int
    """Steps taken; of a recording, the step that is shown."""
    position: Array
    """(n, 3) origins of the bodies' own frames [m]; NaN where a recorded body is not in the world."""
    orientation: Array
    """(n, 4) unit quaternions (w, x, y, z)."""
    velocity: Array
    """(n, 3) velocities of the centres of mass [m/s]."""
    angular_velocity: Array
    """(n, 3) [rad/s]."""
    acceleration: Array
    """(n, 3) change of velocity over the last step, divided by its length [m/s²]."""
    asleep: Array
    """(n,) whether each body sleeps."""
    gravity: Array
    """(3,) [m/s²]."""
    dt: float
    """Length of a step [s]."""
    contacts: Array | None = None
    """Contact points of the last step, as ``World.contacts``; None if they were not asked for or not recorded."""
    contact_count: int = 0
    joints: JointsNow | None = None
    """None of a recording that holds none."""
    running: bool = False
    is_recorded: bool = False
    """Whether it is of a recording."""
    settings: Mapping[str, Any] = field(default_factory=dict)
    """The world's settings by name, with ``dt`` and ``speed``."""
    energy: tuple[float, float] | None = None
    """Kinetic and potential [J]; None if it was not asked for."""
    kinetic: tuple[int, float] | None = None
    """Id and kinetic energy, with that of the rotation [J], of the body that was asked for, if it is dynamic."""
    momentum: Array | None = None
    """(3,) [kg m/s]; None if it was not asked for."""
    stages: Mapping[str, float] = field(default_factory=dict)
    """Seconds per step and stage, averaged over the last steps."""
    real_time_factor: float = 0.0
    """Simulated seconds per second over the last half second."""
    error: str = ""
    """Why the simulation stopped; empty if nothing is wrong."""
    title: str = ""
    """Name of the scene or recording."""
