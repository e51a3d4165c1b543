"""Along which Jacobians joints push in ``avbd``, and where they are to be at the step's end. See avbd_joints.py.

Forces along J of the step's beginning make a leapfrog step with constraints, SHAKE. It errs where bodies turn far within a step, in two ways, and
both are mended by a J that is the share θ of the way from that of the beginning to that of the end:

* *Instability.* A light body under load swings with an angular frequency ω; leapfrog is unstable for κ = h² ω² > 4. The characteristic equation of
  ẍ = −ω² x with the share θ,

      (1 + θ κ) z² − (2 − (1 − θ) κ) z + 1 = 0,

  has no root beyond the unit circle for θ ≥ ½ − 2 / κ. It damps by 1 / (1 + θ κ) a step, only what is that fast. κ is found from last step's load.

* *Work.* A rigid joint does none. But with the velocities v⁻ and v of two steps, impulses λ along J give the bodies the energy W = ½ λ · J (v⁻ + v)
  (that is what changes ½ v · M v), which need not be 0 in the middle of a turn. W is linear in θ, so that its zero is known. Only gains are taken
  away: W < 0 where bodies jerk, which costs energy. What θ is up to ``TO_AND_FRO`` is let be, for so much is given in one step and taken in another.
"""

import math

from atlasphys.engine.jit import routine
from atlasphys.engine.joints.evaluate import COORDINATE, EFFECTIVE, PUSH_A, PUSH_B, ROW_STRIDE, TURN_A, TURN_B
from atlasphys.engine.math import mat, quat, vec
from atlasphys.engine.simd import LANES
from atlasphys.engine.simd.address import call_address
from atlasphys.engine.solvers.avbd_joint_rows import (
    BIAS,
    FACTOR,
    FIRST_MASS,
    FIRST_ROWS,
    LEAST_SHARE,
    PENALTY,
    START,
    end_velocity,
    impulse_along,
    is_soft,
    is_turning,
    row_count,
    row_rate,
    side_of,
)
from atlasphys.engine.solvers.common import load_inverse_mass, weighted
from atlasphys.engine.solvers.integrate import midpoint_spin
from atlasphys.engine.state.bodies import DYNAMIC, STATIC
from atlasphys.engine.state.joint_work import IMPULSES, LIVE, PART, ROW_A, TIED_A
from atlasphys.engine.state.joints import (
    ARM_A,
    ARM_B,
    AT_LOWER,
    AT_UPPER,
    COUPLING,
    DISTANCE,
    FIRST_BLOCK_TYPE,
    SPRING_MASS,
)
from atlasphys.engine.state.pose import ROTATION_LOCKS

RESOLVED = 0.5
"""κ up to which θ is 0. Larger: less is damped, and light bodies between heavy ones, which turn by half a radian a step, gain energy."""

TO_AND_FRO = 0.05
"""θ that gains of energy are let pass without. Smaller: slow motion loses energy (with 0 a chain of ten 0.2 to 2 % in ten seconds)."""

SINGULAR = 1e-6
"""Pivot of K, as a share of its greatest entry, below which a row is left out: nothing moves the bodies along it."""


@routine
def place_ends(bodies, body_count, h):
    """Write to ``motion`` 6–8 and to ``geometry`` where bodies would be at the end of the step; with h = 0, where they are."""
    real = type(h)
    motion, mass = bodies.motion, bodies.mass
    for i in range(body_count):
        orientation = quat.load(bodies.orientation, i)
        if bodies.kind[i] != STATIC:
            spin = (motion[i, 3], motion[i, 4], motion[i, 5])
            for k in range(3):
                motion[i, 6 + k] = h * motion[i, k]
            angle = h * h * vec.length_squared(spin)
            turn = vec.scale(spin, h * (real(1) + angle / real(12) + angle * angle / real(120)))
            isotropic = mass[i, 2] == mass[i, 3] and mass[i, 3] == mass[i, 4]
            free = not bodies.locks[i] & ROTATION_LOCKS
            if bodies.kind[i] == DYNAMIC and not isotropic and free and angle > 0:
                axes = quat.matrix(quat.mul(orientation, quat.load(bodies.principal, i)))
                inertia, inverse = (mass[i, 2], mass[i, 3], mass[i, 4]), (mass[i, 5], mass[i, 6], mass[i, 7])
                w = mat.transpose_mul_vec(axes, spin)
                momentum = (inertia[0] * w[0], inertia[1] * w[1], inertia[2] * w[2])
                turn = mat.mul_vec(axes, vec.scale(midpoint_spin(momentum, inertia, inverse, h), h))
            orientation = quat.unit(quat.mul(quat.cayley(turn), orientation))
        for k in range(4):
            bodies.geometry[i, 12 + k] = real(orientation[k])


