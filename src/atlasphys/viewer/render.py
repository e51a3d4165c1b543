"""Pictures and films of recordings, without a display."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np

from atlasphys.errors import InvalidArgumentError, MissingExtraError, RecordingError
from atlasphys.viewer.frame import Frame
from atlasphys.viewer.picture import Look, Painter
from atlasphys.viewer.replay import Replay
from atlasphys.viewer.viewpoint import FIELD_OF_VIEW, VIEWS, Viewpoint, box_of_all, view_of_box
from atlasphys.world.arguments import choice, in_range

FILMS = (".mp4",)
PICTURES = (".png",)

Report = Callable[[int, int], None]
"""Told how many pictures are done, and of how many."""


class Shot:
    """Where a recording is filmed from: a fixed viewpoint, or one that moves along with a body.

    Args:
        replay: the recording.
        view: direction from which the whole is seen, out of ``VIEWS``; for what is not given below.
        position, look_at: (3,) [m].
        field_of_view: vertical [°].
        orthographic: parallel projection.
        follow: name of a body that is kept in the middle, near.
        moment: simulated time at which the whole is to be seen [s]. Default: from the beginning to the end.

    Raises:
        InvalidArgumentError: there is no such direction or body, or the camera would be where it looks at.
    """

    def __init__(
        self,
        replay: Replay,
        *,
        view: str = "oblique",
        position: tuple[float, float, float] | None = None,
        look_at: tuple[float, float, float] | None = None,
        field_of_view: float = FIELD_OF_VIEW,
        orthographic: bool = False,
        follow: str | None = None,
        moment: float | None = None,
    ) -> None:
        angle = in_range("field of view", field_of_view, 1.0, 150.0)
        span = replay.end - replay.begin
        times = [replay.begin, replay.begin + 0.5 * span, replay.end] if moment is None else [moment]
        box = box_of_all([_frame_at(replay, time) for time in times])
        whole = view_of_box(choice("view", view, VIEWS), *box, angle, orthographic=orthographic)
        target = whole.look_at if look_at is None else np.array(look_at, np.float64)
        place = whole.position if position is None else np.array(position, np.float64)
        if not np.isfinite([place, target]).all() or np.array_equal(place, target):
            raise InvalidArgumentError("the camera's position and the point it looks at must be finite and differ")
        self._fixed = Viewpoint(place, target, angle, orthographic)
        self._row: int | None = None
        if follow is not None:
            names = {entry.name: row for row, entry in enumerate(replay.table.entries) if entry.name}
            self._row = names[choice("follow", follow, names)]
            volume = replay.table.entries[self._row].shape.volume
            width = float(np.cbrt(volume)) if math.isfinite(volume) else 1.0
            arm = self._fixed.position - self._fixed.look_at
            self._arm = arm if position is not None else 6.0 * width * arm / np.sqrt((arm**2).sum())

    def at(self, frame: Frame) -> Viewpoint:
        """The viewpoint for a frame."""
        if self._row is None:
            return self._fixed
        target = np.asarray(frame.position[self._row], np.float64)
        if not np.isfinite(target).all():
            return self._fixed
        return self._fixed._replace(position=target + self._arm, look_at=target)


def _frame_at(replay: Replay, time: float) -> Frame:
    replay.seek_time(time)
    return replay.frame()


def check_output(path: str | os.PathLike[str], look: Look) -> bool:
    """Whether a file is to be a film rather than a picture.

    Raises:
        InvalidArgumentError: its name says neither, it cannot be written there, or a film cannot have this size.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in (*FILMS, *PICTURES):
        raise InvalidArgumentError(f"{path}: the name must end in .mp4 for a film or .png for a picture")
    if not path.resolve().parent.is_dir():
        raise InvalidArgumentError(f"{path}: there is no folder {path.parent}")
    width, height = look.size
    if not (16 <= width <= 8192 and 16 <= height <= 8192):
        raise InvalidArgumentError(f"the size must be from 16x16 to 8192x8192 pixels (got {width}x{height})")
    if suffix in FILMS and (width % 2 or height % 2):
        raise InvalidArgumentError(f"a film's width and height must be even (got {width}x{height})")
    return suffix in FILMS


def render_picture(
    replay: Replay, path: str | os.PathLike[str], shot: Shot, look: Look, seconds: float | None = None
) -> None:
    """Write a picture of a recording at a simulated time. Default: its last step.

    Raises:
        MissingExtraError: pyvista is not installed.
        RecordingError: the recording is damaged.
        InvalidArgumentError: the file cannot be written.
    """
    replay.seek_time(replay.end if seconds is None else seconds)
    replay.contacts_wanted = True
    frame = replay.frame()
    painter = Painter(frame, look)
    try:
        picture = painter.paint(frame, shot.at(frame))
    finally:
        painter.close()
    from PIL import Image

    part = _part(Path(path))
    try:
        Image.fromarray(picture).save(part)
        os.replace(part, path)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise InvalidArgumentError(f"{path}: cannot be written: {error.strerror or error}") from None


def render_film(
    replay: Replay,
    path: str | os.PathLike[str],
    shot: Shot,
    look: Look,
    *,
    frame_rate: float = 30.0,
    speed: float = 1.0,
    begin: float | None = None,
    end: float | None = None,
    report: Report = lambda done, count: None,
) -> int:
    """Write a film of a recording. The file appears when it is complete.

    Args:
        replay: the recording.
        path: the file, .mp4.
        shot: where it is filmed from.
        look: how it looks.
        frame_rate: pictures a second of film.
        speed: simulated seconds a second of film.
        begin, end: simulated times between which is filmed [s]. Default: all.
        report: told of the progress.

    Returns:
        The number of pictures.

    Raises:
        MissingExtraError: pyvista or imageio-ffmpeg is not installed.
        RecordingError: the recording is damaged.
        InvalidArgumentError: a value is out of range, or the file cannot be written.
    """
    try:
        import imageio_ffmpeg
    except ImportError:
        raise MissingExtraError("films need the package imageio-ffmpeg: pip install 'atlasphys[render]'") from None
    rate, factor = in_range("frame rate", frame_rate, 1.0, 240.0), in_range("speed", speed, 1e-3, 1e3)
    first = replay.begin if begin is None else max(begin, replay.begin)
    last = replay.end if end is None else min(end, replay.end)
    if not first <= last:
        raise InvalidArgumentError(
            f"there is nothing to film between {first:g} s and {last:g} s; the recording is from {replay.begin:g} s to {replay.end:g} s"
        )
    count = 1 + round((last - first) / factor * rate)
    replay.contacts_wanted = True
    replay.seek_time(first)
    painter = Painter(replay.frame(), look)
    part = _part(Path(path))
    writer = imageio_ffmpeg.write_frames(
        str(part), look.size, fps=rate, codec="libx264", quality=7, macro_block_size=2, ffmpeg_log_level="error"
    )
    try:
        writer.send(None)
        for k in range(count):
            replay.seek_time(first + k * factor / rate)
            frame = replay.frame()
            writer.send(np.ascontiguousarray(painter.paint(frame, shot.at(frame))))
            report(k + 1, count)
        writer.close()
        os.replace(part, path)
    except OSError as error:
        if isinstance(error, RecordingError):
            raise
        raise InvalidArgumentError(f"{path}: cannot be written: {error.strerror or error}") from None
    finally:
        writer.close()
        part.unlink(missing_ok=True)
        painter.close()
    return count


def _part(path: Path) -> Path:
    """The file that is written before it takes the place of ``path``."""
    return path.with_name(f".{path.stem}.{os.getpid()}.part{path.suffix}")
