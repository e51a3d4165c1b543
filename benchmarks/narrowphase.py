"""What a pair costs in the narrow phase, over eight lanes and in scalar code, and how long each takes to compile.

Run from the repository's root: ``python -m benchmarks.narrowphase``. It prints a table and writes
``benchmarks/narrowphase.csv``. Pairs of one kind overlap, or are apart by more than the margin; boxes also rest on each other,
turned about the vertical. The lanes' blocks are filled beforehand, which a step has to do too; the scalar kernels look the shapes up as
they go. The lanes keep at most four points; scalar code leaves that to ``manifold/reduce.py``. Compile times are of the CPU.
"""

import csv
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

PAIRS, ROUNDS, MARGIN = 800, 60, 0.02


def poses_of(kinds, case, rng):
    """Pairs of one kind as tests have them."""
    from atlasphys.engine.shapes.box import Box
    from tests.engine.narrowphase.poses import Pose, random_poses
    from tests.reference.narrowphase import rotation

    if case == "resting":
        cube, still = Box((1.0, 1.0, 1.0)), np.eye(3)
        turns = [rotation((1, 0, 0.3 * rng.normal(), 0)) for _ in range(PAIRS)]
        return [Pose(cube, cube, np.zeros(3), np.array([0.2 * rng.normal(), 0.999, 0.1]), still, r) for r in turns]
    poses = random_poses(*kinds, rng, "random", PAIRS)
    if case == "apart":  # as neighbours are that the broad phase finds: their bounds overlap, or nearly
        poses = [p._replace(position_b=p.position_a + 1.8 * (p.position_b - p.position_a)) for p in poses]
    return poses


def measure() -> None:
    """Measure in this process, whose kernel cache is empty, and print rows as JSON."""
    from atlasphys.engine.narrowphase.dispatch import METHOD_KERNELS, collide
    from atlasphys.engine.shapes.table import BOX, CAPSULE, SPHERE
    from atlasphys.engine.simd import instruction_set
    from atlasphys.engine.state.contacts import empty_contacts
    from tests.engine.narrowphase.lane_blocks import DRIVERS, blocks_of
    from tests.engine.narrowphase.poses import state_of
    from tests.engine.simd.bodies import contact_problem, solve_contacts

    number = {"sphere": SPHERE, "capsule": CAPSULE, "box": BOX}
    solve_contacts(*contact_problem(1, np.float32), False, 1)  # what Numba needs once a process is not a kernel's time
    rows = []
    for real in (np.float32, np.float64):
        for kinds, driver in DRIVERS.items():
            if kinds[1] == "plane":
                continue
            compiling = {}
            for case in ("overlapping", "apart", "resting") if kinds == ("box", "box") else ("overlapping", "apart"):
                rng = np.random.default_rng(0)
                poses = poses_of(kinds, case, rng)
                blocks, state = blocks_of(poses, real, MARGIN), state_of(poses, real)
                scalar = METHOD_KERNELS["auto"][number[kinds[0]], number[kinds[1]]]
                start = time.process_time()
                driver(*blocks)
                compiling.setdefault("lanes", time.process_time() - start)
                start = time.process_time()
                contacts = collide(*state, "auto", MARGIN, empty_contacts(1, 1, real))
                compiling.setdefault("scalar", time.process_time() - start)
                points = int((blocks.tags[:, 4] > 0).sum()), int((contacts.count[:PAIRS] > 0).sum())
                assert abs(points[0] - points[1]) <= 0.02 * PAIRS, (kinds, case, points)
                which = np.arange(PAIRS)
                forms = {
                    "lanes": lambda driver=driver, blocks=blocks: driver(*blocks),
                    "scalar": lambda kernel=scalar, arguments=(which, *state[:3], MARGIN, contacts): kernel(*arguments),
                }
                took = {name: [] for name in forms}
                for _ in range(ROUNDS):
                    for name, function in forms.items():  # interleaved: a busy moment hits both
                        start = time.perf_counter()
                        function()
                        took[name].append((time.perf_counter() - start) / PAIRS * 1e9)
                rows += [
                    {
                        "instruction_set": instruction_set(),
                        "real": np.dtype(real).name,
                        "pair": " ".join(kinds),
                        "case": case,
                        "touching": round(points[0] / PAIRS, 2),
                        "form": name,
                        "median_ns": round(float(np.median(values)), 1),
                        "min_ns": round(min(values), 1),
                        "compile_s": round(compiling[name], 2),
                    }
                    for name, values in took.items()
                ]
    print(json.dumps(rows))


def main() -> None:
    """Measure in a process with an empty cache, print, write."""
    with tempfile.TemporaryDirectory() as cache:
        environment = os.environ | {"ATLASPHYS_CACHE_DIR": cache}
        command = [sys.executable, "-m", "benchmarks.narrowphase", "measure"]
        rows = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE, env=environment).stdout)
    table = Table(*rows[0])
    for row in rows:
        table.add_row(*(str(value) for value in row.values()))
    Console().print(table)
    with (Path(__file__).parent / "narrowphase.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    measure() if sys.argv[1:] == ["measure"] else main()
