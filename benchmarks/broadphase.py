"""What the broad phases cost: finding all pairs anew, keeping them for bodies that fall apart, and asking whether any left its fat box.

Run from the repository's root: ``python -m benchmarks.broadphase``. It prints a table and writes ``benchmarks/broadphase.csv``. One thread;
the least of several repeats. The pile is a dense lattice of unit boxes, a little jittered and turned, in random rows; the falling boxes
start 3 m apart.
"""

import csv
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

import atlasphys as ap
from atlasphys.engine.broadphase import BROADPHASES
from atlasphys.engine.broadphase.fat_boxes import has_left
from atlasphys.engine.broadphase.tree import FatTree
from atlasphys.engine.jit import kernel
from atlasphys.engine.shapes.bounds import update_bounds
from atlasphys.engine.shapes.table import ShapeTable
from atlasphys.engine.state.bodies import DYNAMIC, empty_bodies
from atlasphys.engine.state.colliders import empty_colliders
from atlasphys.engine.state.pose import refresh

FATTENING, MARGIN, H, GRAVITY = 0.05, 0.02, 1 / 60, (0.0, -9.81, 0.0)
STEPS, REPEATS = 120, 10


@kernel
def any_left(rows, center, geometry, fat, margin, offset, room):
    """Whether any body left its fat box."""
    return has_left(0, len(rows), rows, center, geometry, fat, margin, offset, room)


def boxes(count: int, spacing: float, jitter: float = 0.05) -> tuple[Any, ...]:
    """Tables of a lattice of unit boxes, and their number."""
    rng = np.random.default_rng(0)
    bodies, colliders, table = empty_bodies(count, "f"), empty_colliders(count, "f"), ShapeTable("f")
    table.row_of(ap.Box(size=(1, 1, 1)))
    side = int(np.ceil(count ** (1 / 3)))
    places = rng.permutation(np.indices((side,) * 3).reshape(3, -1).T[:count]) * spacing
    bodies.position[:] = places + rng.uniform(-jitter, jitter, (count, 3))
    bodies.orientation[:, 0] = 1
    bodies.orientation[:, 1:] = rng.normal(size=(count, 3)) * 0.05
    bodies.orientation[:] /= np.linalg.norm(bodies.orientation, axis=1, keepdims=True)
    bodies.kind[:], bodies.mass[:], bodies.response[:, 0] = DYNAMIC, 1, 1
    colliders.body[:], colliders.group[:], colliders.mask[:] = np.arange(count), 1, ~np.uint32(0)
    refresh(bodies, 0, count)
    update_bounds(bodies, colliders, table.arrays, count, MARGIN)
    return bodies, colliders, table.arrays, count


def least(repeats: int, work: Callable[..., object], *arguments: Any) -> float:
    """Milliseconds of the fastest of several calls."""
    took = []
    for _ in range(repeats):
        start = time.perf_counter()
        work(*arguments)
        took.append(time.perf_counter() - start)
    return 1e3 * min(took)


def piles() -> Iterator[dict[str, object]]:
    """A settled pile."""
    for count in (1_000, 10_000, 100_000):
        tables = boxes(count, 1.02)
        pairs = np.empty((16 * count, 2), np.int32)
        for name in ("sweep", "tree"):
            if name == "sweep" and count > 10_000:
                continue  # seconds
            BROADPHASES[name](*tables, pairs)
            found = BROADPHASES[name](*tables, pairs)[1]
            ms = least(REPEATS, BROADPHASES[name], *tables, pairs)
            yield {"scene": "pile", "bodies": count, "work": f"{name}: find_pairs", "ms": ms, "pairs": found}
        tree = FatTree("f", FATTENING)
        tree.update(*tables, H, MARGIN, np.zeros(count, np.uint8), GRAVITY)
        ms = least(REPEATS, tree._find_all, False)
        yield {
            "scene": "pile",
            "bodies": count,
            "work": "fat tree: rebuild and query",
            "ms": ms,
            "pairs": len(tree.pairs),
        }
        offset, room = np.zeros((6, 8), "f"), np.zeros((len(tree.rows), 8), "f")
        arguments = tree.rows, tables[0].center, tables[0].geometry, tree.fat, MARGIN, offset, room
        assert not any_left(*arguments)
        ms = least(50, any_left, *arguments)
        yield {"scene": "pile", "bodies": count, "work": "fat tree: has_left", "ms": ms, "pairs": len(tree.pairs)}
        ms = least(REPEATS, find_one, tree, count // 2)
        yield {"scene": "pile", "bodies": count, "work": "fat tree: one new box", "ms": ms, "pairs": len(tree.pairs)}


def find_one(tree: FatTree, row: int) -> None:
    """Find the pairs of one body anew."""
    tree._changed[row] = 1
    tree._find_changed()


def falling(count: int, speed: float) -> dict[str, object]:
    """Boxes that fall, turn and fly apart at up to ``speed``: milliseconds a step over two seconds, the least of three runs."""
    runs = []
    for _ in range(3):
        tables = boxes(count, 3.0)
        bodies, rng = tables[0], np.random.default_rng(1)
        direction = rng.normal(size=(count, 3))
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        velocity = direction * rng.uniform(0, speed, (count, 1))
        bodies.motion[:, 3:6] = rng.normal(size=(count, 3))
        tree = FatTree("f", FATTENING)
        flying = np.ones(count, np.uint8)
        tree.update(*tables, H, MARGIN, flying, GRAVITY)
        offset, room = np.zeros((6, 8), "f"), np.zeros((len(tree.rows), 8), "f")
        took, pairs = 0.0, 0
        for _ in range(STEPS):
            tree.fat.clock[0] += H
            velocity += np.multiply(GRAVITY, H)
            bodies.position[:] += velocity * H
            bodies.center[:] = bodies.position
            bodies.motion[:, :3] = velocity
            start = time.perf_counter()
            if any_left(tree.rows, bodies.center, bodies.geometry, tree.fat, MARGIN, offset, room):
                tree.update(*tables, H, MARGIN, flying, GRAVITY)
            took += time.perf_counter() - start
            pairs += len(tree.pairs)
        runs.append(1e3 * took / STEPS)
    scene = f"falling, up to {speed:g} m/s apart"
    return {"scene": scene, "bodies": count, "work": "fat tree: a step", "ms": min(runs), "pairs": pairs // STEPS}


def main() -> None:
    """Measure, print, write."""
    falling(64, 20)  # compiles
    rows = [*piles(), *(falling(10_000, speed) for speed in (0, 2, 20))]
    table = Table(*rows[0])
    for row in rows:
        row["ms"] = f"{row['ms']:.3f}"
        table.add_row(*(str(value) for value in row.values()))
    Console().print(table)
    with (Path(__file__).parent / "broadphase.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main()
