"""Joints in ``avbd``: rows that are springs of finite stiffness with multipliers, as its contacts are, but two-sided.

A row of a part (engine/joints) has the coordinate C and the Jacobian J, both of the step's beginning. It pushes along Jᵀ with f = λ − k s, where s is
how fast it is to be led back, or how far it is off at the step's end, over h:

    s = C(x⁻ + h v) / h − keep C(x⁻) / h.

C is taken at the poses in which the step would end, not from J, so that a link that turns within the step does not grow longer; and forces act along
Jᵀ at its beginning. Where the sweeps converge this is the scheme SHAKE (J.-P. Ryckaert, G. Ciccotti, H. J. C. Berendsen, J. Comput. Phys. 23, 1977),
a leapfrog step with constraints, so that a pendulum does not lose energy as in implicit Euler.

Leapfrog is unstable where a light body under load swings faster than steps resolve: an oscillation of angular frequency ω with κ = h² ω² > 4. So J is
a mean of those at the step's beginning and end, with the weight θ = max(0, ½ − ½ / κ) of the end. The characteristic equation of ẍ = −ω² x then,

    (1 + θ κ) z² − (2 − (1 − θ) κ) z + 1 = 0,

has no root beyond the unit circle for θ ≥ ½ − 2 / κ. It damps by 1 / (1 + θ κ) a step, only what is that fast. κ is found from last step's load.

Between two sweeps C is taken to be linear:
C(x⁻ + h v) / h = J v + bias, and after each the bias is set so that this is exact at the present v.

Springs are the exact ones of ``joints/elastic.py``, whose impulse is linear in v: λ = −(q v + p v₀ + β C₀) / (K (1 − q)) is a force with the
stiffness q / (K (1 − q)), and needs no multiplier. Motors and friction have multipliers with bounds, limits such as only push.

Source of the augmented Lagrangian scheme: C. Giles, E. Diaz, C. Yuksel, "Augmented Vertex Block Descent", ACM Trans. Graph. 44 (4), 2025, section 3.
"""

import math

