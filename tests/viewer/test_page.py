"""The page, driven in a real browser as a person would; each test looks at the world as well as at the page."""

import io
import time

import numpy as np
import pytest

import atlasphys as ap
from atlasphys.viewer.session import Session

viser = pytest.importorskip("viser")
page_module = pytest.importorskip("atlasphys.viewer.gui.page")

PATIENCE = 10.0


def until(condition, what="the page to follow"):
    """Wait for a condition; the page and the world need a moment."""
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        if value := condition():
            return value
        time.sleep(0.03)
    raise AssertionError(f"waited {PATIENCE} s for {what}")


class Driver:
    """A page of the viewer and a tab of the browser that shows it."""

    def __init__(self, model, tab):
        shown = page_module.Shown(shadows=False, grid=False, plots=False)
        self.viewer, self.tab = page_module.Page(model, port=0, shown=shown), tab
        self.open()

    def open(self, tab=None):
        tab = tab or self.tab
        tab.goto(self.viewer.url)
        tab.get_by_role("tab", name="Objects").wait_for()
        start = self.viewer.server.initial_camera.look_at
        clients = self.viewer.server.get_clients
        until(
            lambda: clients() and np.allclose(clients()[max(clients())].camera.look_at, start, atol=0.01), "the camera"
        )
        tab.wait_for_function("!!(window.__viserMutable && window.__viserMutable.cameraControl)")

    def sees(self, text):
        """Wait until the page shows a text."""
        self.tab.wait_for_function("text => document.body.innerText.includes(text)", arg=text, timeout=1000 * PATIENCE)

    def ask(self, question):
        """What the model answers, between steps."""
        return self.viewer.simulation.do(question).result(PATIENCE)

    def button(self, name):
        self.tab.get_by_role("button", name=name, exact=True).last.click()

    def tab_of(self, name):
        self.tab.get_by_role("tab", name=name).click()

    def field(self, label):
        """The input that stands beside a label; that of a dialog, if one is open."""
        beside = "following::*[(self::input and not(@type='hidden')) or self::textarea][1]"
        return self.tab.locator(f"xpath=//label[normalize-space()={label!r}]").last.locator(f"xpath={beside}")

    def fill(self, label, value):
        self.field(label).fill(str(value))
        self.field(label).press("Tab")
        time.sleep(0.15)  # the page sends one field in 50 ms; nobody types faster

    def choose(self, label, option):
        self.field(label).click()
        self.tab.get_by_role("option", name=option, exact=True).click()

    def choose_shape(self, shape):
        """In the dialog; its fields are made anew."""
        first_size = self.tab.get_by_role("dialog").locator("label").nth(1)
        before = first_size.get_attribute("for")
        self.choose("Shape", shape)
        until(lambda: first_size.get_attribute("for") != before, "the fields of the shape")

    def bodies(self):
        return self.ask(lambda session: [body.name for body in session.world.bodies])

    def count(self):
        return self.ask(lambda session: len(session.world.bodies))

    @property
    def client(self):
        """The server's side of the only tab."""
        until(lambda: len(self.viewer.server.get_clients()) == 1, "other tabs to be gone")
        return next(iter(self.viewer.server.get_clients().values()))

    def screen(self, point):
        """Where a point of the world is in the tab [pixels]."""
        camera = self.client.camera
        forward = np.array(camera.look_at) - camera.position
        forward /= np.linalg.norm(forward)
        right = np.cross(forward, camera.up_direction)
        right /= np.linalg.norm(right)
        arm = np.array(point) - camera.position
        depth = arm @ forward
        scale = 1 / np.tan(camera.fov / 2) / depth
        box = self.tab.locator("canvas[data-engine]").bounding_box()
        x = arm @ right * scale * box["height"] / 2 + box["width"] / 2
        y = -(arm @ np.cross(right, forward)) * scale * box["height"] / 2 + box["height"] / 2
        return box["x"] + x, box["y"] + y


@pytest.fixture(scope="module")
def tab(browser):
    tab = browser.new_page()
    yield tab
    tab.close()


