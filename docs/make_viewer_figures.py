"""Make the figures of docs/viewer.md: screenshots of the page in headless Chromium, and a picture of a recording.

Run: ``.venv/bin/python docs/make_viewer_figures.py``. Needs Chromium.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import atlasphys as ap

FIGURES = Path(__file__).parent / "figures"


def main() -> None:
    """Make all of them."""
    from playwright.sync_api import sync_playwright

    from atlasphys.viewer.gui.page import Page, Shown
    from atlasphys.viewer.session import Session
    from tests.viewer.conftest import FLAGS, chromium

    def take(name: str, model: Any, shown: Shown, prepare: Callable[[Page, Any], None], *, dark: bool = False) -> None:
        page = Page(model, port=0, shown=shown, dark=dark)
        tab = browser.new_page()
        tab.goto(page.url)
        tab.get_by_role("tab", name="Objects").wait_for()
        time.sleep(2.0)
        prepare(page, tab)
        time.sleep(2.0)
        tab.evaluate("document.querySelectorAll('.mantine-Notification-closeButton').forEach(button => button.click())")
        time.sleep(1.5)
        tab.screenshot(path=FIGURES / f"{name}.png")
        tab.close()
        page.close()

    def select(page: Page, name: str) -> None:
        page.select(page.do(lambda session: int(session.world.bodies.id[session.world.bodies[name].row])).result())

    def look_near(page: Page, position: Any, target: Any) -> None:
        client = next(iter(page.server.get_clients().values()))
        client.camera.position, client.camera.look_at = position, target

    def live(page: Page, tab: Any) -> None:
        page.do(lambda session: session.step(95)).result()
        look_near(page, (5.6, 4.0, 6.9), (1.4, 0.8, 0.2))
        select(page, "cube 2")

    def pit(page: Page, tab: Any) -> None:
        page.do(lambda session: session.step(150)).result()
        look_near(page, (2.6, 13.0, 4.4), (0.0, 1.5, 0.0))
        page.do(Session.start).result()
        tab.get_by_role("tab", name="Plots").click()
        time.sleep(8.0)
        page.do(Session.stop).result()

    def car(page: Page, tab: Any) -> None:
        page.do(lambda session: session.step(60)).result()
        x, y, z = page.do(lambda session: session.world.bodies["chassis"].position).result()
        look_near(page, (x + 2.6, y + 1.8, z + 3.4), (x + 0.1, y - 0.1, z))
        tab.get_by_role("tab", name="Joints").click()
        page.select_joint(page.frame.joints.table.entries[3].id)

    def dialog(page: Page, tab: Any) -> None:
        page.do(lambda session: session.step(60)).result()
        tab.get_by_role("button", name="Add an object…").click()
        time.sleep(1.0)
        tab.get_by_role("dialog").get_by_role("heading").click()  # closes the list of shapes

    with sync_playwright() as driver, tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser = driver.chromium.launch_persistent_context(
            profile, executable_path=chromium(), args=FLAGS, headless=True, viewport={"width": 1280, "height": 720}
        )
        demo = ap.load_scene("demo")
        arrows = Shown(velocity=True, force=True, impulse=True)
        take("viewer_demo", Session.from_scene(demo), arrows, live)
        take("viewer_plots", Session.from_scene(ap.load_scene("sphere_pit")), Shown(), pit, dark=True)
        take("viewer_joints", Session.from_scene(ap.load_scene("suspension")), Shown(), car, dark=True)
        take("viewer_dialog", Session.from_scene(demo), Shown(), dialog)
        browser.close()
    picture()


def picture() -> None:
    """A picture of a recording."""
    from atlasphys.viewer.picture import Look
    from atlasphys.viewer.render import Shot, render_picture
    from atlasphys.viewer.replay import Replay

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "pyramid.h5"
        scene = ap.load_scene("pyramid")
        world = scene.build()
        world.add(
            ap.Sphere(radius=1.2),
            position=(-14, 3.0, 0.6),
            velocity=(22, 3, 0),
            density=3000,
            color="#303848",
            name="ball",
        )
        with ap.Recorder(path, world, scene, contacts=True) as recorder:
            for _ in range(90):
                world.step(1 / 60)
                recorder.record()
        replay = Replay(path)
        shot = Shot(replay, position=(-15, 11, 34), look_at=(0.5, 8.0, 0), field_of_view=40)
        render_picture(replay, FIGURES / "viewer_film.png", shot, Look(size=(1280, 720)), 1.15)
        replay.close()


if __name__ == "__main__":
    main()
