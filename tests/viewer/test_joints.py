"""Joints in the viewer: what is drawn of them, and what its commands and dialogs do to the world."""

import dataclasses
import math

import numpy as np
import pytest

import atlasphys as ap
from atlasphys.errors import InvalidArgumentError
from atlasphys.viewer.joints import NO_LINES, joint_at, joint_lines
from atlasphys.viewer.overlays import centers
from atlasphys.viewer.replay import Replay
from atlasphys.viewer.session import Session

WIDTH = 0.5


def lines(session, selected=None):
    frame = session.frame()
    return joint_lines(frame, centers(frame), WIDTH, selected)


def door(**settings):
    """A cone, whose centre of mass is not its origin, on a hinge of the world, with a ball on it by a rod."""
    world = ap.World(gravity=(0, -10, 0))
    cone = world.add(ap.Cone(radius=0.4, height=1.0), position=(1, 2, 0), name="cone")
    ball = world.add(ap.Sphere(radius=0.2), position=(3, 2, 0), name="ball")
    world.join(ap.Hinge(None, cone, anchor=(0, 2, 0), axis=(0, 0, 2), **settings), name="pivot")
    world.join(ap.Distance(cone, ball))
    return Session(world)


def test_lines_of_a_hinge_and_a_rod():
    session = door()
    drawn = lines(session)
    centre = np.array([1, 2, 0]) + session.world.bodies["cone"].shape.center_of_mass
    assert np.allclose(drawn.arms, [[centre, (0, 2, 0)], [centre, (1, 2, 0)], [(3, 2, 0), (3, 2, 0)]])
    assert np.allclose(drawn.links, [[(0, 2, 0), (0, 2, 0)], [(1, 2, 0), (3, 2, 0)]])
    assert np.allclose(drawn.axes, [[(0, 2, -WIDTH / 2), (0, 2, WIDTH / 2)]])
    assert len(drawn.idle) == len(drawn.selected) == 0
    rod = session.world.joints[1].id
    assert np.allclose(
        lines(session, rod).selected, [[centre, (1, 2, 0)], [(3, 2, 0), (3, 2, 0)], [(1, 2, 0), (3, 2, 0)]]
    )


@pytest.mark.parametrize("name", ["ragdoll", "suspension", "four_bar"])
def test_lines_follow_the_bodies(name):
    """Links are from anchor to anchor as the handles have them; hinges and wheels are marked along axes that turn with their bodies."""
    session = Session.from_scene(ap.load_scene(name))
    session.step(12)
    drawn, joints = lines(session), list(session.world.joints)
    assert np.allclose(drawn.links, [joint.anchors for joint in joints], atol=1e-6)
    assert len(drawn.arms) == sum((joint.a is not None) + (joint.b is not None) for joint in joints)
    marks = {"Hinge": 1, "Wheel": 2}
    assert len(drawn.axes) == sum(marks.get(type(joint.settings).__name__, 0) for joint in joints) > 0
    length = np.sqrt(((drawn.axes[:, 1] - drawn.axes[:, 0]) ** 2).sum(axis=1))
    assert np.allclose(length, WIDTH)


def test_the_axes_of_a_plane_linkage_stay_at_right_angles_to_its_plane():
    session = Session.from_scene(ap.load_scene("four_bar"))
    session.step(12)
    mark = lines(session).axes
    assert np.allclose(np.abs((mark[:, 1] - mark[:, 0]) @ (0, 0, 1)), WIDTH, atol=1e-3)


def test_a_pulley_is_drawn_over_its_wheels():
    world = ap.World()
    a = world.add(ap.Sphere(radius=0.2), position=(-1, 0, 0))
    b = world.add(ap.Sphere(radius=0.2), position=(1, 0, 0))
    world.join(ap.Pulley(a, b, ground_a=(-1, 3, 0), ground_b=(1, 3, 0)))
    drawn = lines(Session(world))
    left, right = (-1, 3, 0), (1, 3, 0)
    assert np.allclose(drawn.links, [[(-1, 0, 0), left], [(1, 0, 0), right], [left, right]])


@pytest.mark.parametrize("name", ["joint_grid", "gear_train", "rope_heavy", "cradle_strings", "tower"])
def test_scenes_of_all_kinds_of_joints_can_be_drawn(name):
    session = Session.from_scene(ap.load_scene(name))
    joints = len(session.world.joints)
    drawn = lines(session)
    assert all(np.isfinite(points).all() for points in drawn)
    assert len(drawn.links) == joints
    assert (joints > 0) == (name != "tower")


