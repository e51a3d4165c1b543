"""The viewer inside a notebook."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from atlasphys.viewer.session import Session

if TYPE_CHECKING:
    from atlasphys.explainer import Story
    from atlasphys.viewer.explorer.page import Page as Explanation
    from atlasphys.viewer.gui.page import Page
    from atlasphys.world.world import World

PANEL_WIDTH = 340
"""Of the panel in a notebook, whose cells are narrow: a wider one hides the middle of the scene [pixels]."""


def show(world: World, *, port: int = 0, height: int = 600) -> Page:
    """A page of a world, which the page takes over, displayed in the notebook if this is one, else announced. See :meth:`World.view`."""
    from atlasphys.viewer.gui.page import Page

    page = Page(Session(world), port=port)
    _display(page, "the world", height)
    return page


def show_story(story: Story, stage: str, *, port: int = 0, height: int = 760) -> Explanation:
    """The explorer's page of a story, displayed in the notebook if this is one, else announced. See :meth:`Story.view`."""
    from atlasphys.viewer.explorer.explorer import Explorer
    from atlasphys.viewer.explorer.page import Page

    page = Page(Explorer(story, stage), port=port)
    _display(page, "the story", height)
    return page


def _display(page: Any, what: str, height: int) -> None:
    if _in_notebook():
        from IPython.display import IFrame, display

        page.server.gui.main_panel.set_width(PANEL_WIDTH)
        display(IFrame(page.url, width="100%", height=height))
    else:
        print(f"{what} is shown at {page.url}")


def _in_notebook() -> bool:
    """Whether this runs in a notebook's kernel, which can display things."""
    try:
        from IPython import get_ipython
    except ImportError:
        return False
    shell = get_ipython()
    return shell is not None and "IPKernelApp" in getattr(shell, "config", {})