@routine
def moved_inverse_mass(inverse_mass, joints, block, lane, side):
    """Inverse masses of the body on a side; zero for the world, and for what impulses do not move."""
    row = joints.integers[block, ROW_A + side, lane]
    m, inertia = load_inverse_mass(inverse_mass, row)
    if joints.integers[block, TIED_A + side, lane] and joints.moves[row]:
        return m, inertia
    zero = m[0] - m[0]
    return (zero, zero, zero), (zero, zero, zero, zero, zero, zero)


@routine
def rod_swing(bodies, block, lane, joints, length):
    """κ / (h λ) of the part distance: of the swing of the two bodies on the rod, and that of each on its own arm. K across the rod is at most
    1/m + r · t² for turns t across the arm r."""
    real = type(length)
    swing = across_rod = length - length
    for side in range(2):
        m, inertia = moved_inverse_mass(bodies.inverse_mass, joints, block, lane, side)
        column = ARM_B if side else ARM_A
        blocks = joints.blocks
        arm = (blocks[block, column, lane], blocks[block, column + 1, lane], blocks[block, column + 2, lane])
        reach = math.sqrt(vec.length_squared(arm))
        across_rod += max(m[0], m[1], m[2])
        if reach > 0:
            q = quat.load(bodies.orientation, joints.integers[block, ROW_A + side, lane])
            u = mat.mul_vec(quat.matrix(q), vec.scale(arm, real(1) / reach))
            s, t = vec.tangents((real(u[0]), real(u[1]), real(u[2])))
            turns = max(vec.dot(s, mat.sym_mul_vec(inertia, s)), vec.dot(t, mat.sym_mul_vec(inertia, t)))
            swing += reach * turns
            across_rod += reach * reach * turns
    return swing + across_rod / length if length > 0 else swing


@routine
def stable_share(kind, block, lane, bodies, joints, rows, h):
    """The θ that keeps the swing of light bodies under load stable.

    Under a load f, a body that turns by φ on a lever ℓ is driven back by f ℓ φ: κ = h² f / (ℓ m), with m the effective mass at its end."""
    real = type(h)
    squared = longest = loosest = h - h
    for r in range(row_count(kind)):
        impulse = impulse_along(kind, block, lane, joints, r)
        squared += impulse * impulse
        mass = rows[block, EFFECTIVE + r, lane]
        if mass > 0:
            loosest = max(loosest, real(1) / mass)
        for column in (TURN_A, TURN_B):
            longest = max(longest, vec.length_squared(side_of(rows, block, lane, r, column)))
    lever = real(1) if is_turning(kind) else math.sqrt(longest)
    stiff = h * math.sqrt(squared)
    if kind == DISTANCE:
        stiff *= rod_swing(bodies, block, lane, joints, rows[block, COORDINATE, lane])
    elif lever > 0:
        stiff *= loosest / lever
    else:
        return h - h
    return real(0.5) - real(0.5 * RESOLVED) / stiff if stiff > real(RESOLVED) else h - h


@routine
def workless_share(kind, block, lane, motion, before, joints, rows, least):
    """The θ with which a rigid part gives the bodies no energy, at least ``least``."""
    blocks = joints.blocks
    real = type(least)
    if kind >= FIRST_BLOCK_TYPE and blocks[block, SPRING_MASS, lane] >= 0:
        return least
    v_a, w_a = end_velocity(motion, joints, block, lane, 0)
    v_b, w_b = end_velocity(motion, joints, block, lane, 1)
    x_a, y_a = end_velocity(before, joints, block, lane, 0)
    x_b, y_b = end_velocity(before, joints, block, lane, 1)
    v_a, w_a, v_b, w_b = vec.add(v_a, x_a), vec.add(w_a, y_a), vec.add(v_b, x_b), vec.add(w_b, y_b)
    begun = ended = least - least
    for r in range(row_count(kind)):
        if kind >= FIRST_BLOCK_TYPE:
            impulse = blocks[block, IMPULSES + r, lane]
        else:
            impulse = blocks[block, IMPULSES + AT_LOWER, lane] - blocks[block, IMPULSES + AT_UPPER, lane]
        begun += impulse * row_rate(rows, block, lane, r, FIRST_ROWS, v_a, w_a, v_b, w_b)
        ended += impulse * row_rate(rows, block, lane, r, 0, v_a, w_a, v_b, w_b)
    if not ended < begun:
        return least
    return min(max(begun / (begun - ended) - real(TO_AND_FRO), least), real(1))


@routine
def coupled_mass(lane, block, rows, r, s, m_a, inertia_a, m_b, inertia_b):
    """K_rs = J_r M⁻¹ J_sᵀ."""
    of_a = vec.dot(weighted(m_a, side_of(rows, block, lane, r, PUSH_A)), side_of(rows, block, lane, s, PUSH_A))
    of_a += vec.dot(
        mat.sym_mul_vec(inertia_a, side_of(rows, block, lane, r, TURN_A)), side_of(rows, block, lane, s, TURN_A)
    )
    of_b = vec.dot(weighted(m_b, side_of(rows, block, lane, r, PUSH_B)), side_of(rows, block, lane, s, PUSH_B))
    of_b += vec.dot(
        mat.sym_mul_vec(inertia_b, side_of(rows, block, lane, r, TURN_B)), side_of(rows, block, lane, s, TURN_B)
    )
    return of_a + of_b


