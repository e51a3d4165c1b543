"""Sequential impulses: projected Gauss–Seidel on the accumulated impulses of all contact points.

Each contact point asks that the bodies do not approach along the normal, v_n ≥ target, with an impulse λ ≥ 0 that acts only
where the condition is tight, and that friction opposes sliding within Coulomb's cone |λ_t| ≤ μ λ_n. One after another each point's
impulse is changed by what would satisfy it alone, Δλ = −(v_n − target) / k with k = n · (M_a⁻¹ + M_b⁻¹) n, the *accumulated*
impulse is clamped, and the difference is applied to both bodies at once. Swept often enough this converges to the solution of
the whole system; starting from last step's impulses (warm starting) makes few sweeps enough for what rests.

Sources: the normal impulse is derived in docs/solver.md; E. Catto, "Iterative Dynamics with Temporal Coherence" (2005) for
accumulated clamping and warm starting; Moreau (1988) for the contact law. Positions are corrected by projection.py or, with
Baumgarte's velocity bias (Baumgarte 1972), here.
"""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from atlasphys.engine.jit import kernel, routine
from atlasphys.engine.math import mat, vec
from atlasphys.engine.solvers.common import (
    invert_2x2,
    load_inverse_mass,
    load_velocity,
    relative_velocity,
    solve_disk,
    store_velocity,
    weighted,
)
from atlasphys.engine.solvers.integrate import integrate_positions, integrate_velocities, place_origins
from atlasphys.engine.solvers.projection import project_positions
from atlasphys.engine.state.state import State


@dataclass(frozen=True, slots=True)
class SequentialImpulse:
    """Settings of the solver ``sequential_impulse``.

    Attributes:
        iterations: sweeps over all contacts for velocities. More: stiffer stacks, in proportion slower.
        position_correction: ``"projection"`` moves and turns overlapping bodies apart after the velocities are done, without
            touching their speed; ``"baumgarte"`` adds to the contact's target speed instead, which is cheaper but gives the bodies
            that speed to keep.
        position_iterations: sweeps of the projection.
        correction: share of the overlap beyond the slop that is removed per sweep of the projection, or per step by Baumgarte's
            bias. Larger: faster, and less stable.
        warm_starting: start from the impulses of the last step. Without it, tall stacks sag and creep.
    """

    iterations: int = 10
    position_correction: Literal["projection", "baumgarte"] = "projection"
    position_iterations: int = 4
    correction: float = 0.2
    warm_starting: bool = True


# Columns of a point's constraint row.
ANGULAR_A, ANGULAR_B = 0, 3  # I_a⁻¹ (r_a × n), I_b⁻¹ (r_b × n)
NORMAL_MASS, TARGET = 6, 7  # 1 / k; least relative normal velocity asked for
FRICTION_INVERSE = 8  # 8–10 inverse of the 2×2 tangent matrix, 11 inverse of its greatest eigenvalue
FRICTION_1, FRICTION_2 = 12, 13  # accumulated friction impulse along the two tangents
APPROACH = 14  # relative normal velocity before this step's forces
POINT_COLUMNS = 16

# Columns of a manifold's frame row.
TANGENT_1, TANGENT_2 = 0, 3
ROLLING_INVERSE = 6  # 6–8 inverse of the 2×2 rolling matrix, 9 inverse of its greatest eigenvalue
TORSIONAL_MASS = 10
ROLLING_1, ROLLING_2 = 11, 12  # accumulated rolling impulse along the two tangents
FRAME_COLUMNS = 16


