"""Measuring: each engine in a process of its own, all of them taking turns, so that whatever else the machine does meets all alike."""

from __future__ import annotations

import gc
import multiprocessing
import os
import signal
import statistics
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from atlasphys.bench.peers import engine, version_of
from atlasphys.bench.scenes import DT, Scene, make
from atlasphys.errors import InvalidArgumentError

if TYPE_CHECKING:
    from atlasphys.bench.quality import Quality

Report = Callable[[str], None]
"""Is told what is being done, several times a scene."""


@dataclass(frozen=True)
class Plan:
    """How to measure."""

    threads: int = 1
    preset: str | None = None
    """For AtlasPhys: a preset's name."""
    rounds: int = 20
    """Number of turns of each engine."""
    turn: float = 0.2
    """Wall time of a turn, about; at least one step [s]."""
    steps: int | None = None
    """Steps of a turn, instead of that time."""
    settle: float | None = None
    """Simulated time before measuring, instead of the scene's [s]."""
    seconds: float | None = None
    """Simulated time at which scenes are judged, instead of their own [s]."""
    patience: float = 300.0
    """Wall time after which an engine that does not answer or has not settled is given up [s]."""

    def of(self, scene: Scene) -> tuple[int, int]:
        """Steps before measuring, and steps in all."""
        settle = scene.settle if self.settle is None else self.settle
        seconds = scene.seconds if self.seconds is None else self.seconds
        first = max(1, round(settle / DT))
        return first, max(first + 1, round(seconds / DT))


@dataclass
class Result:
    """What an engine showed on a scene."""

    scene: str
    engine: str
    version: str
    threads: int = 1
    bodies: int = 0
    wall: list[float] = field(default_factory=list)
    """Seconds per step of each turn."""
    cpu: list[float] = field(default_factory=list)
    """Processor time per step of each turn, all threads together [s]."""
    steps: int = 0
    """Steps of a turn."""
    seconds: float = 0.0
    """Simulated time at which the scene was judged [s]."""
    quality: Quality | None = None
    failure: str = ""
    """Why there is no measurement."""
    median_ratio: float | None = None
    """Median over the rounds of this engine's time to ours."""
    min_ratio: float | None = None
    """Ratio of this engine's least time to ours."""

    @property
    def stands(self) -> bool:
        """Whether the answer counts."""
        return self.quality is not None and self.quality.stands

    @property
    def fault(self) -> str:
        """Why it does not count."""
        return self.failure or (self.quality.fault if self.quality else "")

    def row(self) -> dict[str, Any]:
        """The line of the table."""
        quality = self.quality
        return {
            "scene": self.scene,
            "engine": self.engine,
            "version": self.version,
            "threads": self.threads,
            "median_ms": _round(1e3 * statistics.median(self.wall)) if self.wall else None,
            "min_ms": _round(1e3 * min(self.wall)) if self.wall else None,
            "cpu_ms": _round(1e3 * statistics.median(self.cpu)) if self.cpu else None,
            "median_ratio": _round(self.median_ratio),
            "min_ratio": _round(self.min_ratio),
            "stands": self.stands,
            "worst_drift": _round(quality.worst_drift) if quality else None,
            "deepest_penetration": _round(quality.deepest) if quality else None,
            "stretch": _round(quality.stretch) if quality else None,
            "energy_error": _round(quality.energy) if quality else None,
            "bodies": self.bodies,
            "seconds": round(self.seconds, 2),
            "fault": self.fault,
        }


def _round(value: float | None) -> float | None:
    """Four digits: more would be noise."""
    return None if value is None else float(f"{value:.4g}")


class NoAnswerError(Exception):
    """An engine gave no answer."""


class Worker:
    """An engine in a process of its own; it waits for requests and has one answered at a time."""

    def __init__(self, name: str, plan: Plan) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._patience = plan.patience
        self._process = context.Process(target=_serve, args=(theirs, name, plan.threads, plan.preset), daemon=True)
        self._process.start()
        theirs.close()  # so that its end closes the pipe

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._process.kill()
        self._process.join()

    def ask(self, request: str, value: Any = None) -> Any:
        """Have a request answered.

        Raises:
            NoAnswerError: the engine raised an error, took longer than it may, or its process ended.
        """
        try:
            self._pipe.send((request, value))
            if not self._pipe.poll(self._patience):
                raise NoAnswerError(f"too slow: no answer to {request!r} within {self._patience:g} s")
            error, answer = self._pipe.recv()
        except (EOFError, OSError):
            self._process.join(1.0)
            code = self._process.exitcode
            raise NoAnswerError(f"its process ended with code {code} in {request!r}") from None
        if isinstance(error, InvalidArgumentError):
            raise error
        if error is not None:
            raise NoAnswerError(f"{type(error).__name__}: {error}")
        return answer


def _serve(pipe: Connection, name: str, threads: int, preset: str | None) -> None:
    """What the process does until its pipe is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's to answer
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):  # PyBullet greets, MuJoCo warns; errors go through the pipe
        os.dup2(nowhere, stream)
    state: Any = None
    while True:
        try:
            request, value = pipe.recv()
        except EOFError:
            return
        answer: Any = None
        error: Exception | None = None
        try:
            if request == "build":
                state = None
                state = engine(name)(value, threads, preset)
                answer = state.threads
            elif request == "run":
                wall, cpu = time.perf_counter(), time.process_time()
                state.run(value)
                answer = time.perf_counter() - wall, time.process_time() - cpu
            elif request == "poses":
                answer = state.poses()
            elif request == "memory":
                gc.collect()
                answer = resident_bytes()
        except Exception as raised:
            error = raised
        try:
            pipe.send((error, answer))
        except (TypeError, AttributeError):  # the error cannot be pickled
            pipe.send((RuntimeError(str(error)), None))


def resident_bytes() -> int:
    """Memory that this process has in use [bytes]."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


