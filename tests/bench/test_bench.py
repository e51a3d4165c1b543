"""The command: measuring, files, errors. Its processes are real ones."""

import csv
import json
import os

import numpy as np
import pytest
from numpy.testing import assert_allclose

from atlasphys.bench import measure as measuring
from atlasphys.bench import peers
from atlasphys.bench.measure import Plan, Worker, measure, memory
from atlasphys.bench.scenes import make
from atlasphys.cli import main
from atlasphys.errors import InvalidArgumentError, MissingExtraError

QUICK = ("--against", "none", "--rounds", "2", "--steps", "3", "--settle", "0.1", "--seconds", "0.3")
pythonic = pytest.mark.skipif(os.environ.get("NUMBA_DISABLE_JIT") == "1", reason="slow without compiled kernels")


@pytest.fixture(autouse=True)
def _no_plots_needed(monkeypatch):
    """Matplotlib is in the bench extra; without it, only the drawing is left out here."""
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        from atlasphys.bench import report

        monkeypatch.setattr(peers, "require", lambda package, purpose: None)
        monkeypatch.setattr(report, "plot_ratios", lambda path, results, threads: path)


def test_one_body_alone(tmp_path, capsys):
    assert main(["bench", "one_body", *QUICK, "--out", str(tmp_path)]) == 0
    text = capsys.readouterr().out
    assert "one_body, 1 body" in text
    assert "AtlasPhys" in text
    with (tmp_path / "bench.csv").open(encoding="utf-8", newline="") as file:
        (row,) = csv.DictReader(file)
    assert (row["scene"], row["engine"], row["stands"], row["bodies"]) == ("one_body", "atlasphys", "True", "1")
    assert float(row["median_ms"]) >= float(row["min_ms"]) > 0
    assert float(row["median_ratio"]) == 1.0
    assert float(row["seconds"]) == pytest.approx(0.3)


def test_json_is_all_of_standard_output(tmp_path, capsys):
    assert main(["bench", "one_body", *QUICK, "--out", str(tmp_path), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    (result,) = told["results"]
    assert (result["scene"], result["stands"], result["steps"]) == ("one_body", True, 3)
    assert len(result["wall"]) == len(result["cpu"]) == 2
    assert told["summary"] == {"peers": {}, "fastest_peer": {}}
    assert [file.rpartition(".")[2] for file in told["files"]] == ["csv", "png"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["no_such_scene"], "no benchmark scene 'no_such_scene'"),
        (["one_body", "--against", "bullet"], "--against takes none or some of rapier,box3d"),
        (["one_body", "--rounds", "0"], "--rounds must be at least 1"),
        (["one_body", "--settle", "nan"], "--settle must be a number of seconds"),
        (["one_body", "--scaling"], "scenes of their own"),
        (["--memory", "--scaling"], "scenes of their own"),
        (["one_body", "--against", "none", "--preset", "fastest", "--rounds", "1"], "preset"),
    ],
)
def test_what_makes_no_sense_is_a_usage_error(words, said, tmp_path, capsys):
    assert main(["bench", *words, "--out", str(tmp_path)]) == 2
    streams = capsys.readouterr()
    assert said in streams.err
    assert streams.out == ""


def test_a_missing_extra_says_what_to_install(monkeypatch, capsys, tmp_path):
    monkeypatch.undo()
    monkeypatch.setattr(peers, "find_spec", lambda package: None)
    with pytest.raises(MissingExtraError, match=r"rapier3d: pip install 'atlasphys\[bench\]'"):
        peers.chosen("rapier")
    assert main(["bench", "one_body", "--against", "box3d", "--out", str(tmp_path)]) == 1
    assert "--against box3d needs the package robox3d: pip install 'atlasphys[bench]'" in capsys.readouterr().err
    assert main(["bench", "one_body", "--against", "none", "--out", str(tmp_path)]) == 1
    assert "the plot needs the package matplotlib" in capsys.readouterr().err


def test_the_list_of_peers():
    assert peers.chosen("none") == []
    with pytest.raises(InvalidArgumentError, match="got 'atlasphys'"):
        peers.chosen("atlasphys")


class Slow:
    """An engine that is given up: it raises, ends its process or does not answer."""

    threads = 1

    def __init__(self, scene, threads, preset):
        self.preset = preset

    def run(self, steps):
        if self.preset == "raises":
            raise RuntimeError("broken")
        if self.preset == "dies":
            os._exit(7)
        import time

        time.sleep(60)


@pytest.mark.parametrize(
    ("how", "said"), [("raises", "RuntimeError: broken"), ("dies", "code 7"), ("sleeps", "too slow")]
)
def test_an_engine_without_an_answer_is_given_up(how, said, monkeypatch):
    monkeypatch.setitem(peers.PEERS, "slow", peers.Peer("tests", "numpy", "Slow"))
    monkeypatch.setattr(measuring, "_serve", serve_slow)
    (result,) = measure(make("one_body"), ["slow"], Plan(preset=how, patience=5.0))
    assert said in result.failure
    assert not result.stands
    assert result.row()["median_ms"] is None


REAL_SERVE = measuring._serve


def serve_slow(*arguments):
    """The worker's loop with the engine above; runs in the worker's process."""
    measuring.engine = lambda name: Slow
    REAL_SERVE(*arguments)


@pytest.mark.parametrize("name", [name for name in peers.PEERS if name != "atlasphys"])
def test_each_peer_builds_what_is_described(name):
    pytest.importorskip(peers.PEERS[name].package)
    scene = make("pile_12") if name == "pybullet" else make("mixed_1000")
    with Worker(name, Plan()) as worker:
        assert worker.ask("build", scene) == 1
        positions, orientations = worker.ask("poses")
        assert_allclose(positions, [body.position for body in scene.bodies], atol=1e-5)
        dots = (orientations * [body.orientation for body in scene.bodies]).sum(axis=1)
        assert_allclose(np.abs(dots), 1, atol=1e-6)


@pytest.mark.parametrize("name", [name for name in peers.PEERS if name != "atlasphys"])
def test_each_peer_stands_and_falls(name):
    pytest.importorskip(peers.PEERS[name].package)
    for scene in ("one_body", "falling_8"):
        (result,) = measure(make(scene), [name], Plan(rounds=2, steps=2, settle=0.2, seconds=1.0))
        assert result.stands, result.fault
        assert result.seconds == pytest.approx(1.0)
        assert len(result.wall) == 2


@pytest.mark.parametrize("name", ["atlasphys", "rapier", "box3d"])
def test_chains_swing(name):
    pytest.importorskip(peers.PEERS[name].package)
    (result,) = measure(make("chains_50x20"), [name], Plan(rounds=2, steps=2, settle=0.5, seconds=1.0))
    assert result.stands, result.fault
    assert 0 < result.quality.stretch < 0.05
    assert -0.02 < result.quality.energy < 0


@pytest.mark.parametrize("name", ["pybullet", "mujoco"])
def test_links_are_not_compared_with_all(name):
    pytest.importorskip(peers.PEERS[name].package)
    (result,) = measure(make("chains_50x20"), [name], Plan(rounds=1, steps=1, settle=0.1, seconds=0.2))
    assert "links are compared with Rapier and Box3D alone" in result.fault


@pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="Linux only")
@pythonic
def test_memory():
    (row,) = memory(["atlasphys"], Plan(settle=0.2), scene="pile_40")
    assert row["bodies"] == 40
    assert row["empty_bytes"] > 1e6
    assert row["fault"] == ""
