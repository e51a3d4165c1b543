"""Read a recording."""

from __future__ import annotations

import json
import os
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np
import numpy.typing as npt

from atlasphys.errors import RecordingError
from atlasphys.record.journal import JournaledFile, has_journal
from atlasphys.record.layout import CONTACT_COLUMNS, FORMAT, VERSION
from atlasphys.scene.faults import Source, did_you_mean, show
from atlasphys.scene.scene import Scene
from atlasphys.world.views import CONTACT

if TYPE_CHECKING:
    from collections.abc import Iterator

Array = npt.NDArray[np.float64]


class Poses(NamedTuple):
    """Where all bodies are at one step, in the rows of ``Recording.names``; NaN where a body was not in the world."""

    positions: Array
    """(b, 3) origins of the bodies' own frames [m]."""
    orientations: Array
    """(b, 4) unit quaternions (w, x, y, z)."""


class Trajectory(NamedTuple):
    """Where one body is at all steps; NaN where it was not in the world."""

    times: Array
    """(s,) simulated time [s]."""
    positions: Array
    """(s, 3) origins of the body's own frame [m]."""
    orientations: Array
    """(s, 4) unit quaternions (w, x, y, z)."""


class Recording:
    """A recording, read from its file as it is asked for. Its length is the number of recorded steps.

    Args:
        path: the file. If its writer was killed, it is read up to the last step that had reached it.

    Raises:
        RecordingError: the file cannot be read, is no recording, is cut short, or is of a newer version.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        import h5py

        self.path = Path(path)
        try:
            file = open(self.path, "rb", buffering=0)  # noqa: SIM115
        except (OSError, ValueError) as error:  # ValueError: a null character in the name
            raise RecordingError(f"{self.path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
        with file:
            journaled = has_journal(file)
        with self._reading():
            if journaled:
                self._file = h5py.File(JournaledFile(open(self.path, "rb", buffering=0)), "r")  # noqa: SIM115
            else:
                self._file = h5py.File(self.path, "r")
        try:
            self._check()
        except BaseException:
            self._file.close()
            raise

    def _check(self) -> None:
        with self._reading():
            attributes = dict(self._file.attrs)
        if attributes.get("format") != FORMAT:
            raise RecordingError(f"{self.path}: is an HDF5 file, but no recording of AtlasPhys")
        version = attributes.get("version")
        if version != VERSION:
            by = f" (written by AtlasPhys {attributes.get('atlasphys')})"
            raise RecordingError(f"{self.path}: is of version {version}{by}; this AtlasPhys reads version {VERSION}")
        shapes = {"scene": 0, "bodies": 1, "time": 1, "poses": 3}
        with self._reading():
            missing = [name for name, axes in shapes.items() if getattr(self._file.get(name), "ndim", None) != axes]
            if missing:
                raise RecordingError(f"{self.path}: is damaged: {', '.join(missing)} is missing or of the wrong form")
            self.times = self._file["time"][:]
            """(s,) simulated time of each recorded step [s]."""
            poses = self._file["poses"].shape
        self.times.flags.writeable = False
        if poses != (len(self.times), len(self.bodies), 7):
            raise RecordingError(f"{self.path}: is damaged: poses of {poses} for {len(self.times)} steps")

    @contextmanager
    def _reading(self) -> Iterator[None]:
        """Say whose fault it is when HDF5 cannot make sense of the file."""
        if not getattr(self, "_file", True):
            raise RecordingError(f"{self.path}: is closed")
        try:
            yield
        except RecordingError:
            raise
        except (OSError, RuntimeError, KeyError, ValueError, TypeError, AttributeError) as error:
            text = str(error)
            if "signature not found" in text:
                reason = "is no recording: it is not an HDF5 file"
            elif "truncated file" in text:
                reason = "is cut short, perhaps by a copy that did not finish"
            else:
                reason = f"is damaged: {text}"
            raise RecordingError(f"{self.path}: {reason}") from None

    @cached_property
    def bodies(self) -> tuple[dict[str, Any], ...]:
        """Every body that was ever recorded, in the form of a scene file, as it was at its first recorded step."""
        with self._reading():
            bodies = tuple(json.loads(text) for text in self._file["bodies"][:])
            if not all(isinstance(body, dict) for body in bodies):
                raise ValueError("a body is not described by an object")
        return bodies

    @property
    def names(self) -> list[str | None]:
        """Names of the bodies, None where a body has none."""
        return [body.get("name") for body in self.bodies]

    @cached_property
    def scene(self) -> Scene:
        """The scene that the world was built from."""
        with self._reading():
            data = json.loads(self._file["scene"][()])
        return Scene.from_data(data, Source(str(self.path)))

    def __len__(self) -> int:
        return len(self.times)

    def poses(self, step: int) -> Poses:
        """Poses of all bodies at one recorded step; nothing else is read.

        Args:
            step: from 0, or from the end if negative.

        Raises:
            IndexError: there is no such step.
            RecordingError: the file is damaged.
        """
        count = len(self)
        if isinstance(step, bool) or not hasattr(step, "__index__"):
            raise TypeError(f"step must be an integer (got {show(step)})")
        if not -count <= step < count:
            raise IndexError(f"the recording has {count} steps (got {show(step)})")
        with self._reading():
            values = self._file["poses"][step.__index__() % count]
        return Poses(values[:, 0:3], values[:, 3:7])

    def read_poses(self, first: int, last: int) -> Array:
        """(last − first, b, 7) positions and orientations of all bodies at the steps from ``first`` to before ``last``, read together.

        Raises:
            IndexError: there are no such steps.
            RecordingError: the file is damaged.
        """
        if not 0 <= first <= last <= len(self):
            raise IndexError(f"the recording has {len(self)} steps (got {show(first)} to {show(last)})")
        with self._reading():
            values: Array = self._file["poses"][first:last]
        return values

    @cached_property
    def joints(self) -> tuple[dict[str, Any], ...]:
        """Every joint that was ever recorded, in the form of a scene file, as it was at first; ``a`` and ``b`` are rows of ``bodies``."""
        with self._reading():
            joints = tuple(json.loads(text) for text in self._file["joints"][:]) if "joints" in self._file else ()
            ends = [joint.get(side, 0) for joint in joints for side in "ab"]
            if not all(isinstance(end, int) and 0 <= end < len(self.bodies) for end in ends):
                raise ValueError("a joint is of bodies that are not there")
        return joints

    def joint_states(self, step: int) -> npt.NDArray[np.uint8]:
        """(j,) what each of ``joints`` does at a recorded step: 0, it is not in the world; 1, it is disabled or broken; 2, it acts.

        Raises:
            IndexError: there is no such step.
            RecordingError: the file is damaged.
        """
        if not 0 <= step < len(self):
            raise IndexError(f"the recording has {len(self)} steps (got {show(step)})")
        if not self.joints:
            return np.zeros(0, np.uint8)
        with self._reading():
            states: npt.NDArray[np.uint8] = self._file["joint_state"][step]
            if len(states) != len(self.joints):
                raise ValueError(f"states of {len(states)} joints, of which there are {len(self.joints)}")
        return states

    @cached_property
    def has_contacts(self) -> bool:
        """Whether contact points were recorded."""
        with self._reading():
            return "contacts" in self._file and "contact_end" in self._file

    def contacts(self, step: int) -> np.recarray[Any, Any]:
        """Contact points at one recorded step, as :attr:`World.contacts` has them, bodies being rows of ``names``; none if none were recorded.

        Raises:
            IndexError: there is no such step.
            RecordingError: the file is damaged.
        """
        if not 0 <= step < len(self):
            raise IndexError(f"the recording has {len(self)} steps (got {show(step)})")
        rows = np.empty((0, sum(CONTACT_COLUMNS.values())))
        if self.has_contacts:
            with self._reading():
                begin = self._file["contact_end"][step - 1] if step else 0
                rows = self._file["contacts"][begin : self._file["contact_end"][step]]
        points, first = np.zeros(len(rows), CONTACT), 0
        for name, width in CONTACT_COLUMNS.items():
            points[name] = rows[:, first : first + width].reshape(points[name].shape)
            first += width
        return points.view(np.recarray)

    def body(self, name: str | int) -> Trajectory:
        """One body at all steps.

        Args:
            name: the body's name, or its row in ``names``.

        Raises:
            LookupError: there is no such body.
            RecordingError: the file is damaged.
        """
        if isinstance(name, str):
            found = [row for row, known in enumerate(self.names) if known == name]
            if not found:
                named = [known for known in self.names if known is not None]
                raise KeyError(f"no recorded body is named {name!r}; {did_you_mean(name, named)}")
            row = found[-1]
        else:
            row = range(len(self.bodies))[name]
        with self._reading():
            values = self._file["poses"][:, row]
        return Trajectory(self.times, values[:, 0:3], values[:, 3:7])

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        span = f", {self.times[0]:.6g} to {self.times[-1]:.6g} s" if len(self) else ""
        return f"<Recording {str(self.path)!r}: {len(self)} steps of {len(self.bodies)} bodies{span}>"