from atlasphys.engine.jit import routine
from atlasphys.engine.joints.evaluate import COORDINATE, COORDINATES, EFFECTIVE, JACOBIANS, ROW_STRIDE, TURN_A, TURN_B
from atlasphys.engine.joints.visit import FULL_TURN
from atlasphys.engine.math import mat, quat, vec
from atlasphys.engine.simd import LANES
from atlasphys.engine.simd.address import call_address
from atlasphys.engine.solvers.common import load_velocity
from atlasphys.engine.solvers.integrate import midpoint_spin
from atlasphys.engine.state.bodies import DYNAMIC, STATIC
from atlasphys.engine.state.joint_work import (
    BEFORE,
    IMPULSES,
    LIVE,
    PART,
    ROW_A,
    ROW_B,
    SLIPPED,
    TIED_A,
    TIED_B,
    TOTALS,
)
from atlasphys.engine.state.joints import (
    AT_LOWER,
    AT_UPPER,
    AXIS,
    CONE,
    COUPLING,
    CROSS,
    DISTANCE,
    FIRST_BLOCK_TYPE,
    FRICTION,
    FRICTION_FORCE,
    LINE,
    LOCK,
    LOWER,
    MOTOR,
    MOTOR_FORCE,
    MOTOR_TOTAL,
    PULLEY,
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
from atlasphys.engine.state.pose import ROTATION_LOCKS

# Fields of a block in the table of rows, after those of joints/evaluate.py
START = 42  # 42–44 C as the step began
BIAS = 45  # 45–47 C at the step's end, over h, is J v + bias
FIRST_ROWS = 48  # 48–83 J as the step began
END_SHARE = 84  # θ
FIRST_MASS = 85  # 85–87 effective masses as the step began

PENALTY = 7
"""Column of ``Parts.impulse`` that keeps the penalty from step to step."""


RESOLVED = 0.05
"""κ up to which Jacobians are those of the step's beginning alone."""


@routine
def list_parts(body_count, joints, first, entries):
    """List each body's parts: body i has the entries ``first[i]`` to ``first[i + 1]``, twice 8 block + lane, plus 1 where it is b."""
    integers = joints.integers
    for i in range(body_count + 2):
        first[i] = 0
    for e in range(LANES * len(integers)):
        block, lane = e // LANES, e % LANES
        if integers[block, LIVE, lane]:
            for side in range(2):
                if integers[block, TIED_A + side, lane]:
                    first[integers[block, ROW_A + side, lane] + 2] += 1
    for i in range(body_count):
        first[i + 2] += first[i + 1]
    for e in range(LANES * len(integers)):
        block, lane = e // LANES, e % LANES
        if integers[block, LIVE, lane]:
            for side in range(2):
                if integers[block, TIED_A + side, lane]:
                    row = integers[block, ROW_A + side, lane] + 1
                    entries[first[row]] = 2 * e + side
                    first[row] += 1


@routine
def list_links(joints, pairs, count):
    """Write the bodies that each part ties behind the pairs in contact. Returns how many pairs there are now. A body that is tied to the world is
    paired with itself."""
    integers = joints.integers
    for e in range(LANES * len(integers)):
        block, lane = e // LANES, e % LANES
        if integers[block, LIVE, lane]:
            a, b = integers[block, ROW_A, lane], integers[block, ROW_B, lane]
            pairs[count, 0], pairs[count, 1] = a, b
            count += 1
    return count


@routine
def bind_to_world(joints, kinds, parent, free):
    """Islands with a part that does not act on two bodies alike are not free."""
    integers = joints.integers
    for e in range(LANES * len(integers)):
        block, lane = e // LANES, e % LANES
        if integers[block, LIVE, lane]:
            both = integers[block, TIED_A, lane] and integers[block, TIED_B, lane]
            if not both or kinds[block] == PULLEY or kinds[block] == COUPLING:
                free[parent[integers[block, ROW_A, lane]]] = free[parent[integers[block, ROW_B, lane]]] = False


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
def row_rate(rows, block, lane, r, v_a, w_a, v_b, w_b):
    """J v."""
    of_a = vec.dot(side_of(rows, block, lane, r, 0), v_a) + vec.dot(side_of(rows, block, lane, r, TURN_A), w_a)
    of_b = vec.dot(side_of(rows, block, lane, r, 6), v_b) + vec.dot(side_of(rows, block, lane, r, TURN_B), w_b)
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
def part_force(kind, block, lane, motion, joints, rows, h, alpha, most, keeps):
    """Impulses along the rows of a part, their stiffness, and by how much it is off [speed]."""
    zero = h - h
    v_a, w_a = end_velocity(motion, joints, block, lane, 0)
    v_b, w_b = end_velocity(motion, joints, block, lane, 1)
    penalty = joints.impulse[joints.integers[block, PART, lane], PENALTY]
    rate = row_rate(rows, block, lane, 0, v_a, w_a, v_b, w_b)
    if kind < FIRST_BLOCK_TYPE:
        x, stiffness, off = axial_force(kind, block, lane, joints, rows, penalty, rate, h, alpha, most, keeps)
        return (x, zero, zero), stiffness, off
    second = row_rate(rows, block, lane, 1, v_a, w_a, v_b, w_b)
    third = row_rate(rows, block, lane, 2, v_a, w_a, v_b, w_b) if row_count(kind) == 3 else zero
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
        for r in range(row_count(kind)):
            push, turn = side_of(rows, block, lane, r, 6 * is_b), side_of(rows, block, lane, r, 6 * is_b + TURN_A)
            force = vec.add_scaled(force, push, sign * impulses[r])
            torque = vec.add_scaled(torque, turn, sign * impulses[r])
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


@routine
def end_share(kind, block, lane, joints, rows, h):
    """θ: by how much J is to be that of the step's end.

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
    if kind == DISTANCE and lever == 0:
        lever = rows[block, COORDINATE, lane]
    if lever == 0:
        return h - h
    stiff = h * math.sqrt(squared) * loosest
    stiff /= lever
    return real(0.5) - real(0.5 * RESOLVED) / stiff if stiff > real(RESOLVED) else h - h


@routine
def prepare_parts(joints, kinds, rows, h, gamma, least_penalty, most_penalty):
    """Note coordinates and Jacobians of the step's beginning, and let penalties decay. Returns what ``aim_parts`` has to find anew."""
    mode = COORDINATES
    for e in range(LANES * len(kinds)):
        block, lane = e // LANES, e % LANES
        if joints.integers[block, LIVE, lane]:
            mass = gamma - gamma
            for r in range(row_count(kinds[block])):
                rows[block, START + r, lane] = rows[block, COORDINATE + r, lane]
                rows[block, FIRST_MASS + r, lane] = rows[block, EFFECTIVE + r, lane]
                mass = max(mass, rows[block, EFFECTIVE + r, lane])
                for k in range(ROW_STRIDE * r, ROW_STRIDE * (r + 1)):
                    rows[block, FIRST_ROWS + k, lane] = rows[block, k, lane]
            share = end_share(kinds[block], block, lane, joints, rows, h)
            rows[block, END_SHARE, lane] = share
            if share > 0:
                mode = JACOBIANS
            part = joints.integers[block, PART, lane]
            penalty = max(gamma * joints.impulse[part, PENALTY], least_penalty * mass)
            joints.impulse[part, PENALTY] = min(penalty, most_penalty * mass)
    return mode


@routine
def aim_parts(bodies, body_count, joints, kinds, rows, code, data, mode, h, most):
    """Bring the coordinates at the step's end up to date: J v + bias is C / h at the present velocities, but differs from J v + C(x⁻) / h by no more
    than ``most``, in case a body turns so far in the step that J says nothing of where it ends."""
    motion = bodies.motion
    place_ends(bodies, body_count, h)
    call_address(code, data, mode, 0, len(kinds))
    for e in range(LANES * len(kinds)):
        block, lane = e // LANES, e % LANES
        if joints.integers[block, LIVE, lane]:
            v_a, w_a = end_velocity(motion, joints, block, lane, 0)
            v_b, w_b = end_velocity(motion, joints, block, lane, 1)
            for r in range(row_count(kinds[block])):
                if mode == JACOBIANS:
                    share = rows[block, END_SHARE, lane]
                    for k in range(ROW_STRIDE * r, ROW_STRIDE * (r + 1)):
                        begun = rows[block, FIRST_ROWS + k, lane]
                        rows[block, k, lane] = begun + share * (rows[block, k, lane] - begun)
                    rows[block, EFFECTIVE + r, lane] = rows[block, FIRST_MASS + r, lane]
                bias = rows[block, START + r, lane] / h
                if kinds[block] != COUPLING:  # whose coordinate is the sum of what it slips
                    rate = row_rate(rows, block, lane, r, v_a, w_a, v_b, w_b)
                    bent = (rows[block, COORDINATE + r, lane] - rows[block, START + r, lane]) / h - rate
                    bias += min(max(bent, -most), most)
                rows[block, BIAS + r, lane] = bias


@routine
def update_parts(motion, joints, kinds, rows, h, alpha, most, beta, rise, most_penalty, fall, most_mass, length_unit):
    """λ ← f for all parts, and greater penalties where the load asks for them, as for contacts
    (``avbd.update_multipliers``). Returns the greatest error of a part [speed], angles times the length unit."""
    error = h - h
    for e in range(LANES * len(kinds)):
        block, lane = e // LANES, e % LANES
        if joints.integers[block, LIVE, lane]:
            kind, part = kinds[block], joints.integers[block, PART, lane]
            impulses, _, off = part_force(kind, block, lane, motion, joints, rows, h, alpha, most, True)
            turns = is_turning(kind)
            error = max(error, off * length_unit if turns else off)
            if off > 0:
                unit = length_unit if turns else h / h
                carried = min(math.sqrt(vec.length_squared(impulses)) * unit / fall, most_mass * unit * unit)
                mass = h - h
                for r in range(row_count(kind)):
                    mass = max(mass, rows[block, EFFECTIVE + r, lane])
                penalty = joints.impulse[part, PENALTY]
                wanted = min(beta * carried, rise * penalty)
                joints.impulse[part, PENALTY] = min(max(penalty, wanted), most_penalty * mass)
    return error


@routine
def forget_multipliers(joints):
    """Begin the next step without multipliers. Where the constraints contradict each other they grow from sweep to sweep, and are no guess."""
    for block in range(len(joints.blocks)):
        for k in range(IMPULSES, SLIPPED):
            for lane in range(LANES):
                joints.blocks[block, k, lane] = 0
        for lane in range(LANES):
            if joints.integers[block, LIVE, lane]:
                joints.impulse[joints.integers[block, PART, lane], PENALTY] = 0


@routine
def restrain(motion, inertial, body_count, first, fastest):
    """Let no joined body's velocity be changed by more than ``fastest``, as joints do that contradict each other."""
    for i in range(body_count):
        if first[i] < first[i + 1]:
            for k in (0, 3):
                before = vec.load_columns(inertial, i, k)
                change = vec.sub(vec.load_columns(motion, i, k), before)
                size = math.sqrt(vec.length_squared(change))
                if size > fastest:
                    vec.store_columns(motion, i, k, vec.add_scaled(before, change, fastest / size))


@routine
def report_parts(motion, joints, kinds, rows, h):
    """Write the impulses of the step on body b, the rates of coordinates, and how far couplings have slipped."""
    blocks = joints.blocks
    for e in range(LANES * len(kinds)):
        block, lane = e // LANES, e % LANES
        if joints.integers[block, LIVE, lane]:
            kind = kinds[block]
            turns = is_turning(kind) or kind == COUPLING
            for r in range(row_count(kind)):
                impulse = impulse_along(kind, block, lane, joints, r)
                push, turn = side_of(rows, block, lane, r, 6), side_of(rows, block, lane, r, TURN_B)
                for k in range(3):
                    blocks[block, TOTALS + k, lane] += impulse * push[k]
                    if turns:
                        blocks[block, TOTALS + 3 + k, lane] += impulse * turn[k]
            if kind < FIRST_BLOCK_TYPE:
                v_a, w_a = end_velocity(motion, joints, block, lane, 0)
                v_b, w_b = end_velocity(motion, joints, block, lane, 1)
                rate = row_rate(rows, block, lane, 0, v_a, w_a, v_b, w_b)
                blocks[block, BEFORE, lane] = rate
                blocks[block, TOTALS + MOTOR_TOTAL, lane] = blocks[block, IMPULSES + MOTOR, lane]
                if kind == COUPLING:
                    blocks[block, SLIPPED, lane] += h * rate
