"""What solvers note of their sweeps while a trace is asked for: speeds and impulses after each, and what they lack.

``sequential_impulse`` and ``avbd``, which are called from Python, have entries for their notes, or none (``note_sweep``, ``note_multipliers``).
The fused step of the others is compiled a second time, with notes in it, when the first trace is asked for (``note_pass``).
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from atlasphys.engine.jit import routine
from atlasphys.engine.math import vec
from atlasphys.engine.simd import LANES
from atlasphys.engine.solvers.contact_block import SLIDE, Fields
from atlasphys.engine.solvers.residuals import Sweep, live_points, normal_inverse_mass, normal_speed, point_residuals
from atlasphys.engine.state.blocks import COUNT, MANIFOLD
from atlasphys.engine.state.manifolds import (
    ANCHOR_A,
    ANCHOR_B,
    DEPTH,
    FRICTION,
    NORMAL,
    NORMAL_IMPULSE,
    POINT_COLUMNS,
    RESTITUTION,
    Manifolds,
)
from atlasphys.engine.state.state import State
from atlasphys.engine.state.work import BLOCKS_MANY, BLOCKS_ONE, NOTED

MOST_TRACED = 1000
"""Sweeps of a step that are noted at most."""

SOLVE, RELAX = 0, 1
"""Kinds of passes of a substep: the one before bodies move, and the one after it."""

PASSES = {"soft_step": ("solve", "relax"), "xpbd": ("positions", "velocities")}
"""What the solvers of the fused step call them."""

IMPULSE_ONE, IMPULSE_MANY = Fields(1).impulse, Fields(4).impulse


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
    normal_mass: npt.NDArray[Any],
    target: npt.NDArray[Any],
) -> list[Sweep]:
    """The notes of a step as records. w is the speed beyond the one that the point's constraint asks for, Baumgarte's bias included."""
    points = _Points(state, state.next_manifolds, state.next_count)
    mass = normal_mass[points.place].astype(np.float64)
    inverse_mass = np.where(mass > 0, 1 / np.where(mass > 0, mass, 1.0), 0.0)
    found = []
    for s, (motion, impulse) in enumerate(zip(motions, impulses[:, points.place].astype(np.float64), strict=True)):
        excess = points.speed(motion) - target[points.place]
        rubbed = np.hypot(impulse[:, 1], impulse[:, 2])
        residuals = point_residuals(excess, inverse_mass, impulse[:, 0], rubbed, points.friction, points.depth)
        found.append(Sweep(s, -1, residuals, motion, impulse))
    return found


@routine
def note_multipliers(motions, impulses, s, motion, body_count, manifolds, count):
    """The same as ``note_sweep``, with friction as vectors of the world: their size."""
    for i in range(body_count):
        for k in range(6):
            motions[s, i, k] = motion[i, k]
    for i in range(count):
        for k in range(manifolds.count[i]):
            p = 4 * i + k
            impulses[s, p, 0] = manifolds.points[i, POINT_COLUMNS * k + NORMAL_IMPULSE]
            impulses[s, p, 1] = vec.length(vec.load_columns(manifolds.friction_impulse, i, 3 * k))
            impulses[s, p, 2] = 0


@routine
def note_blocks(s, stop, impulse, integers, blocks, noted):
    """Copy the impulses of contacts in blocks: those along the normal begin at the field ``impulse``. Friction, which acts on the points of a pair
    together, is shared out as they are loaded."""
    for block in range(stop):
        for lane in range(LANES):
            number = integers[block, COUNT, lane]
            if number == 0:
                continue
            total = blocks[block, impulse, lane]
            for k in range(1, number):
                total += blocks[block, impulse + k, lane]
            share = type(total)(1) / total if total > 0 else total
            first = 4 * integers[block, MANIFOLD, lane]
            for k in range(number):
                pushed = blocks[block, impulse + k, lane]
                noted[s, first + k, 0] = pushed
                for t in range(2):
                    noted[s, first + k, 1 + t] = blocks[block, SLIDE + t, lane] * pushed * share


@routine
def note_pass(kind, substep, motion, work):
    """Note a pass over all contacts of the fused step."""
    s = work.status[NOTED]
    if s < len(work.notes):
        work.status[NOTED] += 1
        work.notes[s, 0], work.notes[s, 1] = kind, substep
        for i in range(work.noted_motion.shape[1]):
            for k in range(12):
                work.noted_motion[s, i, k] = motion[i, k]
        note_blocks(s, work.status[BLOCKS_ONE], IMPULSE_ONE, work.integers_one, work.blocks_one, work.noted_impulses)
        note_blocks(
            s, work.status[BLOCKS_MANY], IMPULSE_MANY, work.integers_many, work.blocks_many, work.noted_impulses
        )


class _Points:
    """The contact points of a table of manifolds in double precision: who meets where."""

    def __init__(self, state: State, manifolds: Manifolds, count: int) -> None:
        m = manifolds
        self.rows, self.k = rows, k = live_points(m, count)
        self.place = 4 * rows + k
        self.a, self.b = state.colliders.body[m.a[rows]], state.colliders.body[m.b[rows]]
        self.normal = m.contact[rows, NORMAL : NORMAL + 3].astype(np.float64)
        columns = (POINT_COLUMNS * k)[:, None] + np.arange(3)
        self.arms = [m.points[rows[:, None], columns + anchor].astype(np.float64) for anchor in (ANCHOR_A, ANCHOR_B)]
        self.friction = m.contact[rows, FRICTION].astype(np.float64)
        self.bounces = m.contact[rows, RESTITUTION] > 0
        self.depth = m.points[rows, POINT_COLUMNS * k + DEPTH].astype(np.float64)

    def speed(self, motion: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
        """Speed along the normal at which b leaves a, for columns of velocities; for columns of displacements, how far it has gone."""
        return normal_speed(motion, self.a, self.b, self.arms, self.normal)


def passes(state: State, solver: str, h: float) -> list[Sweep]:
    """The notes of a step of the fused step with substeps of length h as records; the state is that at its end.

    w = v + max(g, 0) / h with the gap g at the time: the speed beyond the one that would close the gap within a substep. Points that nothing has
    pushed may come on between a substep's second pass and the next one's first. A contact that can bounce may part at any speed.
    """
    work = state.workspace.work
    points = _Points(state, state.manifolds, state.manifold_count)
    inverse_mass = normal_inverse_mass(state.bodies.inverse_mass, points.a, points.b, points.arms, points.normal)
    found = []
    for s in range(int(work.status[NOTED])):
        (kind, substep), motion = work.notes[s].tolist(), work.noted_motion[s]
        impulse = work.noted_impulses[s, points.place].astype(np.float64)
        gap = points.speed(motion[:, 6:12]) - points.depth
        excess = points.speed(motion[:, 0:6]) + np.maximum(gap, 0) / h
        free = points.bounces | ((kind == RELAX) & (gap > 0) & (impulse[:, 0] == 0))
        excess = np.where(points.bounces, np.minimum(excess, 0), np.where(free, np.maximum(excess, 0), excess))
        rubbed = np.hypot(impulse[:, 1], impulse[:, 2])
        residuals = point_residuals(excess, inverse_mass, impulse[:, 0], rubbed, points.friction, -gap)
        found.append(Sweep(s, -1, residuals, motion[:, 0:6].copy(), impulse, substep, PASSES[solver][kind]))
    return found
