"""Case 3: a sliding block comes to rest.

Friction μ m g is the only force along the ground, so v̇ = −μ g: the block stops after t = v/(μ g) and d = v²/(2 μ g). Semi-implicit
Euler moves with the velocity at the end of each step, so its d is short by ½ v h, a share of μ g h / v.
"""

from __future__ import annotations

import atlasphys as ap
from atlasphys.validate.case import Case, Curve, G, MakeWorld, record, relative
from atlasphys.world.body import Body
from atlasphys.world.world import World

SPEED, FRICTION = 5.0, 0.5
STOPPING_TIME = SPEED / (FRICTION * G)
STOPPING_DISTANCE = SPEED**2 / (2 * FRICTION * G)


def sliding_block(make_world: MakeWorld, x: float, z: float) -> tuple[World, Body]:
    """A square block on the ground that slides with SPEED along (x, 0, z)."""
    world = make_world(gravity=(0, -G, 0))
    world.add(ap.Plane(normal=(0, 1, 0)), friction=FRICTION)
    block = world.add(
        ap.Box(size=(1, 0.2, 1)), position=(0, 0.1, 0), velocity=(SPEED * x, 0, SPEED * z), friction=FRICTION
    )
    return world, block


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Slide along x until the block is at rest, and a second more."""
    world, block = sliding_block(make_world, 1, 0)
    stopped = 0.0
    while world.time < STOPPING_TIME + 1:
        world.step(dt)
        if block.velocity[0] > 1e-4:
            stopped = world.time
    # The last step that still moves ends within one step before the stop.
    late = max(stopped - STOPPING_TIME, STOPPING_TIME - stopped - dt, 0.0)
    return {"distance": relative(block.position[0], STOPPING_DISTANCE), "time": late / STOPPING_TIME}


def curve(make_world: MakeWorld, dt: float) -> Curve:
    """The way until half a second after the stop."""
    world, block = sliding_block(make_world, 1, 0)
    times, ways = record(world, dt, STOPPING_TIME + 0.5, lambda: block.position[0])
    sliding = times.clip(max=STOPPING_TIME)
    return Curve("distance [m]", times, ways, SPEED * sliding - 0.5 * FRICTION * G * sliding**2)


CASE = Case(
    number=3,
    name="sliding block",
    law="d = v²/(2 μ g), t = v/(μ g)",
    measure=measure,
    tolerances={"distance": 0.01, "time": 0.01},
    orders={"distance": 1.0},
    curve=curve,
)
