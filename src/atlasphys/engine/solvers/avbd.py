"""Augmented vertex block descent: one body after another is moved to where its own energy is least."""

import math
from dataclasses import dataclass

import numpy as np

from atlasphys.engine.jit import kernel, routine
from atlasphys.engine.math import mat, quat, vec
from atlasphys.engine.math.ldlt import solve_6x6
from atlasphys.engine.shapes.arguments import invalid, number
from atlasphys.engine.solvers.common import (
    load_anchors,
    load_inverse_mass,
    load_velocity,
    relative_velocity,
    store_velocity,
    weighted,
)
from atlasphys.engine.solvers.integrate import integrate_positions, integrate_velocities, place_origins
from atlasphys.engine.solvers.sequential_impulse import (
    APPROACH,
    BOUNCE_SWEEPS,
    CONSTRAINT_COLUMNS,
    FINEST,
    MOST_GROWTH,
    MOST_ITERATIONS,
    PRECISION,
    TARGET,
    set_targets,
)
from atlasphys.engine.state.bodies import DYNAMIC
from atlasphys.engine.state.manifolds import (
    DEPTH,
    FRICTION,
    NORMAL,
    NORMAL_IMPULSE,
    PATCH_ROLLING,
    PATCH_TORSION,
    PENALTY,
    POINT_COLUMNS,
    ROLLING,
    TORSIONAL,
)
from atlasphys.engine.state.state import State


@dataclass(frozen=True, slots=True)
class AVBD:
    iterations: int = 10
    alpha: float = 0.95
    beta: float = 0.0
    carry: float = 1.0
    gamma: float = 0.5
    start: float = 3.0
    rest: float = 30.0
    most: float = 1e5
    tol: float = 3e-4
    tau: float = 1.0
    filt: float = 0.5
    decay: float = 1.0


EFFECTIVE_MASS = 0
ROLLING_PENALTY, TORSION_PENALTY = 0, 1


@routine
def prepare(motion, inverse_mass, pairs, manifolds, count, points, frames, ratio, gamma, start, rest, most):
    real = type(ratio)
    zero, one = real(0), real(1)
    contact, contact_points = manifolds.contact, manifolds.points
    for i in range(count):
        a, b = pairs[i, 0], pairs[i, 1]
        m_a, i_a = load_inverse_mass(inverse_mass, a)
        m_b, i_b = load_inverse_mass(inverse_mass, b)
        v_a, w_a = load_velocity(motion, a)
        v_b, w_b = load_velocity(motion, b)
        n = vec.load_columns(contact, i, NORMAL)
        linear = vec.dot(n, weighted(vec.add(m_a, m_b), n))
        for k in range(manifolds.count[i]):
            p = 4 * i + k
            r_a, r_b = load_anchors(contact_points, i, k)
            arm_a, arm_b = vec.cross(r_a, n), vec.cross(r_b, n)
            inverse = linear + vec.dot(arm_a, mat.sym_mul_vec(i_a, arm_a)) + vec.dot(arm_b, mat.sym_mul_vec(i_b, arm_b))
            mass = one / inverse if inverse > 0 else zero
            points[p, EFFECTIVE_MASS] = mass
            points[p, APPROACH] = vec.dot(n, relative_velocity(v_a, w_a, r_a, v_b, w_b, r_b))
            column = POINT_COLUMNS * k + PENALTY
            old = manifolds.local[i, column]
            manifolds.local[i, column] = min(max(gamma * old, (rest if old > 0 else start) * mass), most * mass)
            contact_points[i, POINT_COLUMNS * k + NORMAL_IMPULSE] *= ratio
            points[p, 1] = contact_points[i, POINT_COLUMNS * k + NORMAL_IMPULSE]
            f = vec.scale(vec.load_columns(manifolds.friction_impulse, i, 3 * k), ratio)
            vec.store_columns(manifolds.friction_impulse, i, 3 * k, vec.add_scaled(f, n, -vec.dot(n, f)))
        contact[i, PATCH_TORSION] *= ratio
        f = vec.scale(vec.load_columns(contact, i, PATCH_ROLLING), ratio)
        vec.store_columns(contact, i, PATCH_ROLLING, vec.add_scaled(f, n, -vec.dot(n, f)))
        if contact[i, ROLLING] > 0 or contact[i, TORSIONAL] > 0:
            trace = (i_a[0] + i_b[0]) + (i_a[1] + i_b[1]) + (i_a[2] + i_b[2])
            frames[i, 0] = real(30) / trace if trace > 0 else zero


