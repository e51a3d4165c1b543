"""What ``soft_step`` does with eight bodies at a time: forces, motion in a substep, the pose at the end of a step. Bodies over lanes.

The scheme is that of ``integrate.py``: semi-implicit Euler, and for bodies whose angular velocity changes without torque the implicit
midpoint rule with the Cayley turn of the same ω_m, which keeps angular momentum and energy. Newton's iterations are
a fixed number here.
"""

from atlasphys.engine.simd import (
    absolute,
    all_lanes,
    full,
    gather,
    load,
    maximum,
    scatter,
    select,
    simd_kernel,
    sqrt,
    store,
    vec,
)

POSE = 8
"""First of the columns of ``Bodies.geometry`` that hold 8 R₂₂, 9–11 offset, 12–15 orientation."""

NEWTON_ITERATIONS = 3
"""Newton iterations for ω_m, from ω₀. The error is squared in each; a body that turns by 0.1 rad a substep is at 1e-13 after three."""


def quat_mul(p, q):
    """p q: first the turn q, then p."""
    return (
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    )


def quat_unit(q):
    """q / |q|."""
    inverse = 1 / sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    return tuple(inverse * x for x in q)


def quat_matrix(q):
    """Rotation matrix of a unit quaternion, row by row."""
    w, x, y, z = q
    return (
        1 - 2 * (y * y + z * z),
        2 * (x * y - w * z),
        2 * (x * z + w * y),
        2 * (x * y + w * z),
        1 - 2 * (x * x + z * z),
        2 * (y * z - w * x),
        2 * (x * z - w * y),
        2 * (y * z + w * x),
        1 - 2 * (x * x + y * y),
    )


def cayley(turn):
    """Unit quaternion of the Cayley rotation by a vector: 1 + turn / 2, normalised."""
    return quat_unit((full(turn[0], 1), 0.5 * turn[0], 0.5 * turn[1], 0.5 * turn[2]))


def rotated_diagonal(m, d):
    """M diag(d) Mᵀ: xx yy zz xy xz yz."""
    scaled = tuple(m[3 * i + j] * d[j] for i in range(3) for j in range(3))
    rows = [(scaled[3 * i : 3 * i + 3], m[3 * i : 3 * i + 3]) for i in range(3)]
    return tuple(vec.dot(rows[i][0], rows[j][1]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))


@simd_kernel
def drive(locks, block, rows, motion, force, response, inverse_mass, mass, drives, gravity, h):
    """Work out what a substep of length h does to the velocities: gravity and forces, and damping (an implicit Euler step).

    Unless ``locks`` is None, velocities along and about locked axes are stopped.
    """
    row = load(rows, block)
    push, answer = gather(force, row), gather(response, row)
    inverse, own = gather(inverse_mass, row, 16), gather(mass, row)
    moves = own[1] > 0
    v = [h * (select(inverse[8 + k] > 0, answer[0] * gravity[k], 0) + inverse[8 + k] * push[k]) for k in range(3)]
    w = [h * x for x in vec.sym_mul_vec(inverse[0:6], push[4:7])]
    linear, angular = (select(moves, 1 / (1 + h * answer[i]), 1) for i in (1, 2))
    scatter(drives, row, (*v, linear, *w, angular))
    if locks is not None:
        m = gather(motion, row)
        stopped = [moves & ~(inverse[8 + k] > 0) for k in range(3)] + [moves & ~(inverse[k] > 0) for k in range(3)]
        scatter(motion, row, (*(select(s, 0, x) for s, x in zip(stopped, m[0:6], strict=True)), *m[6:8]))


def driven(m, d):
    """Velocity and angular velocity after the velocity half of a substep."""
    v = [(m[k] + d[k]) * d[3] for k in range(3)]
    w = [(m[3 + k] + d[4 + k]) * d[7] for k in range(3)]
    return (*v, *w)


def turn_of(w, h):
    """2 tan(|h ω| / 2) along ω, to fifth order: the Cayley rotation by it turns by |h ω|."""
    angle = h * h * vec.length_squared(w)
    return vec.scale(w, h * (1 + angle / 12 + angle * angle / 120))


@simd_kernel
def gain_speed(block, rows, motion, drives):
    """The velocity half of a substep."""
    row = load(rows, block)
    m = gather(motion, row)
    scatter(motion, row, (*driven(m, gather(drives, row)), m[6], m[7]))


@simd_kernel
def move(block, rows, motion, geometry, h):
    """The position half of a substep for bodies that keep their angular velocity."""
    row = load(rows, block)
    m, pose = gather(motion, row, 16), gather(geometry, row, 8, POSE)
    advance(row, motion, geometry, m, pose, m[3:6], turn_of(m[3:6], h), h)


@simd_kernel
def fly(block, rows, motion, geometry, drives, h):
    """Both halves of a substep for bodies that keep their angular velocity, between which nothing changes their velocities."""
    row = load(rows, block)
    m, pose = gather(motion, row, 16), gather(geometry, row, 8, POSE)
    m = (*driven(m, gather(drives, row)), *m[6:16])
    advance(row, motion, geometry, m, pose, m[3:6], turn_of(m[3:6], h), h)


