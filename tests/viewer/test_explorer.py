"""The explorer: its model, and its page in a real browser, whose words are compared with the engine's answers."""

import re
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import atlasphys as ap
from atlasphys.cli import main
from atlasphys.explainer import STAGES
from atlasphys.viewer.explorer.explorer import Explorer
from tests.explainer.pairs import story_of
from tests.explainer.test_gjk_epa import compiled_answer
from tests.viewer.test_page import until

# The model -----------------------------------------------------------------------------------------------------------


def test_slides_are_gone_through_and_stages_chosen():
    explorer = Explorer(story_of("deep", preset="classic"), remark="Look here.")
    assert explorer.heading.endswith("Look here.")
    assert explorer.slide.title == "The question"
    explorer.previous()
    assert explorer.index == 0
    while not explorer.is_at_end:
        explorer.next()
    assert explorer.slide.title == "Verdict: overlapping"
    explorer.next()
    assert explorer.is_at_end
    explorer.show("epa")
    assert (explorer.stage, explorer.index) == ("epa", 0)
    explorer.go(5)
    explorer.restart()
    assert explorer.index == 0
    with pytest.raises(ap.InvalidArgumentError, match="stage must be one of"):
        Explorer(story_of("deep"), "all")


@pytest.mark.parametrize("kind", ["separate", "deep cylinders"])
def test_a_shape_that_is_moved_makes_the_engine_run_anew(kind):
    story = story_of(kind, preset="classic")
    explorer = Explorer(story)
    verdict = story.gjk.verdict
    explorer.go(99)
    position, orientation = explorer.pose(1)
    away = position + (0, 0 if verdict == "separated" else 3, 0)
    goal = explorer.pose(0)[0] if verdict == "separated" else away
    explorer.move({1: (goal, orientation)})
    np.testing.assert_allclose(explorer.pose(1)[0], goal)
    assert (verdict == "separated") != (explorer.story.gjk.verdict == "separated")
    assert explorer.is_at_end
    assert explorer.slide.title.endswith(explorer.story.gjk.verdict)
    assert "moved" in explorer.heading
    contacts = compiled_answer(explorer.story)
    assert (int(contacts.count[0]) == 0) == (explorer.story.gjk.verdict == "separated")
    explorer.put_back()
    np.testing.assert_array_equal(explorer.pose(1)[0], position)
    assert str(explorer.story.gjk) == str(story.gjk)


def test_what_the_world_refuses_changes_nothing():
    explorer = Explorer(story_of("deep"))
    before = explorer.pose(1)[0]
    with pytest.raises(ap.InvalidArgumentError):
        explorer.move({1: (np.array((np.nan, 0, 0)), np.array((1.0, 0, 0, 0)))})
    np.testing.assert_array_equal(explorer.pose(1)[0], before)
    explorer.move({1: (before + 1, np.array((1.0, 0, 0, 0)))})
    np.testing.assert_allclose(explorer.pose(1)[0], before + 1)


def test_the_world_that_was_explained_is_left_alone():
    world = ap.load_scene("two_boxes").build()
    with ap.explain(world) as story:
        world.step(1 / 60)
    before = world.state_hash()
    explorer = Explorer(story)
    explorer.move({1: (np.array((0, 0.9, 0)), np.array((1.0, 0, 0, 0)))})
    assert world.state_hash() == before


# The page ------------------------------------------------------------------------------------------------------------


SMALL = {"width": 800, "height": 400}
"""Of the tab [pixels]: graphics without a graphics card take their time."""


