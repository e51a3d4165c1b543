"""Sphinx hook that draws the figures of the theory book before the pages are read."""

import sys
from pathlib import Path

from sphinx.application import Sphinx


def draw(app: Sphinx) -> None:
    """Draw all figures into ``theory/figures``. One that cannot be drawn ends the build."""
    sys.path.insert(0, str(Path(app.srcdir) / "theory"))
    from plots import draw_all

    draw_all(Path(app.srcdir) / "theory" / "figures")


def setup(app: Sphinx) -> dict[str, bool]:
    """Draw when the builder is ready."""
    app.connect("builder-inited", draw)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
