"""What ``sequential_impulse`` notes of its sweeps while a trace is asked for: speeds and impulses after each, and what they lack."""

from typing import Any

import numpy as np
import numpy.typing as npt

from atlasphys.engine.jit import routine
from atlasphys.engine.solvers.residuals import Sweep, live_points, normal_speed, point_residuals
from atlasphys.engine.state.manifolds import (
    ANCHOR_A,
    ANCHOR_B,
    DEPTH,
    FRICTION,
    NORMAL,
    NORMAL_IMPULSE,
    POINT_COLUMNS,
)
from atlasphys.engine.state.state import State

MOST_TRACED = 1000
"""Sweeps of a step that are noted at most."""


@routine
def note_sweep(motions, impulses, s, motion, body_count, manifolds, count, points, friction_column):
    """Copy the speeds of all bodies and the impulses of all contact points into entry s of the notes."""
    for i in range(body_count):
        for k in range(6):
            motions[s, i, k] = motion[i, k]
    for i in range(count):
        for k in range(manifolds.count[i]):
            p = 4 * i + k
            impulses[s, p, 0] = manifolds.points[i, POINT_COLUMNS * k + NORMAL_IMPULSE]
            impulses[s, p, 1], impulses[s, p, 2] = points[p, friction_column], points[p, friction_column + 1]


def sweeps(
    state: State,
    motions: npt.NDArray[Any],
    impulses: npt.NDArray[Any],
    pairs: npt.NDArray[np.int32],
    normal_mass: npt.NDArray[Any],
    target: npt.NDArray[Any],
) -> list[Sweep]:
    """The notes of a step as records. w is the speed beyond the one that the point's constraint asks for, Baumgarte's bias included."""
    m = state.next_manifolds
    rows, k = live_points(m, state.next_count)
    place = 4 * rows + k
    a, b = pairs[rows].T
    normal = m.contact[rows, NORMAL : NORMAL + 3].astype(np.float64)
    columns = (POINT_COLUMNS * k)[:, None] + np.arange(3)
    arms = [m.points[rows[:, None], columns + anchor].astype(np.float64) for anchor in (ANCHOR_A, ANCHOR_B)]
    mass = normal_mass[place].astype(np.float64)
    inverse_mass = np.where(mass > 0, 1 / np.where(mass > 0, mass, 1.0), 0.0)
    friction = m.contact[rows, FRICTION].astype(np.float64)
    depth = m.points[rows, POINT_COLUMNS * k + DEPTH].astype(np.float64)
    found = []
    for s, (motion, impulse) in enumerate(zip(motions, impulses[:, place].astype(np.float64), strict=True)):
        excess = normal_speed(motion, a, b, arms, normal) - target[place]
        rubbed = np.hypot(impulse[:, 1], impulse[:, 2])
        residuals = point_residuals(excess, inverse_mass, impulse[:, 0], rubbed, friction, depth)
        found.append(Sweep(s, -1, residuals, motion, impulse))
    return found
