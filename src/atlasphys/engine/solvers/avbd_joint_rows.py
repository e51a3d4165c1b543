"""Rows of joints in ``avbd``: what impulses they give, how stiff they are, and their part in a body's own system. See avbd_joints.py."""

import math

from atlasphys.engine.jit import routine
from atlasphys.engine.joints.evaluate import EFFECTIVE, PUSH_B, ROW_STRIDE, TURN_A, TURN_B
from atlasphys.engine.joints.visit import FULL_TURN
from atlasphys.engine.math import mat, vec
from atlasphys.engine.simd import LANES
from atlasphys.engine.solvers.common import load_velocity
from atlasphys.engine.state.joint_work import BEFORE, IMPULSES, PART, ROW_A, TIED_A
from atlasphys.engine.state.joints import (
    AT_LOWER,
    AT_UPPER,
    AXIS,
    CONE,
    CROSS,
    FIRST_BLOCK_TYPE,
    FRICTION,
    FRICTION_FORCE,
    LINE,
    LOCK,
    LOWER,
    MOTOR,
    MOTOR_FORCE,
    REST,
    ROTATION,
    SPEED,
    SPRING,
    SPRING_BEFORE,
    SPRING_FORCE,
    SPRING_MASS,
    SPRING_PULL,
    UPPER,
)

# Fields of a block in the table of rows, after those of joints/evaluate.py
START = 42  # 42–44 C as the step began
BIAS = 45  # 45–47 C at the step's end, over h, is J v + bias
FIRST_ROWS = 48  # 48–83 J as the step began
LEAST_SHARE = 84  # the least θ, see avbd_joint_aim.py
FIRST_MASS = 85  # 85–87 effective masses as the step began
FACTOR = 88  # 88–93 of a spring on a vector: the factors of K⁻¹ as the step began

PENALTY = 7
"""Column of ``Parts.impulse`` that keeps the penalty from step to step."""

STIFFEST = 1e3
"""Greatest stiffness of a spring on a vector, in units of the effective mass: overdamped ones have any, but sweeps have to converge."""


@routine
def is_turning(kind):
    """Whether the coordinate of a part is an angle."""
    return kind in (ROTATION, CONE, CROSS, AXIS, LOCK)


@routine
def row_count(kind):
    """Number of rows of a part of a type."""
    if kind < FIRST_BLOCK_TYPE:
        return 1
    return 2 if kind in (AXIS, LINE) else 3


@routine
def is_soft(kind, block, lane, joints):
    """Whether a part is a spring on a vector."""
    return kind >= FIRST_BLOCK_TYPE and joints.blocks[block, SPRING_PULL, lane] > 0


@routine
def side_of(rows, block, lane, r, column):
    """Three entries of row r, from a column on."""
    k = ROW_STRIDE * r + column
    return rows[block, k, lane], rows[block, k + 1, lane], rows[block, k + 2, lane]


@routine
def end_velocity(motion, joints, block, lane, side):
    """Velocity of the body on a side; zero for the world."""
    row = joints.integers[block, ROW_A + side, lane]
    v, w = load_velocity(motion, row)
    if joints.integers[block, TIED_A + side, lane]:
        return v, w
    zero = v[0] - v[0]
    return (zero, zero, zero), (zero, zero, zero)


@routine
def row_rate(rows, block, lane, r, first, v_a, w_a, v_b, w_b):
    """J v, by the present rows (``first`` = 0) or those of the step's beginning (``FIRST_ROWS``)."""
    of_a = vec.dot(side_of(rows, block, lane, r, first), v_a)
    of_a += vec.dot(side_of(rows, block, lane, r, first + TURN_A), w_a)
    of_b = vec.dot(side_of(rows, block, lane, r, first + PUSH_B), v_b)
    of_b += vec.dot(side_of(rows, block, lane, r, first + TURN_B), w_b)
    return of_b - of_a


@routine
def kept(error, alpha, most):
    """The part of an error that is left for later steps: the share ``alpha``, but no less than lets ``most`` be taken back in this step."""
    taken = (type(error)(1) - alpha) * error
    return error - min(max(taken, -most), most)


@routine
def bounded(x, most):
    """x within ±most, and the share of it that this is."""
    one = type(x)(1)
    if abs(x) <= most:
        return x, one
    return (most if x > 0 else -most), most / abs(x)


@routine
def shorter_way(error):
    """An angle between −π and π."""
    full = type(error)(FULL_TURN)
    if error > type(error)(0.5) * full:
        return error - full
    if error < type(error)(-0.5) * full:
        return error + full
    return error


