"""Case 9: a block of height a and base b on an incline tips or slides.

It tips about its lower edge when the weight's line passes beyond it, tan θ = b/a, and slides at tan θ = μ. As the plane is tilted, what is reached
first happens.
"""

from __future__ import annotations

import math

import numpy as np

from atlasphys.validate.case import Case, MakeWorld
from atlasphys.validate.cases.incline import block_on_incline

HEIGHT, SECONDS = 1.0, 2.0


def settles(make_world: MakeWorld, slope: float, friction: float, base: float, dt: float) -> tuple[float, float]:
    """How far the block turns [rad] and how far it slides [m] in two seconds at tan θ = ``slope``."""
    world, block = block_on_incline(make_world, slope, friction, (base, HEIGHT, 1.0))
    start, turned = block.position, 0.0
    at_first = block.orientation
    for _ in range(round(SECONDS / dt)):
        world.step(dt)
        turned = 2 * math.acos(min(abs(float(at_first @ block.orientation)), 1.0))
        if turned > 0.5:
            break
    return turned, float(np.linalg.norm(block.position - start))


def tipping_slope(make_world: MakeWorld, base: float, dt: float) -> float:
    """tan θ at which a block with plenty of friction begins to tip, by bisection to 0.1 %."""
    low, high = 0.9 * base / HEIGHT, 1.1 * base / HEIGHT
    while high - low > 1e-3 * base / HEIGHT:
        middle = 0.5 * (low + high)
        turned, _ = settles(make_world, middle, 2.0 * base / HEIGHT, base, dt)
        low, high = (low, middle) if turned > 0.1 else (middle, high)
    return 0.5 * (low + high)


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Find the slope at which blocks tip, and see which of both comes first where μ is near b/a."""
    errors = {}
    for base in (0.3, 0.6):
        errors[f"tan θ of tipping, b/a = {base:g}"] = abs(tipping_slope(make_world, base, dt) / base - 1)
    wrong = 0
    for base, friction in ((0.4, 0.38), (0.4, 0.42)):
        turned, slid = settles(make_world, 1.03 * min(base, friction), friction, base, dt)
        tips = base / HEIGHT < friction
        wrong += (turned > 0.1) != tips or (not tips and slid < 0.01)
    errors["wrong order of tipping and sliding [cases]"] = float(wrong)
    return errors


CASE = Case(
    number=9,
    name="tipping or sliding",
    law="tips first iff b/a < μ, at tan θ = b/a",
    measure=measure,
    tolerances={
        "tan θ of tipping, b/a = 0.3": 0.02,
        "tan θ of tipping, b/a = 0.6": 0.02,
        "wrong order of tipping and sliding [cases]": 0.0,
    },
)
