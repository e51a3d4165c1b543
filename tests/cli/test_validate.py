"""``atlasphys validate`` and ``atlasphys compare``."""

import json
import re

import pytest

from atlasphys.cli import main
from atlasphys.validate import runner


def test_a_table_with_a_line_a_case(capsys):
    assert main(["validate", "3", "thin", "--dt", "1/120,1/240"]) == 0
    text = capsys.readouterr().out
    for wanted in (
        r"^3 sliding",
        r"distance +0.01 +0.00",
        r"order +1 +[01]\.\d +[01]\.\d",
        r"default \(soft_step\): 1 passed; not offered: 29",
    ):
        assert re.search(wanted, text, re.MULTILINE), (wanted, text)


def test_json_is_one_object(capsys):
    assert main(["validate", "8", "--solver", "classic,soft_step:substeps=2", "--dt", "1/60", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [(entry["contender"], entry["status"]) for entry in told["results"]] == [
        ("classic", "passed"),
        ("soft_step:substeps=2", "passed"),
    ]
    assert not told["interrupted"]


def test_markdown(capsys):
    assert main(["validate", "3", "--solver", "default", "--dt", "1/240", "--markdown"]) == 0
    assert capsys.readouterr().out.startswith("| # | case | error | tolerance | default (soft_step) |\n|---|")


def test_a_report_is_written(tmp_path, capsys):
    pytest.importorskip("matplotlib")
    assert main(["validate", "3", "18", "--solver", "default", "--out", str(tmp_path / "a" / "b")]) == 0
    capsys.readouterr()
    found = {path.name for path in (tmp_path / "a" / "b").iterdir()}
    assert found == {"report.md", "results.json", "errors.png", "trajectories.png"}
    text = (tmp_path / "a" / "b" / "report.md").read_text(encoding="utf-8")
    assert "![Trajectories](trajectories.png)" in text
    assert json.loads((tmp_path / "a" / "b" / "results.json").read_text(encoding="utf-8"))["interrupted"] is False


def test_peers_are_columns(capsys):
    pytest.importorskip("rapier3d")
    assert main(["validate", "3", "18", "--solver", "default", "--dt", "1/240", "--against", "rapier", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    peer = [entry for entry in told["results"] if entry["contender"] == "rapier"]
    assert [entry["status"] for entry in peer] == ["passed", "not offered"]
    assert "torsional" in peer[1]["reason"]


def test_an_interrupt_keeps_what_there_is(monkeypatch, tmp_path, capsys):
    pytest.importorskip("matplotlib")
    run, done = runner.run, []

    def interrupted(job):
        if len(done) == 2:
            raise KeyboardInterrupt
        done.append(job)
        return run(job)

    monkeypatch.setattr(runner, "run", interrupted)
    assert main(["validate", "3", "4", "--solver", "default", "--json", "--out", str(tmp_path)]) == 130
    told = json.loads(capsys.readouterr().out)
    assert told["interrupted"]
    assert len(told["results"]) == 2
    assert (tmp_path / "report.md").exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["nothing"], "no case is called 'nothing'; there are: 1 free fall"),
        (["3", "--solver", "fast"], "--solver takes some of default, classic"),
        (["3", "--solver", "soft_step:substeps=0"], "substeps must be an integer from 1"),
        (["3", "--dt", "soon"], "--dt takes numbers of seconds"),
        (["3", "--dt", "1/0"], "--dt takes numbers of seconds"),
        (["3", "--dt", "-1"], "--dt must be from"),
        (["3", "--against", "unity"], "--against takes none or some of rapier"),
        (["3", "--json", "--markdown"], "give one of --markdown and --json"),
    ],
)
def test_what_makes_no_sense_is_said_in_a_line(words, message, capsys):
    assert main(["validate", *words]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert message in captured.err
    assert captured.err.count("\n") == 1


def test_a_peer_that_is_not_installed(monkeypatch, capsys):
    monkeypatch.setattr("atlasphys.bench.peers.find_spec", lambda name: None)
    assert main(["validate", "3", "--against", "rapier"]) == 1
    assert "needs the package rapier3d: pip install 'atlasphys[bench]'" in capsys.readouterr().err
    assert main(["validate", "3", "--out", "x"]) == 1
    assert "matplotlib" in capsys.readouterr().err


def test_compare(tmp_path, capsys):
    pytest.importorskip("matplotlib")
    words = ["compare", "tower", "--set", "height=3", "--seconds", "0.5", "--solver", "default,classic:iterations=2"]
    assert main([*words, "--json", "--out", str(tmp_path)]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [entry["contender"] for entry in told["results"]] == ["default", "classic:iterations=2"]
    assert {entry["steps"] for entry in told["results"]} == {30}
    samples = json.loads((tmp_path / "compare.json").read_text(encoding="utf-8"))
    assert len(samples[0]["depth"]) == 30
    assert main(words) == 0
    text = capsys.readouterr().out
    assert re.search(r"complementarity residual, greatest +N s +[\d.e-]+ +[\d.e-]+", text)


def test_compare_keeps_what_there_is_when_interrupted(monkeypatch, capsys):
    from atlasphys.world.world import World

    step, done = World.step, []

    def interrupted(world, dt):
        if len(done) == 15:
            raise KeyboardInterrupt
        done.append(dt)
        step(world, dt)

    monkeypatch.setattr(World, "step", interrupted)
    assert (
        main(["compare", "tower", "--set", "height=2", "--seconds", "0.2", "--solver", "default,classic", "--json"])
        == 130
    )
    told = json.loads(capsys.readouterr().out)
    assert [entry["steps"] for entry in told["results"]] == [
        12,
        2,
    ]  # a copy of the first took one more, to note its sweeps


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["nowhere"], "neither a scene of the library nor a file"),
        (["tower", "--solver", "fast"], "--solver takes some of"),
        (["tower", "--set", "height"], "--set takes NAME=VALUE"),
        (["tower", "--dt", "0"], "--dt must be"),
    ],
)
def test_compare_says_what_makes_no_sense(words, message, capsys):
    assert main(["compare", *words]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert message in captured.err