def test_what_does_not_act_is_grey_and_a_recording_has_none():
    session = door()
    pivot, rod = (joint.id for joint in session.world.joints)
    session.edit_joint(rod, {"enabled": False})
    drawn = lines(session)
    assert (len(drawn.arms), len(drawn.idle), len(drawn.links), len(drawn.axes)) == (1, 2, 1, 1)
    session.edit_joint(pivot, {"enabled": False})
    drawn = lines(session)
    assert (len(drawn.arms), len(drawn.idle), len(drawn.links), len(drawn.axes)) == (0, 3, 0, 0)
    frame = dataclasses.replace(session.frame(), joints=None)
    assert joint_lines(frame, centers(frame), WIDTH) == NO_LINES


@pytest.mark.parametrize("name", ["suspension", "gear_train", "cradle_strings", "ragdoll"])
def test_a_recording_shows_the_lines_that_the_world_had(name, tmp_path):
    scene = ap.load_scene(name)
    world = scene.build()
    session = Session(world)
    expected = []
    with ap.Recorder(tmp_path / "a.h5", world, scene) as recorder:
        for step in range(12):
            if step == 4:
                world.joints[0].enabled = False
            if step == 8:
                session.remove_joint(world.joints[1].id)
            world.step(1 / 60)
            recorder.record()
            expected.append(lines(session))
    replay = Replay(tmp_path / "a.h5")
    for step in (2, 6, 10):
        replay.seek(step)
        for got, had in zip(lines(replay), expected[step], strict=True):
            np.testing.assert_allclose(got, had, atol=1e-5)
    assert replay.has_joints
    replay.close()


def test_a_damaged_joint_of_a_recording_is_refused(tmp_path):
    h5py = pytest.importorskip("h5py")
    session = door()
    with ap.Recorder(tmp_path / "a.h5", session.world) as recorder:
        recorder.record()
    with h5py.File(tmp_path / "a.h5", "r+") as file:
        file["joints"][0] = '{"type": "hinge", "b": 0, "axis": [0, 0, 0]}'
    with pytest.raises(ap.RecordingError, match="joint 0"):
        Replay(tmp_path / "a.h5")


def test_a_ray_finds_the_joint_whose_line_it_passes():
    session = door()
    pivot, rod = (joint.id for joint in session.world.joints)
    frame = session.frame()

    def found(target, tolerance=0.01, **settings):
        eye = np.array([1.0, 3.0, 8.0])
        ray = np.subtract(target, eye)
        return joint_at(frame, centers(frame), WIDTH, eye, ray / np.sqrt(ray @ ray), tolerance, **settings)

    assert found((0, 2, 0)) == pivot  # its anchor
    assert found((0, 2, 0.24)) == pivot  # its axis
    assert found((2, 2, 0)) == rod
    assert found((2, 2.02, 0)) == rod
    assert found((2, 2.5, 0)) is None
    assert found((2, 2.5, 0), tolerance=0.2) == rod
    centre = session.world.bodies["cone"].center_of_mass
    arm = 0.75 * centre + 0.25 * np.array([0.0, 2.0, 0.0])
    assert found(arm) == pivot
    assert found(arm, arms=False) is None
    behind = joint_at(frame, centers(frame), WIDTH, (0, 2, 5), (0, 0, 1), 0.01)
    assert behind is None
    session.edit_joint(rod, {"enabled": False})
    frame = session.frame()
    assert found((2, 2, 0)) is None


def test_joints_are_made_and_undone():
    session = door()
    cone, ball = (int(identity) for identity in session.world.bodies.id)
    made = session.join(ap.Ball, cone, None, "tip", anchor=(1, 2.5, 0))
    assert session.world.joints["tip"].id == made
    assert session.joint(made).a.name == "cone"
    before = session.world.state_hash()
    for kind, ends, settings, reason in (
        (ap.Ball, (cone, cone), {}, "two different bodies"),
        (ap.Ball, (None, None), {}, "both None"),
        (ap.Hinge, (cone, ball), {"axis": (0, 0, 0)}, "axis must be"),
        (ap.Gear, (cone, ball), {"axis_a": (1, 0, 0), "axis_b": (1, 0, 0), "ratio": 0}, "ratio must be"),
        (ap.Ball, (cone, 10**9), {}, "no longer there"),
    ):
        with pytest.raises(InvalidArgumentError, match=reason):
            session.join(kind, *ends, **settings)
    with pytest.raises(InvalidArgumentError, match="already taken"):
        session.join(ap.Ball, cone, ball, "tip")
    assert session.world.state_hash() == before
    session.step()
    session.step_back()
    assert session.world.state_hash() == before


