"""Case 18: a flat disc that spins to rest.

A disc of radius R that presses evenly on the ground rubs with τ = ∫ μ p r dA = ⅔ μ m g R, as a patch of effective radius 2R/3 does, and I = ½ m
R² comes to rest after t = I ω0/τ = 3 R ω0/(4 μ g), having turned by ½ ω0 t. The patch is tested with one contact point: a ball with a disc's
moments of inertia. A cylinder's four contact points on the rim rub with τ = μ m g R instead, and stop it after t = R ω0/(2 μ g).
"""

from __future__ import annotations

from typing import Any

import atlasphys as ap
from atlasphys.validate.case import Case, Curve, G, MakeWorld, record, relative
from atlasphys.world.body import Body
from atlasphys.world.world import World

RADIUS, SPIN, FRICTION, MASS = 0.5, 10.0, 0.3, 2.0
PATCH_TIME = 3 * RADIUS * SPIN / (4 * FRICTION * G)
RIM_TIME = RADIUS * SPIN / (2 * FRICTION * G)


def spinning(make_world: MakeWorld, *, rim: bool) -> tuple[World, Body]:
    """A disc that spins about the vertical, on its patch or on its rim."""
    world = make_world(gravity=(0, -G, 0))
    world.add(ap.Plane(normal=(0, 1, 0)), friction=FRICTION)
    square = MASS * RADIUS**2
    moving: dict[str, Any] = {"angular_velocity": (0, SPIN, 0), "mass": MASS, "friction": FRICTION}
    if rim:
        return world, world.add(ap.Cylinder(radius=RADIUS, length=0.2), position=(0, 0.1, 0), **moving)
    inertia = (square / 4, square / 2, square / 4)
    patch: dict[str, Any] = {"inertia": inertia, "torsional_friction": 2 * RADIUS / 3}
    return world, world.add(ap.Sphere(radius=RADIUS), position=(0, RADIUS, 0), **patch, **moving)


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Let both spin to rest, and half a second more."""
    errors = {}
    for name, expected in (("patch", PATCH_TIME), ("rim", RIM_TIME)):
        world, disc = spinning(make_world, rim=name == "rim")
        stopped = turned = 0.0
        while world.time < expected + 0.5:
            world.step(dt)
            spin = float(disc.angular_velocity[1])
            turned += dt * spin
            if spin > 1e-3:
                stopped = world.time
        # The last step that still turns ends within one step before the stop.
        errors[f"stopping time, {name}"] = max(stopped - expected, expected - stopped - dt, 0.0) / expected
        errors[f"angle, {name}"] = relative(turned, 0.5 * SPIN * expected)
    return errors


def curve(make_world: MakeWorld, dt: float) -> Curve:
    """Angular velocity on the patch."""
    world, disc = spinning(make_world, rim=False)
    times, spins = record(world, dt, PATCH_TIME + 0.5, lambda: disc.angular_velocity[1])
    return Curve("angular velocity [rad/s]", times, spins, SPIN * (1 - times / PATCH_TIME).clip(0))


CASE = Case(
    number=18,
    name="disc spinning to rest",
    law="stops at t = 3 R ω0/(4 μ g) on a patch of radius 2R/3, at R ω0/(2 μ g) on four points of the rim",
    measure=measure,
    tolerances={f"{error}, {name}": 0.02 for error in ("stopping time", "angle") for name in ("patch", "rim")},
    curve=curve,
)
