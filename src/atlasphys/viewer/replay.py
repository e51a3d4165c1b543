"""A recording as a model that can be run like a session: commands in, frames out."""

from __future__ import annotations

import os
import time
from typing import Any

import numpy as np
import numpy.typing as npt

from atlasphys.engine.state.joints import WORLD
from atlasphys.errors import AtlasPhysError, RecordingError
from atlasphys.record.layout import ACTS, NOT_THERE
from atlasphys.record.read import Recording
from atlasphys.scene.faults import Source
from atlasphys.scene.joints import JOINTS
from atlasphys.scene.scene import check
from atlasphys.scene.schema import VERSION, BodyModel
from atlasphys.viewer.frame import Entry, Frame, Table
from atlasphys.viewer.joints import JointsNow, JointTable, entry_of
from atlasphys.viewer.meter import Meter
from atlasphys.world.arguments import in_range, rgb
from atlasphys.world.rotation import conjugate, rotate

CHUNK = 50
"""Steps that are read together: as many as lie together in the file."""

Floats = npt.NDArray[np.float64]


class Replay:
    """A recording and a place in it.

    Args:
        path: the file.

    Raises:
        RecordingError: it cannot be read, is no recording, is damaged, or holds no step.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.recording = Recording(path)
        if len(self.recording) == 0:
            self.recording.close()
            raise RecordingError(f"{path}: holds no step yet")
        self.contacts_wanted = self.totals_wanted = False
        self.running, self.loop, self.speed, self.changes = False, True, 1.0, 0
        self.now = 0
        """The step that is shown."""
        self._time = self.begin
        self._meter = Meter()
        self.table = _table(self.recording)
        self.joint_wanted: int | None = None
        self.body_wanted: int | None = None
        """As of a session; a recording knows neither forces of joints nor moments of inertia."""
        self._joints = _joint_table(self.recording, self.table)
        ends = [[joint.get(side, WORLD) for side in "ab"] for joint in self.recording.joints]
        self._joint_bodies = np.array(ends, np.int32).reshape(-1, 2)
        self._window: tuple[int, Floats] = (-1, np.empty(0))
        self._gravity = np.array(self.recording.scene.model.world.gravity or (0.0, -9.81, 0.0))

    @property
    def last_step(self) -> int:
        """Number of the last recorded step."""
        return len(self.recording) - 1

    @property
    def begin(self) -> float:
        """Simulated time of the first recorded step [s]."""
        return float(self.recording.times[0])

    @property
    def end(self) -> float:
        """Simulated time of the last one [s]."""
        return float(self.recording.times[-1])

    @property
    def has_contacts(self) -> bool:
        """Whether contact points were recorded."""
        return self.recording.has_contacts

    @property
    def has_joints(self) -> bool:
        """Whether joints were recorded."""
        return len(self._joints) > 0

    # Commands --------------------------------------------------------------------------------------------------------

    def start(self) -> None:
        """Play, from the beginning if this is the end."""
        if self.now == self.last_step:
            self.seek(0)
        self.running = True
        self._meter.restart()
        self.changes += 1

    def stop(self) -> None:
        """Pause."""
        self.running = False
        self.changes += 1

    def step(self, count: int = 1) -> None:
        """Pause, and go on by so many recorded steps, or back."""
        self.stop()
        self.seek(self.now + count)

    def seek(self, step: int) -> None:
        """Show a recorded step; the first or last if there is none of that number."""
        self.now = max(0, min(int(step), self.last_step))
        self._time = float(self.recording.times[self.now])
        self._meter.restart()
        self.changes += 1

    def seek_time(self, seconds: float) -> None:
        """Show the last step that is not later than a simulated time."""
        self.seek(int(np.searchsorted(self.recording.times, seconds + 1e-9, side="right")) - 1)

    def set_speed(self, factor: float) -> None:
        """Set how many recorded seconds pass in one, 0.01 to 100."""
        self.speed = in_range("speed", factor, 0.01, 100.0)
        self.changes += 1

    def advance(self, elapsed: float) -> None:
        """Let ``elapsed`` seconds of wall time pass."""
        if not self.running:
            return
        self._time += elapsed * self.speed
        if self._time > self.end:
            if self.loop and self.end > self.begin:
                self._time = self.begin + (self._time - self.end) % (self.end - self.begin)
                self._meter.restart()
            else:
                self._time = self.end
                self.running = False
            self.changes += 1
        step = max(0, int(np.searchsorted(self.recording.times, self._time + 1e-9, side="right")) - 1)
        self._meter.note_time(time.perf_counter(), self._time)
        if step != self.now:
            self.now = step
            self.changes += 1

    @property
    def until_next_step(self) -> float:
        """Wall time until another step is to be shown [s]."""
        if not self.running or self.now >= self.last_step:
            return 0.05 if self.running else float("inf")
        return max(0.0, (float(self.recording.times[self.now + 1]) - self._time) / self.speed)

    def close(self) -> None:
        """Close the file."""
        self.recording.close()

    # What is shown ---------------------------------------------------------------------------------------------------

    def _poses(self, step: int) -> Floats:
        """(b, 7) positions and orientations of a step."""
        first = step // CHUNK * CHUNK
        if self._window[0] != first:
            self._window = (first, self.recording.read_poses(first, min(first + CHUNK, len(self.recording))))
        poses: Floats = self._window[1][step - first]
        return poses

    def _velocities(self, step: int) -> tuple[Floats, Floats, float]:
        """Linear and angular velocities of the centres of mass between a step and the one before, and the time between them."""
        count = len(self.table)
        if step == 0:
            return np.zeros((count, 3)), np.zeros((count, 3)), 1.0
        h = float(self.recording.times[step] - self.recording.times[step - 1]) or 1.0
        then, now = self._poses(step - 1), self._poses(step)
        moved = _centers(now, self.table) - _centers(then, self.table)
        turn = _times(now[:, 3:7], conjugate(then[:, 3:7]))
        turn = np.where(turn[:, :1] < 0, -turn, turn)
        spin = 2.0 * turn[:, 1:] / h
        return np.nan_to_num(moved / h), np.nan_to_num(spin), h

    def _joints_now(self, step: int) -> JointsNow | None:
        if not self.has_joints:
            return None
        states = self.recording.joint_states(step)
        return JointsNow(self._joints, self._joint_bodies, states == ACTS, there=states != NOT_THERE)

    def frame(self) -> Frame:
        """The present step. Velocities and accelerations are differences of recorded poses."""
        step = self.now
        velocity, spin, h = self._velocities(step)
        before = self._velocities(step - 1)[0] if step > 1 else velocity
        poses = self._poses(step)
        contacts = self.recording.contacts(step) if self.contacts_wanted and self.has_contacts else None
        return Frame(
            table=self.table,
            time=float(self.recording.times[step]),
            steps=step,
            position=poses[:, 0:3],
            orientation=poses[:, 3:7],
            velocity=velocity,
            angular_velocity=spin,
            acceleration=(velocity - before) / h,
            asleep=np.zeros(len(self.table), np.bool_),
            gravity=self._gravity,
            dt=h,
            contacts=contacts,
            joints=self._joints_now(step),
            contact_count=0 if contacts is None else len(contacts),
            running=self.running,
            is_recorded=True,
            settings={"speed": self.speed},
            real_time_factor=self._meter.real_time_factor if self.running else 0.0,
            title=self.recording.path.name,
        )


def _table(recording: Recording) -> Table:
    """The recorded bodies."""
    entries = []
    for row, data in enumerate(recording.bodies):
        model: BodyModel = check({"version": VERSION, "bodies": [data]}, Source(str(recording.path))).bodies[0]
        shape = model.shape.make()
        kind = model.kind or ("static" if np.isinf(shape.volume) else "dynamic")
        mass = model.mass if model.mass is not None else (model.density or 1000.0) * shape.volume
        colour: Any = None if model.color is None else rgb(model.color)
        entries.append(Entry(row, model.name, shape, kind, colour, mass if kind == "dynamic" else np.inf))
    return Table(tuple(entries))


def _joint_table(recording: Recording, bodies: Table) -> JointTable:
    """The recorded joints; a joint's id is its row."""
    entries, kinds = [], []
    for row, data in enumerate(recording.joints):
        try:
            model = JOINTS[data["type"]](**{key: value for key, value in data.items() if key not in ("a", "b")})
            kinds.append(model.make())
        except (AtlasPhysError, KeyError, ValueError, TypeError) as error:
            raise RecordingError(f"{recording.path}: is damaged: joint {row}: {error}") from None
        ends = [bodies.entries[data[side]].label if side in data else "the world" for side in "ab"]
        entries.append(entry_of(row, row, kinds[-1], data.get("name"), (ends[0], ends[1])))
    return JointTable(entries, kinds)


def _centers(poses: Floats, table: Table) -> Floats:
    return np.asarray(poses[:, 0:3] + rotate(poses[:, 3:7], table.center))


def _times(p: Floats, q: Floats) -> Floats:
    """Products of quaternions, row by row."""
    w = p[:, 0] * q[:, 0] - (p[:, 1:] * q[:, 1:]).sum(axis=1)
    return np.concatenate(
        [w[:, None], p[:, :1] * q[:, 1:] + q[:, :1] * p[:, 1:] + np.cross(p[:, 1:], q[:, 1:])], axis=1
    )
