"""What a validation case is: a physical law with a known answer, the scene that shows it, and the errors it may leave."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial

from atlasphys.world.world import World

G = 9.81
"""Gravity in every case that has any [m/s²]."""

MakeWorld = Callable[..., World]
"""Makes an empty world of the solver under test. Takes any argument of ``World`` that the case prescribes."""


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

    def run(self, make_world: MakeWorld, dt: float | None = None) -> Result:
        """Measure the case in worlds made by ``make_world``, by default with its own dt.

        The case's precision, a restitution threshold of 0 and sleep off are passed to ``make_world`` with what the scene needs.
        """
        h = self.dt if dt is None else dt
        world = partial(make_world, precision=self.precision, restitution_threshold=0.0, sleeping=False)
        return Result(self, h, self.measure(world, h))


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
    def passed(self) -> bool:
        """Whether every error is within its tolerance."""
        return not self.failures


def relative(value: float, reference: float) -> float:
    """|value − reference| / |reference|."""
    return abs(value - reference) / abs(reference)


def turned_about_z(angle: float) -> tuple[float, float, float, float]:
    """The quaternion of a turn about z, rounded so that it is the same on every machine."""
    return round(math.cos(0.5 * angle), 15), 0.0, 0.0, round(math.sin(0.5 * angle), 15)
