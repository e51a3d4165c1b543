"""What the traces of all stages share, and how numbers are written in a story."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

Vector = npt.NDArray[np.floating]
"""(3,) along the world's axes."""
Points = npt.NDArray[np.floating]
"""(n, 3) along the world's axes, from the origin of the first shape."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Trace:
    """What a stage did with the pair, event by event. ``str`` tells it in words."""

    instead: str = ""
    """If the stage has no events: what happened instead."""
    remark: str = ""
    """What to know of the events, such as that the step itself took another routine for this pair."""

    def __str__(self) -> str:
        lines = [self.remark] if self.remark else []
        return "\n".join([*lines, self.instead] if self.instead else [*lines, *self.lines()])

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:
        """What notebooks show."""
        printer.text(str(self))

    def lines(self) -> Iterator[str]:
        """The story of the events, line by line."""
        return iter(())

    def data(self) -> dict[str, Any]:
        """All events as plain values: numbers, strings, lists and dictionaries; what is not finite is None."""
        found: dict[str, Any] = plain_values(self)
        return found


def plain_values(value: Any) -> Any:
    """A value for JSON."""
    if dataclasses.is_dataclass(value):
        return {field.name: plain_values(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, dict):
        return {key: plain_values(entry) for key, entry in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [plain_values(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def number(value: float) -> str:
    """A number with four digits that count."""
    if value == 0:
        return "0"
    return f"{value:.4g}" if abs(value) >= 1e-4 else f"{value:.2e}"


def vector(value: Any) -> str:
    """A vector's three numbers."""
    return "(" + ", ".join(f"{round(float(x), 4) + 0.0:g}" for x in value) + ")"


def length(value: float) -> str:
    """A length with a unit that suits it."""
    size = abs(value)
    if size == 0:
        return "0 m"
    if size < 1e-4:
        return f"{1e6 * value:.3g} µm"
    return f"{1e3 * value:.4g} mm" if size < 0.1 else f"{value:.4g} m"


def listed(words: list[str]) -> str:
    """Words as in a sentence: "1", "1 and 2", "1, 2 and 3"."""
    return words[0] if len(words) == 1 else ", ".join(words[:-1]) + " and " + words[-1]