def measure(scene: Scene, names: Sequence[str], plan: Plan, report: Report = lambda _: None) -> list[Result]:
    """Measure engines on a scene; the first is the one that the others are compared with.

    Raises:
        InvalidArgumentError: AtlasPhys does not take the preset or the number of threads.
    """
    results = [Result(scene.name, name, version_of(name), plan.threads, len(scene.bodies)) for name in names]
    first, total = plan.of(scene)
    with ExitStack() as stack:
        running = {result.engine: (result, stack.enter_context(Worker(result.engine, plan))) for result in results}

        def attempt(action: Callable[[Result, Worker], None], order: Sequence[str]) -> None:
            for name in order:
                if name in running:
                    try:
                        action(*running[name])
                    except NoAnswerError as failure:
                        result, worker = running.pop(name)
                        result.failure = str(failure)
                        worker.__exit__(None, None, None)

        def prepare(result: Result, worker: Worker) -> None:
            report(f"{scene.name}: {result.engine} settles")
            result.threads = worker.ask("build", scene)
            worker.ask("run", 1)  # kernels are compiled or loaded
            done = 1
            count, wall, deadline = 1, 0.0, time.monotonic() + plan.patience
            while done < first:  # in pieces that grow, to see in time whether it is hopeless
                if time.monotonic() > deadline:
                    raise NoAnswerError(f"too slow: {done} of {first} steps to settle in {plan.patience:g} s")
                count = min(first - done, 2 * count, 1 + int(PIECE * count / max(wall, 1e-6)))
                wall, _ = worker.ask("run", count)
                done += count
            result.seconds = done * DT
            most = max(1, (total - done) // plan.rounds)
            result.steps = plan.steps or max(1, min(most, int(plan.turn * count / max(wall, 1e-9))))

        def take_turn(result: Result, worker: Worker) -> None:
            wall, cpu = worker.ask("run", result.steps)
            result.wall.append(wall / result.steps)
            result.cpu.append(cpu / result.steps)
            result.seconds += result.steps * DT

        def judge(result: Result, worker: Worker) -> None:
            # To the same simulated time for all, as far as patience goes. Scenes at rest for hours need not wait.
            report(f"{scene.name}: {result.engine} is judged")
            deadline = time.monotonic() + plan.patience / 10
            step = min(result.wall)
            last = 1 if scene.links else 0  # what swings is judged by a step, from pose to pose
            while (left := min(total, LONGEST_JUDGED) - last - round(result.seconds / DT)) > 0:
                if time.monotonic() > deadline:
                    break
                count = min(left, 1 + int(PIECE / max(step, 1e-6)))
                worker.ask("run", count)
                result.seconds += count * DT
            before = worker.ask("poses") if last else None
            if last:
                worker.ask("run", last)
                result.seconds += last * DT
            positions, orientations = worker.ask("poses")
            from atlasphys.bench import quality

            result.quality = quality.judge(scene, result.seconds, positions, orientations, before)

        attempt(prepare, names)
        for k in range(plan.rounds):
            report(f"{scene.name}: round {k + 1} of {plan.rounds}")
            turned = k % len(names)
            attempt(take_turn, [*names[turned:], *names[:turned]])
        attempt(judge, names)
    compare(results)
    return results


PIECE = 2.0
"""Wall time of a piece of steps that are not measured, about [s]."""

LONGEST_JUDGED = round(60.0 / DT)
"""Scenes are judged after no more steps than this, if they have not been measured for longer."""


def compare(results: list[Result]) -> None:
    """Fill in the ratios of one scene's results to the first's: above 1, the first is faster."""
    ours = results[0].wall
    for result in results:
        if result.wall and len(result.wall) == len(ours):
            result.median_ratio = statistics.median(their / our for their, our in zip(result.wall, ours, strict=True))
            result.min_ratio = min(result.wall) / min(ours)


def memory(names: Sequence[str], plan: Plan, report: Report = lambda _: None, scene: str = "boxes_5000_walls") -> Any:
    """Memory per body of a settled pile, beyond what the same process had with a pile of eight [bytes].

    Raises:
        InvalidArgumentError: the operating system does not tell.
    """
    if not sys.platform.startswith("linux"):
        raise InvalidArgumentError(f"--memory reads /proc, which only Linux has (this is {sys.platform})")
    pile, small = make(scene), make("pile_8")
    rows = []
    for name in names:
        report(f"{scene}: memory of {name}")
        row: dict[str, Any] = {"scene": scene, "engine": name, "bodies": len(pile.bodies)}
        try:
            with Worker(name, plan) as worker:
                sizes = []
                for built in (small, pile):
                    worker.ask("build", built)
                    worker.ask("run", plan.of(built)[0])
                    sizes.append(worker.ask("memory"))
            beyond = sizes[1] - sizes[0]
            row |= {"empty_bytes": sizes[0], "bytes_per_body": round(beyond / len(pile.bodies)), "fault": ""}
        except NoAnswerError as failure:
            row |= {"empty_bytes": None, "bytes_per_body": None, "fault": str(failure)}
        rows.append(row)
    return rows


def as_json(result: Result) -> dict[str, Any]:
    """A result with everything that was measured, in plain values."""
    plain = asdict(result)
    plain["quality"] = result.quality._asdict() if result.quality else None
    return plain | result.row()
