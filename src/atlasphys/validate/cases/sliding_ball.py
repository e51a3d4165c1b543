"""Case 8: a ball that slides at first comes to roll.

Friction μ m g slows the ball, v = v0 − μ g t, and spins it up, R ω = (5/2) μ g t. They meet at t = 2 v0/(7 μ g), where v = 5 v0/7 and
x = 12 v0²/(49 μ g); from then on it rolls on at that speed. (L about a point of the ground is constant, whatever the friction.)
"""

from __future__ import annotations

import numpy as np

import atlasphys as ap
from atlasphys.validate.case import Case, Curve, G, MakeWorld, record, relative
from atlasphys.world.body import Body
from atlasphys.world.world import World

RADIUS, SPEED, FRICTION = 0.5, 5.0, 0.2
TIME = 2 * SPEED / (7 * FRICTION * G)
DISTANCE = 12 * SPEED**2 / (49 * FRICTION * G)


def sliding(make_world: MakeWorld) -> tuple[World, Body]:
    """A ball on the ground, sent off without spin."""
    world = make_world(gravity=(0, -G, 0))
    world.add(ap.Plane(normal=(0, 1, 0)), friction=FRICTION)
    return world, world.add(
        ap.Sphere(radius=RADIUS), position=(0, RADIUS, 0), velocity=(SPEED, 0, 0), friction=FRICTION
    )


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Send a ball off without spin, and follow it until it has rolled for a second."""
    world, ball = sliding(make_world)
    times, path, slipping = [0.0], [0.0], 0.0
    while world.time < TIME + 1:
        world.step(dt)
        times.append(world.time)
        path.append(float(ball.position[0]))
        if ball.velocity[0] + RADIUS * ball.angular_velocity[2] > 1e-4:
            slipping = world.time
    # The last step that still slips ends within one step before rolling begins.
    late = max(slipping - TIME, TIME - slipping - dt, 0.0)
    return {
        "speed": relative(ball.velocity[0], 5 * SPEED / 7),
        "time": late / TIME,
        "distance": relative(float(np.interp(TIME, times, path)), DISTANCE),
    }


def curve(make_world: MakeWorld, dt: float) -> Curve:
    """Speed at which the ball slips: 0 once it rolls."""
    world, ball = sliding(make_world)
    times, slips = record(world, dt, TIME + 0.5, lambda: ball.velocity[0] + RADIUS * ball.angular_velocity[2])
    return Curve("slip [m/s]", times, slips, SPEED * (1 - times / TIME).clip(0))


CASE = Case(
    number=8,
    name="sliding ball",
    law="rolls at 5 v0/7 from t = 2 v0/(7 μ g), x = 12 v0²/(49 μ g)",
    measure=measure,
    tolerances={"speed": 0.01, "time": 0.01, "distance": 0.01},
    orders={"distance": 1.0},
    curve=curve,
)