@routine
def prepare(bodies, colliders, manifolds, count, frames, points, ratio):
    """Effective masses of every contact point, tangents, and last step's impulses scaled by ``ratio`` (0: start from none)."""
    for i in range(count):
        a, b = colliders.body[manifolds.a[i]], colliders.body[manifolds.b[i]]
        m_a, i_a = load_inverse_mass(bodies, a)
        m_b, i_b = load_inverse_mass(bodies, b)
        v_a, w_a = load_velocity(bodies, a)
        v_b, w_b = load_velocity(bodies, b)
        m = vec.add(m_a, m_b)
        n = vec.load(manifolds.normal, i)
        t1, t2 = vec.tangents(n)
        frame = frames[i]
        for k in range(3):
            frame[TANGENT_1 + k], frame[TANGENT_2 + k] = t1[k], t2[k]
        m11, m12, m22 = vec.dot(t1, weighted(m, t1)), vec.dot(t1, weighted(m, t2)), vec.dot(t2, weighted(m, t2))
        m_n = vec.dot(n, weighted(m, n))
        for k in range(manifolds.count[i]):
            point = points[i, k]
            r_a, r_b = vec.load(manifolds.anchor_a[i], k), vec.load(manifolds.anchor_b[i], k)
            arm_a, arm_b = vec.cross(r_a, n), vec.cross(r_b, n)
            angular_a, angular_b = mat.sym_mul_vec(i_a, arm_a), mat.sym_mul_vec(i_b, arm_b)
            for j in range(3):
                point[ANGULAR_A + j], point[ANGULAR_B + j] = angular_a[j], angular_b[j]
            mass = m_n + vec.dot(arm_a, angular_a) + vec.dot(arm_b, angular_b)
            point[NORMAL_MASS] = 1 / mass if mass > 0 else 0
            arm_a1, arm_b1, arm_a2, arm_b2 = vec.cross(r_a, t1), vec.cross(r_b, t1), vec.cross(r_a, t2), vec.cross(r_b, t2)
            turn_a2, turn_b2 = mat.sym_mul_vec(i_a, arm_a2), mat.sym_mul_vec(i_b, arm_b2)
            inverse = invert_2x2(
                m11 + vec.dot(arm_a1, mat.sym_mul_vec(i_a, arm_a1)) + vec.dot(arm_b1, mat.sym_mul_vec(i_b, arm_b1)),
                m12 + vec.dot(arm_a1, turn_a2) + vec.dot(arm_b1, turn_b2),
                m22 + vec.dot(arm_a2, turn_a2) + vec.dot(arm_b2, turn_b2),
            )
            for j in range(4):
                point[FRICTION_INVERSE + j] = inverse[j]
            point[APPROACH] = vec.dot(n, relative_velocity(v_a, w_a, r_a, v_b, w_b, r_b))
            manifolds.normal_impulse[i, k] *= ratio
            friction = vec.scale(vec.load(manifolds.friction_impulse[i], k), ratio)
            point[FRICTION_1], point[FRICTION_2] = vec.dot(friction, t1), vec.dot(friction, t2)
        material = manifolds.material[i]
        if material[2] > 0 or material[3] > 0:
            s_a1, s_b1 = mat.sym_mul_vec(i_a, t1), mat.sym_mul_vec(i_b, t1)
            s_a2, s_b2 = mat.sym_mul_vec(i_a, t2), mat.sym_mul_vec(i_b, t2)
            s1, s2 = vec.add(s_a1, s_b1), vec.add(s_a2, s_b2)
            inverse = invert_2x2(vec.dot(t1, s1), vec.dot(t1, s2), vec.dot(t2, s2))
            for j in range(4):
                frame[ROLLING_INVERSE + j] = inverse[j]
            twist = vec.dot(n, vec.add(mat.sym_mul_vec(i_a, n), mat.sym_mul_vec(i_b, n)))
            frame[TORSIONAL_MASS] = 1 / twist if twist > 0 else 0
            rolling = vec.scale(vec.load(manifolds.rolling_impulse, i), ratio)
            frame[ROLLING_1], frame[ROLLING_2] = vec.dot(rolling, t1), vec.dot(rolling, t2)
            manifolds.torsional_impulse[i] *= ratio
        else:
            frame[ROLLING_1] = frame[ROLLING_2] = 0
            manifolds.torsional_impulse[i] = 0


