"""The ways into the viewer: the command, the notebook, and what is said when something is missing."""

import base64
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


@pytest.fixture
def displayed(monkeypatch):
    """What is displayed in what seems to be a notebook, as HTML."""
    notebook, shown = pytest.importorskip("atlasphys.viewer.notebook"), []
    monkeypatch.setattr(notebook, "_in_notebook", lambda: True)
    monkeypatch.setattr(notebook, "_display_html", shown.append)
    monkeypatch.delenv("JUPYTERHUB_SERVICE_PREFIX", raising=False)
    return shown


@pytest.mark.skipif(sys.platform != "linux", reason="the picture needs no display on Linux only")
def test_a_notebook_that_runs_elsewhere_shows_a_picture_or_a_film(displayed, monkeypatch, capsys):
    for package in ("pyvista", "imageio_ffmpeg", "viser"):
        pytest.importorskip(package)
    from tests.viewer.test_render import can_draw

    if not can_draw():
        pytest.skip("there is no OpenGL")
    world = small_world()
    before = world.state_hash()
    assert world.view(inline="picture", height=90) is None
    assert world.view(inline="film", seconds=0.1, height=90) is None
    assert [text.split(";base64,")[0].split("data:")[1] for text in displayed] == ["image/png", "video/mp4"]
    assert base64.b64decode(displayed[0].split("base64,")[1].split('"')[0]).startswith(b"\x89PNG")
    assert b"ftyp" in base64.b64decode(displayed[1].split("base64,")[1].split('"')[0])[:12]
    assert world.state_hash() == before
    monkeypatch.setenv("JUPYTERHUB_SERVICE_PREFIX", "/user/ann/")
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert world.view(height=90) is None
    assert displayed[2].startswith("<img")
    assert "docs/viewer.md" in capsys.readouterr().out
    monkeypatch.setattr("importlib.util.find_spec", lambda name: object())
    page = world.view()
    try:
        assert f'src="/user/ann/proxy/{page.server.get_port()}/"' in displayed[3]
    finally:
        page.close()


def test_a_picture_is_refused_where_there_is_no_notebook():
    for way, reason in (("picture", "no notebook"), ("film", "no notebook"), ("hologram", "inline")):
        with pytest.raises(ap.InvalidArgumentError, match=reason):
            small_world().view(inline=way)


def test_a_page_that_is_not_reached_says_what_to_do(displayed, browser, tmp_path):
    page = small_world().view()
    tab = browser.new_page()
    try:
        (tmp_path / "cell.html").write_text(displayed[0])
        tab.goto((tmp_path / "cell.html").as_uri())
        tab.frame_locator("iframe").get_by_role("tab", name="Objects").wait_for()
        assert not tab.get_by_text("Nothing answers").is_visible()
        page.close()
        tab.reload()
        tab.get_by_text('inline="picture"').wait_for()
        assert not tab.locator("iframe").is_visible()
    finally:
        page.close()
        tab.close()


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