@pytest.fixture(scope="module")
def viewer(tab):
    """One server for most tests, with kernels that are compiled."""
    session = Session.from_scene(ap.load_scene("demo"))
    session.step(60)
    session.reset()
    driver = Driver(session, tab)
    yield driver
    driver.viewer.close()


@pytest.fixture
def demo(viewer):
    """The demo, not started, as a new user finds it."""
    viewer.ask(lambda session: session.load("demo"))
    viewer.viewer.select(None)
    for name, value in vars(page_module.Shown(shadows=False, grid=False, plots=False)).items():
        setattr(viewer.viewer.shown, name, value)
    viewer.open()
    return viewer


def test_start_stop_step_back_and_reset(demo):
    begin = demo.ask(lambda session: session.world.state_hash())
    demo.button("Start")
    until(lambda: demo.viewer.frame.time > 0.3)
    demo.sees("running at")
    demo.button("Stop")
    until(lambda: not demo.viewer.frame.running)
    demo.sees("stopped")
    steps = demo.ask(lambda session: session.world.steps)
    time.sleep(0.2)
    assert demo.ask(lambda session: session.world.steps) == steps
    demo.button("Step")
    until(lambda: demo.ask(lambda session: session.world.steps) == steps + 1)
    demo.sees(f"step {steps + 1}")
    demo.button("Back")
    demo.button("Back")
    until(lambda: demo.ask(lambda session: session.world.steps) == steps - 1)
    demo.button("Reset")
    until(lambda: demo.ask(lambda session: session.world.steps) == 0)
    assert demo.ask(lambda session: session.world.state_hash()) == begin
    demo.sees("0.000 s")
    demo.tab.locator("canvas[data-engine]").click(position={"x": 20, "y": 520})
    demo.tab.keyboard.press("n")
    until(lambda: demo.ask(lambda session: session.world.steps) == 1)
    demo.tab.keyboard.press("Space")
    until(lambda: demo.viewer.frame.running)
    demo.tab.keyboard.press("Space")
    until(lambda: not demo.viewer.frame.running)


SIZES = {
    "box (cube, rectangular prism)": ({}, lambda s: s.size == (1, 1, 1)),
    "sphere": ({"Radius": 0.25}, lambda s: s.radius == 0.25),
    "capsule": ({"Radius": 0.3, "Length": 0.8}, lambda s: (s.radius, s.length) == (0.3, 0.8)),
    "cylinder": ({"Radius": 0.3, "Length": 0.8}, lambda s: (s.radius, s.length) == (0.3, 0.8)),
    "cone": ({"Radius": 0.4, "Height": 0.9}, lambda s: (s.radius, s.height) == (0.4, 0.9)),
    "convex hull": (
        {"Points": "0 0 0\n2 0 0\n0 2 0\n0 0 2"},
        lambda s: len(s.vertices) == 4 and abs(s.volume - 4 / 3) < 1e-9,
    ),
    "tetrahedron": ({"Radius": 0.6}, lambda s: len(s.vertices) == 4),
    "pyramid (square, pentagonal, …)": ({"Sides": 6}, lambda s: len(s.vertices) == 7),
    "octahedron": ({"Radius": 0.6}, lambda s: len(s.vertices) == 6),
    "plane": ({"Offset": -3}, lambda s: s.offset == -3),
}


def test_every_shape_is_added_by_the_dialog(demo):
    for number, (shape, (sizes, is_right)) in enumerate(SIZES.items()):
        demo.button("Add an object…")
        if number:
            demo.choose_shape(shape)
        for label, value in sizes.items():
            demo.fill(label, value)
        demo.fill("Name", f"my {number}")
        if not number:
            demo.fill("Friction", 0.25)
        demo.button("Add")
        until(lambda name=f"my {number}": name in demo.bodies(), f"{shape} to be added")
        body = demo.ask(lambda session, name=f"my {number}": session.world.bodies[name])
        assert is_right(body.shape), body.shape
        assert body.friction == pytest.approx(0.5 if number else 0.25)
        demo.tab.get_by_role("dialog").wait_for(state="detached")
    assert demo.count() == 9 + len(SIZES)
    demo.sees("19 bodies")


