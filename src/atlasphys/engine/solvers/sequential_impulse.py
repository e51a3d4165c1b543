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
from typing import Any, Literal

import numpy as np

from atlasphys.engine.jit import kernel, routine
from atlasphys.engine.joints.layout import find_code, lay_out, no_visit, set_numbers, visit_all
from atlasphys.engine.math import mat, quat, vec
from atlasphys.engine.shapes.arguments import invalid, number
from atlasphys.engine.simd import LANES
from atlasphys.engine.simd.address import address_call, call_address
from atlasphys.engine.solvers.common import (
    invert_2x2,
    load_anchors,
    load_inverse_mass,
    load_velocity,
    relative_velocity,
    solve_disk,
    store_velocity,
    weighted,
)
from atlasphys.engine.solvers.integrate import integrate_positions, integrate_velocities, place_origins
from atlasphys.engine.solvers.projection import project_positions
from atlasphys.engine.solvers.soft_step import MOST_JOINT_FREQUENCY, softness
from atlasphys.engine.solvers.sweep_trace import MOST_TRACED, note_sweep, sweeps
from atlasphys.engine.state.bodies import DYNAMIC
from atlasphys.engine.state.joint_work import JOINT_FIELDS, KEEP_RESULTS, PREPARE, RELAX, SLIPPED, SOLVE, START, TOTALS
from atlasphys.engine.state.joints import PART_TYPES
from atlasphys.engine.state.manifolds import (
    DEPTH,
    FRICTION,
    NORMAL,
    NORMAL_IMPULSE,
    PATCH_ROLLING,
    PATCH_TORSION,
    POINT_COLUMNS,
    RESTITUTION,
    ROLLING,
    TORSIONAL,
)
from atlasphys.engine.state.pose import inverse_inertia
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

    Raises:
        InvalidArgumentError: a value is not of the right kind or out of range.
    """

    iterations: int = 10
    position_correction: Literal["projection", "baumgarte"] = "projection"
    position_iterations: int = 4
    correction: float = 0.2
    warm_starting: bool = True

    def __post_init__(self) -> None:
        for name, least in (("iterations", 1), ("position_iterations", 0)):
            value = getattr(self, name)
            if type(value) is not int or not least <= value <= MOST_ITERATIONS:
                raise invalid(name, f"an integer from {least} to {MOST_ITERATIONS}", value)
        chosen = self.position_correction
        if not isinstance(chosen, str) or chosen not in ("projection", "baumgarte"):
            raise invalid("position_correction", "'projection' or 'baumgarte'", chosen)
        if not 0 <= number("correction", self.correction) <= 1:
            raise invalid("correction", "a number from 0 to 1", self.correction)
        if type(self.warm_starting) is not bool:
            raise invalid("warm_starting", "True or False", self.warm_starting)


MOST_ITERATIONS = 10_000
"""Limit of the settings that are numbers of sweeps."""


JOINT_DAMPING, JOINT_PUSH_OUT_SPEED = 1.0, 2.5
"""Damping ratio of joints' softness, and greatest speed at which their errors are taken back [m/s, rad/s]. At 10 m/s bodies on long levers, which
turn by a good part of a radian while they are pulled together, gain energy from step to step: relaxing then takes back the speed along other
directions than those that it was given along. At 2 m/s a hundredfold weight pulls a chain of twenty links apart."""

BOUNCE_SWEEPS = 20
"""How many times the usual number of sweeps may be made while bounces are not solved for."""

INNER_SWEEPS = 3
"""Sweeps over the normal impulses of one manifold each time it is visited. With 1 a tower of ten leans within seconds, for its
impulses lag behind the shifting load; 3 cost a quarter more and hold it to a fraction of a millimetre."""

BOUNCING_SWEEPS = 50
"""The same where the pair can bounce. Restitution conserves or loses energy only as far as the impulses are solved for: with 3 sweeps
elastic boxes that meet face to face gain up to 2e-4 of their energy."""

MOST_GROWTH = 4.0
"""By how much last step's impulses may be scaled up for a longer step. Forces grow in proportion to it, but impulses also hold impacts and
what the sweeps of the last step were still correcting: scaled 1000-fold, these throw a tower into the air."""

FINEST = {"f": 1e-6, "d": 1e-13}
"""Relative error of speeds that can be reached, by NumPy's character for the precision."""

