"""Choice of cases, plan, statuses, orders; tables and pictures of made-up outcomes."""

import io
import json
import math
import re

import numpy as np
import pytest
from rich.console import Console

import atlasphys as ap
from atlasphys.errors import InvalidArgumentError
from atlasphys.validate import CASES, Case, Curve, NotOfferedError, Result, plots, report, runner
from atlasphys.validate.contenders import Contender

ONE, TWO = Contender("one", "One", ap.World), Contender("two:a=1", "Two, a=1", ap.World)
PEER = Contender("rapier", "Rapier", ap.World, is_peer=True)


def case(number=3, error=lambda dt: dt, **changes):
    def measure(make_world, dt):
        return {"distance [m]": error(dt), "reported": 7.0}

    entries = {"number": number, "name": "n", "law": "l", "measure": measure, "dt": 0.1}
    return Case(**(entries | {"tolerances": {"distance [m]": 0.2}, "orders": {"distance [m]": 1.0}} | changes))


def outcomes(*jobs):
    return [runner.run(runner.Job(*job)) for job in jobs]


def test_cases_by_number_and_name():
    assert [c.number for c in runner.chosen_cases(["8", "incline", "8"])] == [2, 7, 8]
    assert len(runner.chosen_cases([])) == len(CASES)
    for wrong in ("99", "-1", "nothing"):
        with pytest.raises(InvalidArgumentError, match="there are: 1 free fall"):
            runner.chosen_cases([wrong])


def test_plan():
    jobs = runner.plan([case()], [ONE, TWO], [])
    assert [(job.contender.name, round(job.dt, 9)) for job in jobs] == [
        *(("one", dt) for dt in (0.4, 0.2, 0.1)),
        *(("two:a=1", dt) for dt in (0.4, 0.2, 0.1)),
    ]
    assert [job.dt for job in runner.plan([case()], [ONE], [0.01, 0.05])] == [0.05, 0.01]


def fails(error):
    def measure(make_world, dt):
        raise error

    return case(measure=measure)


def test_statuses():
    missing = NotOfferedError("no friction")
    found = outcomes(
        (case(), ONE, 0.1),
        (case(), ONE, 0.4),
        (fails(missing), ONE, 0.1),
        (fails(RuntimeError("broke")), ONE, 0.1),
        (case(not_offered="why"), ONE, 0.1),
    )
    assert [o.status for o in found] == ["passed", "failed", "not offered", "error", "not offered"]
    assert [o.reason for o in found] == ["", "", "no friction", "RuntimeError: broke", "why"]
    with pytest.raises(KeyboardInterrupt):
        outcomes((fails(KeyboardInterrupt()), ONE, 0.1))


def test_a_case_is_judged_at_its_own_step_or_the_least():
    found = outcomes(
        (case(), ONE, 0.4), (case(), ONE, 0.1), (case(), ONE, 0.02), (case(), TWO, 0.4), (case(), TWO, 0.2)
    )
    assert [o.dt for o in runner.judged(found)] == [0.1, 0.2]


@pytest.mark.parametrize("order", [1.0, 2.0])
def test_observed_order(order):
    points = [(dt, 3 * dt**order) for dt in (0.1, 0.2, 0.4)]
    assert runner.observed_order(points) == pytest.approx(order)
    assert runner.observed_order(points[:1]) is None
    assert runner.observed_order([(0.1, 1e-16), (0.2, 3e-16)]) is None
    assert runner.observed_order([(0.1, 0.1), (0.2, math.inf)]) is None


def test_score():
    limits = {"x": 0.1, "none": 0.0}
    for x, none, expected in ((0.05, 0.0, 0.5), (0.05, 1.0, math.inf), (math.nan, 0.0, math.inf)):
        assert Result(case(tolerances=limits), 0.1, {"x": x, "none": none}).score == expected