def test_bad_values_are_refused_in_the_dialog_with_the_reason(demo):
    demo.button("Add an object…")
    demo.choose("Shape", "sphere")
    demo.field("Radius").wait_for()
    demo.fill("Radius", -1)
    demo.fill("Restitution", 3)
    demo.button("Add")
    dialog = demo.tab.get_by_role("dialog")
    dialog.get_by_text("shape.radius").wait_for()
    dialog.get_by_text("restitution: must be").wait_for()
    assert demo.count() == 9
    demo.fill("Radius", 0.3)
    demo.fill("Restitution", 0.3)
    demo.button("Add")
    until(lambda: demo.count() == 10)
    demo.button("Add an object…")
    demo.button("Cancel")
    dialog.wait_for(state="detached")
    assert demo.count() == 10


def test_select_by_click_and_list_edit_duplicate_delete(demo):
    name = "cube 0"
    identity, place = demo.ask(lambda session: (int(session.world.bodies.id[1]), session.world.bodies[name].position))
    demo.tab.mouse.click(*demo.screen(place))
    until(lambda: demo.viewer.selected == identity, "the click to select")
    until(lambda: demo.field("Selected").input_value() == "1: cube 0")
    demo.sees("kinetic energy")
    demo.button("Edit…")
    demo.fill("Restitution", 0.75)
    demo.button("Apply")
    until(lambda: demo.ask(lambda session: session.world.bodies[name].restitution) == 0.75)
    demo.button("Duplicate")
    until(lambda: demo.count() == 10)
    until(lambda: demo.viewer.selected != identity)
    assert demo.ask(lambda session: session.world.bodies[9].restitution) == 0.75
    demo.button("Delete")
    until(lambda: demo.count() == 9)
    until(lambda: demo.viewer.selected is None)
    demo.choose("Selected", "2: sphere 0")
    until(lambda: demo.viewer.selected == demo.ask(lambda session: int(session.world.bodies.id[2])))
    demo.button("Delete")
    until(lambda: "sphere 0" not in demo.bodies())
    demo.button("Add a cube")
    demo.button("Add a sphere")
    until(lambda: demo.count() == 10)
    demo.button("Clear: delete all but planes")
    until(lambda: demo.bodies() == ["ground"])


def test_gravity_solver_and_other_settings_while_running(demo):
    demo.button("Start")
    demo.tab_of("World")
    demo.fill("Gravity", -20)
    until(lambda: demo.ask(lambda session: session.world.gravity[1]) == -20)
    for label, name, value in (
        ("Solver", "solver", "sequential_impulse"),
        ("Narrow phase", "narrowphase", "gjk_epa"),
        ("Broad phase", "broadphase", "sweep"),
    ):
        demo.choose(label, value)
        until(lambda name=name, value=value: demo.ask(lambda session: getattr(session.world, name)) == value)
    demo.field("Iterations").wait_for()
    demo.fill("Iterations", 6)
    until(lambda: demo.ask(lambda session: session.world.solver_settings.iterations) == 6)
    demo.fill("Time step", 0.01)
    until(lambda: demo.ask(lambda session: session.dt) == 0.01)
    demo.fill("Time step", -1)
    demo.sees("dt must be")
    until(lambda: demo.field("Time step").input_value() == "0.01")
    assert demo.ask(lambda session: session.dt) == 0.01
    assert demo.viewer.frame.running