@routine
def axial_force(kind, block, lane, joints, rows, penalty, rate, h, alpha, most, keeps):
    """Impulse and stiffness of a part with one coordinate, at its rate J v, and by how much it is off [speed]. ``keeps`` is whether the impulses
    become the multipliers."""
    blocks = joints.blocks
    zero = h - h
    coordinate, bias = rows[block, START, lane], rows[block, BIAS, lane]
    total = stiffness = off = zero
    q = blocks[block, SPRING_MASS, lane]
    if q >= 0:
        error = coordinate - blocks[block, REST, lane]
        if kind == ROTATION:
            error = shorter_way(error)
        constant = (
            blocks[block, SPRING_BEFORE, lane] * blocks[block, BEFORE, lane] + blocks[block, SPRING_PULL, lane] * error
        )
        mass = rows[block, EFFECTIVE, lane] / (type(h)(1) - q)
        pull, share = bounded(-mass * (q * rate + constant), h * blocks[block, SPRING_FORCE, lane])
        total += pull
        stiffness += mass * q * share
        if keeps:
            blocks[block, IMPULSES + SPRING, lane] = pull
    limit = h * blocks[block, MOTOR_FORCE, lane]
    if limit > 0:
        beyond = rate - blocks[block, SPEED, lane]
        drive, share = bounded(blocks[block, IMPULSES + MOTOR, lane] - penalty * beyond, limit)
        total += drive
        stiffness += penalty * share
        if share == 1:
            off = max(off, abs(beyond))
        if keeps:
            blocks[block, IMPULSES + MOTOR, lane] = drive
    limit = h * blocks[block, FRICTION_FORCE, lane]
    if limit > 0:
        rub, share = bounded(blocks[block, IMPULSES + FRICTION, lane] - penalty * rate, limit)
        total += rub
        stiffness += penalty * share
        if keeps:
            blocks[block, IMPULSES + FRICTION, lane] = rub
    least, greatest = blocks[block, LOWER, lane], blocks[block, UPPER, lane]
    for side in range(2):
        bound = least if side == 0 else greatest
        if abs(bound) < 1e17 and (side == 0 or least != greatest):
            sign = type(h)(1) if side == 0 else -type(h)(1)
            gap = sign * (coordinate - bound)
            aim = kept(gap, alpha, most)
            if least != greatest:
                aim = min(aim, zero)
            # The gap at the end, over h, less what it is to be
            s = sign * (rate + bias - bound / h) - aim / h
            load = blocks[block, IMPULSES + AT_LOWER + side, lane]
            pressed = load - penalty * s
            if least != greatest:
                pressed = max(pressed, zero)
            if pressed != 0 or load != 0:
                stiffness += penalty
                off = max(off, abs(s))
            total += sign * pressed
            if keeps:
                blocks[block, IMPULSES + AT_LOWER + side, lane] = pressed
    return total, stiffness, off


@routine
def block_force(kind, block, lane, joints, rows, penalty, rates, h, alpha, most, keeps):
    """Impulses along three rows (those that there are not are 0), their stiffness, and by how much they are off [speed]."""
    blocks = joints.blocks
    zero = h - h
    x = y = z = off = zero
    stiffness = penalty
    rubs = blocks[block, SPRING_MASS, lane] > 0  # friction
    n = row_count(kind)
    if rubs:
        x = blocks[block, IMPULSES, lane] - penalty * rates[0]
        y = blocks[block, IMPULSES + 1, lane] - penalty * rates[1]
        z = blocks[block, IMPULSES + 2, lane] - penalty * rates[2] if n == 3 else zero
        _, share = bounded(math.sqrt(x * x + y * y + z * z), h * blocks[block, SPRING_FORCE, lane])
        x, y, z = x * share, y * share, z * share
        stiffness = penalty * share
    else:
        s = rates[0] + rows[block, BIAS, lane] - kept(rows[block, START, lane], alpha, most) / h
        x, off = blocks[block, IMPULSES, lane] - penalty * s, abs(s)
        s = rates[1] + rows[block, BIAS + 1, lane] - kept(rows[block, START + 1, lane], alpha, most) / h
        y, off = blocks[block, IMPULSES + 1, lane] - penalty * s, max(off, abs(s))
        if n == 3:
            s = rates[2] + rows[block, BIAS + 2, lane] - kept(rows[block, START + 2, lane], alpha, most) / h
            z, off = blocks[block, IMPULSES + 2, lane] - penalty * s, max(off, abs(s))
    if keeps:
        blocks[block, IMPULSES, lane], blocks[block, IMPULSES + 1, lane] = x, y
        if n == 3:
            blocks[block, IMPULSES + 2, lane] = z
    return (x, y, z), stiffness, off


@routine
def soft_force(block, lane, joints, rows, rates, h, keeps):
    """Impulses of a spring on a vector, and its stiffness in units of K⁻¹: as that of one coordinate, with K⁻¹ for 1 / K."""
    blocks = joints.blocks
    real = type(h)
    q, pull = blocks[block, SPRING_MASS, lane], blocks[block, SPRING_PULL, lane]
    softness = max(real(1) - q, real(1 / STIFFEST))
    m_x, m_y, m_z = side_of(rows, block, lane, 0, FACTOR)
    a, b, c = side_of(rows, block, lane, 0, FACTOR + 3)
    x = q * rates[0] + pull * rows[block, START, lane]
    y = q * rates[1] + pull * rows[block, START + 1, lane]
    z = q * rates[2] + pull * rows[block, START + 2, lane]
    z = m_z * (z + b * x + c * y)
    y = m_y * (y + a * x)
    x = m_x * x + a * y + b * z
    y += c * z
    x, y, z = -x / softness, -y / softness, -z / softness
    _, share = bounded(math.sqrt(x * x + y * y + z * z), h * blocks[block, SPRING_FORCE, lane])
    impulses = (x * share, y * share, z * share)
    if keeps:
        for k in range(3):
            blocks[block, IMPULSES + k, lane] = impulses[k]
    return impulses, q * share / softness