@routine
def list_contacts(kind, body_count, pairs, count, first, entries):
    """The contacts of each body"""
    for i in range(body_count + 1):
        first[i] = 0
    for i in range(count):
        for side in range(2):
            first[pairs[i, side] + 1] += 1
    for i in range(body_count):
        first[i + 1] += first[i]
    for i in range(count):
        for side in range(2):
            body = pairs[i, side]
            entries[first[body]] = 2 * i + side
            first[body] += 1
    for i in range(body_count, 0, -1):
        first[i] = first[i - 1]
    first[0] = 0


@routine
def point_force(impulse, rubbed, penalty, friction, n, u, target):
    """Impulses on b: normal, friction, and share of the penalty that friction has."""
    zero = penalty - penalty
    speed = vec.dot(n, u)
    pressed = max(impulse - penalty * (speed - target), zero)
    wanted = vec.add_scaled(rubbed, vec.add_scaled(u, n, -speed), -penalty)
    limit = friction * pressed
    squared = vec.length_squared(wanted)
    share = type(zero)(1)
    if squared > limit * limit:
        share = limit / math.sqrt(squared)
    return pressed, vec.scale(wanted, share), share


@routine
def descend(i, motion, inertial, inertia, mass, inverse_mass, locks, pairs, manifolds, points, frames, first, entries):
    """Move body i to the least of its energy"""
    contact, contact_points, local = manifolds.contact, manifolds.points, manifolds.local
    v, w = load_velocity(motion, i)
    m = mass[i, 0]
    zero = m - m
    tensor = (inertia[i, 0], inertia[i, 1], inertia[i, 2], inertia[i, 3], inertia[i, 4], inertia[i, 5])
    target_v, target_w = load_velocity(inertial, i)
    force = vec.scale(vec.sub(target_v, v), m)
    torque = mat.sym_mul_vec(tensor, vec.sub(target_w, w))
    a = (m, m, m, zero, zero, zero)
    b = (zero, zero, zero, zero, zero, zero, zero, zero, zero)
    d = tensor
    for e in range(first[i], first[i + 1]):
        row, side = entries[e] >> 1, entries[e] & 1
        v_a, w_a = load_velocity(motion, pairs[row, 0])
        v_b, w_b = load_velocity(motion, pairs[row, 1])
        n = vec.load_columns(contact, row, NORMAL)
        friction = contact[row, FRICTION]
        s0 = sn = load = zero
        f = s1 = q1 = t = (zero, zero, zero)
        s2 = q2 = (zero, zero, zero, zero, zero, zero)
        for k in range(manifolds.count[row]):
            p = 4 * row + k
            r_a, r_b = load_anchors(contact_points, row, k)
            u = relative_velocity(v_a, w_a, r_a, v_b, w_b, r_b)
            penalty = local[row, POINT_COLUMNS * k + PENALTY]
            rubbed = vec.load_columns(manifolds.friction_impulse, row, 3 * k)
            impulse = contact_points[row, POINT_COLUMNS * k + NORMAL_IMPULSE]
            pressed, rubs, share = point_force(impulse, rubbed, penalty, friction, n, u, points[p, TARGET])
            if pressed > 0 or impulse > 0:
                load += pressed
                r = r_b if side == 1 else r_a
                push = vec.add_scaled(rubs, n, pressed)
                f = vec.add(f, push)
                t = vec.add(t, vec.cross(r, push))
                stick = penalty * share
                kr = vec.scale(r, stick)
                s0 += stick
                s1 = vec.add(s1, kr)
                s2 = (
                    s2[0] + kr[0] * r[0], s2[1] + kr[1] * r[1], s2[2] + kr[2] * r[2],
                    s2[3] + kr[0] * r[1], s2[4] + kr[0] * r[2], s2[5] + kr[1] * r[2],
                )
                if share < 1:
                    rest = penalty - stick
                    q = vec.cross(r, n)
                    kq = vec.scale(q, rest)
                    sn += rest
                    q1 = vec.add(q1, kq)
                    q2 = (
                        q2[0] + kq[0] * q[0], q2[1] + kq[1] * q[1], q2[2] + kq[2] * q[2],
                        q2[3] + kq[0] * q[1], q2[4] + kq[0] * q[2], q2[5] + kq[1] * q[2],
                    )
        a = (
            a[0] + s0 + sn * n[0] * n[0], a[1] + s0 + sn * n[1] * n[1], a[2] + s0 + sn * n[2] * n[2],
            a[3] + sn * n[0] * n[1], a[4] + sn * n[0] * n[2], a[5] + sn * n[1] * n[2],
        )
        b = (
            b[0] + q1[0] * n[0], b[1] + q1[0] * n[1] - s1[2], b[2] + q1[0] * n[2] + s1[1],
            b[3] + q1[1] * n[0] + s1[2], b[4] + q1[1] * n[1], b[5] + q1[1] * n[2] - s1[0],
            b[6] + q1[2] * n[0] - s1[1], b[7] + q1[2] * n[1] + s1[0], b[8] + q1[2] * n[2],
        )
        d = (
            d[0] + s2[1] + s2[2] + q2[0], d[1] + s2[0] + s2[2] + q2[1], d[2] + s2[0] + s2[1] + q2[2],
            d[3] - s2[3] + q2[3], d[4] - s2[4] + q2[4], d[5] - s2[5] + q2[5],
        )
        if contact[row, ROLLING] > 0 or contact[row, TORSIONAL] > 0:
            spin = vec.sub(w_b, w_a)
            moment, around, across = moment_of(contact, row, n, spin, frames[row, 0], load)
            t = vec.add(t, moment)
            rest = around - across
            d = (
                d[0] + across + rest * n[0] * n[0], d[1] + across + rest * n[1] * n[1],
                d[2] + across + rest * n[2] * n[2],
                d[3] + rest * n[0] * n[1], d[4] + rest * n[0] * n[2], d[5] + rest * n[1] * n[2],
            )
        if side == 1:
            force, torque = vec.add(force, f), vec.add(torque, t)
        else:
            force, torque = vec.sub(force, f), vec.sub(torque, t)
    if locks:
        one = type(zero)(1)
        x, y, z, rx, ry, rz = locks & 1, locks & 2, locks & 4, locks & 8, locks & 16, locks & 32
        force = (zero if x else force[0], zero if y else force[1], zero if z else force[2])
        torque = (zero if rx else torque[0], zero if ry else torque[1], zero if rz else torque[2])
        a = (
            one if x else a[0], one if y else a[1], one if z else a[2],
            zero if x or y else a[3], zero if x or z else a[4], zero if y or z else a[5],
        )
        d = (
            one if rx else d[0], one if ry else d[1], one if rz else d[2],
            zero if rx or ry else d[3], zero if rx or rz else d[4], zero if ry or rz else d[5],
        )
        b = (
            zero if rx or x else b[0], zero if rx or y else b[1], zero if rx or z else b[2],
            zero if ry or x else b[3], zero if ry or y else b[4], zero if ry or z else b[5],
            zero if rz or x else b[6], zero if rz or y else b[7], zero if rz or z else b[8],
        )
    dv, dw = solve_6x6(a, b, d, force, torque)
    store_velocity(motion, i, vec.add(v, dv), vec.add(w, dw))
    return max(abs(dv[0]), abs(dv[1]), abs(dv[2]), abs(dw[0]), abs(dw[1]), abs(dw[2]))


