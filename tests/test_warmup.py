"""``atlasphys.warmup`` and compiling ahead: what is in the cache afterwards, and what is not started needlessly."""

import os
import subprocess
import sys

import pytest

from atlasphys import cli, warmup
from atlasphys.engine import ahead
from atlasphys.engine.fused.detection import detection_address
from atlasphys.engine.jit import is_compiled

STEPS = """
import glob, atlasphys as ap
count = lambda: sorted(glob.glob({folder!r} + "/**/*.nbc", recursive=True))
before = count()
from atlasphys.warmup import use_worlds
use_worlds("default", "single")
world = ap.World()
world.add(ap.Box(size=(1, 1, 1)), locks=("rx",))
world.step(0.01)
print([name for name in count() if name not in before])
"""


def run(command, folder):
    environment = os.environ | ahead.environment() | {"ATLASPHYS_CACHE_DIR": str(folder)}
    return subprocess.run(command, check=True, env=environment, capture_output=True, text=True).stdout


@pytest.mark.full
def test_a_default_world_needs_nothing_that_is_not_warmed_up(tmp_path):
    run([sys.executable, "-m", "atlasphys", "warmup"], tmp_path)
    assert run([sys.executable, "-c", STEPS.format(folder=str(tmp_path))], tmp_path).strip() == "[]"


@pytest.mark.parametrize("job", [*warmup.STEP, *warmup.CLASSIC])
def test_each_job_runs(job):
    (warmup.STEP | warmup.CLASSIC)[job]("single")


def test_nothing_is_started_where_all_is_compiled(monkeypatch):
    monkeypatch.setattr(ahead, "_started", set())
    warmup.STEP["detection"]("single")
    assert is_compiled(detection_address)
    monkeypatch.setattr(subprocess, "Popen", lambda *_, **__: pytest.fail("a child was started"))
    ahead.start({"detection": detection_address}, "single")
    ahead.wait()


def test_a_child_that_fails_is_not_waited_for_in_vain(monkeypatch):
    monkeypatch.setattr(ahead, "_started", set())
    monkeypatch.setattr(ahead, "is_compiled", lambda _: False)
    monkeypatch.setattr(ahead.os, "cpu_count", lambda: 2)
    monkeypatch.setattr(ahead, "command", lambda *_: [sys.executable, "-c", "raise SystemExit(3)"])
    ahead.start({"detection": detection_address}, "single")
    assert len(ahead._children) == 1
    ahead.start({"detection": detection_address}, "single")  # it has been tried
    assert len(ahead._children) == 1
    ahead.wait()
    assert not ahead._children


def test_children_end_with_this_process(monkeypatch):
    monkeypatch.setattr(ahead, "_started", set())
    monkeypatch.setattr(ahead, "is_compiled", lambda _: False)
    monkeypatch.setattr(ahead.os, "cpu_count", lambda: 2)
    monkeypatch.setattr(ahead, "command", lambda *_: [sys.executable, "-c", "import time; time.sleep(600)"])
    ahead.start({"detection": detection_address}, "single")
    (child,) = ahead._children
    ahead._end()
    assert child.returncode
    assert not ahead._children


def test_a_job_that_fails_is_named(monkeypatch, capsys):
    failing = [sys.executable, "-c", "raise ValueError('no room')"]
    monkeypatch.setattr(ahead, "command", lambda *_: failing)
    assert cli.main(["warmup", "--processes", "2"]) == 1
    said = capsys.readouterr().err
    assert "compiling 'response' for single precision failed: ValueError: no room" in said


def test_the_command_says_what_is_ready(monkeypatch, capsys):
    monkeypatch.setattr(ahead, "command", lambda *_: [sys.executable, "-c", ""])
    assert cli.main(["warmup", "--preset", "all", "--precision", "all"]) == 0
    assert "default, classic worlds in single and double precision" in capsys.readouterr().out
    assert cli.main(["warmup", "--json"]) == 0
    assert '"precisions": ["single"]' in capsys.readouterr().out