@routine
def part_force(kind, block, lane, motion, joints, rows, h, alpha, most, keeps):
    """Impulses along the rows of a part, their stiffness, and by how much it is off [speed]."""
    zero = h - h
    v_a, w_a = end_velocity(motion, joints, block, lane, 0)
    v_b, w_b = end_velocity(motion, joints, block, lane, 1)
    penalty = joints.impulse[joints.integers[block, PART, lane], PENALTY]
    rate = row_rate(rows, block, lane, 0, 0, v_a, w_a, v_b, w_b)
    if kind < FIRST_BLOCK_TYPE:
        x, stiffness, off = axial_force(kind, block, lane, joints, rows, penalty, rate, h, alpha, most, keeps)
        return (x, zero, zero), stiffness, off
    second = row_rate(rows, block, lane, 1, 0, v_a, w_a, v_b, w_b)
    third = row_rate(rows, block, lane, 2, 0, v_a, w_a, v_b, w_b) if row_count(kind) == 3 else zero
    if is_soft(kind, block, lane, joints):
        impulses, stiffness = soft_force(block, lane, joints, rows, (rate, second, third), h, keeps)
        return impulses, stiffness, zero
    return block_force(kind, block, lane, joints, rows, penalty, (rate, second, third), h, alpha, most, keeps)


@routine
def joint_system(i, motion, joints, kinds, rows, first, entries, h, alpha, most, system):
    """Add to a body's own system (force, torque, and the three blocks of H) what its joints give."""
    force, torque, straight, mixed, turning = system
    one = type(h)(1)
    for e in range(first[i], first[i + 1]):
        part, is_b = entries[e] >> 1, entries[e] & 1
        block, lane = part // LANES, part % LANES
        kind = kinds[block]
        impulses, k, _ = part_force(kind, block, lane, motion, joints, rows, h, alpha, most, False)
        sign = one if is_b else -one
        soft, stiffness = is_soft(kind, block, lane, joints), k
        for r in range(row_count(kind)):
            push, turn = side_of(rows, block, lane, r, 6 * is_b), side_of(rows, block, lane, r, 6 * is_b + TURN_A)
            force = vec.add_scaled(force, push, sign * impulses[r])
            torque = vec.add_scaled(torque, turn, sign * impulses[r])
            if soft:  # Jᵀ K⁻¹ J = (L⁻¹ J)ᵀ Δ⁻¹ (L⁻¹ J)
                k = stiffness * rows[block, FACTOR + r, lane]
                for s in range(r):
                    entry = rows[block, FACTOR + 2 + r + s, lane]
                    push = vec.add_scaled(push, side_of(rows, block, lane, s, 6 * is_b), entry)
                    turn = vec.add_scaled(turn, side_of(rows, block, lane, s, 6 * is_b + TURN_A), entry)
            straight = mat.sym_add_square(straight, push, k)
            turning = mat.sym_add_square(turning, turn, k)
            x, y, z = vec.scale(turn, k)
            mixed = (
                mixed[0] + x * push[0], mixed[1] + x * push[1], mixed[2] + x * push[2],
                mixed[3] + y * push[0], mixed[4] + y * push[1], mixed[5] + y * push[2],
                mixed[6] + z * push[0], mixed[7] + z * push[1], mixed[8] + z * push[2],
            )  # fmt: skip
    return force, torque, straight, mixed, turning


@routine
def joint_push(i, joints, kinds, rows, first, entries):
    """Impulse on a body by the multipliers of its joints."""
    real = rows.dtype.type
    zero, one = real(0), real(1)
    push = (zero, zero, zero)
    for e in range(first[i], first[i + 1]):
        part, is_b = entries[e] >> 1, entries[e] & 1
        block, lane = part // LANES, part % LANES
        sign = one if is_b else -one
        for r in range(row_count(kinds[block])):
            push = vec.add_scaled(
                push,
                side_of(rows, block, lane, r, 6 * is_b),
                sign * impulse_along(kinds[block], block, lane, joints, r),
            )
    return push


@routine
def impulse_along(kind, block, lane, joints, r):
    """Impulse along row r, by the multipliers."""
    blocks = joints.blocks
    if kind >= FIRST_BLOCK_TYPE:
        return blocks[block, IMPULSES + r, lane]
    pulls = blocks[block, IMPULSES + SPRING, lane] + blocks[block, IMPULSES + MOTOR, lane]
    pulls += blocks[block, IMPULSES + FRICTION, lane] + blocks[block, IMPULSES + AT_LOWER, lane]
    return pulls - blocks[block, IMPULSES + AT_UPPER, lane]