@routine
def moment_of(contact, row, n, spin, penalty, load):
    zero = load - load
    one = type(load)(1)
    speed = vec.dot(n, spin)
    wanted = contact[row, PATCH_TORSION] - penalty * speed
    limit = contact[row, FRICTION] * contact[row, TORSIONAL] * load
    around = one if abs(wanted) <= limit else limit / abs(wanted)
    roll = vec.add_scaled(vec.load_columns(contact, row, PATCH_ROLLING), vec.add_scaled(spin, n, -speed), -penalty)
    limit = contact[row, ROLLING] * load
    squared = vec.length_squared(roll)
    across = one if squared <= limit * limit else limit / math.sqrt(squared)
    return vec.add_scaled(vec.scale(roll, across), n, wanted * around), penalty * around, penalty * across


@routine
def update_multipliers(motion, pairs, manifolds, count, points, frames, growth, carry, speed, tau, most):
    contact, contact_points, local = manifolds.contact, manifolds.points, manifolds.local
    real = type(growth)
    error = real(0)
    for i in range(count):
        v_a, w_a = load_velocity(motion, pairs[i, 0])
        v_b, w_b = load_velocity(motion, pairs[i, 1])
        n = vec.load_columns(contact, i, NORMAL)
        load = growth - growth
        for k in range(manifolds.count[i]):
            p = 4 * i + k
            r_a, r_b = load_anchors(contact_points, i, k)
            u = relative_velocity(v_a, w_a, r_a, v_b, w_b, r_b)
            column = POINT_COLUMNS * k + PENALTY
            penalty = local[i, column]
            rubbed = vec.load_columns(manifolds.friction_impulse, i, 3 * k)
            impulse = contact_points[i, POINT_COLUMNS * k + NORMAL_IMPULSE]
            excess = vec.dot(n, u) - points[p, TARGET]
            pressed, rubs, share = point_force(
                impulse, rubbed, tau * penalty, contact[i, FRICTION], n, u, points[p, TARGET]
            )
            if pressed > 0 and excess < 0:
                mass = points[p, EFFECTIVE_MASS]
                wanted = min(carry * pressed / (speed + abs(points[p, APPROACH])), real(4) * penalty)
                local[i, column] = min(max(penalty - growth * mass * excess, wanted), most * mass)
            if pressed > 0 or impulse > 0:
                error = max(error, abs(excess) * points[p, PRECISION])
            load += pressed
            contact_points[i, POINT_COLUMNS * k + NORMAL_IMPULSE] = pressed
            vec.store_columns(manifolds.friction_impulse, i, 3 * k, rubs)
        if contact[i, ROLLING] > 0 or contact[i, TORSIONAL] > 0:
            moment, around, across = moment_of(contact, i, n, vec.sub(w_b, w_a), frames[i, 0], load)
            twist = vec.dot(n, moment)
            contact[i, PATCH_TORSION] = twist
            vec.store_columns(contact, i, PATCH_ROLLING, vec.add_scaled(moment, n, -twist))
    return error