def test_settings_by_degree_of_freedom_are_read():
    fields = pytest.importorskip("atlasphys.viewer.gui.joint_fields")
    entered = {}

    class Form:
        def __getattr__(self, sort):
            return lambda name, label, value, hint=None: entered.update({name: value})

    joint = ap.SixDof(
        None, None, x=(-1, 1), rx="free", friction={"x": 3.0}, springs={"x": ap.Elastic(frequency=2, damping=0.5, rest=0.1)},
        motors={"rx": ap.Motor(speed=2, max_force=10)},
    )  # fmt: skip
    readers = fields.setting_fields(Form(), ap.SixDof, joint)
    assert (entered["friction"], entered["springs"], entered["motors"]) == ("x 3", "x 2 0.5", "rx 2 10")
    for name, reader in readers.items():
        assert reader(entered) == getattr(joint, name), name
    entered |= {"friction": "x 3, rx 2.5", "springs": "x 4", "motors": ""}
    assert readers["friction"](entered) == {"x": 3, "rx": 2.5}
    assert readers["springs"](entered) == {"x": ap.Elastic(frequency=4, rest=0.1)}
    assert readers["motors"](entered) == {}
    for name, text, reason in (
        ("friction", "x", "friction of x must be a number"),
        ("friction", "x 1, x 2", "x is given twice"),
        ("springs", "x 1 2 3", "a frequency and a damping ratio"),
        ("motors", "rx fast", "motors of rx"),
        ("x", "1", "x must be two numbers"),
    ):
        with pytest.raises(InvalidArgumentError, match=reason):
            readers[name](entered | {name: text})


def test_edits_reach_the_world_and_can_be_undone():
    session = door()
    pivot = session.world.joints["pivot"]
    session.step(3)
    session.edit_joint(pivot.id, {"limits": (-0.5, 0.5), "motor": ap.Motor(speed=2, max_force=70), "friction": 1})
    assert (pivot.limits, pivot.motor_speed, pivot.motor_max_force, pivot.friction) == ((-0.5, 0.5), 2, 70, 1)
    session.joint_wanted = pivot.id
    session.step(100)
    state = session.frame().joints.selected
    assert state.coordinates["angle"][0] == pivot.angle
    assert abs(pivot.angle) < 0.52
    assert np.array_equal(state.force, pivot.reaction_force)
    assert np.sqrt((state.force**2).sum()) > 1
    assert state.ends == ("the world", "cone")
    session.remove_joint(pivot.id)
    assert [type(joint.settings).__name__ for joint in session.world.joints] == ["Distance"]
    assert session.frame().joints.selected is None
    with pytest.raises(InvalidArgumentError, match="no longer there"):
        session.edit_joint(pivot.id, {"friction": 2})
    session.step_back()
    assert session.world.joints["pivot"].limits == (-0.5, 0.5)
    assert len(lines(session).axes) == 1


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"friction": 3, "limits": (1, -1)}, "limits must be"),
        ({"enabled": 1, "friction": 3}, "enabled must be"),
        ({"enabled": False, "friction": -1}, "friction must be"),
        ({"cone": 1.0}, "no cone"),
        ({"breaking_force": math.nan}, "breaking_force must be"),
    ],
)
def test_refused_edits_change_nothing(changes, reason):
    session = door()
    pivot, before = session.world.joints["pivot"], session.world.state_hash()
    settings = pivot.settings
    with pytest.raises(InvalidArgumentError, match=reason):
        session.edit_joint(pivot.id, changes)
    assert session.world.state_hash() == before
    assert pivot.settings == settings
    assert pivot.enabled


def test_saving_keeps_joints(tmp_path):
    session = door(limits=(-1, 1))
    session.save(tmp_path / "door.toml")
    world = ap.load_scene(tmp_path / "door.toml").build()
    assert [joint.name for joint in world.joints] == ["pivot", None]
    assert world.joints["pivot"].limits == (-1, 1)


