"""Contacts in ``avbd``: springs of finite stiffness with multipliers, that push, and rub with a force within Coulomb's cone. See avbd.py."""

import math

from atlasphys.engine.jit import routine
from atlasphys.engine.math import mat, vec
from atlasphys.engine.solvers.common import load_anchors, load_inverse_mass, load_velocity, relative_velocity, weighted
from atlasphys.engine.solvers.sequential_impulse import APPROACH, PRECISION, TARGET
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

MOST_PENALTY = 1e5
"""Greatest penalty in units of the effective mass at the contact. Beyond, single precision loses a body's inertia beside it."""

FASTEST_RISE = 4.0
"""By how much a penalty may rise in one iteration. Load and penalty feed each other: unbounded, an impact drives both up."""

ROLLING_STIFFNESS = 10.0
"""Penalty of rolling and torsional friction in units of the effective moment of inertia. It takes little load, and so needs no ramp."""

# Columns of a point's row, beside APPROACH, PRECISION and TARGET; point k of manifold i has row 4 i + k.
EFFECTIVE_MASS, FIRST_GUESS = 0, 1  # 1 / (n · M⁻¹ n); multiplier at the start of the step


@routine
def prepare(motion, inverse_mass, pairs, manifolds, count, points, stiffness, ratio, gamma, least_penalty):
    """Warm start: last step's multipliers, times ``ratio``, and penalties, which decay by ``gamma``."""
    real = type(ratio)
    zero, one = real(0), real(1)
    contact, contact_points, local = manifolds.contact, manifolds.points, manifolds.local
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
            turns = vec.dot(arm_a, mat.sym_mul_vec(i_a, arm_a)) + vec.dot(arm_b, mat.sym_mul_vec(i_b, arm_b))
            mass = one / (linear + turns) if linear + turns > 0 else zero
            points[p, EFFECTIVE_MASS] = mass
            points[p, APPROACH] = vec.dot(n, relative_velocity(v_a, w_a, r_a, v_b, w_b, r_b))
            column = POINT_COLUMNS * k
            penalty = max(gamma * local[i, column + PENALTY], least_penalty * mass)
            local[i, column + PENALTY] = min(penalty, real(MOST_PENALTY) * mass)
            contact_points[i, column + NORMAL_IMPULSE] *= ratio
            points[p, FIRST_GUESS] = contact_points[i, column + NORMAL_IMPULSE]
            rubbed = vec.scale(vec.load_columns(manifolds.friction_impulse, i, 3 * k), ratio)
            vec.store_columns(manifolds.friction_impulse, i, 3 * k, across(rubbed, n))
        contact[i, PATCH_TORSION] *= ratio
        rolled = vec.scale(vec.load_columns(contact, i, PATCH_ROLLING), ratio)
        vec.store_columns(contact, i, PATCH_ROLLING, across(rolled, n))
        trace = i_a[0] + i_a[1] + i_a[2] + i_b[0] + i_b[1] + i_b[2]
        stiffness[i] = real(3 * ROLLING_STIFFNESS) / trace if trace > 0 else zero


@routine
def across(u, n):
    """The part of u across the unit vector n."""
    return vec.add_scaled(u, n, -vec.dot(n, u))


@routine
def contact_force(load, rubbed, penalty, friction, n, u, target):
    """Impulse along n, friction on b, and the share of the penalty that holds across n, at relative velocity u.

    Where friction slips, its force μ f_n opposes the way that λ_t − k u_t points; it is written as a share s ≤ 1 of that. Its derivative
    counts as −s k in all directions across n: too much along the slip, never too little, so that descent stays descent.
    """
    one = type(load)(1)
    speed = vec.dot(n, u)
    pressed = max(load - penalty * (speed - target), one - one)
    wanted = vec.add_scaled(rubbed, vec.add_scaled(u, n, -speed), -penalty)
    limit, squared = friction * pressed, vec.length_squared(wanted)
    share = one if squared <= limit * limit else limit / math.sqrt(squared)
    return pressed, vec.scale(wanted, share), share


