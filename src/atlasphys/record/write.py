"""Write a recording while a world runs."""

from __future__ import annotations

import io
import json
import os
import time
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import numpy.typing as npt

from atlasphys.engine.state.joints import WORLD
from atlasphys.errors import RecordingError
from atlasphys.record.journal import JournaledFile
from atlasphys.record.layout import ACTS, CHUNK_BODIES, CHUNK_STEPS, CONTACT_COLUMNS, FORMAT, IDLE, VERSION
from atlasphys.scene.build import describe_body
from atlasphys.scene.joints import describe_joint
from atlasphys.scene.scene import Scene

HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
"""What every HDF5 file, so every recording, begins with."""

if TYPE_CHECKING:
    from atlasphys.world.world import World

LONGEST_WAIT = 2.0
"""Steps reach the file when 50 are together, or at the first that is recorded later than this after the last [s]."""


class Recorder:
    """Records the poses of a world's bodies, and which joints act, in a file, step by step.

    The file can be read after the writer was killed, at any moment: it then ends with the last steps that had reached it.
    It can also be read while it is written, but not during a commit (some milliseconds, every 50 steps): a reader that comes
    upon one gets a RecordingError and should open the file again. Bodies may be added and removed between steps. An existing file is replaced.

    Args:
        path: the file, usually ``.h5``.
        world: the world.
        scene: what the world was built from, kept in the recording. Default: the world as it is now.
        contacts: whether contact points are recorded too, which the viewer can show. They take several times the room of the poses.

    Raises:
        RecordingError: the file cannot be written.

    >>> import tempfile, atlasphys as ap
    >>> world = ap.World()
    >>> ball = world.add(ap.Sphere(radius=0.5), position=(0, 3, 0), name="ball")
    >>> path = tempfile.mkdtemp() + "/fall.h5"
    >>> with ap.Recorder(path, world) as recorder:
    ...     for _ in range(3):
    ...         world.step(1 / 60)
    ...         recorder.record()
    >>> with ap.Recording(path) as recording:
    ...     print(len(recording), recording.body("ball").positions[-1, 1])
    3 2.98672
    """

    def __init__(
        self, path: str | os.PathLike[str], world: World, scene: Scene | None = None, *, contacts: bool = False
    ) -> None:
        import h5py

        self.path = Path(path)
        _refuse_other_files(self.path)
        self.steps = 0
        """Number of recorded steps."""
        self._world = world
        self._ids = np.empty(0, np.int64)
        self._columns = np.empty(0, np.intp)
        self._column_of: dict[int, int] = {}
        self._new_bodies: list[str] = []
        self._joint_ids = np.empty(0, np.int64)
        self._joint_columns = np.empty(0, np.intp)
        self._column_of_joint: dict[int, int] = {}
        self._new_joints: list[str] = []
        self._joint_states = np.zeros((CHUNK_STEPS, 0), np.uint8)
        self._times = np.empty(CHUNK_STEPS)
        self._poses = np.full((CHUNK_STEPS, CHUNK_BODIES, 7), np.nan)
        self._contacts: list[npt.NDArray[np.float32]] | None = [] if contacts else None
        """Contact points of the steps of the present chunk."""
        self._contacts_before = 0
        """Number of those of the chunks before."""
        self._filled = self._stored = 0
        self._last_commit = time.monotonic()
        try:
            _replace(self.path.resolve(), _empty_recording(scene or Scene.from_world(world), contacts))
            self._journal = JournaledFile(open(self.path, "r+b", buffering=0))  # noqa: SIM115
        except (OSError, ValueError) as error:  # ValueError: a null character in the name
            raise RecordingError(f"{self.path}: cannot be written: {_reason(error)}") from None
        self._file = h5py.File(self._journal, "r+")

    @property
    def closed(self) -> bool:
        """Whether the recording is closed."""
        return not self._file

    def record(self) -> None:
        """Record the world as it is now.

        Raises:
            RecordingError: the file can no longer be written, for one because the disk is full. It keeps the steps that
                had reached it.
        """
        if self.closed:
            raise RecordingError(f"{self.path}: the recording is closed")
        bodies = self._world.bodies
        ids = bodies.id
        if not np.array_equal(ids, self._ids):
            self._assign_columns(ids)
        row = self._filled
        self._times[row] = self._world.time
        self._poses[row] = np.nan
        self._poses[row, self._columns, 0:3] = bodies.position
        self._poses[row, self._columns, 3:7] = bodies.orientation
        self._record_joints(row)
        if self._contacts is not None:
            self._contacts.append(self._contact_rows())
        self._filled += 1
        self.steps += 1
        if self._filled == CHUNK_STEPS or time.monotonic() - self._last_commit > LONGEST_WAIT:
            self._commit()

    def close(self) -> None:
        """Write what is left and close the file.

        Raises:
            RecordingError: as :meth:`record`.
        """
        if not self.closed:
            self._commit()
            self._close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _assign_columns(self, ids: npt.NDArray[np.int64]) -> None:
        """Give each body its column: that which it had, or the next free one."""
        for row, identity in enumerate(ids.tolist()):
            if identity not in self._column_of:
                self._column_of[identity] = len(self._column_of)
                self._new_bodies.append(json.dumps(describe_body(self._world.bodies[row])))
        self._ids = ids.copy()
        self._columns = np.array([self._column_of[identity] for identity in ids.tolist()], np.intp)
        missing = len(self._column_of) - self._poses.shape[1]
        if missing > 0:
            room = np.full((CHUNK_STEPS, max(missing, self._poses.shape[1]), 7), np.nan)
            self._poses = np.concatenate([self._poses, room], axis=1)

    def _record_joints(self, row: int) -> None:
        """Note which joints there are and which act; each keeps its column."""
        joints = self._world.joints
        ids = joints.id
        if not np.array_equal(ids, self._joint_ids):
            for place, identity in enumerate(ids.tolist()):
                if identity not in self._column_of_joint:
                    self._column_of_joint[identity] = len(self._column_of_joint)
                    ends = {
                        side: int(self._columns[end])
                        for side, end in zip("ab", joints.bodies[place].tolist(), strict=True)
                        if end != WORLD
                    }
                    entry = {key: value for key, value in describe_joint(joints[place]).items() if key not in "ab"}
                    self._new_joints.append(json.dumps(entry | ends))
            self._joint_ids = ids.copy()
            self._joint_columns = np.array([self._column_of_joint[identity] for identity in ids.tolist()], np.intp)
            missing = len(self._column_of_joint) - self._joint_states.shape[1]
            self._joint_states = np.pad(self._joint_states, ((0, 0), (0, missing)))
        self._joint_states[row] = 0
        self._joint_states[row, self._joint_columns] = np.where(joints.acts, ACTS, IDLE)

    def _contact_rows(self) -> npt.NDArray[np.float32]:
        """(k, 13) the contact points of the last step."""
        points = self._world.contacts
        columns = [points[name].reshape(len(points), width) for name, width in CONTACT_COLUMNS.items()]
        columns[:2] = [self._columns[rows] for rows in columns[:2]]
        return np.concatenate(columns, axis=1).astype(np.float32)

    def _commit(self) -> None:
        """Write the steps of the present chunk. A full chunk ends here; another is written again later, with more."""
        first, last, count = self._stored, self._stored + self._filled, len(self._column_of)
        try:
            bodies, times, poses = (self._file[name] for name in ("bodies", "time", "poses"))
            if self._new_bodies:
                known = len(bodies)
                bodies.resize((count,))
                bodies[known:] = self._new_bodies
                self._new_bodies.clear()
            times.resize((last,))
            times[first:] = self._times[: self._filled]
            poses.resize((last, count, 7))
            poses[first:] = self._poses[: self._filled, :count]
            self._commit_joints(first, last)
            if self._contacts is not None:
                ends = self._contacts_before + np.cumsum([len(rows) for rows in self._contacts], dtype=np.int64)
                for name, values, start in (
                    ("contact_end", ends, first),
                    ("contacts", np.concatenate(self._contacts), self._contacts_before),
                ):
                    self._file[name].resize(start + len(values), axis=0)
                    self._file[name][start:] = values
            self._file.flush()
            self._journal.commit()
        except (OSError, RuntimeError) as error:  # h5py wraps what the file below it raises
            self._journal.abandon()
            self._close()
            kept = f"the first {self._stored} steps are kept"
            raise RecordingError(f"{self.path}: cannot be written any more: {_reason(error)}; {kept}") from None
        self._last_commit = time.monotonic()
        if self._filled == CHUNK_STEPS:
            self._stored, self._filled = last, 0
            if self._contacts is not None:
                self._contacts_before += sum(len(rows) for rows in self._contacts)
                self._contacts.clear()

    def _commit_joints(self, first: int, last: int) -> None:
        joints, states, count = self._file["joints"], self._file["joint_state"], len(self._column_of_joint)
        if self._new_joints:
            joints.resize((count,))
            joints[count - len(self._new_joints) :] = self._new_joints
            self._new_joints.clear()
        states.resize((last, count))
        if count:
            states[first:] = self._joint_states[: self._filled]

    def _close(self) -> None:
        self._file.close()
        self._journal.commit()
        self._journal.close()


