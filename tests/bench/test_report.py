"""Ratios, means and files of made-up measurements."""

import csv
import re

import pytest

from atlasphys.bench.measure import Plan, Result, compare
from atlasphys.bench.quality import Quality
from atlasphys.bench.report import plot_ratios, plot_scaling, print_results, summary, write_csv
from atlasphys.bench.scenes import make

STOOD, FELL = Quality(True, "", 0.001, 0.002, 0), Quality(False, "3 of 4 bodies fell", 2.0, 0.5, 1)


def result(scene, engine, wall, quality=STOOD):
    return Result(scene, engine, "1.2", bodies=4, wall=wall, cpu=wall, seconds=10.0, quality=quality)


def compared(*results):
    compare(list(results))
    return list(results)


def test_ratios_are_of_rounds_and_of_least_times():
    # The machine was busy in the third round, for both alike.
    _, peer = compared(result("a", "atlasphys", [1.0, 2.0, 10.0]), result("a", "rapier", [3.0, 4.0, 30.0]))
    assert peer.median_ratio == 3.0  # of 3, 2, 3
    assert peer.min_ratio == 3.0  # 3 / 1
    _, peer = compared(result("a", "atlasphys", [2.0, 2.0, 1.0]), result("a", "rapier", [2.0, 8.0, 4.0]))
    assert (peer.median_ratio, peer.min_ratio) == (4.0, 2.0)


def test_an_engine_that_failed_has_no_ratio():
    _, peer = compared(result("a", "atlasphys", [1.0, 2.0]), result("a", "rapier", [3.0]))
    assert peer.median_ratio is None
    _, peer = compared(result("a", "atlasphys", []), result("a", "rapier", []))
    assert peer.median_ratio is None


def results():
    return [
        *compared(result("a", "atlasphys", [1.0]), result("a", "rapier", [2.0]), result("a", "box3d", [3.0])),
        *compared(result("b", "atlasphys", [1.0]), result("b", "rapier", [8.0]), result("b", "box3d", [0.1], FELL)),
        *compared(result("c", "atlasphys", [1.0], FELL), result("c", "rapier", [100.0]), result("c", "box3d", [100.0])),
    ]


def test_wrong_answers_do_not_count():
    told = summary(results())
    assert told["peers"] == {"rapier": {"scenes": 2, "mean_ratio": 4.0}, "box3d": {"scenes": 1, "mean_ratio": 3.0}}
    assert told["fastest_peer"] == {
        "a": {"engine": "rapier", "median_ratio": 2.0},
        "b": {"engine": "rapier", "median_ratio": 8.0},
    }


def test_the_table_shows_no_ratio_of_a_wrong_answer(capsys):
    print_results(results(), threads=1)
    text = capsys.readouterr().out
    fallen = [line for line in text.splitlines() if "fell" in line and line.split()[0] in ("Box3D", "AtlasPhys")]
    assert len(fallen) == 2
    assert all(re.search(r"–\s+–", line) for line in fallen)
    assert "b, box3d: 3 of 4 bodies fell, after 10 s" in text
    assert "Rapier takes 4 times as long (mean of 2 scenes that stood)" in text


def test_csv(tmp_path):
    path = write_csv(tmp_path / "bench.csv", [each.row() for each in results()])
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 9
    assert rows[1] | {"cpu_ms": ""} == {
        "scene": "a",
        "engine": "rapier",
        "version": "1.2",
        "threads": "1",
        "median_ms": "2000.0",
        "min_ms": "2000.0",
        "cpu_ms": "",
        "median_ratio": "2.0",
        "min_ratio": "2.0",
        "stands": "True",
        "worst_drift": "0.001",
        "deepest_penetration": "0.002",
        "bodies": "4",
        "seconds": "10.0",
        "stretch": "",
        "energy_error": "",
        "fault": "",
    }


def test_plots(tmp_path):
    pytest.importorskip("matplotlib")
    failed = Result("a", "mujoco", "1", failure="too slow")
    path = plot_ratios(tmp_path / "bench.png", [*results(), failed], threads=2)
    assert path.read_bytes().startswith(b"\x89PNG")
    line = [result(f"pile_{n}", name, [1.0]) for n in (10, 100) for name in ("atlasphys", "rapier")]
    path = plot_scaling(tmp_path / "scaling.png", [*line, failed])
    assert path.read_bytes().startswith(b"\x89PNG")


def test_a_plan_keeps_to_the_scene_unless_told_otherwise():
    scene = make("tower_100")
    assert Plan().of(scene) == (120, 600)
    assert Plan(settle=0.5, seconds=1.0).of(scene) == (30, 60)
    assert Plan(settle=5.0, seconds=1.0).of(scene) == (300, 301)