def advance(row, motion, geometry, m, pose, spin, turn, h):
    """Write the motion since the step's start, the angular velocity and the orientation."""
    moved = [m[6 + k] + h * m[k] for k in range(3)]
    turned = [m[9 + k] + turn[k] for k in range(3)]
    scatter(motion, row, (*m[0:3], *spin, *moved, *turned, *m[12:16]))
    scatter(geometry, row, (*pose[0:4], *quat_mul(cayley(turn), pose[4:8])), POSE)


@simd_kernel
def tumble(block, rows, motion, geometry, mass, frame, inverse_mass, h):
    """The position half of a substep for bodies with unequal moments of inertia; their inverse inertia turns with them.

    Lanes of other bodies are moved as ``move`` does.
    """
    row = load(rows, block)
    m, pose = gather(motion, row, 16), gather(geometry, row, 8, POSE)
    own, at, inverse_row = gather(mass, row), gather(frame, row), gather(inverse_mass, row, 16)
    free = at[3] > 0
    spin = m[3:6]
    zero = full(spin[0], 0)
    # Moments relative to the greatest: products of three of them stay within single precision's range, whatever the body's size.
    greatest = select(free, maximum(own[2], maximum(own[3], own[4])), 1)
    inertia = [select(free, own[2 + k] / greatest, 1) for k in range(3)]
    inverse = [select(free, own[5 + k] * greatest, 1) for k in range(3)]
    to_world = quat_mul(pose[4:8], at[4:8])
    axes = quat_matrix(quat_unit(to_world))
    w = start = vec.mat_transpose_mul_vec(axes, spin)
    momentum = tuple(inertia[k] * w[k] for k in range(3))
    half = 0.5 * h
    for _ in range(NEWTON_ITERATIONS):
        p = tuple(inertia[k] * w[k] for k in range(3))
        residual = vec.sub(vec.add_scaled(p, vec.cross(w, p), half), momentum)
        u = (inertia[0], half * (w[2] * inertia[0] - p[2]), half * (p[1] - w[1] * inertia[0]))
        v = (half * (p[2] - w[2] * inertia[1]), inertia[1], half * (w[0] * inertia[1] - p[0]))
        x = (half * (w[1] * inertia[2] - p[1]), half * (p[0] - w[0] * inertia[2]), inertia[2])
        vx = vec.cross(v, x)
        scale = 1 / vec.dot(u, vx)
        step = vec.dot(residual, vx), vec.dot(u, vec.cross(residual, x)), vec.dot(u, vec.cross(v, residual))
        w = vec.sub(w, vec.scale(step, scale))
    turn = vec.select_vec(free, vec.mat_mul_vec(axes, vec.scale(w, h)), turn_of(spin, h))
    after = quat_matrix(quat_unit(quat_mul(cayley(turn), to_world)))
    # L is kept in world axes; round-off in the axes has a bias in energy, which is taken out.
    kept = vec.mat_transpose_mul_vec(after, vec.mat_mul_vec(axes, momentum))
    spun = vec.mat_mul_vec(after, tuple(inverse[k] * kept[k] for k in range(3)))
    now = vec.mat_transpose_mul_vec(after, spun)
    energy = inertia[0] * now[0] * now[0] + inertia[1] * now[1] * now[1] + inertia[2] * now[2] * now[2]
    before = inertia[0] * start[0] * start[0] + inertia[1] * start[1] * start[1] + inertia[2] * start[2] * start[2]
    excess = energy - before
    share = select(absolute(excess) < energy, -0.5 * excess / energy, zero)
    spun = vec.add_scaled(spun, spun, share)
    turned = rotated_diagonal(after, [select(free, own[5 + k], 1) for k in range(3)])
    tensor = [select(free, turned[k], inverse_row[k]) for k in range(6)]
    scatter(inverse_mass, row, (*tensor, *inverse_row[6:16]))
    advance(row, motion, geometry, m, pose, vec.select_vec(free, spun, spin), turn, h)


@simd_kernel
def settle(block, rows, motion, geometry, frame, moved) -> bool:
    """The pose at the end of a step: unit orientation, rotation matrix, offset of the centre of mass. Whether all numbers are finite.

    ``moved`` (8, 8) receives what is left to do in double precision: 0–2 displacement; 3–5 the new offset; the motion since the step's
    start is set to zero.
    """
    row = load(rows, block)
    m, pose, at = gather(motion, row, 16), gather(geometry, row, 8, POSE), gather(frame, row)
    q = quat_unit(pose[4:8])
    rotation = quat_matrix(q)
    offset = vec.mat_mul_vec(rotation, at[0:3])
    zero = full(m[0], 0)
    total = zero
    for x in (*m[0:9], *q):
        total = total + 0 * x  # NaN where x is not finite
    for k in range(3):
        store(moved, k, m[6 + k])
        store(moved, 3 + k, offset[k])
    scatter(motion, row, (*m[0:6], *([zero] * 6), *m[12:16]))
    scatter(geometry, row, (*rotation, *offset, *q))
    return all_lanes(total == 0)
