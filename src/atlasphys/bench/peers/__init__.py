"""The engines that are compared: one file each, a class that builds a scene, steps it, and gives poses back.

Each is left at its own defaults but for what the comparison fixes: gravity, the time step, friction, the number of threads, and that
nothing sleeps. What that means for each is said at the top of its file.
"""

from __future__ import annotations

import sys
from importlib import import_module
from importlib.metadata import version
from importlib.util import find_spec
from typing import TYPE_CHECKING, NamedTuple, Protocol

from atlasphys import __version__
from atlasphys.errors import InvalidArgumentError, MissingExtraError

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from atlasphys.bench.scenes import Scene

    Poses = tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]

OURS = "atlasphys"


class Engine(Protocol):
    """A scene in an engine."""

    threads: int
    """Number of threads that it works with; 1 where it offers no choice."""

    def __init__(self, scene: Scene, threads: int, preset: str | None) -> None:
        """Build the scene. The preset is for AtlasPhys alone."""

    def run(self, steps: int) -> None:
        """Take steps of ``scenes.DT``."""

    def poses(self) -> Poses:
        """Positions (n, 3) and orientations (w, x, y, z) (n, 4) of the scene's bodies, in its order."""


class Peer(NamedTuple):
    """Where an engine is found."""

    package: str
    """What is imported."""
    distribution: str
    """What is installed, and has a version."""
    title: str


PEERS = {
    OURS: Peer("atlasphys", "atlasphys", "AtlasPhys"),
    "rapier": Peer("rapier3d", "rapier3d", "Rapier"),
    "box3d": Peer("robox3d", "robox3d", "Box3D"),
    "pybullet": Peer("pybullet", "pybullet", "PyBullet"),
    "mujoco": Peer("mujoco", "mujoco", "MuJoCo"),
}
"""Name on the command line → where it is found; AtlasPhys first."""

NOT_OFFERED = {"pybullet"} if sys.version_info >= (3, 13) else set()
"""Engines that cannot be installed with this Python."""


def chosen(names: str | None) -> list[str]:
    """The engines to compare with, by a list with commas; by default all that this Python can have.

    Raises:
        InvalidArgumentError: a name is not known.
        MissingExtraError: one is not installed.
    """
    others = [name for name in PEERS if name != OURS]
    if names is None:
        names = ",".join(name for name in others if name not in NOT_OFFERED)
    result = [] if names == "none" else list(dict.fromkeys(name.strip() for name in names.split(",")))
    for name in result:
        if name not in others:
            raise InvalidArgumentError(f"--against takes none or some of {','.join(others)} (got {name!r})")
    for name in result:
        require(PEERS[name].package, f"--against {name}")
    return result


def require(package: str, purpose: str) -> None:
    """Make sure that an optional package is installed.

    Raises:
        MissingExtraError: it is not.
    """
    if find_spec(package) is None:
        raise MissingExtraError(f"{purpose} needs the package {package}: pip install 'atlasphys[bench]'")


def version_of(name: str) -> str:
    """An engine's version."""
    return __version__ if name == OURS else version(PEERS[name].distribution)


def engine(name: str) -> type[Engine]:
    """The class of an engine; imports what it needs."""
    found: type[Engine] = import_module(f"atlasphys.bench.peers.{name}").ENGINE
    return found
