"""What the viewer costs: streaming 5 000 moving bodies to a browser, and rendering 1 000 bodies without a display.

Run: ``.venv/bin/python benchmarks/viewer.py``. It prints a table and writes ``benchmarks/viewer.csv``.

Streaming is measured with a client that receives everything, as a page does, and does not draw: software WebGL would take all processors of a machine
without a graphics card. The processor time outside physics is that of the whole process (drawing, numbers, plots, web server, snapshots) less that of
``World.step``.
"""

from __future__ import annotations

import csv
import statistics
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

import atlasphys as ap
from atlasphys.viewer.gui.page import Page, Shown
from atlasphys.viewer.picture import Look, Painter
from atlasphys.viewer.session import Session
from atlasphys.viewer.viewpoint import view_from

BODIES, SECONDS = 5000, 10.0
RENDERED, PICTURES = 1000, 20


CLIENT = """
import sys, viser
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect
received = 0
with connect(sys.argv[1], subprotocols=[f"viser-v{viser.__version__}"], compression=None, max_size=None) as socket:
    try:
        while True:
            received += len(socket.recv())
    except ConnectionClosed:
        print(received)
"""


class Counted(Session):
    """A session that counts the processor time of its steps."""

    physics = 0.0

    def _step(self) -> None:
        begin = time.thread_time()
        self.history.before_step(self.world, self.dt, self._changed_by_hand)
        kept = time.thread_time()
        super()._step()
        self.physics += time.thread_time() - kept
        self.kept = getattr(self, "kept", 0.0) + kept - begin


def moving_bodies(count: int) -> ap.World:
    """Balls and boxes that fly about without gravity and hardly ever meet."""
    world = ap.World(gravity=(0, 0, 0), sleeping=False)
    side = round(count ** (1 / 3) + 0.5)
    for k in range(count):
        where = (2.0 * (k % side), 2.0 * (k // side % side), 2.0 * (k // side**2))
        shape = ap.Box(size=(0.5, 0.5, 0.5)) if k % 2 else ap.Sphere(radius=0.25)
        world.add(
            shape, position=where, velocity=(0.1 * (k % 7 - 3), 0.1 * (k % 5 - 2), 0.05), angular_velocity=(0, 1, k % 3)
        )
    return world


def stream() -> list[dict[str, Any]]:
    """Frames a second and processor time outside physics."""
    session = Counted(moving_bodies(BODIES))
    session.step(2)
    page = Page(session, port=0, shown=Shown(shadows=False, grid=False))
    client = subprocess.Popen([sys.executable, "-c", CLIENT, page.url.replace("http", "ws")], stdout=subprocess.PIPE)
    page.do(Session.start).result()
    time.sleep(3.0)
    start = (time.perf_counter(), time.process_time(), session.physics, page.frames_drawn, session.world.steps)
    time.sleep(SECONDS)
    end = (time.perf_counter(), time.process_time(), session.physics, page.frames_drawn, session.world.steps)
    page.close()
    assert int(client.communicate(timeout=30)[0]) > 1e6, "the client received nothing"
    wall, cpu, physics, frames, steps = (b - a for a, b in zip(start, end, strict=True))
    return [
        {"what": f"{BODIES} moving bodies: frames sent", "value": round(frames / wall, 1), "unit": "a second"},
        {"what": "steps", "value": round(steps / wall, 1), "unit": "a second"},
        {
            "what": "processor time outside physics",
            "value": round(100 * (cpu - physics) / wall, 1),
            "unit": "% of a core",
        },
        {"what": "processor time of physics", "value": round(100 * physics / wall, 1), "unit": "% of a core"},
    ]


def render() -> list[dict[str, Any]]:
    """Time for a picture of 1280×720."""
    rows = []
    session = Session(moving_bodies(RENDERED))
    session.add({"shape": {"type": "plane", "offset": -1.0}})
    for shadows in (True, False):
        painter = Painter(session.frame(), Look(shadows=shadows))
        times = []
        for _ in range(PICTURES):
            session.step()
            frame = session.frame()
            start = time.perf_counter()
            painter.paint(frame, view_from("oblique", frame))
            times.append(1e3 * (time.perf_counter() - start))
        painter.close()
        what = f"{RENDERED} bodies, 1280x720, {'with' if shadows else 'without'} shadows: median (least)"
        rows.append(
            {"what": what, "value": f"{statistics.median(times[2:]):.0f} ({min(times):.0f})", "unit": "ms a picture"}
        )
    return rows


def main() -> None:
    """Measure, print, write."""
    rows = [*render(), *stream()]
    table = Table(*rows[0])
    for row in rows:
        table.add_row(*(str(value) for value in row.values()))
    Console().print(table)
    with (Path(__file__).parent / "viewer.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main()
