"""The table of cases, and how a result is judged."""

import math
from typing import Any

import numpy as np
import pytest

import atlasphys as ap
from atlasphys.validate import CASES, Case, Result
from atlasphys.validate.cases import four_bar, intermediate_axis, pendulum


def case(**changes: Any) -> Case:
    entries: dict[str, Any] = {"number": 1, "name": "n", "law": "l", "measure": lambda make_world, dt: {}}
    return Case(**(entries | {"tolerances": {"x": 0.1, "y": 0.0}} | changes))


@pytest.mark.parametrize(
    ("errors", "failures"),
    [
        ({"x": 0.1, "y": 0.0, "reported": 9.0}, []),
        ({"x": 0.11, "y": 0.0}, ["x"]),
        ({"x": math.nan, "y": 1e-300}, ["x", "y"]),
    ],
)
def test_failures(errors: dict[str, float], failures: list[str]) -> None:
    result = Result(case(), 0.01, errors)
    assert list(result.failures) == failures
    assert result.passed == (not failures)


def test_conventions_reach_the_world() -> None:
    seen: list[tuple[ap.World, float]] = []

    def measure(make_world: Any, dt: float) -> dict[str, float]:
        seen.append((make_world(gravity=(0, 0, -1)), dt))
        return {"x": 0.0, "y": 0.0}

    made = case(measure=measure, precision="double", dt=0.02)
    assert made.run(ap.World).dt == 0.02
    assert made.run(ap.World, 0.5).dt == 0.5
    assert [dt for _, dt in seen] == [0.02, 0.5]
    world = seen[0][0]
    assert world.precision == "double"
    assert world.restitution_threshold == 0
    assert world.gravity.tolist() == [0, 0, -1]


def test_table() -> None:
    required = {*range(1, 33)} - {29}
    assert required <= {number for number, entry in CASES.items() if entry.not_offered is None}
    for number, entry in CASES.items():
        assert entry.number == number
        assert entry.tolerances or entry.not_offered
        # Double precision is asked for where single could not do.
        assert entry.precision == "double" or all(limit == 0 or limit >= 1e-4 for limit in entry.tolerances.values())
    assert "continuous" in str(CASES[29].not_offered)
    with pytest.raises(NotImplementedError, match="continuous"):
        CASES[29].run(ap.World)


@pytest.mark.parametrize(
    "spin", [(0.3, 3.0, 0.2), (0.1, 3.0, 0.9), (-0.5, 3.0, 0.2), (0.3, -3.0, -0.2), (0.9, -3.0, 0.1), (0.1, 3.0, -0.9)]
)
def test_elliptic_solution_solves_eulers_equations(
    spin: tuple[float, float, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(intermediate_axis, "SPIN", spin)
    h = 1e-4
    times = np.arange(0, 12, 0.37)
    before, now, after = (intermediate_axis.solution(t)[0] for t in (times - h, times, times + h))
    moments = intermediate_axis.MOMENTS
    np.testing.assert_allclose(intermediate_axis.solution(np.zeros(1))[0][0], spin, rtol=1e-12)
    np.testing.assert_allclose((after - before) / (2 * h), np.cross(moments * now, now) / moments, atol=1e-4)
    period = intermediate_axis.solution(times)[1]
    np.testing.assert_allclose(intermediate_axis.solution(times + period)[0], now, atol=1e-9)


def test_freudensteins_solution_closes_the_loop() -> None:
    crank = np.linspace(0, 7, 50)
    rocker, coupler, speed = four_bar.solution(crank)
    for function, ground in ((np.cos, four_bar.GROUND), (np.sin, 0.0)):
        loop = four_bar.CRANK * function(crank) + four_bar.COUPLER * function(coupler)
        np.testing.assert_allclose(loop, ground + four_bar.ROCKER * function(rocker), atol=1e-12)
    h = 1e-5
    before, after = (four_bar.solution(crank + sign * h)[0] for sign in (-1, 1))
    np.testing.assert_allclose(speed, four_bar.RATE * (after - before) / (2 * h), atol=1e-6)


@pytest.mark.parametrize("degrees", pendulum.AMPLITUDES)
def test_pendulum_period_by_quadrature(degrees: float) -> None:
    from scipy.integrate import quad

    k = math.sin(math.radians(degrees) / 2)
    quarter = quad(lambda phi: 1 / math.sqrt(1 - (k * math.sin(phi)) ** 2), 0, math.pi / 2)[0]
    assert pendulum.period(degrees) == pytest.approx(4 * pendulum.SMALL * quarter, rel=1e-9)


@pytest.mark.parametrize(
    ("number", "dt"),
    [(3, 1 / 60), (8, 1 / 60), (11, 1 / 60)],
)
def test_order(number: int, dt: float) -> None:
    """Halving dt divides the error by 2 to the order."""
    entry = CASES[number]

    def make_world(**options: Any) -> ap.World:
        return ap.World(**(options | {"precision": "double"}))

    coarse, fine = (entry.run(make_world, h).errors for h in (dt, dt / 2))
    for name, order in entry.orders.items():
        assert math.log2(coarse[name] / fine[name]) == pytest.approx(order, abs=0.2), name
