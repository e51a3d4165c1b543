"""Figures of the theory book, drawn by the documentation's build from what the engine does and what it tells of it.

A figure is a function that returns a Matplotlib figure; its name is the file's. ``draw_all`` finds them in the modules of this package.
"""

from importlib import import_module
from pathlib import Path
from types import FunctionType

MODULES = ("integrators", "collision", "contacts", "solvers")


def figures() -> dict[str, FunctionType]:
    """All figures by name: the public functions of the modules."""
    found = {}
    for name in MODULES:
        module = import_module(f"{__name__}.{name}")
        found |= {
            key: value
            for key, value in vars(module).items()
            if isinstance(value, FunctionType) and value.__module__ == module.__name__ and not key.startswith("_")
        }
    return found


def draw_all(folder: Path, *names: str) -> None:
    """Draw the figures of some names (default: all) as SVG into a folder."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    folder.mkdir(exist_ok=True)
    # Identifiers that do not change from one build to the next.
    style = {"axes.spines.top": False, "axes.spines.right": False, "svg.hashsalt": "atlasphys", "font.size": 9}
    with plt.rc_context(style):
        for name, draw in figures().items():
            if not names or name in names:
                figure = draw()
                figure.savefig(folder / f"{name}.svg", metadata={"Date": None})
                plt.close(figure)
