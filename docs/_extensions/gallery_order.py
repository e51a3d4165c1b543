"""How the gallery is ordered, and how its figures look."""

from pathlib import Path

import matplotlib.pyplot as plt

ORDER = (
    "first_scene",
    "scene_from_toml",
    "record_and_replay",
    "events",
    "drawing",
    "bouncing_ball",
    "incline",
    "newtons_cradle",
    "dzhanibekov",
    "dominoes",
    "angle_of_repose",
    "tower_and_sleep",
    "weights_in_a_stack",
    "four_solvers",
    "explain_gjk",
    "explain_epa",
    "branching_futures",
    "precision_and_hashes",
    "profile_by_stage",
)
"""From first steps over physics to the inside of the engine."""

STYLE = {"axes.spines.top": False, "axes.spines.right": False, "figure.dpi": 140, "savefig.dpi": 140}


def place(name: str) -> int:
    """Where an example comes; one that is not in the list is an error."""
    return ORDER.index(Path(name).stem)


def style(conf: dict[str, object], name: str) -> None:
    """Called before each example: figures are alike."""
    plt.rcParams.update(STYLE)