@routine
def bounce_speed(restitution, approach, acceleration, gap, h):
    """Speed of separation after an impact that happens within this step; negative if the bounce is too weak to be resolved.

    ``approach`` is the speed of approach at the start of the step, ``acceleration`` that at which it grows. Semi-implicit Euler in a
    uniform field keeps E = ½ v² + g y − ½ g h v, not ½ v² + g y. Impact speed S at gap 0 and speed u after the bounce at the present
    gap follow from that quantity, so that apexes fall by e² a bounce, with an error of second order in h instead of first:
    S² = s² + g h s + 2 g gap and ½ u² − ½ g h u + g gap = ½ e² S².
    """
    real = type(h)
    half_gain = real(0.5) * acceleration * h
    gap = max(gap, -approach * h)  # deeper than it could have come in a step: an overlap of other origin
    impact = approach * approach + real(2) * acceleration * gap + real(2) * half_gain * approach
    if not impact > 0:
        return real(-1)
    bounce = restitution * restitution * impact
    if bounce <= real(4) * half_gain * half_gain and acceleration != 0:
        return real(-1)
    return half_gain + math.sqrt(max(bounce + half_gain * half_gain - real(2) * acceleration * gap, real(0)))


@routine
def set_targets(bodies, colliders, manifolds, count, points, h, bias, slop, max_correction, threshold):
    """The least relative normal velocity that each point asks for, once this step's forces have acted."""
    real = type(h)
    for i in range(count):
        a, b = colliders.body[manifolds.a[i]], colliders.body[manifolds.b[i]]
        v_a, w_a = load_velocity(bodies, a)
        v_b, w_b = load_velocity(bodies, b)
        n = vec.load(manifolds.normal, i)
        restitution = manifolds.material[i, 1]
        for k in range(manifolds.count[i]):
            r_a, r_b = vec.load(manifolds.anchor_a[i], k), vec.load(manifolds.anchor_b[i], k)
            speed = vec.dot(n, relative_velocity(v_a, w_a, r_a, v_b, w_b, r_b))
            gap = -manifolds.depth[i, k]
            approach = -points[i, k, APPROACH]
            target = -gap / h if gap > 0 else bias * min(max(-gap - slop, real(0)), max_correction)
            if restitution > 0 and approach > threshold and gap + speed * h < 0:
                target = max(target, bounce_speed(restitution, approach, (-speed - approach) / h, gap, h))
            points[i, k, TARGET] = target


@routine
def warm_start(bodies, colliders, manifolds, count, frames, points):
    """Apply the impulses with which the iterations begin."""
    for i in range(count):
        a, b = colliders.body[manifolds.a[i]], colliders.body[manifolds.b[i]]
        m_a, i_a = load_inverse_mass(bodies, a)
        m_b, i_b = load_inverse_mass(bodies, b)
        v_a, w_a = load_velocity(bodies, a)
        v_b, w_b = load_velocity(bodies, b)
        n = vec.load(manifolds.normal, i)
        frame = frames[i]
        t1, t2 = (frame[0], frame[1], frame[2]), (frame[3], frame[4], frame[5])
        for k in range(manifolds.count[i]):
            point = points[i, k]
            impulse = vec.add(
                vec.scale(n, manifolds.normal_impulse[i, k]),
                vec.add(vec.scale(t1, point[FRICTION_1]), vec.scale(t2, point[FRICTION_2])),
            )
            v_a, v_b = vec.sub(v_a, weighted(m_a, impulse)), vec.add(v_b, weighted(m_b, impulse))
            w_a = vec.sub(w_a, mat.sym_mul_vec(i_a, vec.cross(vec.load(manifolds.anchor_a[i], k), impulse)))
            w_b = vec.add(w_b, mat.sym_mul_vec(i_b, vec.cross(vec.load(manifolds.anchor_b[i], k), impulse)))
        if manifolds.material[i, 2] > 0 or manifolds.material[i, 3] > 0:
            impulse = vec.add(
                vec.scale(n, manifolds.torsional_impulse[i]),
                vec.add(vec.scale(t1, frame[ROLLING_1]), vec.scale(t2, frame[ROLLING_2])),
            )
            w_a, w_b = vec.sub(w_a, mat.sym_mul_vec(i_a, impulse)), vec.add(w_b, mat.sym_mul_vec(i_b, impulse))
        store_velocity(bodies, a, v_a, w_a)
        store_velocity(bodies, b, v_b, w_b)


