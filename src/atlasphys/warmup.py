"""What is compiled for worlds, in jobs that processes do at the same time: ``python -m atlasphys.warmup single detection response``.

``STEP`` are the large kernels of the default step, which do not depend on each other, ``OTHERS`` what may take the place of
its solver. ``WORLDS`` run worlds that need all the rest; that of the
default preset takes from the cache what the former left there.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial
from typing import Any

import atlasphys as ap
from atlasphys.engine.fused import addresses
from atlasphys.engine.fused.bounce import bounce_address, bounce_address_with_locks
from atlasphys.engine.fused.constants import Constants, constants
from atlasphys.engine.fused.detection import detection_address
from atlasphys.engine.fused.generic import generic_address
from atlasphys.engine.fused.response import response_address, response_address_with_locks
from atlasphys.engine.fused.steps import run_steps
from atlasphys.engine.fused.workspace import Workspace
from atlasphys.engine.manifold import update_manifolds
from atlasphys.engine.solvers.sequential_impulse import SequentialImpulse, advance
from atlasphys.engine.solvers.soft_step import SoftStep
from atlasphys.engine.state.state import Environment, State

PRECISIONS = {"single": "f", "double": "d"}


def empty_state(precision: str) -> State:
    """A state without bodies."""
    state = State(PRECISIONS[precision], Environment((0.0, 0.0, 0.0), 1.0, 1.0, 0, 0))
    state.workspace = Workspace(state, "auto", "soft_step")
    return state


def compile_part(kernel: Callable[..., Any], precision: str) -> None:
    """Compile a part of the default step."""
    state = empty_state(precision)
    kernel(*addresses.part_arguments(state, _constants(state)))


def compile_steps(precision: str) -> None:
    """Compile the default step itself."""
    state = empty_state(precision)
    space = state.workspace
    before = (*addresses.tables(state), state.contacts, space.kept, 0)
    run_steps(*before, space.tree.fat, _constants(state), space.work, 0, addresses.NO_SYNC)


def _constants(state: State) -> Constants:
    return constants(state.real.char, state.environment, SoftStep(), 1 / 60, 0.0)


def compile_classic_solver(precision: str) -> None:
    """Compile the stages of the classic step from the manifolds on."""
    state = empty_state(precision)
    update_manifolds(state, 0)
    advance(state, SequentialImpulse(), 1.0)


def use_worlds(preset: str, precision: str) -> None:
    """Have worlds of a preset do what worlds can do, with a body of each shape, all of them touching each other, and one in flight."""
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
    world.add(ap.Sphere(radius=0.5), position=(9, 9, 9), velocity=(0, 100, 0))
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


def join_bodies(precision: str) -> None:
    """Have a default world step with joints that take a part of each type."""
    world = ap.World(precision=precision)
    a, b = (world.add(ap.Sphere(radius=0.5), position=(x, 0, 0)) for x in (-1.0, 1.0))
    for joint in (
        ap.Ball(a, b, anchor=(0, 0, 0), axis=(1, 0, 0), cone=1.0, twist=(-1, 1)),
        ap.Slider(a, b, anchor=(0, 0, 0), axis=(1, 0, 0), limits=(-1, 1)),
        ap.Wheel(a, b, anchor=(0, 0, 0), axis=(0, 1, 0), axle=(0, 0, 1)),
        ap.Distance(a, b, length=2.0),
        ap.Universal(a, b, anchor=(0, 0, 0), axis=(1, 0, 0), axis_b=(0, 1, 0)),
        ap.Gear(a, b, axis_a=(1, 0, 0), axis_b=(1, 0, 0)),
        ap.Pulley(a, b, ground_a=(-1, 2, 0), ground_b=(1, 2, 0)),
    ):
        world.join(joint)
    world.step(1e-4)


STEP: dict[str, Callable[[str], None]] = {
    "response": partial(compile_part, response_address),
    "detection": partial(compile_part, detection_address),
    "steps": compile_steps,
    "generic": partial(compile_part, generic_address),
    "bounce": partial(compile_part, bounce_address),
    "response-with-locks": partial(compile_part, response_address_with_locks),
    "bounce-with-locks": partial(compile_part, bounce_address_with_locks),
}
OTHERS: dict[str, Callable[[str], None]] = {
    addresses.job_of(kernel): partial(compile_part, kernel)
    for kernels in addresses.RESPONSES.values()
    for kernel in kernels
}
CLASSIC: dict[str, Callable[[str], None]] = {"classic-solver": compile_classic_solver}
WORLDS: dict[str, Callable[[str], None]] = {preset: partial(use_worlds, preset) for preset in ("default", "classic")}
WORLDS["joints"] = join_bodies

if __name__ == "__main__":
    for job in sys.argv[2:]:
        (OTHERS | STEP | CLASSIC | WORLDS)[job](sys.argv[1])
