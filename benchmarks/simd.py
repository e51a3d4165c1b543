"""What a block of eight contacts costs as vector code and as scalar code, and how long each takes to compile.

Run from the repository's root: ``python -m benchmarks.simd``. It prints a table and writes ``benchmarks/simd.csv``. The bodies are
those of ``tests/engine/simd/bodies.py``: a normal and two friction impulses per contact, with the bodies' rows gathered and scattered.
"""

import csv
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

BLOCKS, SWEEPS, ROUNDS = 250, 4, 60


def measure() -> None:
    """Measure in this process, whose kernel cache is empty, and print rows as JSON."""
    from atlasphys.engine.jit import kernel
    from atlasphys.engine.simd import instruction_set, load, simd_kernel, store
    from tests.engine.simd.bodies import contact_problem, solve_contacts, solve_contacts_scalar

    @simd_kernel
    def first(x):
        store(x, 0, load(x, 0) + 1)

    @kernel
    def warm_up(x):
        first(x)

    warm_up(np.ones((1, 8)))  # what Numba needs once a process is not a kernel's compile time
    rows = []
    for real in (np.float32, np.float64):
        forms = {"lanes": solve_contacts, "scalar": solve_contacts_scalar}
        compiling, took, problems = {}, {name: [] for name in forms}, {}
        for name, function in forms.items():
            start = time.perf_counter()
            function(*contact_problem(1, real), False, 1)
            compiling[name] = time.perf_counter() - start
            problems[name] = contact_problem(BLOCKS, real)
        for _ in range(ROUNDS):
            for name, function in forms.items():  # interleaved: a busy moment hits both
                start = time.perf_counter()
                function(*problems[name], False, SWEEPS)
                took[name].append((time.perf_counter() - start) / (BLOCKS * SWEEPS) * 1e9)
        for one, two in zip(*problems.values(), strict=True):
            assert np.array_equal(one, two)  # a fast wrong answer does not count
        ratio = statistics.median(s / v for s, v in zip(took["scalar"], took["lanes"], strict=True))
        rows += [
            {
                "instruction_set": instruction_set(),
                "real": np.dtype(real).name,
                "form": name,
                "median_ns": round(statistics.median(values), 1),
                "min_ns": round(min(values), 1),
                "times_faster": round(ratio, 2) if name == "lanes" else 1.0,
                "compile_s": round(compiling[name], 2),
            }
            for name, values in took.items()
        ]
    print(json.dumps(rows))


def main() -> None:
    """Measure native and generic code, print, write."""
    targets = [{}]
    if platform.machine() in ("x86_64", "AMD64"):
        targets += [
            {"NUMBA_CPU_NAME": "haswell", "NUMBA_CPU_FEATURES": "+avx,+avx2"},
            {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""},
        ]
    rows = []
    for settings in targets:
        with tempfile.TemporaryDirectory() as cache:
            environment = os.environ | {"ATLASPHYS_CACHE_DIR": cache} | settings
            command = [sys.executable, "-m", "benchmarks.simd", "measure"]
            rows += json.loads(subprocess.run(command, check=True, capture_output=True, env=environment).stdout)
    table = Table(*rows[0])
    for row in rows:
        table.add_row(*(str(value) for value in row.values()))
    Console().print(table)
    with (Path(__file__).parent / "simd.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    measure() if sys.argv[1:] == ["measure"] else main()