def test_arrows_and_other_switches(demo):
    demo.ask(lambda session: session.step(40))
    demo.tab_of("Show")
    names = {
        "Velocity arrows": "velocity",
        "m × a arrows": "force",
        "Impulse arrows": "impulse",
        "Contact points": "contacts",
        "Contact normals": "normals",
        "Bounding boxes": "boxes",
        "Centres of mass": "centers",
    }
    tree = "() => window.__viserSceneTree.getState()"
    for label, name in names.items():
        demo.field(label).check()
        until(lambda name=name: getattr(demo.viewer.shown, name))
        node = f"/overlays/{name}"
        until(lambda node=node: any(node in key for key in demo.tab.evaluate(tree)), node)
        if name in ("force", "impulse"):
            drawn = demo.viewer.stage._lines[name][1]
            assert len(drawn.points) > 0
            assert drawn.visible
    demo.field("Velocity arrows").uncheck()
    until(lambda: not demo.viewer.stage._lines["velocity"][1].visible)
    demo.field("Plane").uncheck()
    until(lambda: not demo.viewer.stage._planes[0][1].visible)
    demo.field("Islands by colour").check()
    demo.field("Dark").check()
    until(lambda: demo.viewer.dark)
    assert demo.ask(lambda session: session.world.steps) == 40


def test_projection_views_and_mouse_sensitivity(demo):
    client = demo.client
    demo.tab_of("Camera")
    before = demo.screen((0, 0, 0)), demo.screen((0, 3, 0))
    demo.button("Orthographic")
    until(lambda: client.camera.fov < 0.03)
    until(lambda: np.linalg.norm(np.array(client.camera.position) - client.camera.look_at) > 500)

    def is_orthographic():
        """As high as before, and parallel: as large near as far. The camera's numbers come one after another."""
        lower = demo.screen((0, 0, 0)), demo.screen((0, 3, 0))
        height = [a[1] - b[1] for a, b in (before, lower)]
        near, far = (demo.screen((0, 3, z))[1] - demo.screen((0, 4, z))[1] for z in (-20, 20))
        return height[1] == pytest.approx(height[0], rel=0.4) and near == pytest.approx(far, rel=0.06)

    until(is_orthographic)
    demo.button("Perspective")
    until(lambda: client.camera.fov > 0.5)
    demo.button("Top")
    until(lambda: client.camera.position[1] > 10 and abs(client.camera.position[0] - client.camera.look_at[0]) < 0.1)
    demo.fill("Mouse sensitivity", 2.5)
    demo.tab.wait_for_function("window.__viserMutable.cameraControl.azimuthRotateSpeed === 2.5")
    position = np.array(client.camera.position)
    demo.tab.locator("canvas[data-engine]").click(position={"x": 20, "y": 520})
    demo.tab.keyboard.down("w")
    until(lambda: np.linalg.norm(np.array(client.camera.position) - position) > 0.2, "W to fly")
    demo.tab.keyboard.up("w")


def test_a_body_is_dragged_and_thrown_and_a_ball_shot(demo):
    place = demo.ask(lambda session: session.world.bodies["sphere 3"].position)
    demo.ask(lambda session: (session.configure(gravity=(0, 0, 0)), session.start()))
    x, y = demo.screen(place)
    demo.tab.mouse.move(x, y)
    time.sleep(0.3)  # the page finds out what is under the pointer
    demo.tab.mouse.down()
    time.sleep(0.2)
    for k in range(10):
        demo.tab.mouse.move(x + 8 * k, y, steps=2)
        time.sleep(0.05)
    until(lambda: demo.ask(lambda session: session.grab_held is not None))
    until(lambda: np.linalg.norm(demo.ask(lambda session: session.world.bodies["sphere 3"].position) - place) > 0.5)
    demo.tab.mouse.up()
    until(lambda: demo.ask(lambda session: session.grab_held is None))
    demo.tab.keyboard.press("t")
    until(lambda: demo.count() == 10)
    assert np.linalg.norm(demo.ask(lambda session: session.world.bodies[9].velocity)) > 5


def test_close_up_follows_the_selected_body(demo):
    client = demo.client
    home = np.array(client.camera.position)
    demo.choose("Selected", "7: cube 3")
    until(lambda: demo.viewer.selected is not None)
    demo.button("With the camera")
    until(lambda: np.linalg.norm(np.array(client.camera.position) - home) > 1)
    demo.button("Start")
    until(lambda: demo.viewer.frame.time > 1)
    demo.button("Stop")
    until(lambda: not demo.viewer.frame.running)
    target = demo.ask(lambda session: session.world.bodies["cube 3"].position)
    until(lambda: np.linalg.norm(np.array(client.camera.look_at) - target) < 0.5, "the camera to follow")
    demo.button("With the camera")
    until(lambda: np.linalg.norm(np.array(client.camera.position) - home) < 0.1)


