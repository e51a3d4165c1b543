"""Case 28: momentum, angular momentum and energy of two hundred bodies that collide in empty space.

Contact impulses act in opposite pairs at common points, so P and L cannot change, whatever the material. Inelastic contacts
(e = 0) take energy, and so do frictionless ones of any e: with v⁺ = −e v⁻ along the normals the work of the impulses is
½ (v⁺ + v⁻) · λ ≤ 0. With both friction and restitution Newton's law of restitution can gain energy, a known fault of the law itself
(Kane and Levinson 1985; Stronge 1990), so that rise is reported but not judged.

A solver that recycles contacts takes the arms of pairs at rest relative to each other for constant. That costs angular momentum, which is judged by
itself; all else is measured with and without.
"""

from __future__ import annotations

import dataclasses

import numpy as np

import atlasphys as ap
from atlasphys.validate.case import Case, MakeWorld
from atlasphys.world.world import World

MATERIALS = ((0.0, 0.0), (0.0, 0.5), (0.5, 0.0), (1.0, 0.0), (0.5, 0.5))
"""(e, μ) of the runs."""

SEEDS = (6, 28)
"""Two sets of random poses for e = 1, which has no loss to spare and so shows every impulse not solved to the end; the last one otherwise."""

ROUND_OFF = 1e-12

RECYCLED = "angular momentum, contacts recycled"


def implosion(make_world: MakeWorld, restitution: float, friction: float, seed: int) -> World:
    """Boxes, spheres and capsules, apart at first, that fly and spin towards the middle."""
    world = make_world(gravity=(0, 0, 0))
    shapes = (
        ap.Box(size=(0.8, 0.5, 0.3)),
        ap.Sphere(radius=0.35),
        ap.Capsule(radius=0.2, length=0.5),
        ap.Box(size=(0.6, 0.6, 0.6)),
    )
    random = np.random.default_rng(seed)
    places = [(x, y, z) for x in range(6) for y in range(6) for z in range(6)][8:208]
    for i, place in enumerate(places):
        position = 1.1 * (np.array(place) - 2.5)
        world.add(
            shapes[i % len(shapes)],
            position=position,
            orientation=random.uniform(-1, 1, 4),
            velocity=-1.5 * position + random.uniform(-0.5, 0.5, 3),
            angular_velocity=random.uniform(-2, 2, 3),
            density=1000,
            restitution=restitution,
            friction=friction,
        )
    return world


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Run each material for two seconds. Momenta are relative to the sum of the bodies' own, energies to that at first."""
    errors = {"momentum": 0.0, "angular momentum": 0.0, RECYCLED: 0.0}
    for restitution, friction in MATERIALS:
        rise = 0.0
        for seed in SEEDS if restitution == 1 else SEEDS[-1:]:
            world = implosion(make_world, restitution, friction, seed)
            worlds = {"angular momentum": world}
            if getattr(world.solver_settings, "contact_recycling", False):
                exact = implosion(make_world, restitution, friction, seed)
                exact.solver = dataclasses.replace(world.solver_settings, contact_recycling=False)
                worlds = {"angular momentum": exact, RECYCLED: world}
            for name, world in worlds.items():
                off_momentum, off_spin, risen = follow(world, dt)
                errors["momentum"] = max(errors["momentum"], off_momentum)
                errors[name] = max(errors[name], off_spin)
                rise = max(rise, risen)
        errors[f"energy rise in a step, e = {restitution:g}, μ = {friction:g}"] = rise
    return errors


def follow(world: World, dt: float) -> tuple[float, float, float]:
    """Two seconds: changes of momentum and angular momentum, and the greatest rise of energy in a step."""
    mass = world.bodies.mass[:, None]
    momentum, spin, energy = world.momentum(), world.angular_momentum(), world.energy().kinetic
    momentum_scale = float(np.abs(mass * world.bodies.velocity).sum())
    spin_scale = float(np.abs(np.cross(world.bodies.position, mass * world.bodies.velocity)).sum())
    first, rise = energy, 0.0
    for _ in range(round(2 / dt)):
        world.step(dt)
        now = world.energy().kinetic
        rise, energy = max(rise, (now - energy) / first), now
    off_momentum, off_spin = world.momentum() - momentum, world.angular_momentum() - spin
    return float(np.abs(off_momentum).max()) / momentum_scale, float(np.abs(off_spin).max()) / spin_scale, rise


CASE = Case(
    number=28,
    name="conservation in a pile in empty space",
    law="P and L are constant; E never rises for e = 0, nor for any e without friction",
    measure=measure,
    tolerances={"momentum": ROUND_OFF, "angular momentum": ROUND_OFF, RECYCLED: 1e-3}
    | {
        f"energy rise in a step, e = {restitution:g}, μ = {friction:g}": ROUND_OFF
        for restitution, friction in MATERIALS
        if restitution == 0 or friction == 0
    },
    precision="double",
)
