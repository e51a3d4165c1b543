"""The ways into the viewer: the command, the notebook, and what is said when something is missing."""

import sys
import urllib.request

import pytest

import atlasphys as ap
from atlasphys.cli import main


def small_world():
    world = ap.World()
    world.add(ap.Plane())
    world.add(ap.Box(size=(1, 1, 1)), position=(0, 0.5, 0))
    return world


def test_a_world_has_a_small_table_for_notebooks():
    world = small_world()
    world.run(seconds=1)
    text = world._repr_html_()
    for words in ("<table>", "1 Plane, 1 Box", "1 asleep", "1 s, 60 steps", "4</td>", "soft_step"):
        assert words in text, words
    assert world.contact_count == len(world.contacts) == 4
    assert world.bodies.asleep.tolist() == [False, True] == [body.asleep for body in world.bodies]


def test_view_shows_a_copy_and_leaves_the_world_alone(capsys):
    pytest.importorskip("viser")
    world = small_world()
    before = world.state_hash()
    page = world.view()
    try:
        assert page.url in capsys.readouterr().out
        assert b"<html" in urllib.request.urlopen(page.url).read()[:2000].lower()
        page.do(lambda session: session.step(3)).result(60)
        assert world.state_hash() == before
    finally:
        page.close()


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["view", "towr"], 2, "did you mean 'tower'?"),
        (["view", "missing.h5"], 1, "missing.h5: cannot be read"),
        (["view", "missing.h5", "--solver", "soft_step"], 2, "is a recording"),
        (["view", "demo", "--set", "pairs=0"], 2, "pairs"),
        (["run", "demo", "--record-contacts"], 2, "--record"),
    ],
)
def test_wrong_commands_are_refused_in_a_line(words, code, said, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(words) == code
    error = capsys.readouterr().err
    assert said in error
    assert len(error.splitlines()) == 1


@pytest.mark.parametrize(
    ("package", "extra"), [("viser", "viewer"), ("pyvista", "render"), ("imageio_ffmpeg", "render")]
)
def test_a_missing_extra_names_the_command_that_installs_it(package, extra, monkeypatch, tmp_path, capsys):
    world = small_world()
    with ap.Recorder(tmp_path / "a.h5", world) as recorder:
        world.step(1 / 60)
        recorder.record()
    monkeypatch.setitem(sys.modules, package, None)
    words = {
        "viser": ["view", "demo"],
        "pyvista": ["render", str(tmp_path / "a.h5"), str(tmp_path / "a.png")],
        "imageio_ffmpeg": ["render", str(tmp_path / "a.h5"), str(tmp_path / "a.mp4")],
    }
    assert main(words[package]) == 1
    error = capsys.readouterr().err
    assert f"pip install 'atlasphys[{extra}]'" in error
    assert len(error.splitlines()) == 1