@routine
def sweep(bodies, colliders, manifolds, count, frames, points):
    """One Gauss–Seidel sweep: friction, then the normal impulses, which have the last word since they keep bodies apart."""
    for i in range(count):
        a, b = colliders.body[manifolds.a[i]], colliders.body[manifolds.b[i]]
        m_a, i_a = load_inverse_mass(bodies, a)
        m_b, i_b = load_inverse_mass(bodies, b)
        v_a, w_a = load_velocity(bodies, a)
        v_b, w_b = load_velocity(bodies, b)
        n = vec.load(manifolds.normal, i)
        frame, material = frames[i], manifolds.material[i]
        friction, rolling, torsional = material[0], material[2], material[3]
        t1, t2 = (frame[0], frame[1], frame[2]), (frame[3], frame[4], frame[5])
        push = n[0] - n[0]
        for k in range(manifolds.count[i]):
            push += manifolds.normal_impulse[i, k]

        if torsional > 0:
            limit = friction * torsional * push
            old = manifolds.torsional_impulse[i]
            new = old - frame[TORSIONAL_MASS] * vec.dot(n, vec.sub(w_b, w_a))
            new = min(max(new, -limit), limit)
            manifolds.torsional_impulse[i] = new
            impulse = vec.scale(n, new - old)
            w_a, w_b = vec.sub(w_a, mat.sym_mul_vec(i_a, impulse)), vec.add(w_b, mat.sym_mul_vec(i_b, impulse))
        if rolling > 0:
            spin = vec.sub(w_b, w_a)
            old1, old2 = frame[ROLLING_1], frame[ROLLING_2]
            inverse = (frame[6], frame[7], frame[8], frame[9])
            new1, new2 = solve_disk((old1, old2), (vec.dot(t1, spin), vec.dot(t2, spin)), inverse, rolling * push)
            frame[ROLLING_1], frame[ROLLING_2] = new1, new2
            impulse = vec.add(vec.scale(t1, new1 - old1), vec.scale(t2, new2 - old2))
            w_a, w_b = vec.sub(w_a, mat.sym_mul_vec(i_a, impulse)), vec.add(w_b, mat.sym_mul_vec(i_b, impulse))

        if friction > 0:
            for k in range(manifolds.count[i]):
                point = points[i, k]
                r_a, r_b = vec.load(manifolds.anchor_a[i], k), vec.load(manifolds.anchor_b[i], k)
                v = relative_velocity(v_a, w_a, r_a, v_b, w_b, r_b)
                old1, old2 = point[FRICTION_1], point[FRICTION_2]
                inverse = (point[8], point[9], point[10], point[11])
                limit = friction * manifolds.normal_impulse[i, k]
                new1, new2 = solve_disk((old1, old2), (vec.dot(t1, v), vec.dot(t2, v)), inverse, limit)
                point[FRICTION_1], point[FRICTION_2] = new1, new2
                impulse = vec.add(vec.scale(t1, new1 - old1), vec.scale(t2, new2 - old2))
                v_a, v_b = vec.sub(v_a, weighted(m_a, impulse)), vec.add(v_b, weighted(m_b, impulse))
                w_a = vec.sub(w_a, mat.sym_mul_vec(i_a, vec.cross(r_a, impulse)))
                w_b = vec.add(w_b, mat.sym_mul_vec(i_b, vec.cross(r_b, impulse)))

        for k in range(manifolds.count[i]):
            point = points[i, k]
            r_a, r_b = vec.load(manifolds.anchor_a[i], k), vec.load(manifolds.anchor_b[i], k)
            speed = vec.dot(n, relative_velocity(v_a, w_a, r_a, v_b, w_b, r_b))
            old = manifolds.normal_impulse[i, k]
            new = max(old - point[NORMAL_MASS] * (speed - point[TARGET]), n[0] - n[0])
            manifolds.normal_impulse[i, k] = new
            change = new - old
            impulse = vec.scale(n, change)
            v_a, v_b = vec.sub(v_a, weighted(m_a, impulse)), vec.add(v_b, weighted(m_b, impulse))
            w_a = vec.add_scaled(w_a, (point[0], point[1], point[2]), -change)
            w_b = vec.add_scaled(w_b, (point[3], point[4], point[5]), change)
        store_velocity(bodies, a, v_a, w_a)
        store_velocity(bodies, b, v_b, w_b)


