"""``atlasphys render``: pictures and films of recordings."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from atlasphys.errors import InvalidArgumentError


def render(
    recording: Path,
    out: Path,
    /,
    *,
    size: str = "1280x720",
    fps: float = 30.0,
    speed: float = 1.0,
    begin: float | None = None,
    end: float | None = None,
    time: float | None = None,
    view: str = "oblique",
    position: str | None = None,
    look_at: str | None = None,
    fov: float = 50.0,
    orthographic: Annotated[bool, Parameter(negative=())] = False,
    follow: str | None = None,
    show: str = "",
    joints: bool = True,
    shadows: bool = True,
    dark: Annotated[bool, Parameter(negative=())] = False,
) -> int:
    """Make a film (.mp4) or a picture (.png) of a recording. No display is needed.

    Parameters
    ----------
    recording
        A recording, as `atlasphys run SCENE --record` makes them.
    out
        The file to be written, .mp4 or .png.
    size
        WIDTHxHEIGHT in pixels.
    fps
        Pictures a second of film.
    speed
        Simulated seconds a second of film.
    begin
        Simulated time at which the film begins [s]. Default: that of the recording.
    end
        Simulated time at which it ends [s]. Default: that of the recording.
    time
        Simulated time of a picture [s]. Default: the end.
    view
        Side from which the whole is seen: oblique, front, back, left, right or top.
    position
        Position of the camera X,Y,Z instead [m].
    look_at
        Point X,Y,Z in the middle of the picture [m].
    fov
        Vertical angle of view [degrees].
    orthographic
        Parallel instead of perspective projection.
    follow
        Name of a body to stay near to.
    show
        What to draw beside the bodies, separated by commas: velocity, force, impulse, contacts, boxes, axes.
    joints
        Draw joints, as lines in front of the bodies.
    shadows
        Draw shadows.
    dark
        On a dark ground.
    """
    from atlasphys.viewer.picture import SHOWABLE, Look
    from atlasphys.viewer.render import Shot, check_output, render_film, render_picture
    from atlasphys.viewer.replay import Replay
    from atlasphys.world.arguments import choice

    shown = tuple(choice("--show", word, SHOWABLE) for word in show.replace(",", " ").split())
    look = Look(size=_size(size), shadows=shadows, dark=dark, shown=shown, joints=joints)
    is_film = check_output(out, look)
    if time is not None and is_film:
        raise InvalidArgumentError("--time is for pictures; a film has --begin and --end")
    replay = Replay(recording)
    try:
        if {"impulse", "contacts"} & set(shown) and not replay.has_contacts:
            raise InvalidArgumentError(f"{recording} holds no contacts; record with --record-contacts to show them")
        shot = Shot(
            replay, view=view, position=_point("--position", position), look_at=_point("--look-at", look_at), field_of_view=fov,
            orthographic=orthographic, follow=follow, moment=None if is_film else replay.end if time is None else time,
        )  # fmt: skip
        if not is_film:
            render_picture(replay, out, shot, look, time)
            print(f"{out}: {look.size[0]}x{look.size[1]}")
            return 0
        with _progress() as report:
            count = render_film(
                replay, out, shot, look, frame_rate=fps, speed=speed, begin=begin, end=end, report=report
            )
        print(f"{out}: {count} pictures of {look.size[0]}x{look.size[1]}, {count / fps:.3g} s")
    finally:
        replay.close()
    return 0


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.lower().partition("x")
    if not (width.isdecimal() and height.isdecimal()):
        raise InvalidArgumentError(f"--size takes WIDTHxHEIGHT, such as 1280x720 (got {text!r})")
    return int(width), int(height)


def _point(option: str, text: str | None) -> tuple[float, float, float] | None:
    if text is None:
        return None
    try:
        x, y, z = (float(word) for word in text.split(","))
    except ValueError:
        raise InvalidArgumentError(f"{option} takes X,Y,Z, such as 5,3,8 (got {text!r})") from None
    return x, y, z


@contextmanager
def _progress() -> Iterator[Callable[[int, int], None]]:
    """A progress bar on standard error, if that is a terminal."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("rendering"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True, disable=not sys.stderr.isatty()) as bar:
        task = bar.add_task("", total=None)
        yield lambda done, count: bar.update(task, completed=done, total=count)