@routine
def guess(bodies, body_count, pairs, manifolds, first, entries, gravity, h, inertial):
    """Adaptive initial guess."""
    motion = bodies.motion
    real = type(h)
    zero, one = real(0), real(1)
    strength = vec.length_squared(gravity)
    for i in range(body_count):
        for k in range(6):
            inertial[i, k] = motion[i, k]
        if bodies.kind[i] == DYNAMIC and strength > 0 and first[i] < first[i + 1] and bodies.response[i, 0] != 0:
            held = zero
            for e in range(first[i], first[i + 1]):
                row, side = entries[e] >> 1, entries[e] & 1
                n = vec.load_columns(manifolds.contact, row, NORMAL)
                total = (zero, zero, zero)
                for k in range(manifolds.count[row]):
                    push = manifolds.points[row, POINT_COLUMNS * k + NORMAL_IMPULSE]
                    total = vec.add(total, vec.add_scaled(vec.load_columns(manifolds.friction_impulse, row, 3 * k), n, push))
                along = vec.dot(total, gravity)
                held += along if side == 1 else -along
            share = -held * bodies.mass[i, 1] / (h * strength * bodies.response[i, 0])
            share = min(max(share, zero), one)
            for k in range(3):
                if bodies.inverse_mass[i, 8 + k] > 0:
                    motion[i, k] -= share * h * bodies.response[i, 0] * gravity[k]