@routine
def store_impulses(manifolds, count, frames, points):
    """Write friction and rolling impulses back as world vectors, and note which pairs touch."""
    for i in range(count):
        frame = frames[i]
        t1, t2 = (frame[0], frame[1], frame[2]), (frame[3], frame[4], frame[5])
        for k in range(manifolds.count[i]):
            point = points[i, k]
            impulse = vec.add(vec.scale(t1, point[FRICTION_1]), vec.scale(t2, point[FRICTION_2]))
            vec.store(manifolds.friction_impulse[i], k, impulse)
            if manifolds.normal_impulse[i, k] > 0 or manifolds.depth[i, k] >= 0:
                manifolds.touching[i] = True
        vec.store(
            manifolds.rolling_impulse, i, vec.add(vec.scale(t1, frame[ROLLING_1]), vec.scale(t2, frame[ROLLING_2]))
        )


@kernel
def solve(
    bodies, body_count, colliders, manifolds, count, frames, points, displacement,
    gravity, h, ratio, iterations, position_iterations, bias, position_rate, threshold, tolerances,
):  # fmt: skip
    """One step of length h for all bodies: velocities, then positions."""
    prepare(bodies, colliders, manifolds, count, frames, points, ratio)
    integrate_velocities(bodies, body_count, gravity, h)
    set_targets(bodies, colliders, manifolds, count, points, h, bias, tolerances.slop, tolerances.max_correction, threshold)
    warm_start(bodies, colliders, manifolds, count, frames, points)
    for _ in range(iterations):
        sweep(bodies, colliders, manifolds, count, frames, points)
    store_impulses(manifolds, count, frames, points)
    integrate_positions(bodies, body_count, h)
    project_positions(
        bodies, body_count, colliders, manifolds, count, points, displacement, position_iterations, position_rate, tolerances
    )
    place_origins(bodies, body_count)


def advance(state: State, settings: SequentialImpulse, h: float) -> None:
    """Advance all bodies by one step of length h [s]."""
    real = state.real.type
    environment = state.environment
    baumgarte = settings.position_correction == "baumgarte"
    capacity = max(state.next_count, 1)
    frames = np.empty((capacity, FRAME_COLUMNS), state.real)
    points = np.empty((capacity, 4, POINT_COLUMNS), state.real)
    solve(
        state.bodies, state.count, state.colliders, state.next_manifolds, state.next_count,
        frames, points, state.displacement,
        tuple(real(g) for g in environment.gravity),
        real(h),
        real(h / state.last_h if settings.warm_starting and state.last_h > 0 else 0.0),
        settings.iterations,
        0 if baumgarte else settings.position_iterations,
        real(settings.correction / h if baumgarte else 0.0),
        real(settings.correction),
        real(environment.restitution_threshold),
        state.tolerances,
    )  # fmt: skip
