"""Augmented vertex block descent: one body after another is put where its own energy is least.

Implicit Euler finds the positions x at the end of a step of length h as the least of Σ ½ |x − y|²_M / h² + E(x), where y = x⁻ + h v⁻ + h² g is
where the bodies would go without contacts and E the energy of these. Block descent (Chen et al. 2024) lowers it body by body: each solves its own
6×6 system H Δx = f, the others held. A contact with the constraint C ≥ 0 (C is the gap) is a spring of finite stiffness k and a multiplier λ, of
force f = max(0, λ − k C), and after each sweep λ ← f (augmented Lagrangian: C → 0 with k finite). Friction is the same in the plane of contact, with
|f_t| ≤ μ f_n. So the load sits in λ, and k need only be of the order of the masses that rest on the contact: this is what carries a
thousandfold mass.

Source: C. Giles, E. Diaz, C. Yuksel, "Augmented Vertex Block Descent", ACM Trans. Graph. 44 (4), 2025, names α, β, γ as there; A. H. Chen et al.,
"Vertex Block Descent", ACM Trans. Graph. 43 (4), 2024. docs/avbd.md derives it, and says where and why this differs.

Everything is multiplied through by h: the unknowns are Δx / h, velocities, constraints are speeds, multipliers impulses [N s], stiffnesses k h²
penalties [kg].
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from atlasphys.engine.jit import kernel, routine
from atlasphys.engine.joints.addresses import tables_address
from atlasphys.engine.joints.evaluate import ROW_FIELDS, evaluate_address
from atlasphys.engine.joints.layout import lay_out, no_visit, set_numbers
from atlasphys.engine.math import mat, quat, vec
from atlasphys.engine.math.ldlt import solve_6x6
from atlasphys.engine.shapes.arguments import invalid, number
from atlasphys.engine.simd import LANES
from atlasphys.engine.simd.address import address_call, call_address
from atlasphys.engine.solvers.avbd_contacts import (
    EFFECTIVE_MASS,
    FASTEST_RISE,
    MOST_PENALTY,
    contact_system,
    prepare,
    report,
    update_multipliers,
)
from atlasphys.engine.solvers.avbd_joint_aim import aim_parts, place_ends, prepare_parts
from atlasphys.engine.solvers.avbd_joint_rows import joint_push, joint_system
from atlasphys.engine.solvers.avbd_joints import (
    bind_to_world,
    forget_multipliers,
    list_links,
    list_parts,
    report_parts,
    restrain,
    update_parts,
)
from atlasphys.engine.solvers.common import load_velocity, store_velocity
from atlasphys.engine.solvers.free_islands import SUM_COLUMNS, keep_momenta, list_free_islands, load_tensor
from atlasphys.engine.solvers.integrate import integrate_positions, integrate_velocities, place_origins
from atlasphys.engine.solvers.sequential_impulse import (
    CONSTRAINT_COLUMNS,
    FINEST,
    MOST_GROWTH,
    MOST_ITERATIONS,
    TARGET,
    set_targets,
)
from atlasphys.engine.solvers.sweep_trace import MOST_TRACED, note_multipliers, sweeps
from atlasphys.engine.state.arrays import aligned_zeros
from atlasphys.engine.state.bodies import DYNAMIC
from atlasphys.engine.state.joint_work import FIRST, KEEP_RESULTS, PREPARE, STOP, TYPE
from atlasphys.engine.state.manifolds import (
    NORMAL,
    NORMAL_IMPULSE,
    POINT_COLUMNS,
)
from atlasphys.engine.state.state import State


@dataclass(frozen=True, slots=True)
class AVBD:
    """Settings of the solver ``avbd``.

    Attributes:
        iterations: most sweeps over all bodies, forth and back, each followed by an update of the multipliers. Fewer are made once nothing
            changes any more. More: taller stacks stand, and momenta pass through piles in fewer steps.
        alpha: share of an overlap beyond the slop that is left for later steps (the paper's α). Larger: overlaps are eased out
            slower, and give the bodies less speed.
        beta: penalty of a loaded contact, in units of the mass whose weight is its load. Larger: stiffer under sudden load, but tall
            stacks begin to shiver.
        gamma: share of its penalty that a contact starts the next step with (the paper's γ).
        least_penalty: least penalty, in units of the effective mass at the contact (the paper's k_start). Impacts converge best at about 3,
            stacks at 10.
        smoothing: share of the last step's first guess in the multipliers that the next one starts from. 0: what the last iteration found, which
            also holds what it corrected, so that tall stacks swing from step to step.
        tolerance: the sweeps end when none changes a velocity by more than this, in units of the speed that gravity gives in a step.

        joint_alpha: share of a joint's error that is left for later steps. Smaller: errors are taken back sooner, but give the bodies speed, and
            with it energy, that jerks in chains have no other source for.
        joint_push_out_speed: greatest speed at which errors of joints are taken back [m/s, rad/s], for a length unit of 1 m.
        joint_tolerance: the sweeps go on, up to 20 times ``iterations``, while a joint is off at the step's end by more than this, in units of the
            way that bodies fall in the step. Larger: faster; ropes that jerk gain energy from 0.05 on.

    Raises:
        InvalidArgumentError: a value is not of the right kind or out of range.
    """

    iterations: int = 20
    alpha: float = 0.95
    beta: float = 1.0
    gamma: float = 0.9
    least_penalty: float = 5.0
    smoothing: float = 0.25
    tolerance: float = 3e-5
    joint_alpha: float = 0.9
    joint_push_out_speed: float = 4.0
    joint_tolerance: float = 0.005

    def __post_init__(self) -> None:
        if type(self.iterations) is not int or not 1 <= self.iterations <= MOST_ITERATIONS:
            raise invalid("iterations", f"an integer from 1 to {MOST_ITERATIONS}", self.iterations)
        for name, least, most in (
            ("alpha", 0.0, 1.0),
            ("beta", 0.0, 1e3),
            ("gamma", 0.0, 1.0),
            ("least_penalty", 1e-3, 1e3),
            ("smoothing", 0.0, 1.0),
            ("tolerance", 0.0, 1.0),
            ("joint_alpha", 0.0, 1.0),
            ("joint_push_out_speed", 0.0, 1e6),
            ("joint_tolerance", 0.0, 1.0),
        ):
            if not least <= number(name, getattr(self, name)) <= most:
                raise invalid(name, f"a number from {least:g} to {most:g}", getattr(self, name))


FINEST_JOINT = 2e-7
"""Least error of joints that is asked for, in length units: what single precision can tell."""

GROSS = 1000.0
"""Error of joints, in units of what is allowed, from which on more sweeps are not tried, and the multipliers that the step ends with are not kept."""

BOUNCE_SWEEPS = 20
"""How many times the usual number of iterations may be made while bounces and joints are not solved for."""


@routine
def list_contacts(body_count, pairs, count, first, entries):
    """List each body's contacts: body i has the entries ``first[i]`` to ``first[i + 1]``, twice the manifold's row, plus 1 where it is b."""
    for i in range(body_count + 2):
        first[i] = 0
    for i in range(count):
        for side in range(2):
            first[pairs[i, side] + 2] += 1
    for i in range(body_count):
        first[i + 2] += first[i + 1]
    for i in range(count):
        for side in range(2):
            row = pairs[i, side] + 1
            entries[first[row]] = 2 * i + side
            first[row] += 1


@routine
def guess(
    bodies, body_count, manifolds, first, entries, joints, kinds, rows, joint_first, joint_entries, gravity, h, inertial, inertia
):  # fmt: skip
    """The velocities towards y, to ``inertial``; the tensors of inertia; and the velocities at which the sweeps begin, to ``motion``.

    Adaptive initial guess (Chen et al. 2024, 3.7): a body is given the share of gravity that it followed in the last step, from 0 to 1. What
    kept it from following is read off the multipliers.
    """
    motion, mass = bodies.motion, bodies.mass
    real = type(h)
    zero, one = real(0), real(1)
    strength = vec.length_squared(gravity)
    for i in range(body_count):
        for k in range(6):
            inertial[i, k] = motion[i, k]
        if bodies.kind[i] == DYNAMIC:
            axes = quat.matrix(quat.mul(quat.load(bodies.orientation, i), quat.load(bodies.principal, i)))
            tensor = mat.rotated_diagonal(axes, (mass[i, 2], mass[i, 3], mass[i, 4]))
            for k in range(6):
                inertia[i, k] = tensor[k]
            weight = h * strength * bodies.response[i, 0] * mass[i, 0]
            if weight != 0:
                held = -vec.dot(joint_push(i, joints, kinds, rows, joint_first, joint_entries), gravity)
                for e in range(first[i], first[i + 1]):
                    row, is_b = entries[e] >> 1, entries[e] & 1
                    push = (zero, zero, zero)
                    for k in range(manifolds.count[row]):
                        push = vec.add(push, vec.load_columns(manifolds.friction_impulse, row, 3 * k))
                        n, load = vec.load_columns(manifolds.contact, row, NORMAL), POINT_COLUMNS * k + NORMAL_IMPULSE
                        push = vec.add_scaled(push, n, manifolds.points[row, load])
                    held += -vec.dot(push, gravity) if is_b else vec.dot(push, gravity)
                share = min(max(held / weight, zero), one)
                for k in range(3):
                    if bodies.inverse_mass[i, 8 + k] > 0:
                        motion[i, k] -= share * h * bodies.response[i, 0] * gravity[k]


@routine
def descend(
    i, bodies, inertial, inertia, pairs, manifolds, points, stiffness, first, entries,
    joints, kinds, rows, joint_first, joint_entries, h, joint_alpha, joint_most, length_unit,
):  # fmt: skip
    """Solve body i's own system H Δv = f and move it. Returns the greatest change of speed, that of points a length unit away included.

    H = M + Σ k Jᵀ J over its contact points and the rows of its joints. Constraints are linear in the step, so there is no geometric stiffness.
    """
    motion, mass = bodies.motion, bodies.mass
    v, w = load_velocity(motion, i)
    m = mass[i, 0]
    zero = m - m
    tensor = load_tensor(inertia, i)
    v_inertial, w_inertial = load_velocity(inertial, i)
    force = vec.scale(vec.sub(v_inertial, v), m)
    torque = mat.sym_mul_vec(tensor, vec.sub(w_inertial, w))
    straight = (m, m, m, zero, zero, zero)  # H's blocks: force by velocity, torque by velocity, torque by spin
    mixed = (zero, zero, zero, zero, zero, zero, zero, zero, zero)
    force, torque, straight, mixed, turning = contact_system(
        i, motion, pairs, manifolds, points, stiffness, first, entries, (force, torque, straight, mixed, tensor)
    )
    if joint_first[i] < joint_first[i + 1]:
        force, torque, straight, mixed, turning = joint_system(
            i, motion, joints, kinds, rows, joint_first, joint_entries, h, joint_alpha, joint_most,
            (force, torque, straight, mixed, turning),
        )  # fmt: skip
    if bodies.locks[i]:
        straight, mixed, turning, force, torque = lock(bodies.locks[i], straight, mixed, turning, force, torque)
    dv, dw = solve_6x6(straight, mixed, turning, force, torque)
    store_velocity(motion, i, vec.add(v, dv), vec.add(w, dw))
    dw = vec.scale(dw, length_unit)
    return max(abs(dv[0]), abs(dv[1]), abs(dv[2]), abs(dw[0]), abs(dw[1]), abs(dw[2]))


@routine
def lock(locks, a, b, d, force, torque):
    """The system without the rows and columns of locked directions: 1 on the diagonal, 0 beside it."""
    zero = a[0] - a[0]
    one = type(zero)(1)
    x, y, z = zero if locks & 1 else one, zero if locks & 2 else one, zero if locks & 4 else one
    rx, ry, rz = zero if locks & 8 else one, zero if locks & 16 else one, zero if locks & 32 else one
    linear = (a[0] * x + one - x, a[1] * y + one - y, a[2] * z + one - z, a[3] * x * y, a[4] * x * z, a[5] * y * z)
    mixed = (
        b[0] * rx * x, b[1] * rx * y, b[2] * rx * z,
        b[3] * ry * x, b[4] * ry * y, b[5] * ry * z,
        b[6] * rz * x, b[7] * rz * y, b[8] * rz * z,
    )  # fmt: skip
    angular = (
        d[0] * rx + one - rx, d[1] * ry + one - ry, d[2] * rz + one - rz,
        d[3] * rx * ry, d[4] * rx * rz, d[5] * ry * rz,
    )  # fmt: skip
    force = (force[0] * x, force[1] * y, force[2] * z)
    return linear, mixed, angular, force, (torque[0] * rx, torque[1] * ry, torque[2] * rz)


@kernel
def solve(
    bodies, body_count, colliders, manifolds, count, pairs, points, stiffness, first, entries, before, inertial, inertia, parent, free, sums,
    gravity, h, ratio, iterations, bias, beta, gamma, least_penalty, smoothing, fall, least_change, length_unit,
    threshold, finest, tolerances, motions, impulses,
    joints, kinds, rows, joint_first, joint_entries, tables_code, rows_code, joint_alpha, joint_most, joint_tolerance,
):  # fmt: skip
    """One step of length h for all bodies. Returns the number of sweeps; ``motions`` and ``impulses`` take notes of them as far as they have room."""
    real = type(h)
    motion = bodies.motion
    for i in range(count):
        pairs[i, 0], pairs[i, 1] = colliders.body[manifolds.a[i]], colliders.body[manifolds.b[i]]
    list_contacts(body_count, pairs, count, first, entries)
    inverse_mass = bodies.inverse_mass
    tables = address_call(no_visit, (motion, bodies.geometry, inverse_mass, bodies.center, joints))[1]
    parts = address_call(no_visit, (motion, bodies.geometry, inverse_mass, joints, kinds, rows))[1]
    for i in range(body_count):
        for k in range(6):
            before[i, k] = motion[i, k]
    if len(kinds) > 0:
        call_address(tables_code, tables, PREPARE, 0, len(kinds))
        place_ends(bodies, body_count, h - h)
        call_address(rows_code, parts, 0, 0, len(kinds))
        prepare_parts(bodies, joints, kinds, rows, h, gamma, least_penalty, real(MOST_PENALTY))
    list_parts(body_count, joints, joint_first, joint_entries)
    list_free_islands(bodies, body_count, pairs, list_links(joints, pairs, count), parent, free)
    bind_to_world(joints, kinds, parent, free)
    prepare(motion, bodies.inverse_mass, pairs, manifolds, count, points, stiffness, ratio, gamma, least_penalty)
    integrate_velocities(bodies, body_count, gravity, h)
    set_targets(
        motion, pairs, manifolds, count, points, h, bias, tolerances.slop, tolerances.max_correction, threshold, finest
    )
    guess(
        bodies, body_count, manifolds, first, entries, joints, kinds, rows, joint_first, joint_entries, gravity, h, inertial, inertia
    )  # fmt: skip
    if len(kinds) > 0:
        aim_parts(bodies, body_count, before, joints, kinds, rows, rows_code, parts, h, joint_most / h)
    most_mass = h - h
    for i in range(body_count):
        if bodies.kind[i] == DYNAMIC:
            most_mass += bodies.mass[i, 0]
    if len(motions) > 0:
        note_multipliers(motions, impulses, 0, motion, body_count, manifolds, count)
    made = 0
    off = off_last = h - h
    for s in range(BOUNCE_SWEEPS * iterations):
        change = h - h
        for j in range(
            2 * body_count
        ):  # forth and back: in one direction only, stiff contacts make the multipliers diverge
            i = j if j < body_count else 2 * body_count - 1 - j
            if bodies.kind[i] == DYNAMIC and (first[i] < first[i + 1] or joint_first[i] < joint_first[i + 1]):
                moved = descend(
                    i, bodies, inertial, inertia, pairs, manifolds, points, stiffness, first, entries,
                    joints, kinds, rows, joint_first, joint_entries, h, joint_alpha, joint_most, length_unit,
                )  # fmt: skip
                change = max(change, moved)
        error = update_multipliers(
            motion, pairs, manifolds, count, points, stiffness, beta if s < iterations else h - h, fall, most_mass
        )
        if len(kinds) > 0:
            aim_parts(bodies, body_count, before, joints, kinds, rows, rows_code, parts, h, joint_most / h)
            off = update_parts(
                motion, joints, kinds, rows, h, joint_alpha, joint_most, beta if s < iterations else h - h,
                real(FASTEST_RISE), real(MOST_PENALTY), fall, most_mass, length_unit,
            )  # fmt: skip
            error = max(error, off * h / joint_tolerance)
        made = s + 1
        if made < len(motions):
            note_multipliers(motions, impulses, made, motion, body_count, manifolds, count)
        if made >= iterations and off * h > real(GROSS) * joint_tolerance and not off < off_last:
            break
        off_last = off
        if error <= 1 and (s + 1 >= iterations or change <= least_change):
            break
    gross = off * h > real(GROSS) * joint_tolerance
    if gross:
        restrain(motion, inertial, body_count, joint_first, joint_most / h)
    keep_momenta(bodies, body_count, inertial, inertia, parent, free, sums)
    report(manifolds, count, points, smoothing)
    if len(kinds) > 0:
        report_parts(motion, joints, kinds, rows, h)
        if gross:
            forget_multipliers(joints)
        call_address(tables_code, tables, KEEP_RESULTS, 0, len(kinds))
    integrate_positions(bodies, body_count, h)
    place_origins(bodies, body_count)
    return made


def ready_joints(state: State, h: float, ratio: float) -> tuple[Any, ...]:
    """What ``solve`` is to know of joints: their working memory, the type of each block, the table of rows, and two addresses of code."""
    table, bodies = state.joints, state.bodies
    if table.layout is None:
        table.layout = lay_out(state, np.ones(max(state.count, 1), np.uint8))
    layout = table.layout
    kinds = np.repeat(layout.phases[:, TYPE], layout.phases[:, STOP] - layout.phases[:, FIRST])
    rows = aligned_zeros((len(kinds), ROW_FIELDS, LANES), state.real)
    if len(kinds) == 0:
        return layout.work, kinds, rows, (0, 0)
    set_numbers(state, layout, h, ratio, (0.0, 1.0), 0.0)
    given = (bodies.motion, bodies.geometry, bodies.inverse_mass)
    codes = tables_address((*given, bodies.center, layout.work)), evaluate_address((*given, layout.work, kinds, rows))
    return layout.work, kinds, rows, codes


def advance(state: State, settings: AVBD, h: float) -> None:
    """Advance all bodies by one step of length h [s]."""
    real, environment, slop = state.real.type, state.environment, float(state.tolerances.slop)
    bodies, contacts = max(state.count, 1), max(state.next_count, 1)
    fall = h * math.sqrt(sum(g * g for g in environment.gravity))
    points = np.empty((4 * contacts, CONSTRAINT_COLUMNS), state.real)
    noted = 0 if state.trace is None else min(BOUNCE_SWEEPS * settings.iterations, MOST_TRACED) + 1
    motions = np.empty((noted, state.count, 6), state.real)
    impulses = np.empty((noted, 4 * contacts, 3), state.real)
    ratio = real(min(h / state.last_h, MOST_GROWTH) if state.last_h > 0 else 0.0)
    joints, kinds, rows, codes = ready_joints(state, h, float(ratio))
    parts = LANES * len(kinds)
    made = solve(
        state.bodies, state.count, state.colliders, state.next_manifolds, state.next_count,
        np.empty((contacts + parts, 2), np.int32),
        points,
        np.empty(contacts, state.real),
        np.empty(bodies + 2, np.int32),
        np.empty(2 * contacts, np.int32),
        np.empty((bodies, 6), state.real),
        np.empty((bodies, 6), state.real),
        np.empty((bodies, 6), state.real),
        np.empty(bodies, np.int32),
        np.empty(bodies, np.bool_),
        np.empty((bodies, SUM_COLUMNS), state.real),
        tuple(real(g) for g in environment.gravity),
        real(h),
        ratio,
        settings.iterations,
        real((1 - settings.alpha) / h),
        real(settings.beta),
        real(settings.gamma),
        real(settings.least_penalty),
        real(settings.smoothing),
        real(fall if fall > 0 else slop / h),
        real(settings.tolerance * fall),
        real(environment.length_unit),
        real(environment.restitution_threshold),
        real(FINEST[state.real.char]),
        state.tolerances,
        motions,
        impulses,
        joints, kinds, rows,
        np.empty(bodies + 2, np.int32),
        np.empty(2 * parts, np.int32),
        codes[0],
        codes[1],
        real(settings.joint_alpha),
        real(settings.joint_push_out_speed * environment.length_unit * h),
        real(max(settings.joint_tolerance * h * (fall if fall > 0 else slop / h), FINEST_JOINT * environment.length_unit)),
    )  # fmt: skip
    if state.trace is not None:
        noted = min(made + 1, noted)
        state.trace += sweeps(state, motions[:noted], impulses[:noted], points[:, EFFECTIVE_MASS], points[:, TARGET])
