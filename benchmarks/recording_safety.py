"""How often a plain HDF5 file is unreadable or wrong if its writer is killed between two writes.

This is the table in docs/recordings.md.

A file object notes every write that HDF5 makes; after every third one the file as it then stands is read back.

Usage: python benchmarks/recording_safety.py
"""

import io

import h5py
import numpy as np

CHUNKS, STEPS, BODIES = 120, 50, 150


class NotingFile(io.BytesIO):
    """A file in memory that notes what is written where."""

    def __init__(self) -> None:
        super().__init__()
        self.writes: list[tuple[int, bytes | None]] = []

    def write(self, data) -> int:
        """Note and write."""
        self.writes.append((self.tell(), bytes(data)))
        return super().write(data)

    def truncate(self, size=None) -> int:
        """Note and cut."""
        self.writes.append((size, None))
        return super().truncate(size)


def record(libver: str | None) -> tuple[list[tuple[int, bytes | None]], int]:
    """The writes of a program that flushes after every 50 steps, and how many of them make the empty file."""
    file = NotingFile()
    with h5py.File(file, "w", libver=libver) as recording:
        packed = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
        poses = recording.create_dataset(
            "poses", (0, BODIES, 7), "f8", maxshape=(None, None, 7), chunks=(STEPS, 64, 7), fillvalue=np.nan, **packed
        )
        times = recording.create_dataset("time", (0,), "f8", maxshape=(None,), chunks=(STEPS,))
        recording.flush()
        empty = len(file.writes)
        for chunk in range(CHUNKS):
            now = np.arange(STEPS * chunk, STEPS * (chunk + 1))
            poses.resize(now[-1] + 1, 0)
            poses[now[0] :] = np.broadcast_to(now[:, None, None], (STEPS, BODIES, 7))
            recording.flush()
            times.resize(now[-1] + 1, 0)
            times[now[0] :] = now
            recording.flush()
    return file.writes, empty


def is_right(image: bytes) -> bool:
    """Whether the file opens and holds right poses for every time in it."""
    try:
        with h5py.File(io.BytesIO(image), "r") as recording:
            times, poses = recording["time"][:], recording["poses"]
            steps = np.arange(len(times))
            return np.array_equal(times, steps) and np.array_equal(poses[: len(times), 0, 0], steps)
    except (OSError, RuntimeError, KeyError):
        return False


def main() -> None:
    """Print the table."""
    for libver in (None, "latest"):
        writes, empty = record(libver)
        image = bytearray()
        tried = wrong = 0
        for number, (place, data) in enumerate(writes):
            if data is None:
                image = image[:place].ljust(place, b"\0")
            else:
                image = image.ljust(place, b"\0")
                image[place : place + len(data)] = data
            if number >= empty and number % 3 == 0:
                tried += 1
                wrong += not is_right(bytes(image))
        print(
            f"libver={libver or 'default'}: {wrong} of {tried} moments unreadable or wrong ({100 * wrong / tried:.0f} %)"
        )


if __name__ == "__main__":
    main()