def test_the_tab_lists_edits_and_removes(browser):
    page_tests = pytest.importorskip("tests.viewer.test_page")
    until, tab = page_tests.until, browser.new_page()
    page = page_tests.Driver(door(motor=ap.Motor(speed=1, max_force=5)), tab)
    try:
        page.tab_of("Joints")
        page.sees("2 joints, 2 act")
        page.choose("Selected joint", "0: Hinge 'pivot', the world to cone")
        page.sees("anchors apart")
        until(lambda: page.viewer.stage._lines["joint selected"][1].visible)
        page.button("Edit joint…")
        page.fill("Motor max force", -5)
        page.fill("Limits", "1 and 2")
        page.button("Apply")
        dialog = tab.get_by_role("dialog")
        dialog.get_by_text("limits must be two numbers").wait_for()
        page.fill("Limits", "-1 0.5")
        page.button("Apply")
        dialog.get_by_text("max_force must be").wait_for()
        assert page.ask(lambda session: session.world.joints["pivot"].motor_max_force) == 5
        page.fill("Motor max force", 40)
        page.button("Apply")
        dialog.wait_for(state="detached")
        pivot = page.ask(lambda session: session.world.joints["pivot"].settings)
        assert (pivot.limits, pivot.motor.max_force, pivot.motor.speed) == ((-1, 0.5), 40, 1)
        assert tab.evaluate("""() => { let there = 0, tested = 0;
            window.__viserMutable.nodeRefFromName['/overlays/joint arms'].traverse(one => {
              if (one.material) { there += 1; tested += one.material.depthTest; }});
            return [there > 0, tested]; }""") == [True, 0]
        page.tab_of("Show")
        page.field("Joints").uncheck()
        until(lambda: not page.viewer.stage._lines["joint arms"][1].visible)
        page.tab_of("Joints")
        page.button("Remove joint")
        until(lambda: page.ask(lambda session: len(session.world.joints)) == 1)
        page.sees("1 joints, 1 act")
    finally:
        page.viewer.close()
        tab.close()


def test_joints_are_made_by_dialog_and_selected_by_click(browser):
    page_tests = pytest.importorskip("tests.viewer.test_page")
    until, tab = page_tests.until, browser.new_page()
    world = ap.World(gravity=(0, 0, 0))
    for k in range(2):
        world.add(ap.Box(size=(0.6, 0.6, 0.6)), position=(2 * k, 2, 0), name=f"box {k}")
    page = page_tests.Driver(Session(world), tab)
    try:
        page.tab_of("Joints")
        ids = page.ask(lambda session: session.world.bodies.id.tolist())
        for k in range(2):
            tab.mouse.click(*page.screen((2 * k, 2, 0)))
            until(lambda k=k: page.viewer.selected == ids[k])
        page.button("Join two bodies…")
        dialog = tab.get_by_role("dialog")
        assert [page.field(f"Body {end}").input_value() for end in "ab"] == ["0: box 0", "1: box 1"]
        page.fill("Limits", "1 -1")
        page.button("Join")
        dialog.get_by_text("limits must be").wait_for()
        page.fill("Limits", "-1 1")
        before = page.field("Limits").get_attribute("id")
        page.choose("Body a", "1: box 1")
        until(lambda: page.field("Limits").get_attribute("id") != before, "the fields of the bodies")
        until(lambda: page.field("Limits").input_value() == "-1 1", "what was entered to be kept")
        page.button("Join")
        dialog.get_by_text("two different bodies").wait_for()
        assert page.ask(lambda session: len(session.world.joints)) == 0
        page.choose("Body a", "0: box 0")
        page.fill("Joint name", "pivot")
        page.button("Join")
        dialog.wait_for(state="detached")
        pivot = page.ask(lambda session: session.world.joints["pivot"])
        assert (pivot.limits, pivot.a.name, pivot.b.name) == ((-1, 1), "box 0", "box 1")
        assert np.allclose(pivot.anchors, (1, 2, 0))
        assert page.viewer.selected_joint == pivot.id
        page.choose("Selected joint", "(none)")
        until(lambda: page.viewer.selected_joint is None)
        page.button("Join two bodies…")
        page.choose("Kind", "Gear")
        page.field("Ratio").wait_for()
        page.fill("Ratio", "-3")
        page.button("Join")
        dialog.wait_for(state="detached")
        assert page.ask(lambda session: session.world.joints[1].settings.ratio) == -3
        page.ask(lambda session: session.remove_joint(session.world.joints[1].id))
        tab.mouse.click(*page.screen((1, 2, 0)))
        until(lambda: page.viewer.selected_joint == pivot.id, "the click to select")
        assert page.viewer.selected is None
        page.tab_of("Objects")
        page.sees("Selected joint 0: Hinge 'pivot'")
        tab.keyboard.press("Delete")
        until(lambda: page.ask(lambda session: len(session.world.joints)) == 0)
        assert page.count() == 2
    finally:
        page.viewer.close()
        tab.close()
