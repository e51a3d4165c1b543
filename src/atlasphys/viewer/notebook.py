"""The viewer inside a notebook."""

from __future__ import annotations

import base64
import importlib.util
import io
import os
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from atlasphys.errors import InvalidArgumentError
from atlasphys.viewer.session import Session
from atlasphys.world.arguments import choice, in_range

if TYPE_CHECKING:
    from atlasphys.explainer import Story
    from atlasphys.viewer.explorer.page import Page as Explanation
    from atlasphys.viewer.gui.page import Page
    from atlasphys.world.world import World

PANEL_WIDTH = 340
"""Of the panel in a notebook, whose cells are narrow: a wider one hides the middle of the scene [pixels]."""


WAYS = ("auto", "page", "proxy", "picture", "film")
"""How a world can be shown."""

FRAME = """<div><iframe src="URL" width="100%" height="HEIGHT" style="border:0"></iframe>
<div style="display:none;padding:1em;border:1px solid">Nothing answers at URL.
The page is served on the machine where the kernel runs, and this browser seems to be on another. There, a world is shown by
<code>world.view(inline="picture")</code> or <code>world.view(inline="film")</code>, or its page by
<code>world.view(inline="proxy")</code>, where the notebook server has jupyter-server-proxy.</div>
<img src="data:," style="display:none" onerror="const parts = this.parentElement.children;
fetch('URL', {mode: 'no-cors'}).catch(function () { parts[0].style.display = 'none'; parts[1].style.display = ''; })"></div>"""
"""A page in a notebook, or what to do where the browser does not reach it."""


def show(world: World, *, inline: str = "auto", seconds: float = 5.0, port: int = 0, height: int = 600) -> Page | None:
    """A page of a world, which the page takes over, displayed in the notebook if this is one, else announced. See :meth:`World.view`."""
    choice("inline", inline, WAYS)
    way = _way() if inline == "auto" else inline
    if way in ("picture", "film"):
        if not _in_notebook():
            raise InvalidArgumentError(
                f"there is no notebook here to show a {way} in; record with ap.Recorder and make one with atlasphys render"
            )
        _display_html(_picture(world, height) if way == "picture" else _film(world, height, seconds))
        if inline == "auto":
            print(
                "This notebook runs elsewhere; docs/viewer.md says how the interactive page can be reached from there."
            )
        return None
    from atlasphys.viewer.gui.page import Page

    page = Page(Session(world), port=port)
    if way == "proxy":
        page.server.gui.main_panel.set_width(PANEL_WIDTH)
        _display_html(f'<iframe src="{proxied(page)}" width="100%" height="{height}" style="border:0"></iframe>')
    else:
        _display(page, "the world", height)
    return page


def _way() -> str:
    """What reaches the reader of this notebook."""
    if not _in_notebook():
        return "page"
    if "google.colab" in sys.modules:
        return "picture"
    if os.environ.get("JUPYTERHUB_SERVICE_PREFIX"):
        return "proxy" if importlib.util.find_spec("jupyter_server_proxy") else "picture"
    return "page"


def proxied(page: Any) -> str:
    """Path of a page on the host of the notebook server, through jupyter-server-proxy."""
    base = os.environ.get("JUPYTERHUB_SERVICE_PREFIX") or os.environ.get("JPY_BASE_URL") or "/"
    return f"{base.rstrip('/')}/proxy/{page.server.get_port()}/"


def _picture(world: World, height: int) -> str:
    """A picture of a world, as HTML."""
    from atlasphys.viewer.picture import Look, Painter
    from atlasphys.viewer.viewpoint import view_from

    frame = Session(world).frame()
    painter = Painter(frame, Look(size=_size(height)))
    try:
        picture = painter.paint(frame, view_from("oblique", frame))
    finally:
        painter.close()
    from PIL import Image

    file = io.BytesIO()
    Image.fromarray(picture).save(file, "PNG")
    return f'<img style="max-width:100%" src="data:image/png;base64,{base64.b64encode(file.getvalue()).decode()}">'


def _film(world: World, height: int, seconds: float) -> str:
    """A film of what a world will do, as HTML."""
    from atlasphys.record.write import Recorder
    from atlasphys.viewer.picture import Look
    from atlasphys.viewer.render import Shot, render_film
    from atlasphys.viewer.replay import Replay

    steps = max(1, round(in_range("seconds", seconds, 0.0, 600.0) * 60))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "world.h5"
        with Recorder(path, world) as recorder:
            recorder.record()
            for _ in range(steps):
                world.step(1 / 60)
                recorder.record()
        replay = Replay(path)
        try:
            render_film(replay, path.with_suffix(".mp4"), Shot(replay), Look(size=_size(height)))
        finally:
            replay.close()
        film = base64.b64encode(path.with_suffix(".mp4").read_bytes()).decode()
    return f'<video controls autoplay loop muted style="max-width:100%" src="data:video/mp4;base64,{film}"></video>'


def _size(height: int) -> tuple[int, int]:
    """Width and height of a picture of about that height, both even."""
    even = 2 * round(height / 2)
    return 2 * round(even * 8 / 9), even


def show_story(story: Story, stage: str, *, port: int = 0, height: int = 760) -> Explanation:
    """The explorer's page of a story, displayed in the notebook if this is one, else announced. See :meth:`Story.view`."""
    from atlasphys.viewer.explorer.explorer import Explorer
    from atlasphys.viewer.explorer.page import Page

    page = Page(Explorer(story, stage), port=port)
    _display(page, "the story", height)
    return page


def _display(page: Any, what: str, height: int) -> None:
    if _in_notebook():
        page.server.gui.main_panel.set_width(PANEL_WIDTH)
        _display_html(FRAME.replace("URL", page.url).replace("HEIGHT", str(height)))
    else:
        print(f"{what} is shown at {page.url}")


def _display_html(text: str) -> None:
    from IPython.display import HTML, display

    display(HTML(text))


def _in_notebook() -> bool:
    """Whether this runs in a notebook's kernel, which can display things."""
    try:
        from IPython import get_ipython
    except ImportError:
        return False
    shell = get_ipython()
    return shell is not None and "IPKernelApp" in getattr(shell, "config", {})
