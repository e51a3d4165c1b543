"""The errors that AtlasPhys raises, as one tree under :class:`AtlasPhysError`.

Each also derives from the built-in exception that a Python user would expect to catch.
"""

from __future__ import annotations

__all__ = [
    "AtlasPhysError",
    "DivergenceError",
    "InvalidArgumentError",
    "MissingExtraError",
    "RecordingError",
    "RemovedBodyError",
    "RemovedJointError",
    "SceneError",
]


class AtlasPhysError(Exception):
    """Base of every error raised on purpose by AtlasPhys."""


class InvalidArgumentError(AtlasPhysError, ValueError):
    """A value given to the public interface is of the wrong type, shape or range. The world is unchanged."""


class RemovedBodyError(AtlasPhysError, LookupError):
    """A handle was used whose body is no longer in its world."""


class RemovedJointError(AtlasPhysError, LookupError):
    """A handle was used whose joint is no longer in its world."""


class DivergenceError(AtlasPhysError, ArithmeticError):
    """A step produced non-finite numbers. The world is as it was before that step.

    Attributes:
        bodies: names (or ``body <row>`` where unnamed) of the bodies whose state became non-finite.
    """

    def __init__(self, message: str, bodies: tuple[str, ...] = ()) -> None:
        super().__init__(message)
        self.bodies = bodies

    def __reduce__(self) -> tuple[type[DivergenceError], tuple[str, tuple[str, ...]]]:
        return type(self), (str(self), self.bodies)


class SceneError(AtlasPhysError, ValueError):
    """A scene cannot be built. The message lists every fault with its file, line and path."""


class RecordingError(AtlasPhysError, OSError):
    """A recording cannot be written or read."""


class MissingExtraError(AtlasPhysError, ImportError):
    """An optional dependency is not installed. The message holds the command that installs it."""