@kernel
def solve(
    bodies, body_count, colliders, manifolds, count, pairs, points, frames, first, entries, inertial, inertia,
    gravity, h, ratio, iterations, bias, growth, carry, speed, tau, gamma, start, rest, most, filt, tol, threshold, finest, tolerances,
):  # fmt: skip
    """One step of length h for all bodies."""
    motion, inverse_mass = bodies.motion, bodies.inverse_mass
    for i in range(count):
        pairs[i, 0], pairs[i, 1] = colliders.body[manifolds.a[i]], colliders.body[manifolds.b[i]]
    list_contacts(bodies.kind, body_count, pairs, count, first, entries)
    prepare(motion, inverse_mass, pairs, manifolds, count, points, frames, ratio, gamma, start, rest, most)
    integrate_velocities(bodies, body_count, gravity, h)
    set_targets(
        motion, pairs, manifolds, count, points, h, bias, tolerances.slop, tolerances.max_correction, threshold, finest
    )
    guess(bodies, body_count, pairs, manifolds, first, entries, gravity, h, inertial)
    mass = bodies.mass
    for i in range(body_count):
        if bodies.kind[i] == DYNAMIC:
            axes = quat.matrix(quat.mul(quat.load(bodies.orientation, i), quat.load(bodies.principal, i)))
            tensor = mat.rotated_diagonal(axes, (mass[i, 2], mass[i, 3], mass[i, 4]))
            for k in range(6):
                inertia[i, k] = tensor[k]
    for s in range(BOUNCE_SWEEPS * iterations):
        change = h - h
        for j in range(2 * body_count):
            i = j if j < body_count else 2 * body_count - 1 - j
            if bodies.kind[i] == DYNAMIC and first[i] < first[i + 1]:
                moved = descend(
                    i, motion, inertial, inertia, mass, inverse_mass, bodies.locks[i], pairs, manifolds, points, frames, first, entries
                )
                change = max(change, moved)
        error = update_multipliers(motion, pairs, manifolds, count, points, frames, growth, carry, speed, tau, most)
        if error <= 1 and (s + 1 >= iterations or change <= tol):
            manifolds.contact[0,15] = s
            break
    for i in range(count):
        for k in range(manifolds.count[i]):
            c = POINT_COLUMNS * k
            if manifolds.points[i, c + NORMAL_IMPULSE] > 0 or manifolds.points[i, c + DEPTH] >= 0:
                manifolds.touching[i] = True
        for k in range(4):
            c = POINT_COLUMNS * k + NORMAL_IMPULSE
            manifolds.total[i, k] = manifolds.points[i, c]
            if k < manifolds.count[i]:
                manifolds.points[i, c] += (points[4 * i + k, 1] - manifolds.points[i, c]) * filt
        manifolds.total[i, 7] = manifolds.contact[i, PATCH_TORSION]
    integrate_positions(bodies, body_count, h)
    place_origins(bodies, body_count)


def advance(state: State, settings: AVBD, h: float) -> None:
    """Advance all bodies by one step of length h [s]."""
    real = state.real.type
    environment = state.environment
    capacity = max(state.next_count, 1)
    points = np.empty((4 * capacity, CONSTRAINT_COLUMNS), state.real)
    frames = np.empty((capacity, 2), state.real)
    pairs = np.empty((capacity, 2), np.int32)
    first = np.zeros(state.count + 2, np.int32)
    entries = np.zeros(2 * capacity, np.int32)
    inertial = np.zeros((state.count + 1, 6), state.real)
    inertia = np.zeros((state.count + 1, 6), state.real)
    solve(
        state.bodies, state.count, state.colliders, state.next_manifolds, state.next_count,
        pairs, points, frames, first, entries, inertial, inertia,
        tuple(real(g) for g in environment.gravity),
        real(h),
        real(settings.decay * min(h / state.last_h, MOST_GROWTH) if state.last_h > 0 else 0.0),
        settings.iterations,
        real((1 - settings.alpha) / h),
        real(settings.beta * h / float(state.tolerances.slop)),
        real(settings.carry),
        real(h * np.linalg.norm(environment.gravity) if any(environment.gravity) else state.tolerances.slop / h),
        real(settings.tau),
        real(settings.gamma),
        real(settings.start),
        real(settings.rest),
        real(settings.most),
        real(settings.filt),
        real(settings.tol * h * np.linalg.norm(environment.gravity)),
        real(environment.restitution_threshold),
        real(FINEST[state.real.char]),
        state.tolerances,
    )  # fmt: skip
