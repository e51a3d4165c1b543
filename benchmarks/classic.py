"""The classic preset against PyBullet on the same pyramid: one thread each, sleeping off, interleaved in one run.

Run: ``.venv/bin/pip install -e '.[bench]' && .venv/bin/python benchmarks/classic.py``. It prints a table and writes ``benchmarks/classic.csv``.

Each engine runs in a process of its own. The two take turns, ten steps at a time, so that whatever else the machine does meets both.
A result counts only if the pyramid still stands at the end (PyBullet's leans, and falls soon after).
"""

import csv
import multiprocessing
import statistics
import time
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path

from rich.console import Console
from rich.progress import track
from rich.table import Table

BASE, GAP = 20, 0.1
DT = 1 / 60
ROUNDS, STEPS_A_ROUND = 40, 10


def places() -> list[tuple[float, float, float]]:
    """Centres of the pyramid's unit cubes, y up."""
    spacing = 1 + GAP
    return [(spacing * (k - 0.5 * (BASE - row - 1)), row + 0.5, 0.0) for row in range(BASE) for k in range(BASE - row)]


def atlasphys() -> tuple[Callable[[], None], Callable[[], float]]:
    """Our world: a function that steps it, and one that gives the height of the top cube."""
    import atlasphys as ap

    world = ap.World(preset="classic")
    world.add(ap.Plane())
    cubes = [world.add(ap.Box(size=(1, 1, 1)), position=place, mass=1) for place in places()]
    return lambda: world.step(DT), lambda: float(cubes[-1].position[1])


def pybullet() -> tuple[Callable[[], None], Callable[[], float]]:
    """PyBullet's, at its defaults."""
    import pybullet as bullet

    bullet.connect(bullet.DIRECT)
    bullet.setGravity(0, -9.81, 0)
    bullet.setTimeStep(DT)
    plane = bullet.createCollisionShape(bullet.GEOM_PLANE, planeNormal=[0, 1, 0])
    bullet.createMultiBody(0, plane)
    box = bullet.createCollisionShape(bullet.GEOM_BOX, halfExtents=[0.5] * 3)
    cubes = [bullet.createMultiBody(1, box, basePosition=place) for place in places()]
    return bullet.stepSimulation, lambda: bullet.getBasePositionAndOrientation(cubes[-1])[0][1]


def serve(make: Callable[[], tuple[Callable[[], None], Callable[[], float]]], pipe: Connection) -> None:
    """Build a world, then answer each request for a round with the seconds per step, until told to stop."""
    step, top = make()
    step()  # compile, allocate
    pipe.send(None)
    while pipe.recv():
        start = time.perf_counter()
        for _ in range(STEPS_A_ROUND):
            step()
        pipe.send((time.perf_counter() - start) / STEPS_A_ROUND)
    pipe.send(top())


def main() -> None:
    """Measure, print, write."""
    context = multiprocessing.get_context("spawn")
    pipes = {}
    for make in (atlasphys, pybullet):
        ours, theirs = context.Pipe()
        context.Process(target=serve, args=(make, theirs), daemon=True).start()
        pipes[make.__name__] = ours
    for pipe in pipes.values():
        pipe.recv()
    times: dict[str, list[float]] = {name: [] for name in pipes}
    for _ in track(range(ROUNDS), description="measuring"):
        for name, pipe in pipes.items():
            pipe.send(True)
            times[name].append(pipe.recv())
    tops = {}
    for name, pipe in pipes.items():
        pipe.send(False)
        tops[name] = pipe.recv()

    ours = times["atlasphys"]
    rows = [
        {
            "scene": f"pyramid {BASE}",
            "engine": name,
            "median_ms": round(1e3 * statistics.median(values), 3),
            "min_ms": round(1e3 * min(values), 3),
            "median_ratio": round(statistics.median(v / o for v, o in zip(values, ours, strict=True)), 2),
            "min_ratio": round(min(values) / min(ours), 2),
            "stands": tops[name] > BASE - 1,
        }
        for name, values in times.items()
    ]
    table = Table(*rows[0], title="ms per step; ratio to AtlasPhys")
    for row in rows:
        table.add_row(*(str(value) for value in row.values()))
    Console().print(table)
    with (Path(__file__).parent / "classic.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main()
