"""Runs cases for contenders and steps, one at a time, and says how each went."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from atlasphys.errors import InvalidArgumentError
from atlasphys.validate import CASES
from atlasphys.validate.case import Case, Curve, NotOfferedError, Result
from atlasphys.validate.contenders import Contender

FACTORS = (4, 2, 1)
"""A case is run with these multiples of its dt, unless others are asked for."""

NOISE = 1e-10
"""An error below this has no order: it is round-off."""


class Job(NamedTuple):
    """One measurement to make."""

    case: Case
    contender: Contender
    dt: float


@dataclass(frozen=True, slots=True)
class Outcome:
    """How it went."""

    case: Case
    contender: Contender
    dt: float
    result: Result | None
    """None if there is none."""
    reason: str
    """Why there is none."""
    status: str
    """``passed``, ``failed``, ``not offered``, or ``error`` where it could not be run to its end."""
    wall: float
    """Time taken [s]."""


def chosen_cases(words: Sequence[str]) -> list[Case]:
    """Cases by number, or by a part of their name; all if none is given.

    Raises:
        InvalidArgumentError: no case is meant by a word.
    """
    if not words:
        return list(CASES.values())
    chosen: dict[int, Case] = {}
    for word in words:
        found = [case for number, case in CASES.items() if str(number) == word]
        if not found and not word.lstrip("-").isdigit():
            found = [case for case in CASES.values() if word.lower() in case.name.lower()]
        if not found:
            known = ", ".join(f"{number} {case.name}" for number, case in CASES.items())
            raise InvalidArgumentError(f"no case is called {word!r}; there are: {known}")
        chosen |= {case.number: case for case in found}
    return [case for number, case in CASES.items() if number in chosen]


def plan(cases: Iterable[Case], contenders: Sequence[Contender], dts: Sequence[float]) -> list[Job]:
    """The measurements to make, longest step first, case by case; without ``dts``, a case's own dt and multiples of it."""
    return [
        Job(case, contender, dt)
        for case in cases
        for contender in contenders
        for dt in sorted(dts or [factor * case.dt for factor in FACTORS], reverse=True)
    ]


def run(job: Job) -> Outcome:
    """Make one measurement."""
    started = time.perf_counter()
    result, reason, status = None, "", "error"
    if job.case.not_offered:
        reason, status = job.case.not_offered, "not offered"
    else:
        try:
            result = job.case.run(job.contender.make_world, job.dt)
            status = "passed" if result.passed else "failed"
        except NotOfferedError as missing:
            reason, status = str(missing), "not offered"
        except Exception as error:  # whatever an engine raises is an answer too
            reason = f"{type(error).__name__}: {error}"
    return Outcome(*job, result, reason, status, time.perf_counter() - started)


def judged(outcomes: Iterable[Outcome]) -> list[Outcome]:
    """Of each case and contender, the outcome at the case's own dt, or at the least dt where that was not run."""
    best: dict[tuple[int, str], Outcome] = {}
    for outcome in outcomes:
        key = outcome.case.number, outcome.contender.name
        if key not in best or _rank(outcome) < _rank(best[key]):
            best[key] = outcome
    return list(best.values())


def _rank(outcome: Outcome) -> tuple[bool, float]:
    return not math.isclose(outcome.dt, outcome.case.dt), outcome.dt


def errors_by_dt(outcomes: Iterable[Outcome], number: int, contender: str, name: str) -> list[tuple[float, float]]:
    """dt and error of one name, case and contender, least dt first."""
    return sorted(
        (outcome.dt, outcome.result.errors[name])
        for outcome in outcomes
        if outcome.case.number == number
        and outcome.contender.name == contender
        and outcome.result
        and name in outcome.result.errors
    )


def observed_order(points: Sequence[tuple[float, float]]) -> float | None:
    """Slope of the logarithm of the error over that of dt (least squares); None where the errors are round-off or too few."""
    if len(points) < 2 or not all(NOISE < error < math.inf for _, error in points):
        return None
    dts, errors = np.array(points).T
    return float(np.polyfit(np.log(dts), np.log(errors), 1)[0])


def trajectories(outcomes: Iterable[Outcome]) -> dict[int, dict[str, Curve]]:
    """The curves of every case that has one, for each contender that could run it: number → contender's title → curve."""
    found: dict[int, dict[str, Curve]] = {}
    for outcome in judged(outcomes):
        if outcome.case.curve is not None and outcome.result is not None:
            curve = outcome.case.trajectory(outcome.contender.make_world, outcome.dt)
            assert curve is not None
            found.setdefault(outcome.case.number, {})[outcome.contender.title] = curve
    return found


def as_json(outcomes: Sequence[Outcome], *, interrupted: bool) -> dict[str, Any]:
    """Everything that was found, in plain values; what is not a number is null."""
    cases = {outcome.case.number: outcome.case for outcome in outcomes}
    return {
        "interrupted": interrupted,
        "cases": [
            {
                "number": case.number,
                "name": case.name,
                "law": case.law,
                "dt": case.dt,
                "precision": case.precision,
                "tolerances": dict(case.tolerances),
                "orders": dict(case.orders),
            }
            for case in cases.values()
        ],
        "results": [
            {
                "case": outcome.case.number,
                "contender": outcome.contender.name,
                "dt": outcome.dt,
                "status": outcome.status,
                "reason": outcome.reason,
                "errors": {name: _finite(value) for name, value in outcome.result.errors.items()}
                if outcome.result
                else {},
                "failures": list(outcome.result.failures) if outcome.result else [],
                "score": _finite(outcome.result.score) if outcome.result else None,
                "wall_seconds": outcome.wall,
            }
            for outcome in outcomes
        ],
        "observed_orders": [
            {"case": outcome.case.number, "contender": outcome.contender.name, "error": name, "order": order}
            for outcome in judged(outcomes)
            if outcome.result
            for name in outcome.result.errors
            if (order := observed_order(errors_by_dt(outcomes, outcome.case.number, outcome.contender.name, name)))
            is not None
        ],
    }


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
