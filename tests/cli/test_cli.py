"""The command line, run as its users run it: in a process of its own."""

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import atlasphys as ap
from atlasphys.cli import main
from atlasphys.scene import library

SOURCES = str(Path(ap.__file__).parents[1])
COMMAND = [sys.executable, "-W", "error", "-m", "atlasphys"]
posix = pytest.mark.skipif(os.name != "posix", reason="POSIX signals and terminals")


def environment():
    return os.environ | {"PYTHONPATH": SOURCES, "PYTHONIOENCODING": "utf-8"}


def atlasphys(*words, cwd=None):
    return subprocess.run(
        [*COMMAND, *map(str, words)], capture_output=True, text=True, timeout=300, env=environment(), cwd=cwd
    )


@pytest.fixture(scope="module", autouse=True)
def _compiled_kernels():
    """So that no test below waits for the compiler."""
    for name in ("tower", "pyramid"):
        ap.load_scene(name).build().step(1 / 60)


def complaints(stderr):
    """What is on standard error beside the notice that kernels are being compiled, be it by another process with the same cache."""
    return [line for line in stderr.splitlines() if not line.startswith("compiling kernels")]


def test_help_lists_the_commands():
    result = atlasphys("--help")
    assert result.returncode == 0
    assert all(command in result.stdout for command in ("run", "scenes", "doctor"))


def test_help_imports_nothing_heavy():
    code = (
        "import sys; from atlasphys.cli import main; main(['run', '--help']); "
        "print([name for name in ('numba', 'numpy', 'h5py', 'pydantic', 'scipy') if name in sys.modules])"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment(), timeout=60)
    assert result.stdout.strip().endswith("[]"), result.stdout + result.stderr


def test_run_ends_with_a_table():
    result = atlasphys("run", "tower", "--seconds", 1)
    assert result.returncode == 0
    assert complaints(result.stderr) == []
    for row in (
        "simulated",
        "speed",
        "bodies",
        "in place",
        "fell",
        "at rest",
        "kinetic energy",
        "deepest contact",
        "time per step",
        "state hash",
    ):
        assert re.search(rf"^{row} ", result.stdout, re.MULTILINE), row
    assert "1 s in 60 steps of 0.01667 s" in result.stdout
    assert "10 of 10, within 0.05 m" in result.stdout


def test_json_is_one_object_and_nothing_else(tmp_path):
    result = atlasphys(
        "run", "tower", "--set", "height=3", "--seconds", 0.5, "--dt", 0.01, "--record", tmp_path / "a.h5", "--json"
    )
    assert result.returncode == 0
    assert complaints(result.stderr) == []
    assert result.stdout.count("\n") == 1
    summary = json.loads(result.stdout)
    assert (summary["scene"], summary["steps"], summary["dt"], summary["bodies"]) == ("tower", 50, 0.01, 4)
    assert (summary["dynamic_bodies"], summary["in_place"], summary["fell"]) == (3, 3, 0)
    assert summary["recording"] == {"path": str(tmp_path / "a.h5"), "steps": 50}
    assert set(summary["stage_milliseconds"]) == {
        "broadphase",
        "narrowphase",
        "manifold",
        "islands",
        "solver",
        "continuous",
        "finish",
    }
    assert (summary["interrupted"], summary["error"]) == (False, None)

    world = ap.load_scene("tower", height=3).build()
    world.run(seconds=0.5, dt=0.01)
    assert summary["state_hash"] == world.state_hash()
    assert summary["energy"]["total"]["end"] == world.energy().total
    with ap.Recording(tmp_path / "a.h5") as recording:
        assert len(recording) == 50
        assert np.array_equal(recording.poses(-1).positions, world.bodies.position)
        assert recording.scene == ap.load_scene("tower", height=3)


def test_what_fell_is_said():
    result = atlasphys("run", "two_boxes", "--set", "drop=2", "--seconds", 2, "--json")
    summary = json.loads(result.stdout)
    assert (summary["fell"], summary["fallen"], summary["at_rest"]) == (1, ["upper"], 2)
    assert summary["farthest"]["body"] == "upper"
    assert summary["farthest"]["distance"] == pytest.approx(2, abs=0.02)


def test_a_scene_file_runs(tmp_path):
    ap.load_scene("two_boxes").save(tmp_path / "mine.toml")
    result = atlasphys("run", "mine.toml", "--seconds", 0.1, "--json", cwd=tmp_path)
    assert json.loads(result.stdout)["steps"] == 6


def test_settings_on_the_command_line_replace_the_scenes(tmp_path):
    scene = {
        "version": 1,
        "world": {"solver": "sequential_impulse", "solver_settings": {"iterations": 3}, "broadphase": "brute"},
    }
    (tmp_path / "a.json").write_text(json.dumps(scene))
    kept = json.loads(atlasphys("run", tmp_path / "a.json", "--seconds", 0.1, "--json").stdout)
    assert kept["settings"]["broadphase"] == "brute"
    replaced = json.loads(
        atlasphys("run", tmp_path / "a.json", "--seconds", 0.1, "--preset", "classic", "--json").stdout
    )
    assert replaced["settings"]["broadphase"] == "sweep"