class Driver:
    """An explorer's page and a tab that shows it."""

    def __init__(self, story, tab, stage="gjk"):
        page_module = pytest.importorskip("atlasphys.viewer.explorer.page")
        self.page, self.tab = page_module.Page(Explorer(story, stage), port=0), tab
        tab.goto(self.page.url)
        self.sees_slide(1)

    @property
    def explorer(self):
        return self.page.explorer

    def sees_slide(self, number):
        self.tab.wait_for_function(
            "n => (document.querySelector('#slide') || {innerText: ''}).innerText.startsWith(n + ' of')",
            arg=number,
            polling=50,
        )

    def next(self):
        number = self.explorer.index + 2
        self.tab.get_by_role("button", name="Next step").click(force=True)  # not waiting for pictures, which take long
        self.sees_slide(number)

    @property
    def title(self):
        return self.tab.inner_text("#title")

    @property
    def text(self):
        return self.tab.inner_text("#slide")

    def formulas(self):
        """All formulas on the page, as text."""
        return self.tab.evaluate("[...document.querySelectorAll('#slide math')].map(m => m.textContent)")

    def vector(self, begins):
        """The numbers after the = of the formula that begins like that."""
        formula = next(text for text in self.formulas() if text.startswith(begins))
        return [float(word.replace("−", "-")) for word in re.findall(r"[−\d.]+", formula.rpartition("=")[2])]

    def close(self):
        self.tab.goto("about:blank")
        self.page.close()


@pytest.fixture(scope="module")
def tab(browser):
    tab = browser.new_page()
    tab.set_viewport_size(SMALL)
    yield tab
    tab.close()


@pytest.fixture
def show(tab):
    drivers = []

    def make(story, stage="gjk"):
        drivers.append(Driver(story, tab, stage))
        return drivers[-1]

    yield make
    for driver in drivers:
        driver.close()


@pytest.mark.parametrize("kind", ["separate", "touching", "deep"])
def test_next_step_goes_through_all_of_gjk_and_epa_with_the_engines_numbers(kind, show):
    story = story_of(kind, preset="classic")
    driver = show(story)
    contacts = compiled_answer(story)
    trace = story.gjk
    for step in trace.steps:
        driver.next()
        assert "ask for a support point" in driver.title
        np.testing.assert_allclose(driver.vector("w=s"), step.point, rtol=6e-4, atol=6e-5)
        np.testing.assert_allclose(driver.vector("sA(d)"), step.support_a, rtol=6e-4, atol=6e-5)
        assert "src/atlasphys/engine/narrowphase/gjk.py, line" in driver.text
        marked = driver.tab.locator("#slide div[style*='ffe9a8']").inner_text()
        assert "difference_support(" in marked
        if step.closest is not None:
            driver.next()
            size = ("point", "line", "triangle", "tetrahedron")[len(step.simplex) - 1]
            assert driver.title.endswith(f"the simplex is a {size}")
            np.testing.assert_allclose(driver.vector("c=("), step.closest, rtol=6e-4, atol=6e-5)
    driver.next()
    assert driver.explorer.is_at_end
    assert driver.title == f"Verdict: {trace.verdict}"
    assert (trace.verdict == "separated") == (contacts.count[0] == 0)
    if trace.verdict == "separated":
        np.testing.assert_allclose(driver.vector("n="), trace.normal, rtol=6e-4, atol=6e-5)
        assert f" {trace.distance:.4g} m, along" in driver.text

    driver.tab.get_by_role("textbox", name="Stage").or_(driver.tab.get_by_label("Stage")).first.click()
    driver.tab.get_by_role("option", name="epa", exact=True).click()
    until(lambda: driver.explorer.stage == "epa")
    driver.sees_slide(1)
    trace = story.epa
    if kind == "separate":
        assert "GJK found the shapes" in driver.text
        return
    for step in trace.steps:
        driver.next()
        assert driver.title.endswith("ask the nearest face")
        np.testing.assert_allclose(driver.vector("w=s"), step.point, rtol=6e-4, atol=6e-5)
        if step.grown is not None:
            driver.next()
            assert driver.vector(f"{len(step.polytope.faces)}−") == [len(step.grown.faces)]
    driver.next()
    assert driver.explorer.is_at_end
    normal = driver.vector("n=")
    np.testing.assert_allclose(normal, contacts.normal[0], rtol=6e-4, atol=6e-5)
    assert float(contacts.depth[: contacts.count[0]].max()) == pytest.approx(trace.depth, abs=1e-6)
    if kind == "deep":
        assert driver.title == f"Verdict: {contacts.depth[0]:.4g} m deep"


