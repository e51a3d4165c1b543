"""``atlasphys view``: the interactive world, or the replay of a recording, in the browser."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

if TYPE_CHECKING:
    from atlasphys.viewer.replay import Replay
    from atlasphys.viewer.session import Session


def view(
    what: str = "demo",
    /,
    *,
    set: Annotated[list[str] | None, Parameter(negative=())] = None,
    preset: str | None = None,
    solver: str | None = None,
    port: int | None = None,
    open: bool = True,
    shadows: bool = True,
    dark: Annotated[bool, Parameter(negative=())] = False,
) -> int:
    """Show a scene as an interactive world, or replay a recording, on a page in the browser. Ctrl-C ends it.

    Parameters
    ----------
    what
        Name of a scene of the library (see `atlasphys scenes`), a scene file, or a recording (.h5).
    set
        NAME=VALUE: a parameter of a scene of the library. May be given several times.
    preset
        Named choice of algorithms, such as classic.
    solver
        Name of the solver.
    port
        Port of the page on this machine; 0: any that is free. Default: 8080, or the next free one.
    open
        Open the page in the browser.
    shadows
        Draw shadows.
    dark
        Begin with dark colours.
    """
    from atlasphys.viewer.gui.page import Page, Shown

    given = {"preset": preset, "solver": solver}
    model = open_model(what, set or [], {name: value for name, value in given.items() if value is not None})
    page = Page(model, port=port, shown=Shown(shadows=shadows), dark=dark)
    return until_interrupted(page, page.frame.title, open)


def until_interrupted(page: Any, title: str, in_browser: bool) -> int:
    """Say where a page is and serve it until Ctrl-C; open it in the browser if that is wanted."""
    try:
        print(f"{title} at {page.url}  (Ctrl-C ends)", flush=True)  # whoever reads it may interrupt at once
        if in_browser:
            import webbrowser

            webbrowser.open(page.url)
        while True:
            time.sleep(3600)
    except KeyboardInterrupt:
        print(file=sys.stderr)
    finally:
        page.close()
    return 0


def open_model(what: str, parameters: list[str], settings: dict[str, str]) -> Session | Replay:
    """The session of a scene, or the replay of a recording.

    Raises:
        SceneError, RecordingError, InvalidArgumentError: there is none, or it is wrong.
    """
    from atlasphys.cli.run import parameters_of
    from atlasphys.errors import InvalidArgumentError
    from atlasphys.scene.load import load_scene
    from atlasphys.viewer.session import Session

    if is_recording(what):
        from atlasphys.viewer.replay import Replay

        if parameters or settings:
            raise InvalidArgumentError(f"{what} is a recording: --set, --preset and --solver are for scenes")
        return Replay(what)
    return Session.from_scene(load_scene(what, **parameters_of(parameters)), **settings)


def is_recording(what: str) -> bool:
    """Whether a file is, or by its name would be, a recording."""
    from atlasphys.record.write import HDF5_SIGNATURE

    if Path(what).suffix.lower() in (".h5", ".hdf5"):
        return True
    try:
        with Path(what).open("rb") as file:
            return file.read(len(HDF5_SIGNATURE)) == HDF5_SIGNATURE
    except (OSError, ValueError):
        return False