MIXED = [
    (case(), ONE, 0.1),
    (case(), ONE, 0.2),
    (case(), TWO, 0.1),
    (case(number=4, error=lambda dt: 5.0), ONE, 0.1),
    (case(number=4, measure=fails(NotOfferedError("no friction")).measure), PEER, 0.1),
    (case(number=5, not_offered="impossible", tolerances={}), ONE, 0.1),
    (case(number=6, measure=fails(RuntimeError("broke")).measure), TWO, 0.1),
]


def test_table(monkeypatch):
    text = io.StringIO()
    monkeypatch.setattr(report, "Console", lambda **options: Console(file=text, width=100, **options))
    report.print_table(outcomes(*MIXED))
    lines = text.getvalue()
    for wanted in (
        r"3 n +✓ 50 % +✓ 50 %",
        r"distance \[m\] +0.2 +0.1 +0.1",
        r"order +1 +1.0",
        r"4 n +✗ 25× +–",
        r"5 n +–",
        r"6 n +error",
        r"One: 1 passed; failed: 4; not offered: 5",
        r"Rapier, case 4: no friction",
        r"Two, a=1, case 6: RuntimeError: broke",
        r"case 5, n: impossible",
    ):
        assert re.search(wanted, lines), (wanted, lines)


def test_markdown():
    text = report.markdown(outcomes(*MIXED))
    assert "| 3 | n | distance [m] | 0.2 | 0.1 (order 1.0) | 0.1 | – |" in text
    assert "| 3 | n | reported | reported | 7 | 7 | – |" in text
    assert "| 4 | n | distance [m] | 0.2 | **5** | – | – |" in text
    assert "| 6 | n | distance [m] | 0.2 | – | **error** | – |" in text
    assert "| 3 | n | 0.5 | 0.5 | – | One, Two, a=1 |" in text


def test_json():
    plain = runner.as_json(outcomes(*MIXED, (case(number=7, error=lambda dt: math.nan), ONE, 0.1)), interrupted=True)
    assert json.loads(json.dumps(plain, allow_nan=False)) == plain
    assert plain["interrupted"] is True
    assert [entry["number"] for entry in plain["cases"]] == [3, 4, 5, 6, 7]
    assert plain["results"][-1]["errors"]["distance [m]"] is None
    assert plain["results"][-1]["failures"] == ["distance [m]"]
    assert plain["observed_orders"][0]["order"] == pytest.approx(1.0)


def test_pictures(tmp_path):
    pytest.importorskip("matplotlib")
    times = np.linspace(0, 1, 5)

    def curve(make_world, dt):
        return Curve("height [m]", times, times + 0.01, times)

    found = outcomes(*MIXED, (case(number=8, curve=curve), ONE, 0.1))
    errors = plots.plot_errors(tmp_path / "errors.png", found)
    looks = [(contender.name, contender.title, contender.is_peer) for contender in (ONE, TWO, PEER)]
    curves = runner.trajectories(found)
    assert {number: list(entry) for number, entry in curves.items()} == {8: ["One"]}
    paths = plots.plot_trajectories(tmp_path / "trajectories.png", curves, {8: "n"}, looks)
    for picture in (errors, paths):
        assert picture is not None
        assert picture.read_bytes().startswith(b"\x89PNG")
    assert plots.plot_errors(tmp_path / "none.png", found[-1:]) is None
    assert plots.plot_trajectories(tmp_path / "none.png", {}, {}, looks) is None
    written = report.write_report(tmp_path, found, [("Errors", errors)])
    assert "![Errors](errors.png)" in written.read_text(encoding="utf-8")


@pytest.mark.parametrize("number", [number for number, entry in CASES.items() if entry.curve])
def test_curves_follow_the_exact_ones(number):
    curve = CASES[number].trajectory(ap.World)
    assert len(curve.times) == len(curve.found) == len(curve.exact) > 100
    assert np.abs(curve.found - curve.exact).max() < 0.01 * np.ptp(curve.exact)