def test_buttons_keys_slider_and_play(show):
    driver = show(story_of("deep", preset="classic"))
    driver.next()
    driver.next()
    driver.tab.get_by_role("button", name="Previous").click()
    driver.sees_slide(2)
    driver.tab.locator("canvas[data-engine]").click(position={"x": 20, "y": 380})
    driver.tab.keyboard.press("n")
    driver.sees_slide(3)
    driver.tab.keyboard.press("b")
    driver.sees_slide(2)
    driver.tab.keyboard.press("r")
    driver.sees_slide(1)
    driver.page.patience = 0.05
    driver.tab.get_by_role("button", name="Play").click()
    driver.sees_slide(len(driver.explorer.slides))
    until(lambda: not driver.page.playing)
    driver.tab.get_by_role("button", name="Restart").click()
    driver.sees_slide(1)
    driver.page.patience = 30.0
    driver.tab.keyboard.press("Space")
    until(lambda: driver.page.playing)
    driver.tab.wait_for_function("document.querySelector('#slide').innerText.includes('playing')")


def test_a_shape_is_dragged_and_the_run_changes(show, tab):
    tab.set_viewport_size({"width": 900, "height": 500})
    driver = show(story_of("separate", preset="classic"))
    page = driver.page
    page.do(lambda explorer: explorer.go(99)).result(10)
    until(lambda: driver.title == "Verdict: separated")
    client = next(iter(page.server.get_clients().values()))
    until(lambda: abs(client.camera.aspect - canvas_aspect(tab)) < 0.02)
    time.sleep(0.5)
    start, goal = (screen(tab, client.camera, place(page, which)) for which in (1, 0))
    tab.mouse.move(*start)
    time.sleep(0.3)  # the page finds out what is under the pointer
    tab.mouse.down()
    time.sleep(0.2)
    for k in range(1, 11):
        tab.mouse.move(*(np.array(start) + k / 10 * (np.array(goal) - start)), steps=2)
        time.sleep(0.05)
    until(lambda: driver.title == "Verdict: overlapping")
    tab.mouse.up()
    assert page.explorer.story.gjk.verdict == "overlapping"
    assert "you have moved them" in tab.inner_text("body")
    tab.get_by_text("Look", exact=True).click()
    tab.get_by_role("button", name="Put the shapes back").click()
    until(lambda: driver.title == "Verdict: separated")
    tab.set_viewport_size(SMALL)


def canvas_aspect(tab):
    box = tab.locator("canvas[data-engine]").bounding_box()
    return box["width"] / box["height"]


def place(page, which):
    """Where a shape is drawn."""
    return np.array(page.scene.shapes.frame.position) + page.explorer.pose(which)[0] - page.scene.middles[0]


def screen(tab, camera, point):
    """Where that is in the tab [pixels]."""
    forward = np.array(camera.look_at) - camera.position
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, (0, 1, 0))
    right /= np.linalg.norm(right)
    arm = np.array(point) - camera.position
    box = tab.locator("canvas[data-engine]").bounding_box()
    scale = box["height"] / 2 / np.tan(camera.fov / 2) / (arm @ forward)
    return (
        box["x"] + box["width"] / 2 + arm @ right * scale,
        box["y"] + box["height"] / 2 - arm @ np.cross(right, forward) * scale,
    )


