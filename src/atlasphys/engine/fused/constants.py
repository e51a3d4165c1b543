"""Numbers of a run of the fused step, from the settings."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from atlasphys.engine.constants import SLEEP_SPEED
from atlasphys.engine.simd.by_address import by_address
from atlasphys.engine.solvers.bounce_block import FINEST
from atlasphys.engine.solvers.soft_step import SoftStep, softness
from atlasphys.engine.solvers.xpbd import XPBD
from atlasphys.engine.state.state import Environment, tolerances_of


@by_address
class Constants(NamedTuple):
    """Numbers of a run, in the world's precision."""

    h: float
    """Length of a substep [s]."""
    substeps: int
    slow: float
    """Speed below which a body counts as at rest [m/s]."""
    gravity: tuple[float, float, float]
    ratio: float
    """Factor on last step's impulses."""
    soft: tuple[float, float, float, float, float, float]
    """See solvers/soft_contact.py; zeros with another solver."""
    positions: tuple[float, float, float]
    """See ``solve_positions`` in solvers/xpbd_contact.py; zeros with another solver."""
    bounce: tuple[float, float, float, float, float]
    """Threshold [m/s], lengths of the step and of a substep [s], slop [m], finest relative error; see solvers/bounce_block.py."""
    recycling: tuple[float, float, float, float, float]
    """See manifold/recycle.py."""
    margin: float
    match_distance: float
    friction_rule: int
    restitution_rule: int
    joint_sweeps: int
    """Passes over the joints in a substep, before the relax pass."""


MOST_GROWTH = 4.0
"""By how much last step's impulses may be scaled up for a longer step; see solvers/sequential_impulse.py."""


FREQUENCY = 34 / 240
"""Frequency of contacts as a share of the number of substeps a second, if none is asked for: sag falls as the square of a substep."""


MOST_FREQUENCY = 0.15
"""Greatest frequency of contacts, as a share of the number of substeps a second. From 0.17 on pyramids jitter (docs/soft_step.md)."""


STATIC_STIFFENING = 1.0
"""Factor on the frequency of contacts with bodies that are not dynamic. With 2, which other engines use, pyramids jitter from two thirds of that
frequency on, and so their other contacts have to be softer."""


@lru_cache(maxsize=64)
def constants(
    precision: str, environment: Environment, settings: SoftStep | XPBD, h: float, last_h: float
) -> Constants:
    """The numbers of a run with steps of length h [s], after substeps of length ``last_h``, or 0; ``precision`` is NumPy's character for the
    world's."""
    real, tolerances = np.dtype(precision).type, tolerances_of(environment, precision)
    sub = h / settings.substeps
    unit = environment.length_unit
    threshold, fastest = environment.restitution_threshold, settings.push_out_speed * unit
    soft: tuple[float, ...] = (0.0,) * 6
    positions: tuple[float, ...] = (0.0,) * 3
    recycling = (-1.0, 0.0, 0.0, 0.0, 0.0)
    if isinstance(settings, XPBD):
        positions = (1 / sub, settings.compliance / sub**2, fastest)
        threshold = max(threshold, 2 * math.hypot(*environment.gravity) * sub)
        ratio = last_h / sub if last_h > 0 else 1.0
    else:
        frequency = FREQUENCY / sub
        if settings.contact_frequency > 0:
            frequency = min(settings.contact_frequency, MOST_FREQUENCY / sub)
        soft = (
            1 / sub,
            *softness(frequency, settings.contact_damping, sub),
            *softness(STATIC_STIFFENING * frequency, settings.contact_damping, sub),
            fastest,
        )
        if settings.contact_recycling:
            recycling = (
                (settings.recycle_slip * unit) ** 2,
                (2 * math.sin(settings.recycle_turn / 4)) ** 2,
                (2 * math.sin(settings.recycle_twist / 4)) ** 2,
                float(tolerances.margin),
                settings.recycle_speed * unit * h,
            )
        ratio = min(sub / last_h, MOST_GROWTH) if last_h > 0 else 1.0
        ratio = ratio if settings.warm_starting else 0.0
    bounce = (threshold, h, sub, float(tolerances.slop), FINEST[precision])
    return Constants(
        h=real(sub),
        substeps=settings.substeps,
        slow=real(SLEEP_SPEED * unit),
        gravity=tuple(real(g) for g in environment.gravity),
        ratio=real(ratio),
        soft=tuple(real(x) for x in soft),
        positions=tuple(real(x) for x in positions),
        bounce=tuple(real(x) for x in bounce),
        recycling=tuple(real(x) for x in recycling),
        margin=tolerances.margin,
        match_distance=real(tolerances.match_distance),
        friction_rule=environment.friction_rule,
        restitution_rule=environment.restitution_rule,
        joint_sweeps=settings.joint_sweeps if isinstance(settings, SoftStep) else 0,
    )
