"""What a validation case is: a physical law with a known answer, the scene that shows it, and the errors it may leave."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from atlasphys.world.world import World

Doubles = npt.NDArray[np.float64]

G = 9.81
"""Gravity in every case that has any [m/s²]."""

MakeWorld = Callable[..., World]
"""Makes an empty world of the solver under test. Takes any argument of ``World`` that the case prescribes."""


class NotOfferedError(Exception):
    """What is under test has no way to express what a case needs; the message says what is missing."""


class Curve(NamedTuple):
    """A quantity over time, as it was found and as it should be."""

    quantity: str
    """What it is, with its unit."""
    times: npt.NDArray[np.float64]
    """(n,) [s]."""
    found: npt.NDArray[np.float64]
    exact: npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Case:
    """A law of physics with a known answer.

    Attributes:
        number: its number in docs/validation.md.
        name: a few words.
        law: the reference answer, as a formula or sentence.
        measure: ``measure(make_world, dt)`` builds the scene, runs it with steps of dt [s] and returns named errors: relative to the
            reference unless the name says a unit.
        tolerances: greatest error allowed, by name. An error without one is reported, not judged.
        orders: order in dt at which the error of that name falls.
        dt: step at which the tolerances hold [s].
        precision: precision in which they hold. Double where one is below 1e-4.
        not_offered: why no solver can run the case, where none can.
        curve: ``curve(make_world, dt)`` gives a trajectory of the case beside the exact one, for pictures.
    """

    number: int
    name: str
    law: str
    measure: Callable[[MakeWorld, float], dict[str, float]]
    tolerances: Mapping[str, float]
    orders: Mapping[str, float] = field(default_factory=dict)
    dt: float = 1 / 240
    precision: str = "single"
    not_offered: str | None = None
    curve: Callable[[MakeWorld, float], Curve] | None = None

    def run(self, make_world: MakeWorld, dt: float | None = None) -> Result:
        """Measure the case in worlds made by ``make_world``, by default with its own dt.

        The case's precision, a restitution threshold of 0 and sleep off are passed to ``make_world`` with what the scene needs.
        """
        h = self.dt if dt is None else dt
        return Result(self, h, self.measure(self._world(make_world), h))

    def trajectory(self, make_world: MakeWorld, dt: float | None = None) -> Curve | None:
        """The case's curve, under the same conventions; None if it has none."""
        return None if self.curve is None else self.curve(self._world(make_world), self.dt if dt is None else dt)

    def _world(self, make_world: MakeWorld) -> MakeWorld:
        return partial(make_world, precision=self.precision, restitution_threshold=0.0, sleeping=False)


@dataclass(frozen=True, slots=True)
class Result:
    """The errors that a case left in one run."""

    case: Case
    dt: float
    """Step of the run [s]."""
    errors: Mapping[str, float]

    @property
    def failures(self) -> dict[str, float]:
        """The errors beyond their tolerance, NaN included."""
        return {
            name: self.errors[name] for name, limit in self.case.tolerances.items() if not self.errors[name] <= limit
        }

    @property
    def score(self) -> float:
        """The greatest error as a share of its tolerance, at most 1 if the case is passed; what a tolerance of 0 allows is all or nothing."""
        shares = [
            self.errors[name] / limit if limit > 0 else (0.0 if self.errors[name] == 0 else math.inf)
            for name, limit in self.case.tolerances.items()
        ]
        return max((math.inf if math.isnan(share) else share for share in shares), default=0.0)

    @property
    def passed(self) -> bool:
        """Whether every error is within its tolerance."""
        return not self.failures


def record(world: World, dt: float, seconds: float, read: Callable[[], float]) -> tuple[Doubles, Doubles]:
    """Step a world for a time and read a quantity before the first step and after each: times and values."""
    times, values = [world.time], [float(read())]
    for _ in range(round(seconds / dt)):
        world.step(dt)
        times.append(world.time)
        values.append(float(read()))
    return np.array(times), np.array(values)


def relative(value: float, reference: float) -> float:
    """|value − reference| / |reference|."""
    return abs(value - reference) / abs(reference)


def turned_about_z(angle: float) -> tuple[float, float, float, float]:
    """The quaternion of a turn about z, rounded so that it is the same on every machine."""
    return round(math.cos(0.5 * angle), 15), 0.0, 0.0, round(math.sin(0.5 * angle), 15)