@routine
def patch_moment(contact, i, n, spin, penalty, load):
    """Moment of torsional and rolling friction on b, and the shares of the penalty that hold about n and across it."""
    one = type(load)(1)
    twist = contact[i, PATCH_TORSION] - penalty * vec.dot(n, spin)
    limit = contact[i, FRICTION] * contact[i, TORSIONAL] * load
    about = one if abs(twist) <= limit else limit / abs(twist)
    roll = vec.add_scaled(vec.load_columns(contact, i, PATCH_ROLLING), across(spin, n), -penalty)
    limit, squared = contact[i, ROLLING] * load, vec.length_squared(roll)
    sideways = one if squared <= limit * limit else limit / math.sqrt(squared)
    return vec.add_scaled(vec.scale(roll, sideways), n, twist * about), about, sideways


@routine
def contact_system(i, motion, pairs, manifolds, points, stiffness, first, entries, system):
    """Add to a body's own system (force, torque, and the three blocks of H) what its contacts give.

    At each point J is the 3×6 matrix of its velocity, [1, −r×]. With k alike in all directions across and along n, but for what slips, the sums
    Σ k, Σ k r and Σ k r rᵀ give all of Σ k Jᵀ J.

    A point counts in H while it pushes or its multiplier would have it push. Without the latter, bodies rattle: they leave contacts
    as if these were gone, and come back.
    """
    contact, contact_points, local = manifolds.contact, manifolds.points, manifolds.local
    force, torque, straight, mixed, turning = system
    zero = force[0] - force[0]
    one = type(zero)(1)
    for e in range(first[i], first[i + 1]):
        row, is_b = entries[e] >> 1, entries[e] & 1
        v_a, w_a = load_velocity(motion, pairs[row, 0])
        v_b, w_b = load_velocity(motion, pairs[row, 1])
        n = vec.load_columns(contact, row, NORMAL)
        friction = contact[row, FRICTION]
        load = k_sum = kn_sum = zero
        push = moment = kr_sum = kq_sum = (zero, zero, zero)
        krr = (zero, zero, zero, zero, zero, zero)
        for k in range(manifolds.count[row]):
            column = POINT_COLUMNS * k
            r_a, r_b = load_anchors(contact_points, row, k)
            u = relative_velocity(v_a, w_a, r_a, v_b, w_b, r_b)
            multiplier, penalty = contact_points[row, column + NORMAL_IMPULSE], local[row, column + PENALTY]
            rubbed = vec.load_columns(manifolds.friction_impulse, row, 3 * k)
            pressed, rubs, share = contact_force(
                multiplier, rubbed, penalty, friction, n, u, points[4 * row + k, TARGET]
            )
            if pressed > 0 or multiplier > 0:
                r = r_b if is_b else r_a
                impulse = vec.add_scaled(rubs, n, pressed)
                load += pressed
                push, moment = vec.add(push, impulse), vec.add(moment, vec.cross(r, impulse))
                sticking = share * penalty
                k_sum += sticking
                kr_sum = vec.add_scaled(kr_sum, r, sticking)
                krr = mat.sym_add_square(krr, r, sticking)
                if share < 1:
                    slipping, q = penalty - sticking, vec.cross(r, n)
                    kn_sum += slipping
                    kq_sum = vec.add_scaled(kq_sum, q, slipping)
                    turning = mat.sym_add_square(turning, q, slipping)
        if contact[row, ROLLING] > 0 or contact[row, TORSIONAL] > 0:
            patch, about, sideways = patch_moment(contact, row, n, vec.sub(w_b, w_a), stiffness[row], load)
            moment = vec.add(moment, patch)
            stiff_across = stiffness[row] * sideways
            turning = mat.sym_add_square(turning, n, stiffness[row] * about - stiff_across)
            turning = mat.sym_add_scalar(turning, stiff_across)
        sign = one if is_b else -one
        force, torque = vec.add_scaled(force, push, sign), vec.add_scaled(torque, moment, sign)
        straight = mat.sym_add_scalar(mat.sym_add_square(straight, n, kn_sum), k_sum)
        x, y, z = kr_sum
        mixed = (
            mixed[0] + kq_sum[0] * n[0],
            mixed[1] + kq_sum[0] * n[1] - z,
            mixed[2] + kq_sum[0] * n[2] + y,
            mixed[3] + kq_sum[1] * n[0] + z,
            mixed[4] + kq_sum[1] * n[1],
            mixed[5] + kq_sum[1] * n[2] - x,
            mixed[6] + kq_sum[2] * n[0] - y,
            mixed[7] + kq_sum[2] * n[1] + x,
            mixed[8] + kq_sum[2] * n[2],
        )
        trace = krr[0] + krr[1] + krr[2]
        turning = mat.sym_add_scalar(
            (
                turning[0] - krr[0],
                turning[1] - krr[1],
                turning[2] - krr[2],
                turning[3] - krr[3],
                turning[4] - krr[4],
                turning[5] - krr[5],
            ),
            trace,
        )
    return force, torque, straight, mixed, turning


