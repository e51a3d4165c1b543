"""Case 26: two cards that lean on each other.

Each card of length L and thickness t leans at α from the vertical; they touch along the upper edges of their inner faces. By symmetry the force
there is horizontal. Moments about a card's foot, the lower edge of that face, give H L cos α = m g (½ L sin α − ½ t cos α), and the ground
carries N = m g and has to hold H ≤ μ N: they stand iff μ ≥ ½ (tan α − t/L), for thin cards ½ tan α.
"""

from __future__ import annotations

import math

import numpy as np

import atlasphys as ap
from atlasphys.validate.case import Case, G, MakeWorld, turned_about_z

LENGTH, THICKNESS, SECONDS = 1.0, 0.02, 3.0
LEANS = (0.3, 0.5)
"""α [rad]."""

CARD_FRICTION = 1.0
"""Between the cards; more than tan α, so that they do not slide there whatever the normal of two edges that meet is taken to be."""


def sinks(make_world: MakeWorld, lean: float, friction: float, dt: float) -> float:
    """How far the cards sink in three seconds [m] on ground against which they have a coefficient of friction."""
    sine, cosine = round(math.sin(lean), 15), round(math.cos(lean), 15)
    world = make_world(gravity=(0, -G, 0))
    # The coefficients of two bodies make their geometric mean.
    world.add(ap.Plane(normal=(0, 1, 0)), friction=friction**2 / CARD_FRICTION)
    for side in (-1, 1):
        world.add(
            ap.Box(size=(THICKNESS, LENGTH, 0.6)),
            position=(
                side * 0.5 * (LENGTH * sine + THICKNESS * cosine),
                0.5 * (LENGTH * cosine + THICKNESS * sine),
                0,
            ),
            orientation=turned_about_z(side * lean),
            friction=CARD_FRICTION,
        )
    start = world.bodies.position[1:, 1].copy()
    world.run(seconds=SECONDS, dt=dt)
    return float(np.abs(world.bodies.position[1:, 1] - start).max())


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Give the ground 0.9 and 1.1 of the friction that the cards need."""
    errors = {}
    for lean in LEANS:
        least = 0.5 * (math.tan(lean) - THICKNESS / LENGTH)
        errors[f"sinks with 1.1 of the friction [m], α = {lean:g}"] = sinks(make_world, lean, 1.1 * least, dt)
        fallen = sinks(make_world, lean, 0.9 * least, dt) > 0.3 * LENGTH
        errors[f"stands with 0.9 of the friction [cases], α = {lean:g}"] = float(not fallen)
    return errors


CASE = Case(
    number=26,
    name="two cards",
    law="cards leaning at α from the vertical stand iff μ ≥ ½ tan α (thickness t: ½ (tan α − t/L))",
    measure=measure,
    tolerances={f"sinks with 1.1 of the friction [m], α = {lean:g}": 0.01 for lean in LEANS}
    | {f"stands with 0.9 of the friction [cases], α = {lean:g}": 0.0 for lean in LEANS},
)
