"""Pictures and films: the right size and length, and the bodies where they are."""

import numpy as np
import pytest

import atlasphys as ap
from atlasphys.cli import main

pytest.importorskip("pyvista", reason="pyvista is not installed: pip install 'atlasphys[render]'")
imageio_ffmpeg = pytest.importorskip("imageio_ffmpeg", reason="imageio-ffmpeg is not installed")
image = pytest.importorskip("PIL.Image")

from atlasphys.viewer.lines import projected  # noqa: E402
from atlasphys.viewer.picture import Look, Painter  # noqa: E402
from atlasphys.viewer.render import Shot, check_output, render_film, render_picture  # noqa: E402
from atlasphys.viewer.replay import Replay  # noqa: E402
from atlasphys.viewer.session import Session  # noqa: E402
from atlasphys.viewer.viewpoint import Viewpoint  # noqa: E402

SMALL = Look(size=(320, 180))


def can_draw():
    """Whether VTK finds an OpenGL here; without one it would end the process."""
    import subprocess
    import sys

    code = "import pyvista; p = pyvista.Plotter(off_screen=True); p.add_mesh(pyvista.Sphere()); p.screenshot(return_img=True)"
    return subprocess.run([sys.executable, "-c", code], capture_output=True).returncode == 0


@pytest.fixture(scope="module", autouse=True)
def _needs_opengl():
    if not can_draw():
        pytest.skip("there is no OpenGL: apt-get install libosmesa6 or libegl1 with libgl1-mesa-dri")


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("render") / "demo.h5"
    world = ap.load_scene("demo").build()
    with ap.Recorder(path, world, contacts=True) as recorder:
        for _ in range(60):
            world.step(1 / 60)
            recorder.record()
    return path


def film_size(path):
    frames = imageio_ffmpeg.read_frames(str(path))
    try:
        facts = next(frames)
    finally:
        frames.close()
    return facts["size"], facts["fps"], imageio_ffmpeg.count_frames_and_secs(str(path))[0]


def test_a_red_ball_is_where_the_camera_looks():
    world = ap.World()
    world.add(ap.Plane())
    world.add(ap.Sphere(radius=0.5), position=(3, 1, -2), color="#ff0000")
    frame = Session(world).frame()
    for orthographic in (False, True):
        painter = Painter(frame, SMALL)
        seen = painter.paint(frame, Viewpoint(np.array((3, 1, 6.0)), np.array((3, 1, -2.0)), 30.0, orthographic))
        painter.close()
        assert seen.shape == (180, 320, 3)
        red = (seen[:, :, 0] > 90) & (seen[:, :, 1] < 60)
        rows, columns = np.nonzero(red)
        assert abs(rows.mean() - 90) < 3
        assert abs(columns.mean() - 160) < 3
        expected = 0.5 / (8 * np.tan(np.radians(15))) * 90  # radius in pixels
        assert np.ptp(columns) / 2 == pytest.approx(expected, rel=0.1)


def test_shadows_darken_the_ground_and_can_be_switched_off():
    world = ap.World()
    world.add(ap.Plane())
    world.add(ap.Box(size=(1, 1, 1)), position=(0, 2, 0))
    frame = Session(world).frame()
    view = Viewpoint(np.array((0, 9.0, 12.0)), np.zeros(3))
    pictures = []
    for shadows in (True, False):
        painter = Painter(frame, Look(size=(320, 180), shadows=shadows))
        pictures.append(painter.paint(frame, view).astype(int))
        painter.close()
    darker = (pictures[1] - pictures[0]).sum(axis=2) > 60
    assert 30 < darker.sum() < 5000