# Columns of a point's constraint row. Point k of manifold i has row 4 i + k.
# 0–2 I_a⁻¹ (r_a × n), 3–5 I_b⁻¹ (r_b × n)
NORMAL_MASS, TARGET = 6, 7  # 1 / k; least relative normal velocity asked for
# 8–10 inverse of the 2×2 tangent matrix, 11 inverse of its greatest eigenvalue
FRICTION_1, FRICTION_2 = 12, 13  # accumulated friction impulse along the two tangents
APPROACH = 14  # relative normal velocity before this step's forces
PRECISION = 15  # inverse of the error in speed that a bounce allows; 0 where nothing bounces
CONSTRAINT_COLUMNS = 16

# Columns of a manifold's frame row.
# 0–2 and 3–5 the two tangents
# 6–8 inverse of the 2×2 rolling matrix, 9 inverse of its greatest eigenvalue
TORSIONAL_MASS = 10
ROLLING_1, ROLLING_2 = 11, 12  # accumulated rolling impulse along the two tangents
BODY_A, BODY_B = 0, 1  # columns of ``pairs``: rows of the two bodies
FRAME_COLUMNS = 16


@routine
def prepare(motion, inverse_mass, pairs, manifolds, count, frames, points, blocks, ratio):
    """Effective masses of every contact point, tangents, and last step's impulses scaled by ``ratio`` (0: start from none)."""
    real = type(ratio)
    one, zero = real(1), real(0)
    contact, contact_points = manifolds.contact, manifolds.points
    for i in range(count):
        a, b = pairs[i, BODY_A], pairs[i, BODY_B]
        m_a, i_a = load_inverse_mass(inverse_mass, a)
        m_b, i_b = load_inverse_mass(inverse_mass, b)
        v_a, w_a = load_velocity(motion, a)
        v_b, w_b = load_velocity(motion, b)
        m = vec.add(m_a, m_b)
        n = vec.load_columns(contact, i, NORMAL)
        t1, t2 = vec.tangents(n)
        frames[i, 0], frames[i, 1], frames[i, 2] = t1
        frames[i, 3], frames[i, 4], frames[i, 5] = t2
        m11, m12, m22 = vec.dot(t1, weighted(m, t1)), vec.dot(t1, weighted(m, t2)), vec.dot(t2, weighted(m, t2))
        m_n = vec.dot(n, weighted(m, n))
        for k in range(manifolds.count[i]):
            p = 4 * i + k
            r_a, r_b = load_anchors(contact_points, i, k)
            arm_a, arm_b = vec.cross(r_a, n), vec.cross(r_b, n)
            angular_a, angular_b = mat.sym_mul_vec(i_a, arm_a), mat.sym_mul_vec(i_b, arm_b)
            points[p, 0], points[p, 1], points[p, 2] = angular_a
            points[p, 3], points[p, 4], points[p, 5] = angular_b
            mass = m_n + vec.dot(arm_a, angular_a) + vec.dot(arm_b, angular_b)
            points[p, NORMAL_MASS] = one / mass if mass > 0 else zero
            for j in range(k + 1):
                q = 4 * i + j
                other_a, other_b = vec.load(points, q), (points[q, 3], points[q, 4], points[q, 5])
                entry = m_n + vec.dot(arm_a, other_a) + vec.dot(arm_b, other_b)
                blocks[i, 4 * k + j] = blocks[i, 4 * j + k] = entry
            k11, k12, k22 = tangent_matrix(r_a, i_a, t1, t2)
            l11, l12, l22 = tangent_matrix(r_b, i_b, t1, t2)
            inverse = invert_2x2(m11 + k11 + l11, m12 + k12 + l12, m22 + k22 + l22)
            points[p, 8], points[p, 9], points[p, 10], points[p, 11] = inverse
            points[p, APPROACH] = vec.dot(n, relative_velocity(v_a, w_a, r_a, v_b, w_b, r_b))
            contact_points[i, POINT_COLUMNS * k + NORMAL_IMPULSE] *= ratio
            friction = vec.scale(vec.load_columns(manifolds.friction_impulse, i, 3 * k), ratio)
            points[p, FRICTION_1], points[p, FRICTION_2] = vec.dot(friction, t1), vec.dot(friction, t2)
        frames[i, ROLLING_1] = frames[i, ROLLING_2] = zero
        if contact[i, ROLLING] > 0 or contact[i, TORSIONAL] > 0:
            total = (
                i_a[0] + i_b[0],
                i_a[1] + i_b[1],
                i_a[2] + i_b[2],
                i_a[3] + i_b[3],
                i_a[4] + i_b[4],
                i_a[5] + i_b[5],
            )
            s1, s2 = mat.sym_mul_vec(total, t1), mat.sym_mul_vec(total, t2)
            inverse = invert_2x2(vec.dot(t1, s1), vec.dot(t1, s2), vec.dot(t2, s2))
            frames[i, 6], frames[i, 7], frames[i, 8], frames[i, 9] = inverse
            twist = vec.dot(n, mat.sym_mul_vec(total, n))
            frames[i, TORSIONAL_MASS] = one / twist if twist > 0 else zero
            rolling = vec.scale(vec.load_columns(contact, i, PATCH_ROLLING), ratio)
            frames[i, ROLLING_1], frames[i, ROLLING_2] = vec.dot(rolling, t1), vec.dot(rolling, t2)
        contact[i, PATCH_TORSION] *= ratio