@routine
def update_multipliers(motion, pairs, manifolds, count, points, stiffness, beta, fall, most_mass):
    """λ ← f for all contacts, and greater penalties where the load asks for them while the bodies still come closer.

    A load of weight m g h asks for the penalty β m: with it the contact gives way by g h, as much as if the mass fell freely for this step. At
    impacts the speed of approach counts beside g h (``fall``), so that a fast body does not count as a heavy one; and no contact carries more
    than all there is (``most_mass``), not even one between bodies that are jammed. Returns the greatest error in speed at a bounce, in units of
    what is allowed.
    """
    real = type(beta)
    contact, contact_points, local = manifolds.contact, manifolds.points, manifolds.local
    error = real(0)
    for i in range(count):
        v_a, w_a = load_velocity(motion, pairs[i, 0])
        v_b, w_b = load_velocity(motion, pairs[i, 1])
        n = vec.load_columns(contact, i, NORMAL)
        load = real(0)
        for k in range(manifolds.count[i]):
            p, column = 4 * i + k, POINT_COLUMNS * k
            r_a, r_b = load_anchors(contact_points, i, k)
            u = relative_velocity(v_a, w_a, r_a, v_b, w_b, r_b)
            multiplier, penalty = contact_points[i, column + NORMAL_IMPULSE], local[i, column + PENALTY]
            rubbed = vec.load_columns(manifolds.friction_impulse, i, 3 * k)
            pressed, rubs, _ = contact_force(multiplier, rubbed, penalty, contact[i, FRICTION], n, u, points[p, TARGET])
            excess = vec.dot(n, u) - points[p, TARGET]
            if excess < 0:
                carried = min(pressed / (fall + abs(points[p, APPROACH])), most_mass)
                wanted = min(beta * carried, real(FASTEST_RISE) * penalty)
                local[i, column + PENALTY] = min(max(penalty, wanted), real(MOST_PENALTY) * points[p, EFFECTIVE_MASS])
            if pressed > 0 or multiplier > 0:
                error = max(error, abs(excess) * points[p, PRECISION])
            load += pressed
            contact_points[i, column + NORMAL_IMPULSE] = pressed
            vec.store_columns(manifolds.friction_impulse, i, 3 * k, rubs)
        if contact[i, ROLLING] > 0 or contact[i, TORSIONAL] > 0:
            moment, _, _ = patch_moment(contact, i, n, vec.sub(w_b, w_a), stiffness[i], load)
            contact[i, PATCH_TORSION] = vec.dot(n, moment)
            vec.store_columns(contact, i, PATCH_ROLLING, across(moment, n))
    return error


@routine
def report(manifolds, count, points, smoothing):
    """Write the step's impulses to ``total``, smooth the multipliers for the next step, and note which pairs touch."""
    for i in range(count):
        for k in range(4):
            column = POINT_COLUMNS * k + NORMAL_IMPULSE
            pressed = manifolds.points[i, column]
            manifolds.total[i, k] = pressed
            if k < manifolds.count[i]:
                manifolds.points[i, column] += smoothing * (points[4 * i + k, FIRST_GUESS] - pressed)
                if pressed > 0 or manifolds.points[i, POINT_COLUMNS * k + DEPTH] >= 0:
                    manifolds.touching[i] = True
        manifolds.total[i, 7] = manifolds.contact[i, PATCH_TORSION]