def _empty_recording(scene: Scene, contacts: bool) -> bytes:
    """The file before the first step. Made in memory, so that a whole file appears at once."""
    import h5py

    from atlasphys import __version__

    image = io.BytesIO()
    text = h5py.string_dtype()
    packed: dict[str, Any] = {"compression": "gzip", "compression_opts": 1, "shuffle": True, "fletcher32": True}
    with h5py.File(image, "w") as file:
        file.attrs.update({"format": FORMAT, "version": VERSION, "atlasphys": __version__})
        file.create_dataset("scene", data=json.dumps(scene.data()), dtype=text)
        file.create_dataset("bodies", (0,), text, maxshape=(None,), chunks=(CHUNK_BODIES,))
        file.create_dataset("time", (0,), "f8", maxshape=(None,), chunks=(20 * CHUNK_STEPS,))
        chunks = (CHUNK_STEPS, CHUNK_BODIES, 7)
        file.create_dataset(
            "poses", (0, 0, 7), "f8", maxshape=(None, None, 7), chunks=chunks, fillvalue=np.nan, **packed
        )
        file.create_dataset("joints", (0,), text, maxshape=(None,), chunks=(CHUNK_BODIES,))
        file.create_dataset("joint_state", (0, 0), "u1", maxshape=(None, None), chunks=(CHUNK_STEPS, 256), **packed)
        if contacts:
            width = sum(CONTACT_COLUMNS.values())
            file.create_dataset("contact_end", (0,), "i8", maxshape=(None,), chunks=(20 * CHUNK_STEPS,))
            file.create_dataset("contacts", (0, width), "f4", maxshape=(None, width), chunks=(2048, width), **packed)
    return image.getvalue()


def _refuse_other_files(path: Path) -> None:
    """A recording may replace a recording, but nothing else that is not empty."""
    try:
        with path.open("rb") as file:
            start = file.read(len(HDF5_SIGNATURE))
    except (OSError, ValueError):
        return  # new, or what cannot be written either
    if start and start != HDF5_SIGNATURE:
        raise RecordingError(f"{path}: is there already and is no recording; it is not replaced")


def _replace(path: Path, content: bytes) -> None:
    """Put a file of this content in the place of the file that is there, if any, at once."""
    if path.exists() and not path.is_file():
        raise ValueError("it is not a regular file")
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        part.write_bytes(content)
        os.replace(part, path)
    except OSError:
        part.unlink(missing_ok=True)
        raise


def _reason(error: Exception) -> str:
    return getattr(error, "strerror", None) or str(error)