def test_a_close_up_window_follows_the_selected_body_while_the_camera_stays(demo):
    client = demo.client
    home = np.array(client.camera.position)
    demo.button("In a window")
    demo.sees("Click on a body, or choose one from the list.")
    demo.choose("Selected", "7: cube 3")
    window = demo.viewer.close_ups._windows[client.client_id]
    until(lambda: window.pictures > 0, "a picture")

    def body_is_in_the_middle():
        red, green, blue = window._image.image[95:115, 150:170].reshape(-1, 3).mean(axis=0)
        return min(red, green) > blue + 40  # what is selected is yellow

    until(body_is_in_the_middle, "the body in the middle of the window")
    demo.button("Start")
    until(lambda: demo.viewer.frame.time > 0.6)
    demo.button("Stop")
    until(lambda: not demo.viewer.frame.running)
    until(body_is_in_the_middle, "the window to follow")

    def is_still():
        pictures = window.pictures
        time.sleep(1.0)
        return window.pictures == pictures

    until(is_still, "no more pictures when nothing changes")
    assert np.allclose(client.camera.position, home, atol=0.01)
    demo.button("Close this window")
    until(lambda: not demo.viewer.close_ups._windows)
    demo.tab.get_by_role("button", name="Close this window").wait_for(state="detached")


def test_scenes_are_loaded_unloaded_and_saved(demo, tmp_path):
    demo.tab_of("Scene")
    demo.choose("Library", "tower")
    demo.field("Height").wait_for()
    demo.fill("Height", 4)
    demo.button("Load this scene")
    until(lambda: demo.bodies() == ["ground", "cube 0", "cube 1", "cube 2", "cube 3"])
    demo.sees("tower: 5 bodies")
    demo.button("Save the world…")
    path = tmp_path / "mine.toml"
    demo.fill("File", path)
    demo.button("Save")
    until(path.exists)
    assert len(ap.load_scene(path).bodies) == 5
    demo.button("Unload: only the ground")
    until(lambda: demo.bodies() == ["ground"])
    demo.fill("Scene file", path)
    demo.button("Load the file")
    until(lambda: demo.count() == 5)
    demo.fill("Scene file", tmp_path / "missing.toml")
    demo.button("Load the file")
    demo.sees("cannot be read")
    assert demo.count() == 5


def test_plots_run_along(demo):
    demo.tab_of("Plots")
    demo.field("Plots run along").check()
    demo.button("Start")
    charts = (
        "() => Object.values(window.__viserTestpoints.uplots || {}).map(u => [u.chart.width, u.chart.data[0].length])"
    )
    until(lambda: len(c := demo.tab.evaluate(charts)) == 4 and min(n for _, n in c) > 4, "four plots")
    assert min(width for width, _ in demo.tab.evaluate(charts)) > 200
    frame = demo.viewer.frame
    assert sum(frame.energy) < 1e9


def test_reloading_two_pages_and_killing_them_leave_the_simulation_sane(demo, browser):
    demo.button("Start")
    demo.tab.reload()
    demo.sees("running at")
    other = browser.new_page()
    demo.open(other)
    other.get_by_role("button", name="Stop", exact=True).click()
    demo.sees("stopped")
    other.get_by_role("button", name="Start", exact=True).click()
    until(lambda: demo.viewer.frame.running)
    other.close()
    demo.tab.goto("about:blank")
    until(lambda: not demo.viewer.server.get_clients(), "the server to notice")
    steps = demo.ask(lambda session: session.world.steps)
    until(lambda: demo.ask(lambda session: session.world.steps) > steps + 5)
    assert demo.ask(lambda session: session.error) == ""
    demo.open()
    demo.sees("running at")