def test_scenes_are_listed_a_line_each(capsys):
    assert main(["scenes"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == list(library.names())
    assert main(["scenes", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)
    assert listed["tower"]["parameters"]["height"]["default"] == 10
    assert main(["scenes", "--schema"]) == 0
    assert json.loads(capsys.readouterr().out)["title"] == "SceneModel"


def test_doctor_shows_versions(capsys):
    assert main(["doctor"]) == 0
    output = capsys.readouterr().out
    assert re.search(r"^numba +\d+\.", output, re.MULTILINE)
    assert "compiled" in output


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["run"], "requires an argument"),
        (["run", "towr"], "towr: neither a scene of the library nor a file; did you mean 'tower'?"),
        (["run", "missing.toml"], "missing.toml: cannot be read: No such file or directory"),
        (["run", "tower", "--set", "heigth=3"], "tower: heigth: unknown parameter; did you mean 'height'?"),
        (["run", "tower", "--set", "name_or_path=3"], "tower: name_or_path: unknown parameter"),
        (["run", "tower", "--set", "height"], "--set takes NAME=VALUE (got 'height')"),
        (["run", "tower", "--set", "height=3", "--set", "height=4"], "--set height is given twice"),
        (["run", "tower", "--set", "height=0"], "tower: height: must be greater than or equal to 1"),
        (["run", "tower", "--seconds", "-1"], "--seconds must be a number of seconds greater than 0 (got -1)"),
        (["run", "tower", "--seconds", "nan"], "--seconds must be a number of seconds greater than 0"),
        (["run", "tower", "--seconds", "soon"], "soon"),
        (["run", "tower", "--dt", "0"], "--dt must be"),
        (["run", "tower", "--dt", "1e-300"], "must be at most 1,000,000,000 steps"),
        (["run", "tower", "--dt", "100", "--seconds", "1000"], "dt must be a number from"),
        (
            ["run", "tower", "--solver", "magic"],
            "solver must be one of 'soft_step', 'sequential_impulse', 'xpbd', 'avbd' (got 'magic')",
        ),
        (["run", "tower", "--preset", "magic"], "preset must be one of 'default', 'classic', 'xpbd', 'avbd'"),
        (["run", "tower", "--threads", "0"], "threads must be"),
        (["run", "tower", "--sceonds", "1"], "--sceonds"),
        (["rnu", "tower"], "rnu"),
    ],
)
def test_a_command_that_makes_no_sense_is_refused_in_a_line(capsys, words, message):
    assert main([*words, "--json"] if words[0] == "run" else words) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert message in captured.err
    assert len(captured.err.splitlines()) == 1
    assert captured.err.startswith("atlasphys: ")