@routine
def tangent_matrix(r, inverse_inertia, t1, t2):
    """What one body's rotation adds to the 2×2 matrix of the tangents: (r × tᵢ) · I⁻¹ (r × tⱼ)."""
    arm1, arm2 = vec.cross(r, t1), vec.cross(r, t2)
    turn1, turn2 = mat.sym_mul_vec(inverse_inertia, arm1), mat.sym_mul_vec(inverse_inertia, arm2)
    return vec.dot(arm1, turn1), vec.dot(arm1, turn2), vec.dot(arm2, turn2)


@routine
def bounce_speed(restitution, approach, acceleration, gap, h):
    """Speed of separation after an impact that happens within this step; negative if the bounce is too weak to be resolved.

    ``approach`` is the speed of approach at the start of the step, ``acceleration`` that at which it grows. Semi-implicit Euler in a
    uniform field keeps E = ½ v² + g y − ½ g h v, not ½ v² + g y. Impact speed S at gap 0 follows from it, S² = s² + g h s + 2 g gap; and so
    does the speed u with which the step, begun at the present gap, must end at gap + h u: ½ u² + ½ g h u + g gap = ½ e² S². Apexes
    then fall by e² a bounce, with an error of second order in h instead of first.
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
    return math.sqrt(max(bounce + half_gain * half_gain - real(2) * acceleration * gap, real(0))) - half_gain


@routine
def set_targets(motion, pairs, manifolds, count, points, h, bias, slop, max_correction, threshold, finest):
    """The least relative normal velocity that each point asks for, once this step's forces have acted.

    Restitution loses energy, or with e = 1 keeps it, only as far as the impulses are solved for: an error of more than about
    (1 − e) times the approach speed could gain some. A tenth of that is asked for, but no more than ``finest`` of the speed.
    """
    real = type(h)
    contact, contact_points = manifolds.contact, manifolds.points
    for i in range(count):
        v_a, w_a = load_velocity(motion, pairs[i, BODY_A])
        v_b, w_b = load_velocity(motion, pairs[i, BODY_B])
        n = vec.load_columns(contact, i, NORMAL)
        restitution = contact[i, RESTITUTION]
        for k in range(manifolds.count[i]):
            p = 4 * i + k
            r_a, r_b = load_anchors(contact_points, i, k)
            speed = vec.dot(n, relative_velocity(v_a, w_a, r_a, v_b, w_b, r_b))
            gap = -contact_points[i, POINT_COLUMNS * k + DEPTH]
            approach = -points[p, APPROACH]
            target = -gap / h if gap > 0 else bias * min(max(-gap - slop, real(0)), max_correction)
            end = gap + speed * h
            points[p, PRECISION] = real(0)
            if restitution > 0 and abs(approach) > threshold and (approach < 0 or end < 0):
                points[p, PRECISION] = real(1) / (abs(approach) * max(real(0.1) * (real(1) - restitution), finest))
            if restitution > 0 and approach > threshold and -slop < end < 0 and gap > -end:
                # The impact is nearer to the step's end than to its beginning, and the overlap until then within the slop: bounce
                # in the next step. Otherwise bounces would come half a step early on average.
                target = speed
                points[p, PRECISION] = real(0)
            elif restitution > 0 and approach > threshold and end < 0:
                target = max(target, bounce_speed(restitution, approach, (-speed - approach) / h, gap, h))
            elif restitution > 0 and approach < -threshold:
                # Moreau's form of the law holds for contacts that part as well. Asking for no approach instead, where another
                # impact pushes the pair back together, can gain energy.
                target = min(target, restitution * approach)
            points[p, TARGET] = target


@routine
def push(v_a, w_a, m_a, i_a, r_a, v_b, w_b, m_b, i_b, r_b, impulse):
    """The velocities of a and b after an impulse on b, and its opposite on a, at a contact."""
    return (
        vec.sub(v_a, weighted(m_a, impulse)),
        vec.sub(w_a, mat.sym_mul_vec(i_a, vec.cross(r_a, impulse))),
        vec.add(v_b, weighted(m_b, impulse)),
        vec.add(w_b, mat.sym_mul_vec(i_b, vec.cross(r_b, impulse))),
    )


@routine
def warm_start(motion, inverse_mass, pairs, manifolds, count, frames, points):
    """Apply the impulses with which the iterations begin."""
    contact, contact_points = manifolds.contact, manifolds.points
    for i in range(count):
        a, b = pairs[i, BODY_A], pairs[i, BODY_B]
        m_a, i_a = load_inverse_mass(inverse_mass, a)
        m_b, i_b = load_inverse_mass(inverse_mass, b)
        v_a, w_a = load_velocity(motion, a)
        v_b, w_b = load_velocity(motion, b)
        n = vec.load_columns(contact, i, NORMAL)
        t1, t2 = vec.load(frames, i), vec.load_columns(frames, i, 3)
        for k in range(manifolds.count[i]):
            p = 4 * i + k
            r_a, r_b = load_anchors(contact_points, i, k)
            pushed = contact_points[i, POINT_COLUMNS * k + NORMAL_IMPULSE]
            impulse = combined(n, pushed, t1, points[p, FRICTION_1], t2, points[p, FRICTION_2])
            v_a, w_a, v_b, w_b = push(v_a, w_a, m_a, i_a, r_a, v_b, w_b, m_b, i_b, r_b, impulse)
        impulse = combined(n, contact[i, PATCH_TORSION], t1, frames[i, ROLLING_1], t2, frames[i, ROLLING_2])
        w_a, w_b = vec.sub(w_a, mat.sym_mul_vec(i_a, impulse)), vec.add(w_b, mat.sym_mul_vec(i_b, impulse))
        store_velocity(motion, a, v_a, w_a)
        store_velocity(motion, b, v_b, w_b)


@routine
def combined(u, x, v, y, w, z):
    """x u + y v + z w."""
    return (
        u[0] * x + v[0] * y + w[0] * z,
        u[1] * x + v[1] * y + w[1] * z,
        u[2] * x + v[2] * y + w[2] * z,
    )


@routine
def sweep(motion, inverse_mass, pairs, manifolds, count, frames, points, blocks, excess, change):
    """One Gauss–Seidel sweep: friction, then the normal impulses, which have the last word since they keep bodies apart.

    Returns the greatest error in speed that it found at a bounce, in units of what is allowed.
    """
    contact, contact_points = manifolds.contact, manifolds.points
    error = type(points[0, 0])(0)
    for i in range(count):
        a, b = pairs[i, BODY_A], pairs[i, BODY_B]
        m_a, i_a = load_inverse_mass(inverse_mass, a)
        m_b, i_b = load_inverse_mass(inverse_mass, b)
        v_a, w_a = load_velocity(motion, a)
        v_b, w_b = load_velocity(motion, b)
        n = vec.load_columns(contact, i, NORMAL)
        t1, t2 = vec.load(frames, i), vec.load_columns(frames, i, 3)
        friction, rolling, torsional = contact[i, FRICTION], contact[i, ROLLING], contact[i, TORSIONAL]
        zero = friction - friction
        load = zero
        for k in range(manifolds.count[i]):
            load += contact_points[i, POINT_COLUMNS * k + NORMAL_IMPULSE]

        if rolling > 0 or torsional > 0:
            spin = vec.sub(w_b, w_a)
            limit = friction * torsional * load
            old = (contact[i, PATCH_TORSION], frames[i, ROLLING_1], frames[i, ROLLING_2])
            twist = min(max(old[0] - frames[i, TORSIONAL_MASS] * vec.dot(n, spin), -limit), limit)
            inverse = (frames[i, 6], frames[i, 7], frames[i, 8], frames[i, 9])
            roll1, roll2 = solve_disk((old[1], old[2]), (vec.dot(t1, spin), vec.dot(t2, spin)), inverse, rolling * load)
            contact[i, PATCH_TORSION], frames[i, ROLLING_1], frames[i, ROLLING_2] = twist, roll1, roll2
            impulse = combined(n, twist - old[0], t1, roll1 - old[1], t2, roll2 - old[2])
            w_a, w_b = vec.sub(w_a, mat.sym_mul_vec(i_a, impulse)), vec.add(w_b, mat.sym_mul_vec(i_b, impulse))

        if friction > 0:
            for k in range(manifolds.count[i]):
                p = 4 * i + k
                r_a, r_b = load_anchors(contact_points, i, k)
                v = relative_velocity(v_a, w_a, r_a, v_b, w_b, r_b)
                old1, old2 = points[p, FRICTION_1], points[p, FRICTION_2]
                inverse = (points[p, 8], points[p, 9], points[p, 10], points[p, 11])
                limit = friction * contact_points[i, POINT_COLUMNS * k + NORMAL_IMPULSE]
                new1, new2 = solve_disk((old1, old2), (vec.dot(t1, v), vec.dot(t2, v)), inverse, limit)
                points[p, FRICTION_1], points[p, FRICTION_2] = new1, new2
                impulse = vec.add_scaled(vec.scale(t1, new1 - old1), t2, new2 - old2)
                v_a, w_a, v_b, w_b = push(v_a, w_a, m_a, i_a, r_a, v_b, w_b, m_b, i_b, r_b, impulse)

        # The normal impulses of one manifold as a block: its velocities once, inner sweeps on the block's own matrix, then the sum.
        number = manifolds.count[i]
        for k in range(number):
            r_a, r_b = load_anchors(contact_points, i, k)
            v = relative_velocity(v_a, w_a, r_a, v_b, w_b, r_b)
            excess[k] = vec.dot(n, v) - points[4 * i + k, TARGET]
            change[k] = zero
            if contact_points[i, POINT_COLUMNS * k + NORMAL_IMPULSE] > 0 or excess[k] < 0:
                error = max(error, abs(excess[k]) * points[4 * i + k, PRECISION])
        sweeps = 1 if number == 1 else (INNER_SWEEPS if contact[i, RESTITUTION] == 0 else BOUNCING_SWEEPS)
        for _ in range(sweeps):
            for k in range(number):
                column = POINT_COLUMNS * k + NORMAL_IMPULSE
                old = contact_points[i, column]
                new = max(old - points[4 * i + k, NORMAL_MASS] * excess[k], zero)
                contact_points[i, column] = new
                change[k] += new - old
                for j in range(number):
                    excess[j] += blocks[i, 4 * k + j] * (new - old)
        total = zero
        for k in range(number):
            p = 4 * i + k
            total += change[k]
            w_a = vec.add_scaled(w_a, vec.load(points, p), -change[k])
            w_b = vec.add_scaled(w_b, (points[p, 3], points[p, 4], points[p, 5]), change[k])
        impulse = vec.scale(n, total)
        v_a, v_b = vec.sub(v_a, weighted(m_a, impulse)), vec.add(v_b, weighted(m_b, impulse))
        store_velocity(motion, a, v_a, w_a)
        store_velocity(motion, b, v_b, w_b)
    return error


@routine
def store_impulses(manifolds, count, frames, points):
    """Write friction and rolling impulses back as world vectors, and note which pairs touch."""
    contact_points = manifolds.points
    for i in range(count):
        t1, t2 = vec.load(frames, i), (frames[i, 3], frames[i, 4], frames[i, 5])
        for k in range(manifolds.count[i]):
            p = 4 * i + k
            impulse = vec.add_scaled(vec.scale(t1, points[p, FRICTION_1]), t2, points[p, FRICTION_2])
            vec.store_columns(manifolds.friction_impulse, i, 3 * k, impulse)
            first = POINT_COLUMNS * k
            if contact_points[i, first + NORMAL_IMPULSE] > 0 or contact_points[i, first + DEPTH] >= 0:
                manifolds.touching[i] = True
        for k in range(4):
            manifolds.total[i, k] = contact_points[i, POINT_COLUMNS * k + NORMAL_IMPULSE]
        manifolds.total[i, 7] = manifolds.contact[i, PATCH_TORSION]
        rolling = vec.add_scaled(vec.scale(t1, frames[i, ROLLING_1]), t2, frames[i, ROLLING_2])
        vec.store_columns(manifolds.contact, i, PATCH_ROLLING, rolling)


@routine
def clear_totals(blocks):
    """Forget the impulses that a pass over the joints has summed up: the next one notes them once more."""
    for block in range(len(blocks)):
        for k in range(TOTALS, JOINT_FIELDS):
            for lane in range(LANES):
                blocks[block, k, lane] = 0


@routine
def keep_slips(blocks, slips):
    """Note how far couplings have slipped. The first relaxing pass finds it from the speeds with which the bodies moved."""
    for block in range(len(blocks)):
        for lane in range(LANES):
            slips[block, lane] = blocks[block, SLIPPED, lane]


@routine
def return_slips(slips, blocks):
    """Write back what ``keep_slips`` noted."""
    for block in range(len(blocks)):
        for lane in range(LANES):
            blocks[block, SLIPPED, lane] = slips[block, lane]


@kernel
def solve(
    bodies, body_count, colliders, manifolds, count, pairs, frames, points, blocks, excess, change, displacement, spin_change,
    gravity, h, ratio, iterations, position_iterations, bias, position_rate, threshold, finest, tolerances, motions, impulses,
    joints, phases, calls, slips,
):  # fmt: skip
    """One step of length h for all bodies: velocities, then positions. Returns the number of sweeps.

    Joints (state/joint_work.py) are visited before the contacts in each sweep, as soft constraints. Once the bodies have moved, as many sweeps again
    make them rigid where they are now: velocities are those of the step's end, without the speed that taking back errors gave.

    ``motions`` and ``impulses`` take notes of the sweeps as far as they have room: none, unless a trace is asked for.
    """
    motion, inverse_mass = bodies.motion, bodies.inverse_mass
    data = address_call(no_visit, (motion, bodies.geometry, inverse_mass, bodies.center, joints))[1]
    if len(phases) > 0:
        call_address(calls[PART_TYPES], data, PREPARE, 0, len(joints.blocks))
    for i in range(count):
        pairs[i, BODY_A], pairs[i, BODY_B] = colliders.body[manifolds.a[i]], colliders.body[manifolds.b[i]]
    prepare(motion, inverse_mass, pairs, manifolds, count, frames, points, blocks, ratio)
    integrate_velocities(bodies, body_count, gravity, h)
    set_targets(
        motion, pairs, manifolds, count, points, h, bias, tolerances.slop, tolerances.max_correction, threshold, finest
    )
    visit_all(START, calls, data, phases)
    warm_start(motion, inverse_mass, pairs, manifolds, count, frames, points)
    if len(motions) > 0:
        note_sweep(motions, impulses, 0, motion, body_count, manifolds, count, points, FRICTION_1)
    made = 0
    for s in range(BOUNCE_SWEEPS * iterations):
        visit_all(SOLVE, calls, data, phases)
        error = sweep(motion, inverse_mass, pairs, manifolds, count, frames, points, blocks, excess, change)
        made = s + 1
        if made < len(motions):
            note_sweep(motions, impulses, made, motion, body_count, manifolds, count, points, FRICTION_1)
        if made >= iterations and error <= 1:
            break
    integrate_positions(bodies, body_count, h)
    if len(phases) > 0:
        for i in range(body_count):
            for k in range(4):
                bodies.geometry[i, 12 + k] = bodies.orientation[i, k]
            if bodies.kind[i] == DYNAMIC:  # impulses along new arms with the old inertia would add energy
                turned = inverse_inertia(bodies, i, quat.load(bodies.orientation, i))
                for k in range(6):
                    inverse_mass[i, k] = turned[k]
        for s in range(iterations):
            if s == iterations - 1:
                clear_totals(joints.blocks)
            visit_all(RELAX, calls, data, phases)
            if s == 0:
                keep_slips(joints.blocks, slips)
            sweep(motion, inverse_mass, pairs, manifolds, count, frames, points, blocks, excess, change)
        return_slips(slips, joints.blocks)
        call_address(calls[PART_TYPES], data, KEEP_RESULTS, 0, len(joints.blocks))
    store_impulses(manifolds, count, frames, points)
    project_positions(
        bodies, body_count, pairs, manifolds, count, points, displacement, spin_change,
        position_iterations, position_rate, tolerances.slop, tolerances.max_correction,
    )  # fmt: skip
    place_origins(bodies, body_count)
    return made


def ready_joints(state: State, h: float, ratio: float) -> tuple[Any, ...]:
    """What ``solve`` is to know of joints."""
    table = state.joints
    if table.layout is None:
        table.layout = lay_out(state, np.ones(max(state.count, 1), np.uint8))
    layout = table.layout
    if len(layout.phases):
        soft = softness(MOST_JOINT_FREQUENCY / h, JOINT_DAMPING, h)
        set_numbers(state, layout, h, ratio, soft, JOINT_PUSH_OUT_SPEED * state.environment.length_unit)
        find_code(state, layout)
    slips = np.empty((len(layout.work.blocks), LANES), state.real)
    return layout.work, layout.phases, layout.calls, slips


def advance(state: State, settings: SequentialImpulse, h: float) -> None:
    """Advance all bodies by one step of length h [s]."""
    real = state.real.type
    environment = state.environment
    baumgarte = settings.position_correction == "baumgarte"
    capacity = max(state.next_count, 1)
    frames = np.empty((capacity, FRAME_COLUMNS), state.real)
    points = np.empty((4 * capacity, CONSTRAINT_COLUMNS), state.real)
    blocks = np.empty((capacity, 16), state.real)
    excess, change = np.empty((2, 4), state.real)
    pairs = np.empty((capacity, 2), np.int32)
    noted = 0 if state.trace is None else min(BOUNCE_SWEEPS * settings.iterations, MOST_TRACED) + 1
    motions = np.empty((noted, state.count, 6), state.real)
    impulses = np.empty((noted, 4 * capacity, 3), state.real)
    ratio = real(min(h / state.last_h, MOST_GROWTH) if settings.warm_starting and state.last_h > 0 else 0.0)
    joints = ready_joints(state, h, float(ratio))
    made = solve(
        state.bodies, state.count, state.colliders, state.next_manifolds, state.next_count,
        pairs, frames, points, blocks, excess, change, state.displacement, state.spin_change,
        tuple(real(g) for g in environment.gravity),
        real(h),
        ratio,
        settings.iterations,
        0 if baumgarte else settings.position_iterations,
        real(settings.correction / h if baumgarte else 0.0),
        real(settings.correction),
        real(environment.restitution_threshold),
        real(FINEST[state.real.char]),
        state.tolerances,
        motions,
        impulses,
        *joints,
    )  # fmt: skip
    if state.trace is not None:
        noted = min(made + 1, noted)
        state.trace += sweeps(state, motions[:noted], impulses[:noted], points[:, NORMAL_MASS], points[:, TARGET])