def test_a_diverging_world_stops_and_the_page_says_why(browser):
    world = ap.World()
    world.add(ap.Plane(), name="ground")
    world.add(ap.Sphere(radius=0.5), mass=1e36, position=(0, 0.4, 0), velocity=(0, -1e4, 0), name="star")
    driver = Driver(Session(world, dt=1e-4), browser.new_page())
    try:
        driver.button("Start")
        driver.sees("star")
        assert not driver.viewer.frame.running
        assert "star" in driver.viewer.frame.error
    finally:
        driver.tab.close()
        driver.viewer.close()


def test_a_busy_port_is_refused():
    first = page_module.Page(Session.empty(), port=0)
    try:
        port = first.server.get_port()
        with pytest.raises(ap.InvalidArgumentError, match=f"port {port} cannot be used"):
            page_module.Page(Session.empty(), port=port)
        with pytest.raises(ap.InvalidArgumentError, match="65535"):
            page_module.Page(Session.empty(), port=70000)
    finally:
        first.close()


def test_a_recording_is_replayed(browser, tmp_path):
    from atlasphys.viewer.replay import Replay

    path = tmp_path / "tower.h5"
    scene = ap.load_scene("tower", height=3)
    world = scene.build()
    with ap.Recorder(path, world, scene, contacts=True) as recorder:
        for _ in range(60):
            world.step(1 / 60)
            recorder.record()
    driver = Driver(Replay(path), browser.new_page())
    try:
        driver.button("Play")
        until(lambda: driver.viewer.frame.steps > 10)
        driver.sees("running at")
        driver.button("Pause")
        until(lambda: not driver.viewer.frame.running)
        driver.fill("Timeline", 59)
        until(lambda: driver.viewer.frame.steps == 59)
        np.testing.assert_array_equal(driver.viewer.frame.position, world.bodies.position)
        driver.sees("1.000 s")
        driver.button("Back")
        until(lambda: driver.viewer.frame.steps == 58)
        driver.tab_of("Show")
        driver.field("Impulse arrows").check()
        until(lambda: "impulse" in driver.viewer.stage._lines)
        assert driver.viewer.frame.contact_count == 12
        driver.fill("Speed", 5)
        driver.button("Play")
        until(lambda: driver.viewer.frame.steps < 50, "the loop")
    finally:
        driver.tab.close()
        driver.viewer.close()


def test_colours_are_true_and_shadows_span_the_scene(browser):
    """What the snippets of look.py do; a viser without the objects that they use would fail here."""
    image = pytest.importorskip("PIL.Image")
    world = ap.World()
    world.add(ap.Plane())
    for x in (-40, 0, 40):  # viser's own shadows end 20 m from the camera
        world.add(ap.Box(size=(4, 4, 4)), position=(x, 2, 0), color="#c03020", kind="static")
    driver = Driver(Session(world), browser.new_page())
    try:
        lights = """() => { const found = []; window.__viserMutable.scene.traverse(one => {
            if (one.isDirectionalLight) found.push([one.castShadow, one.shadow.camera.right]); }); return found; }"""
        until(lambda: [cast for cast, _ in driver.tab.evaluate(lights)] == [False])
        driver.viewer.shown.shadows = True
        until(lambda: [cast for cast, _ in driver.tab.evaluate(lights)] == [True])
        assert driver.tab.evaluate(lights)[0][1] > 40
        driver.viewer.cameras.look(driver.client, "front")
        driver.client.camera.position, driver.client.camera.look_at = (0, 3, 14), (0, 2, 0)
        x, y = driver.tab.locator("canvas[data-engine]").bounding_box()["width"] / 2, 270

        def middle():
            pixels = image.open(io.BytesIO(driver.tab.screenshot())).convert("RGB")
            return np.array(pixels.crop((int(x) - 4, int(y) - 4, int(x) + 4, int(y) + 4))).reshape(-1, 3).mean(axis=0)

        until(lambda: middle()[0] > 100, "the box in the middle")
        red, green, blue = middle()
        assert red / green == pytest.approx(0xC0 / 0x30, rel=0.25)  # 1.9 if taken for shares of light
        assert red / blue == pytest.approx(0xC0 / 0x20, rel=0.3)
    finally:
        driver.tab.close()
        driver.viewer.close()