@routine
def factor(block, lane, inverse_mass, joints, rows):
    """Write the factors of K⁻¹ = L⁻ᵀ Δ⁻¹ L⁻¹ of three rows, where K = L Δ Lᵀ: the diagonal of Δ⁻¹, 0 for what nothing moves, and L⁻¹ below its
    diagonal of ones."""
    m_a, inertia_a = moved_inverse_mass(inverse_mass, joints, block, lane, 0)
    m_b, inertia_b = moved_inverse_mass(inverse_mass, joints, block, lane, 1)
    xx = coupled_mass(lane, block, rows, 0, 0, m_a, inertia_a, m_b, inertia_b)
    xy = coupled_mass(lane, block, rows, 0, 1, m_a, inertia_a, m_b, inertia_b)
    xz = coupled_mass(lane, block, rows, 0, 2, m_a, inertia_a, m_b, inertia_b)
    yy = coupled_mass(lane, block, rows, 1, 1, m_a, inertia_a, m_b, inertia_b)
    yz = coupled_mass(lane, block, rows, 1, 2, m_a, inertia_a, m_b, inertia_b)
    zz = coupled_mass(lane, block, rows, 2, 2, m_a, inertia_a, m_b, inertia_b)
    real = type(xx)
    zero, one = real(0), real(1)
    least = real(SINGULAR) * max(xx, yy, zz)
    x = one / xx if xx > least else zero
    a, b = xy * x, xz * x
    pivot = yy - a * xy
    y = one / pivot if pivot > least else zero
    beside = yz - b * xy
    c = beside * y
    pivot = zz - b * xz - c * beside
    z = one / pivot if pivot > least else zero
    for k, entry in enumerate((x, y, z, -a, c * a - b, -c)):
        rows[block, FACTOR + k, lane] = entry


@routine
def prepare_parts(bodies, joints, kinds, rows, h, gamma, least_penalty, most_penalty):
    """Note coordinates and Jacobians of the step's beginning, and let penalties decay."""
    for e in range(LANES * len(kinds)):
        block, lane = e // LANES, e % LANES
        if joints.integers[block, LIVE, lane]:
            kind = kinds[block]
            mass = gamma - gamma
            for r in range(row_count(kind)):
                rows[block, START + r, lane] = rows[block, COORDINATE + r, lane]
                rows[block, FIRST_MASS + r, lane] = rows[block, EFFECTIVE + r, lane]
                mass = max(mass, rows[block, EFFECTIVE + r, lane])
                for k in range(ROW_STRIDE * r, ROW_STRIDE * (r + 1)):
                    rows[block, FIRST_ROWS + k, lane] = rows[block, k, lane]
            rows[block, LEAST_SHARE, lane] = stable_share(kind, block, lane, bodies, joints, rows, h)
            if is_soft(kind, block, lane, joints):
                factor(block, lane, bodies.inverse_mass, joints, rows)
            part = joints.integers[block, PART, lane]
            penalty = max(gamma * joints.impulse[part, PENALTY], least_penalty * mass)
            joints.impulse[part, PENALTY] = min(penalty, most_penalty * mass)


@routine
def aim_parts(bodies, body_count, before, joints, kinds, rows, code, data, h, most):
    """Bring Jacobians and the coordinates at the step's end up to date: J v + bias is C / h at the present velocities, but differs from
    J v + C(x⁻) / h by no more than ``most``, in case a body turns so far in the step that J says nothing of where it ends. ``before`` are the
    velocities as the step began."""
    motion = bodies.motion
    place_ends(bodies, body_count, h)
    call_address(code, data, 0, 0, len(kinds))
    for e in range(LANES * len(kinds)):
        block, lane = e // LANES, e % LANES
        if joints.integers[block, LIVE, lane]:
            kind = kinds[block]
            v_a, w_a = end_velocity(motion, joints, block, lane, 0)
            v_b, w_b = end_velocity(motion, joints, block, lane, 1)
            share = workless_share(kind, block, lane, motion, before, joints, rows, rows[block, LEAST_SHARE, lane])
            for r in range(row_count(kind)):
                for k in range(ROW_STRIDE * r, ROW_STRIDE * (r + 1)):
                    begun = rows[block, FIRST_ROWS + k, lane]
                    rows[block, k, lane] = begun + share * (rows[block, k, lane] - begun)
                rows[block, EFFECTIVE + r, lane] = rows[block, FIRST_MASS + r, lane]
                bias = rows[block, START + r, lane] / h
                if kind != COUPLING:  # whose coordinate is the sum of what it slips
                    rate = row_rate(rows, block, lane, r, 0, v_a, w_a, v_b, w_b)
                    bent = (rows[block, COORDINATE + r, lane] - rows[block, START + r, lane]) / h - rate
                    bias += min(max(bent, -most), most)
                rows[block, BIAS + r, lane] = bias
