"""The viewer inside a notebook."""

from __future__ import annotations

from typing import TYPE_CHECKING

from atlasphys.viewer.session import Session

if TYPE_CHECKING:
    from atlasphys.viewer.gui.page import Page
    from atlasphys.world.world import World


def show(world: World, *, port: int = 0, height: int = 600) -> Page:
    """A page of a world, which the page takes over, displayed in the notebook if this is one, else announced. See :meth:`World.view`."""
    from atlasphys.viewer.gui.page import Page

    page = Page(Session(world), port=port)
    if _in_notebook():
        from IPython.display import IFrame, display

        display(IFrame(page.url, width="100%", height=height))
    else:
        print(f"the world is shown at {page.url}")
    return page


def _in_notebook() -> bool:
    """Whether this runs in a notebook's kernel, which can display things."""
    try:
        from IPython import get_ipython
    except ImportError:
        return False
    shell = get_ipython()
    return shell is not None and "IPKernelApp" in getattr(shell, "config", {})
