"""Make the figures of docs/explain.md: screenshots of the explorer in headless Chromium.

Run: ``PYTHONPATH=. python docs/make_explorer_figures.py [NAME …]``. Needs Chromium.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import atlasphys as ap

FIGURES = Path(__file__).parent / "figures"
SIZE = {"width": 1240, "height": 760}


def told(world: ap.World, *pair: str) -> ap.Story:
    """The story of a pair's next step."""
    with ap.explain(world, pair=pair) as story:
        world.step(1 / 60)
    return story


def polygons(distance: float) -> ap.Story:
    """The first lesson."""
    return told(ap.load_scene("polygons", distance=distance).build(), "triangle", "pentagon")


def boxes() -> ap.Story:
    """Two boxes deep in each other."""
    world = ap.World(gravity=(0, 0, 0), preset="classic")
    world.add(ap.Box(size=(1, 1, 1)), name="box")
    world.add(ap.Box(size=(0.6, 0.8, 1)), position=(0.3, 0.4, 0.2), orientation=(0.92, 0.2, 0.3, 0.1), name="prism")
    return told(world, "box", "prism")


def stack() -> ap.Story:
    """A turned box that lies on another."""
    world = ap.World(preset="classic")
    world.add(ap.Box(size=(1, 1, 1)), kind="static", name="table")
    world.add(ap.Box(size=(0.7, 0.5, 0.9)), position=(0.2, 0.747, 0.1), orientation=(0.96, 0, 0.28, 0), name="crate")
    world.run(seconds=1 / 60)
    return told(world, "table", "crate")


def fallen() -> ap.Story:
    """A cube that has fallen on another."""
    world = ap.load_scene("two_boxes").build(preset="classic")
    world.run(seconds=0.5)
    return told(world, "lower", "upper")


def main(*wanted: str) -> None:
    """Make those that are wanted, or all."""
    from playwright.sync_api import sync_playwright

    from atlasphys.viewer.explorer.explorer import Explorer
    from atlasphys.viewer.explorer.page import Page
    from tests.viewer.conftest import FLAGS, chromium

    def take(name: str, story: ap.Story, stage: str, title: str, scroll: int = 0) -> None:
        if wanted and name not in wanted:
            return
        explorer = Explorer(story, stage)
        page = Page(explorer, port=0)
        tab = browser.new_page()
        tab.goto(page.url)
        tab.get_by_role("button", name="Next step").wait_for()
        time.sleep(2.0)
        number = next(i for i, slide in enumerate(explorer.slides) if title in slide.title + slide.text)
        page.do(lambda explorer: explorer.go(number)).result()
        time.sleep(2.0)
        for button in tab.locator(".mantine-Notification-closeButton").all():
            button.click()
        if scroll:
            tab.locator("#slide").hover()
            tab.mouse.wheel(0, scroll)
        time.sleep(1.5)
        tab.screenshot(path=FIGURES / f"{name}.png")
        tab.close()
        page.close()

    with sync_playwright() as driver, tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser: Any = driver.chromium.launch_persistent_context(
            profile, executable_path=chromium(), args=FLAGS, headless=True, viewport=SIZE
        )
        take("explorer_plane_apart", polygons(1.4), "gjk", "Step 2: ask for")
        take("explorer_plane", polygons(0.5), "gjk", "Step 3: the simplex is a triangle")
        take("explorer_gjk", boxes(), "gjk", "Step 4: the simplex is a tetrahedron")
        take("explorer_epa", boxes(), "epa", "Step 3: ask the nearest face")
        take("explorer_sat", boxes(), "sat", "Axis 5")
        take("explorer_clip", stack(), "clip", "lies beyond is")
        take("explorer_manifold", stack(), "manifold", "Verdict")
        take("explorer_solver", fallen(), "solver", "Sweep 6", scroll=500)
        browser.close()


if __name__ == "__main__":
    main(*sys.argv[1:])
