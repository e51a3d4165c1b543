"""How long a user waits: import, help, the first and a later run of a scene, and Ctrl-C.

Run: ``.venv/bin/python benchmarks/responsiveness.py``. It prints a table and writes ``benchmarks/responsiveness.csv``.
"""

import csv
import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from rich.console import Console
from rich.table import Table

import atlasphys as ap

COMMAND = [sys.executable, "-m", "atlasphys"]
REPEATS = 7


def seconds(*command: str, cache: str | None = None) -> float:
    """Wall time of a command."""
    environment = os.environ | ({"ATLASPHYS_CACHE_DIR": cache} if cache else {})
    start = time.perf_counter()
    subprocess.run(command, check=True, capture_output=True, env=environment)
    return time.perf_counter() - start


def interrupt() -> float:
    """Time from SIGINT to the end of a recorded run of the pyramid, whose recording must be whole."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.h5"
        command = [*COMMAND, "run", "pyramid", "--seconds", "1000", "--record", str(path), "--json"]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        while not path.exists():
            time.sleep(0.05)
        time.sleep(1.5)
        start = time.perf_counter()
        process.send_signal(signal.SIGINT)
        process.wait()
        took = time.perf_counter() - start
        with ap.Recording(path) as recording:
            assert len(recording) > 0
        return took


def main() -> None:
    """Measure, print, write."""
    with tempfile.TemporaryDirectory() as cache:
        cold = seconds(*COMMAND, "run", "tower", cache=cache)
    seconds(*COMMAND, "run", "tower")
    seconds(*COMMAND, "run", "pyramid", "--seconds", "0.1")
    measured = {
        "first run of tower, empty kernel cache": [cold],
        "later run of tower": [seconds(*COMMAND, "run", "tower") for _ in range(REPEATS)],
        "import atlasphys": [seconds(sys.executable, "-c", "import atlasphys") for _ in range(REPEATS)],
        "atlasphys --help": [seconds(*COMMAND, "--help") for _ in range(REPEATS)],
        "Ctrl-C to end of process": [interrupt() for _ in range(REPEATS)],
    }
    rows = [
        {
            "what": what,
            "median_s": round(statistics.median(values), 3),
            "min_s": round(min(values), 3),
            "max_s": round(max(values), 3),
        }
        for what, values in measured.items()
    ]
    table = Table(*rows[0])
    for row in rows:
        table.add_row(*(str(value) for value in row.values()))
    Console().print(table)
    with (Path(__file__).parent / "responsiveness.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main()
