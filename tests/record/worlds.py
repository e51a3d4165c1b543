"""A world whose bodies are put where a formula says: recordings need no physics."""

import numpy as np

import atlasphys as ap


def small_world(bodies: int = 3) -> ap.World:
    world = ap.World()
    for row in range(bodies):
        world.add(ap.Sphere(radius=0.5), name=f"ball {row}")
    return world


def expected_position(step: int, row: int) -> tuple[float, float, float]:
    return step + 0.25, float(row), step * 0.1 + row


def put(world: ap.World, step: int) -> None:
    """The state that stands for a step."""
    rows = range(len(world.bodies))
    world.bodies.position[:] = [expected_position(step, row) for row in rows]
    angle = 0.01 * step
    world.bodies.orientation[:] = np.array([np.cos(angle), np.sin(angle), 0, 0])
    world._state.time = step / 60
