"""What is compiled for worlds, in jobs that processes do at the same time: ``python -m atlasphys.warmup single detection response``.

``STEP`` are the large kernels of the default step, which do not depend on each other. ``WORLDS`` run worlds that need all the rest; that of the
default preset takes from the cache what the former left there.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial
from typing import Any

import atlasphys as ap
from atlasphys.engine import run
from atlasphys.engine.fused.detection import detection_address
from atlasphys.engine.fused.response import response_address, response_address_with_locks
from atlasphys.engine.fused.steps import run_steps
from atlasphys.engine.manifold import update_manifolds
from atlasphys.engine.solvers.sequential_impulse import SequentialImpulse, advance
from atlasphys.engine.solvers.soft_step import SoftStep
from atlasphys.engine.state.state import Environment, State

PRECISIONS = {"single": "f", "double": "d"}


def empty_state(precision: str) -> State:
    """A state without bodies."""
    state = State(PRECISIONS[precision], Environment((0.0, 0.0, 0.0), 1.0, 1.0, 0, 0))
    state.workspace = run.Workspace(state, "auto")
    return state


def compile_part(kernel: Callable[..., Any], precision: str) -> None:
    """Compile a part of the default step."""
    state = empty_state(precision)
    kernel(*run.tables(state), *_rest(state), run.NO_SYNC)


def compile_steps(precision: str) -> None:
    """Compile the default step itself."""
    state = empty_state(precision)
    arguments = (
        *run.tables(state),
        state.contacts,
        state.workspace.kept,
        0,
        *_rest(state),
        0,
        run.NO_SYNC,
    )
    run_steps(*arguments)


def _rest(state: State) -> tuple[Any, ...]:
    values = run.constants(state.real.char, state.environment, SoftStep(), 1 / 60, 0.0)
    return state.workspace.tree.fat, values, state.workspace.work


def compile_classic_solver(precision: str) -> None:
    """Compile the stages of the classic step from the manifolds on."""
    state = empty_state(precision)
    update_manifolds(state, 0)
    advance(state, SequentialImpulse(), 1.0)


def use_worlds(preset: str, precision: str) -> None:
    """Have worlds of a preset do what worlds can do, with a body of each shape, all of them touching each other."""
    settings: dict[str, Any] = {"preset": preset, "precision": precision}
    world = ap.World(**settings)
    world.add(ap.Plane())
    vertices = [(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]
    for shape in (
        ap.Sphere(radius=0.5),
        ap.Box(size=(1, 1, 1)),
        ap.Capsule(radius=0.3, length=0.5),
        ap.Cylinder(radius=0.5, length=1),
        ap.Cone(radius=0.5, height=1),
        ap.ConvexHull(points=[*vertices, (0, 0.8, 0)]),
    ):
        for shift in (0.0, 0.1):
            world.add(shape, position=(shift, 0.4 + shift, 0), rolling_friction=0.01, restitution=0.5)
    before = world.snapshot()
    world.step(1e-4)
    world.restore(before)
    world.step(1e-4)
    world.state_hash(), world.energy(), len(world.contacts)
    world.bodies.velocity[1] = (0.0, 1.0, 0.0)
    world.step(1e-4)
    if preset == "default":
        world.threads = 2
        world.step(1e-4)


STEP: dict[str, Callable[[str], None]] = {
    "response": partial(compile_part, response_address),
    "detection": partial(compile_part, detection_address),
    "steps": compile_steps,
    "response-with-locks": partial(compile_part, response_address_with_locks),
}
CLASSIC: dict[str, Callable[[str], None]] = {"classic-solver": compile_classic_solver}
WORLDS: dict[str, Callable[[str], None]] = {preset: partial(use_worlds, preset) for preset in ("default", "classic")}

if __name__ == "__main__":
    for job in sys.argv[2:]:
        (STEP | CLASSIC | WORLDS)[job](sys.argv[1])