def test_a_film_has_the_asked_size_rate_and_length(recorded, tmp_path):
    replay, seen = Replay(recorded), []
    shot = Shot(replay, view="front")
    count = render_film(
        replay, tmp_path / "a.mp4", shot, SMALL, frame_rate=20, begin=0.2, end=0.7, report=lambda *p: seen.append(p)
    )
    assert count == 11
    assert seen == [(k + 1, 11) for k in range(11)]
    assert film_size(tmp_path / "a.mp4") == ((320, 180), 20.0, 11)
    assert [path.name for path in tmp_path.iterdir()] == ["a.mp4"]
    with pytest.raises(ap.InvalidArgumentError, match="nothing to film"):
        render_film(replay, tmp_path / "b.mp4", shot, SMALL, begin=5.0)
    with pytest.raises(ap.InvalidArgumentError, match="frame rate"):
        render_film(replay, tmp_path / "b.mp4", shot, SMALL, frame_rate=0)
    assert not (tmp_path / "b.mp4").exists()
    replay.close()


def test_pictures_of_other_times_and_bodies_differ(recorded, tmp_path):
    replay = Replay(recorded)
    looks = {
        "early": (Shot(replay), SMALL, 0.1),
        "late": (Shot(replay), SMALL, None),
        "near": (Shot(replay, follow="cube 2"), SMALL, 0.1),
        "arrows": (
            Shot(replay),
            Look(size=(320, 180), shown=("velocity", "force", "impulse", "contacts", "boxes", "axes")),
            0.1,
        ),
        "dark": (Shot(replay, orthographic=True), Look(size=(320, 180), dark=True), 0.1),
    }
    pictures = {}
    for name, (shot, look, seconds) in looks.items():
        render_picture(replay, tmp_path / f"{name}.png", shot, look, seconds)
        pictures[name] = np.asarray(image.open(tmp_path / f"{name}.png")).astype(int)
        assert pictures[name].shape == (180, 320, 3)
    for name in ("late", "near", "arrows", "dark"):
        assert np.abs(pictures[name] - pictures["early"]).max() > 50, name
    replay.close()


def test_what_makes_no_sense_is_refused(recorded, tmp_path):
    replay = Replay(recorded)
    for bad in (
        {"view": "below"},
        {"follow": "nobody"},
        {"position": (1, 1, 1), "look_at": (1, 1, 1)},
        {"field_of_view": 200},
    ):
        with pytest.raises(ap.InvalidArgumentError):
            Shot(replay, **bad)
    for path, look in (
        ("a.avi", SMALL),
        ("missing/a.mp4", SMALL),
        ("a.mp4", Look(size=(321, 180))),
        ("a.png", Look(size=(1, 1))),
    ):
        with pytest.raises(ap.InvalidArgumentError):
            check_output(tmp_path / path, look)
    replay.close()


def test_the_command_renders_without_a_display(recorded, tmp_path, capsys):
    assert main(["render", str(recorded), str(tmp_path / "a.png"), "--size", "200x100", "--time", "0.5"]) == 0
    assert image.open(tmp_path / "a.png").size == (200, 100)
    assert main(["render", str(recorded), str(tmp_path / "a.mp4"), "--size", "200x100", "--fps", "5"]) == 0
    assert film_size(tmp_path / "a.mp4")[2] == 6
    capsys.readouterr()
    for words, said in (
        (["a.gif"], "must end in .mp4"),
        (["a.mp4", "--time", "1"], "--time is for pictures"),
        (["a.png", "--size", "big"], "WIDTHxHEIGHT"),
        (["a.png", "--position", "1,2"], "X,Y,Z"),
        (["a.png", "--show", "ghosts"], "--show must be one of"),
    ):
        assert main(["render", str(recorded), str(tmp_path / words[0]), *words[1:]]) == 2
        assert said in capsys.readouterr().err
    assert main(["render", str(tmp_path / "none.h5"), str(tmp_path / "b.png")]) == 1
    assert "cannot be read" in capsys.readouterr().err


def pendulum(path):
    """A recording of a small ball that hangs still, by a rod, from a point of the world."""
    world = ap.World(gravity=(0, 0, 0))
    ball = world.add(ap.Sphere(radius=0.2), position=(0, 1, 0), color="#808080")
    world.join(ap.Distance(None, ball, anchor_a=(0, 4, 0)))
    with ap.Recorder(path, world) as recorder:
        recorder.record()