def test_polygons_are_shown_in_the_plane_and_stay_there(show):
    world = ap.load_scene("polygons").build()
    with ap.explain(world, pair=(0, 1)) as story:
        world.step(1 / 60)
    driver = show(story)
    page = driver.page
    assert page.is_flat
    client = until(lambda: next(iter(page.server.get_clients().values()), None))
    until(lambda: abs(client.camera.fov - 0.035) < 0.01)
    for _, handles in page.scene.bodies:
        assert np.ptp(handles[0].vertices[:, 2]) == 0
    page.put(1, np.array((0.5, 0.3, 0.7)), np.array((0.9, 0.3, 0.1, 0.2)))
    until(lambda: "4 contact points" in driver.explorer.heading or "moved" in driver.explorer.heading)
    position, orientation = driver.explorer.pose(1)
    assert position[2] == 0
    assert orientation[1] == orientation[2] == 0
    assert all(step.point[2] == 0 for step in driver.explorer.story.gjk.steps)
    driver.tab.get_by_text("Look", exact=True).click()
    driver.tab.get_by_label("In the plane").click()
    until(lambda: not page.is_flat)
    until(lambda: client.camera.fov > 0.5)


def test_every_stage_can_be_gone_through(show):
    world = ap.load_scene("two_boxes").build(preset="classic")
    world.run(seconds=0.55)
    with ap.explain(world, pair=("lower", "upper")) as story:
        world.step(1 / 60)
    driver = show(story, "broadphase")
    for stage in STAGES:
        driver.page.do(lambda explorer, stage=stage: explorer.show(stage)).result(10)
        driver.page.do(lambda explorer: explorer.go(len(explorer.slides))).result(10)
        driver.tab.wait_for_function(
            "t => document.querySelector('#title').innerText == t", arg=driver.explorer.slide.title
        )
    charts = "() => Object.values(window.__viserTestpoints.uplots || {}).map(u => u.chart.data.map(d => d.length))"
    sweeps = len(story.solver.sweeps)
    until(lambda: driver.tab.evaluate(charts) == [[sweeps] * 5, [sweeps] * 3], "the plots")


# The ways in ---------------------------------------------------------------------------------------------------------


def test_a_story_shows_itself(capsys):
    pytest.importorskip("viser")
    page = story_of("deep").view("epa")
    try:
        assert f"the story is shown at {page.url}" in capsys.readouterr().out
        assert page.explorer.stage == "epa"
    finally:
        page.close()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["gjk", "two_boxes", "--view", "--json"], "give one of the two"),
        (["gjk", "two_boxes", "--port", "9000"], "--view"),
        (["gjk", "two_boxes", "--view", "--port", "70000"], "65535"),
        (["gjk", "two_boxes", "--view", "--pair", "lower,nobody"], "no body is named 'nobody'"),
        (["gjk", "two_boxes", "--view", "--step", "9999"], "--step must be from 1 to 300"),
    ],
)
def test_wrong_commands_are_refused_in_a_line(words, said, capsys):
    pytest.importorskip("viser")
    assert main(["explain", *words]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert len(error.splitlines()) == 1


def test_a_missing_extra_names_the_command_that_installs_it(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "viser", None)
    assert main(["explain", "gjk", "polygons", "--step", "1", "--view"]) == 1
    assert "pip install 'atlasphys[viewer]'" in capsys.readouterr().err


def heed_interrupts():
    """Programs that a shell runs in the background begin by ignoring interrupts, and so do their children."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows sends no interrupt to one process alone")
def test_ctrl_c_ends_the_command_well():
    pytest.importorskip("viser")
    words = ["explain", "epa", "polygons", "--step", "1", "--view", "--port", "0", "--no-open"]
    with subprocess.Popen(
        [sys.executable, "-m", "atlasphys", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=heed_interrupts,
    ) as process:
        try:
            assert "triangle and pentagon, at http://127.0.0.1:" in process.stdout.readline()
            process.send_signal(signal.SIGINT)
            _, error = process.communicate(timeout=30)
        finally:
            process.kill()
    assert process.returncode == 0
    assert "Traceback" not in error  # but for a cold cache, that kernels are compiled