def test_every_fault_of_a_scene_file_has_its_line(tmp_path, capsys):
    (tmp_path / "a.toml").write_text("version = 1\nseconds = -1\n[[bodies]]\nshape = {type = 'sphere', radius = 0}\n")
    assert main(["run", str(tmp_path / "a.toml")]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 2
    assert "a.toml:4: bodies[0].shape.radius: must be greater than 0 (got 0)" in lines[1]


def test_a_recording_that_cannot_be_written_is_an_error_of_the_run(tmp_path, capsys):
    assert main(["run", "tower", "--seconds", "0.1", "--record", str(tmp_path / "missing" / "a.h5"), "--json"]) == 1
    captured = capsys.readouterr()
    assert "a.h5: cannot be written: No such file or directory" in captured.err


DIVERGING = {
    "version": 1,
    "bodies": [
        {"shape": {"type": "plane"}, "name": "ground"},
        {
            "name": "star",
            "shape": {"type": "sphere", "radius": 0.5},
            "mass": 1e36,
            "position": [0, 9, 0],
            "velocity": [0, -1e4, 0],
        },
        {"name": "ball", "shape": {"type": "sphere", "radius": 0.5}, "position": [0, 50, 0]},
    ],
}


def test_divergence_names_the_bodies_and_keeps_the_recording(tmp_path):
    """The star's momentum, 1e40 kg m/s, is too large for single precision, and the ground must take it."""
    (tmp_path / "a.json").write_text(json.dumps(DIVERGING))
    result = atlasphys(
        "run", tmp_path / "a.json", "--dt", 1e-4, "--seconds", 0.01, "--record", tmp_path / "a.h5", "--json"
    )
    assert result.returncode == 1, result.stderr
    assert "star" in result.stderr
    assert len(complaints(result.stderr)) == 1
    summary = json.loads(result.stdout)
    assert "star" in summary["error"]
    with ap.Recording(tmp_path / "a.h5") as recording:
        assert len(recording) == summary["steps"] == summary["recording"]["steps"] > 0
        assert np.isfinite(recording.poses(-1).positions).all()


def heed_interrupts():
    """In the child: jobs that a shell starts in the background ignore SIGINT, and so would their children."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@pytest.fixture(autouse=True)
def no_survivors(monkeypatch):
    """Kill what a failing test has started and not ended."""
    started = []
    original = subprocess.Popen

    def start(*words, **options):
        started.append(original(*words, **options))
        return started[-1]

    monkeypatch.setattr(subprocess, "Popen", start)
    yield
    for process in started:
        if process.poll() is None:
            process.kill()
            process.communicate()


def start_long_run(path, *words):
    """A run that has begun to record."""
    process = subprocess.Popen(
        [*COMMAND, "run", "pyramid", "--seconds", "10000", "--record", str(path), *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=heed_interrupts,
        env=environment(),
    )
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline:
        if path.exists():
            with contextlib.suppress(ap.RecordingError), ap.Recording(path) as recording:  # a commit may be under way
                if len(recording):
                    return process
        time.sleep(0.02)
    process.kill()
    raise AssertionError(f"no steps were recorded: {process.communicate()}")


@posix
def test_ctrl_c_stops_with_the_recording_intact(tmp_path):
    # How long it takes is measured by benchmarks/responsiveness.py.
    for attempt in range(3):
        path = tmp_path / f"{attempt}.h5"
        process = start_long_run(path, "--json")
        time.sleep(0.05 * attempt)
        process.send_signal(signal.SIGINT)
        output, errors = process.communicate(timeout=10)
        assert process.returncode == 130
        assert complaints(errors) == []
        summary = json.loads(output)
        assert summary["interrupted"]
        with ap.Recording(path) as recording:
            assert len(recording) == summary["recording"]["steps"] > 0
            assert np.isfinite(recording.poses(-1).positions).all()
            assert recording.times[-1] == pytest.approx(len(recording) / 60)


@posix
def test_ctrl_c_prints_the_summary_so_far(tmp_path):
    process = start_long_run(tmp_path / "a.h5")
    process.send_signal(signal.SIGINT)
    output, _ = process.communicate(timeout=10)
    assert process.returncode == 130
    assert "(stopped by Ctrl-C)" in output
    assert "recording" in output


@posix
def test_ctrl_c_while_kernels_are_compiled_stops_at_once(tmp_path):
    process = subprocess.Popen(
        [*COMMAND, "run", "tower", "--record", str(tmp_path / "a.h5")],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=heed_interrupts,
        env=environment() | {"ATLASPHYS_CACHE_DIR": str(tmp_path / "cache")},
    )
    line = process.stderr.readline()
    assert line == "compiling kernels: up to a minute, once for each kind of shape\n"
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    output, _ = process.communicate(timeout=10)  # compiling on takes longer
    assert process.returncode == 130
    assert "0 steps" in output


@posix
def test_kill_9_leaves_the_recording_readable(tmp_path):
    process = start_long_run(tmp_path / "a.h5")
    process.kill()
    process.communicate()
    with ap.Recording(tmp_path / "a.h5") as recording:
        assert len(recording) >= 50
        assert recording.scene.name == "pyramid"
        assert np.isfinite(recording.poses(-1).positions).all()


@posix
def test_progress_is_shown_on_a_terminal():
    """What a person sees: time simulated, bodies, contacts, and speed against real time."""
    import pty

    master, slave = pty.openpty()
    process = subprocess.Popen(
        [*COMMAND, "run", "pyramid", "--seconds", "5"],
        stdin=slave,
        stdout=subprocess.PIPE,
        stderr=slave,
        text=True,
        preexec_fn=heed_interrupts,
        env=environment() | {"TERM": "xterm", "COLUMNS": "120"},
    )
    os.close(slave)
    shown = b""
    while True:
        try:
            piece = os.read(master, 65536)
        except OSError:  # the terminal's other end is closed
            break
        if not piece:
            break
        shown += piece
    output, _ = process.communicate(timeout=60)
    os.close(master)
    text = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", shown.decode())
    assert re.search(r"pyramid +\d\.\d\d / 5 s .*211 bodies, \d+ contacts, [\d.e+]+ × real time", text), text[-2000:]
    assert "state hash" in output
    assert "× real time" not in output.split("speed")[0]


def test_a_reader_that_goes_away_is_no_crash():
    result = subprocess.run(
        f"{' '.join(COMMAND)} scenes --schema | head -1",
        shell=True,
        capture_output=True,
        text=True,
        preexec_fn=heed_interrupts,
        env=environment(),
        timeout=60,
    )
    assert result.stdout == "{\n"
    assert "Traceback" not in result.stderr
