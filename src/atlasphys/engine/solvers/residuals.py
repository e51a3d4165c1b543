"""How far a state is from what the laws of contact ask: for every solver alike, from what it reports.

At a contact point with normal impulse λ ≥ 0, friction impulse λ_t and coefficient μ, let w be the speed beyond what the gap allows and k the
inverse of the mass that the contact feels, k = n · (M_a⁻¹ + M_b⁻¹) n. The laws are complementarity, 0 ≤ λ ⟂ w ≥ 0, and Coulomb's cone, |λ_t| ≤ μ
λ. What is missing from them:

- complementarity |min(w/k, λ)| [N s]: 0 where the point neither approaches nor, with an impulse, parts;
- cone max(0, |λ_t| − μ λ) [N s];
- work |λ w| [J].

(The natural residual of a complementarity problem: Facchinei and Pang, "Finite-Dimensional Variational Inequalities", 2003, §1.5.)

After a step of length h that began with a gap g0 and left the speed v along the normal, a gap may be closed, not more: w = v + max(g0, 0)/h. With
the gap g = g0 + h v at its end that is w = max(v, g/h): what pushes overlap out does not count against a contact. A contact that can bounce may
part at any speed.
"""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from atlasphys.engine.state.arrays import copy_rows
from atlasphys.engine.state.manifolds import (
    COLLISION_DEPTH,
    DEPTH,
    FRICTION,
    IS_RECYCLABLE,
    LOCAL_A,
    LOCAL_B,
    NORMAL,
    POINT_COLUMNS,
    RESTITUTION,
    Manifolds,
    live_rows,
)
from atlasphys.engine.state.pose import refresh
from atlasphys.engine.state.state import State

Doubles = npt.NDArray[np.float64]


class Residuals(NamedTuple):
    """What is missing from the laws of contact, a row for each contact point."""

    complementarity: Doubles
    """(n,) [N s]"""
    cone: Doubles
    """(n,) [N s]"""
    work: Doubles
    """(n,) [J]"""
    depth: Doubles
    """(n,) overlap [m]; negative where there is a gap."""


class Sweep(NamedTuple):
    """What a solver notes of one of its sweeps in ``State.trace``, if that is a list."""

    sweep: int
    """0 before the first."""
    colour: int
    """Colour of the contacts that were visited; −1: all."""
    residuals: Residuals
    motion: npt.NDArray[Any]
    """(bodies, 6) velocities and angular velocities after it."""
    impulse: Doubles | None = None
    """(n, 3) normal impulse and friction impulse along two tangents of each contact point [N s], if the solver notes them: since the
    step began, or with substeps since the substep began."""
    substep: int = 0
    """Of the sweep, for solvers that have substeps."""
    kind: str = "sweep"
    """What the solver calls it."""


def point_residuals(
    excess: Doubles,
    inverse_mass: Doubles,
    impulse: Doubles,
    friction_impulse: Doubles,
    friction: Doubles,
    depth: Doubles,
) -> Residuals:
    """Residuals of contact points from numbers.

    Args:
        excess: w, speed beyond what the gap allows [m/s], (n,).
        inverse_mass: k [1/kg], (n,); 0 where neither body can give way, which leaves no residual.
        impulse: λ [N s], (n,).
        friction_impulse: |λ_t| [N s], (n,).
        friction: μ, (n,).
        depth: overlap, passed on [m], (n,).
    """
    movable = inverse_mass > 0
    lacking = np.where(movable, excess / np.where(movable, inverse_mass, 1.0), 0.0)
    return Residuals(
        np.where(movable, np.abs(np.minimum(lacking, impulse)), 0.0),
        np.maximum(friction_impulse - friction * impulse, 0.0),
        np.abs(impulse * excess),
        depth,
    )


def contact_residuals(state: State) -> Residuals:
    """Residuals at the end of the last step, of all contact points. The state is left as it is."""
    m, count = state.manifolds, state.manifold_count
    rows, points = live_points(m, count)
    bodies = copy_rows(state.bodies)
    refresh(bodies, 0, state.count)  # in a copy: what steps derive from the state is theirs
    a, b = state.colliders.body[m.a[rows]], state.colliders.body[m.b[rows]]
    normal = m.contact[rows, NORMAL : NORMAL + 3].astype(np.float64)
    first = POINT_COLUMNS * points
    arms = []
    for body, column in ((a, LOCAL_A), (b, LOCAL_B)):
        rotation = bodies.geometry[body, :9].astype(np.float64).reshape(-1, 3, 3)
        local = m.local[rows[:, None], (first + column)[:, None] + np.arange(3)].astype(np.float64)
        arms.append((rotation @ local[:, :, None])[:, :, 0])
    speed = normal_speed(bodies.motion, a, b, arms, normal)
    apart = bodies.center[b] + arms[1] - bodies.center[a] - arms[0]
    recycled = m.reference[rows, IS_RECYCLABLE] > 0
    collided = np.where(recycled, m.local[rows, first + COLLISION_DEPTH], m.points[rows, first + DEPTH])
    gap = (apart * normal).sum(axis=1) - collided
    excess = np.maximum(speed, gap / state.last_h) if state.last_h > 0 else speed
    excess = np.where(m.contact[rows, RESTITUTION] > 0, np.minimum(excess, 0.0), excess)
    impulse = m.total[rows, points].astype(np.float64)
    # Friction that acts on the points of a pair together is shared out as they are loaded.
    whole = m.total[rows, :4].sum(axis=1, dtype=np.float64)
    share = np.where(whole > 0, impulse / np.where(whole > 0, whole, 1.0), 1 / m.count[rows])
    rubbed = m.friction_impulse[rows[:, None], 3 * points[:, None] + np.arange(3)] + m.total[rows, 4:7] * share[:, None]
    friction = m.contact[rows, FRICTION].astype(np.float64)
    inverse_mass = normal_inverse_mass(bodies.inverse_mass, a, b, arms, normal)
    return point_residuals(excess, inverse_mass, impulse, np.linalg.norm(rubbed, axis=1), friction, -gap)


def live_points(manifolds: Manifolds, count: int) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Manifold and number within it of every point in use, in the order of the pairs."""
    live = live_rows(manifolds, count)
    places, points = np.nonzero(np.arange(4) < manifolds.count[live, None])
    return live[places], points


def normal_speed(motion: npt.NDArray[Any], a: Any, b: Any, arms: list[Doubles], normal: Doubles) -> Doubles:
    """Speed along the normal at which b leaves a at points that lie at ``arms`` from their centres of mass."""
    moving = motion.astype(np.float64)
    velocity = moving[b, 0:3] + np.cross(moving[b, 3:6], arms[1]) - moving[a, 0:3] - np.cross(moving[a, 3:6], arms[0])
    speed: Doubles = (velocity * normal).sum(axis=1)
    return speed


def normal_inverse_mass(
    inverse_mass: npt.NDArray[Any], a: Any, b: Any, arms: list[Doubles], normal: Doubles
) -> Doubles:
    """k = n · (M_a⁻¹ + M_b⁻¹) n, from the column ``Bodies.inverse_mass``."""
    total = np.zeros(len(normal))
    for body, arm in zip((a, b), arms, strict=True):
        rows = inverse_mass[body].astype(np.float64)
        x, y, z = np.cross(arm, normal).T
        xx, yy, zz, xy, xz, yz = rows[:, 0:6].T
        total += (rows[:, 8:11] * normal**2).sum(axis=1)
        total += xx * x * x + yy * y * y + zz * z * z + 2 * (xy * x * y + xz * x * z + yz * y * z)
    return total
