"""Kill writers of recordings with SIGKILL at random moments and read what they leave.

Prints the numbers of intact files and of steps read.

Usage: kill_writers.py FOLDER COUNT
"""

import mmap
import os
import random
import signal
import sys
import time
from pathlib import Path

import h5py  # noqa: F401  (before the fork, so that the writers start at once)

import atlasphys as ap
from tests.record.worlds import expected_position, put, small_world


def write_for_ever(path: Path, world: ap.World, stored: mmap.mmap) -> None:
    recorder = ap.Recorder(path, world)
    stored[8] = 1
    step = 0
    while True:
        put(world, step)
        recorder.record()
        step += 1
        if step % 50 == 0:
            stored[0:8] = step.to_bytes(8, "little")


def main(folder: Path, count: int) -> None:
    moment = random.Random(2)
    world = small_world(20)
    intact = total = 0
    for number in range(count):
        path = folder / f"{number}.h5"
        stored = mmap.mmap(-1, 9)
        writer = os.fork()
        if writer == 0:
            write_for_ever(path, world, stored)
        while not stored[8]:
            time.sleep(0.001)
        time.sleep(0.12 * moment.random())
        os.kill(writer, signal.SIGKILL)
        os.waitpid(writer, 0)
        at_least = int.from_bytes(stored[0:8], "little")
        with ap.Recording(path) as recording:
            assert len(recording) >= at_least, (len(recording), at_least)
            assert len(recording) % 50 == 0
            for step in range(0, len(recording), 7):
                positions = recording.poses(step).positions
                assert positions.tolist() == [list(expected_position(step, row)) for row in range(20)]
            total += len(recording)
        intact += 1
    print(intact, total)


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]))