def test_joints_are_drawn_in_pictures(tmp_path):
    pendulum(tmp_path / "a.h5")
    replay = Replay(tmp_path / "a.h5")
    shot = Shot(replay, position=(0, 2.5, 8), look_at=(0, 2.5, 0))
    pictures = []
    for joints in (True, False):
        render_picture(replay, tmp_path / "a.png", shot, Look(size=(320, 180), joints=joints))
        pictures.append(np.asarray(image.open(tmp_path / "a.png")).astype(int))
    replay.close()
    with_joints, without = pictures
    differs = np.abs(with_joints - without).max(axis=2) > 60
    rows, columns = np.nonzero(differs)
    # The rod is 3 m long, 8 m away, in the middle of the picture.
    height = 3 / 8 / np.tan(np.radians(25)) / 2 * 180
    assert abs(np.ptp(rows) - height) < 4
    assert np.abs(columns - 160).max() <= 2
    red, green, blue = with_joints[90, 159:162].mean(axis=0)
    assert red > green > blue + 20  # orange


def test_lines_are_projected_as_bodies_are():
    """Small balls, and the same points by the projection of lines; in perspective, orthographic and from above."""
    world = ap.World(gravity=(0, 0, 0))
    places = np.array([(1.0, 0.5, -0.5), (-1.2, 1.0, 0.4), (0.3, -0.8, 1.0)])
    for place in places:
        world.add(ap.Sphere(radius=0.08), position=place, color="#ff0000")
    frame = Session(world).frame()
    look = Look(size=(320, 180), shadows=False)
    for position, orthographic in (((2, 3, 5), False), ((2, 3, 5), True), ((0, 6, 0.001), False)):
        viewpoint = Viewpoint(np.array(position, float), np.zeros(3), 40.0, orthographic)
        painter = Painter(frame, look)
        picture = painter.paint(frame, viewpoint).astype(int)
        painter.close()
        expected = projected(np.stack([places, places], axis=1), viewpoint, look.size)[:, 0]
        is_red = picture[:, :, 0] > picture[:, :, 1] + 60
        rows, columns = np.nonzero(is_red)
        found = np.stack([columns + 0.5, 180 - (rows + 0.5)], axis=1)
        nearest = np.sqrt(((found[:, None] - expected) ** 2).sum(axis=2))
        assert nearest.min(axis=1).max() < 9  # all red is on a ball
        for k in range(3):
            middle = found[nearest.argmin(axis=1) == k].mean(axis=0)
            assert np.abs(middle - expected[k]).max() < 1.5


def test_lines_behind_the_camera_are_cut_off():
    viewpoint = Viewpoint(np.array([0.0, 0.0, 5.0]), np.zeros(3), 90.0)
    ahead, through, behind = [(0, 0, 0), (1, 0, 0)], [(1, 0, 0), (1, 0, 20)], [(0, 0, 6), (1, 0, 9)]
    points = projected(np.array([ahead, through, behind], float), viewpoint, (200, 100))
    assert np.allclose(points[0], [(100, 50), (110, 50)])
    assert len(points) == 2
    assert np.allclose(points[1], [(110, 50), (1100, 50)])  # cut at 1/100 of 5 m before the camera


def test_a_film_is_taken_from_where_all_of_it_is_seen(tmp_path):
    world = ap.World(gravity=(0, 0, 0))
    ball = world.add(ap.Sphere(radius=0.5), velocity=(6, 0, 0))
    world.add(ap.Sphere(radius=0.5), position=(0, 3, 0))
    with ap.Recorder(tmp_path / "a.h5", world) as recorder:
        for _ in range(61):
            recorder.record()
            world.step(1 / 60)
    replay = Replay(tmp_path / "a.h5")
    assert np.allclose(Shot(replay).at(replay.frame()).look_at, (2.5, 1.5, 0), atol=0.6)
    assert np.allclose(Shot(replay, moment=0).at(replay.frame()).look_at, (0, 1.5, 0), atol=1e-6)
    assert np.allclose(Shot(replay, moment=1).at(replay.frame()).look_at, (3, 1.5, 0), atol=1e-3)
    assert ball.position[0] > 6
    replay.close()
