"""Integration of velocities and positions over one step of length h.

Semi-implicit Euler: velocities first, then positions with the new velocities, so that free fall gives exactly
y = y0 + v0 t − ½ g t (t + h) and energies do not drift.

A free rigid body keeps its angular momentum L, not its angular velocity: ω̇ = −I⁻¹ ω × Iω. In the body's principal axes that
is L̇ = L × I⁻¹L. One step solves it by the implicit midpoint rule, L₁ = L₀ + h L_m × ω_m with L_m = ½ (L₀ + L₁), ω_m = I⁻¹ L_m,
and turns the body by the Cayley transform of the same ω_m, R₁ = R₀ cay(h ω_m). The two belong together: the midpoint rule reads
L₁ = cay(−h ω_m) L₀, so R₁ L₁ = R₀ L₀ holds exactly, for any ω_m; and the rule keeps every quadratic invariant, so the energy
½ L · I⁻¹L too, as far as the equation is solved. (Austin, Krishnaprasad, Wang, "Almost Poisson Integration of Rigid Body
Systems", J. Comput. Phys. 107, 1993.)
"""

import math

from atlasphys.engine.jit import routine
from atlasphys.engine.math import mat, quat, vec
from atlasphys.engine.solvers.common import load_inverse_mass
from atlasphys.engine.state.bodies import DYNAMIC, STATIC
from atlasphys.engine.state.pose import ROTATION_LOCKS

MIDPOINT_ITERATIONS = 12
"""Most Newton iterations for ω_m. From the start value ω₀ two or three reach round-off unless a body turns by a radian a step."""


@routine
def integrate_velocities(bodies, count, gravity, h):
    """v ← (v + h (s g + F / m)) / (1 + h c), ω likewise with the torque. The gyroscopic term is part of the position step.

    Damping is the implicit Euler step of v̇ = −c v: never unstable, however large c h.
    """
    one = type(h)(1)
    motion, force, response = bodies.motion, bodies.force, bodies.response
    for i in range(count):
        if bodies.kind[i] == DYNAMIC:
            linear, angular = one / (one + h * response[i, 1]), one / (one + h * response[i, 2])
            inverse_mass, inverse_inertia = load_inverse_mass(bodies.inverse_mass, i)
            for k in range(3):
                if inverse_mass[k] > 0:
                    acceleration = response[i, 0] * gravity[k] + inverse_mass[k] * force[i, k]
                    motion[i, k] = (motion[i, k] + h * acceleration) * linear
                else:  # locked
                    motion[i, k] = 0
            spin = (motion[i, 3], motion[i, 4], motion[i, 5])
            if bodies.locks[i] & ROTATION_LOCKS:
                zero = h - h
                spin = (
                    zero if bodies.locks[i] & 8 else spin[0],
                    zero if bodies.locks[i] & 16 else spin[1],
                    zero if bodies.locks[i] & 32 else spin[2],
                )
            change = mat.sym_mul_vec(inverse_inertia, (force[i, 4], force[i, 5], force[i, 6]))
            for k in range(3):
                motion[i, 3 + k] = (spin[k] + h * change[k]) * angular


@routine
def midpoint_spin(momentum, inertia, inverse, h):
    """ω_m in principal axes: the root of I ω + ½ h ω × Iω = L₀ (the midpoint rule, solved for ω_m = I⁻¹ L_m), by Newton."""
    real = type(h)
    half = real(0.5) * h
    w = (momentum[0] * inverse[0], momentum[1] * inverse[1], momentum[2] * inverse[2])
    tolerance = (real(1e-30) if real(1) + real(1e-10) > real(1) else real(1e-13)) * vec.length_squared(w)
    for _ in range(MIDPOINT_ITERATIONS):
        m = (inertia[0] * w[0], inertia[1] * w[1], inertia[2] * w[2])
        residual = vec.sub(vec.add_scaled(m, vec.cross(w, m), half), momentum)
        # Jacobian I + ½ h (ω̂ I − (Iω)^)
        j01 = half * (m[2] - w[2] * inertia[1])
        j02 = half * (w[1] * inertia[2] - m[1])
        j10 = half * (w[2] * inertia[0] - m[2])
        j12 = half * (m[0] - w[0] * inertia[2])
        j20 = half * (m[1] - w[1] * inertia[0])
        j21 = half * (w[0] * inertia[1] - m[0])
        u, v, x = (inertia[0], j10, j20), (j01, inertia[1], j21), (j02, j12, inertia[2])
        vx = vec.cross(v, x)
        determinant = vec.dot(u, vx)
        if not abs(determinant) > 0:
            break
        step = (
            vec.dot(residual, vx) / determinant,
            vec.dot(u, vec.cross(residual, x)) / determinant,
            vec.dot(u, vec.cross(v, residual)) / determinant,
        )
        w = vec.sub(w, step)
        if vec.length_squared(step) <= tolerance:
            break
    return w


@routine
def quadratic(inertia, w):
    """ω · I ω in principal axes: twice the energy of rotation."""
    return inertia[0] * w[0] * w[0] + inertia[1] * w[1] * w[1] + inertia[2] * w[2] * w[2]


@routine
def integrate_positions(bodies, count, h):
    """Move centres by h v and turn orientations, keeping each free body's angular momentum; note both in ``motion`` 6–11."""
    real = type(h)
    motion, mass = bodies.motion, bodies.mass
    for i in range(count):
        if bodies.kind[i] != STATIC:
            spin = (motion[i, 3], motion[i, 4], motion[i, 5])
            # 2 tan(|h ω| / 2), to fifth order: the Cayley rotation by it turns by |h ω|.
            angle = h * h * vec.length_squared(spin)
            turn = vec.scale(spin, h * (real(1) + angle / real(12) + angle * angle / real(120)))
            isotropic = mass[i, 2] == mass[i, 3] and mass[i, 3] == mass[i, 4]
            if bodies.kind[i] == DYNAMIC and not isotropic and vec.length_squared(spin) > 0:
                orientation = quat.load(bodies.orientation, i)
                to_world = quat.mul(orientation, quat.load(bodies.principal, i))
                axes = quat.matrix(to_world)
                inertia, inverse = (mass[i, 2], mass[i, 3], mass[i, 4]), (mass[i, 5], mass[i, 6], mass[i, 7])
                w = mat.transpose_mul_vec(axes, spin)
                if not bodies.locks[i] & ROTATION_LOCKS:
                    momentum = (inertia[0] * w[0], inertia[1] * w[1], inertia[2] * w[2])
                    middle = midpoint_spin(momentum, inertia, inverse, h)
                    turn = mat.mul_vec(axes, vec.scale(middle, h))
                    turned = quat.matrix(quat.mul(quat.cayley(turn), to_world))
                    momentum = mat.transpose_mul_vec(turned, mat.mul_vec(axes, momentum))
                    spin = mat.mul_vec(
                        turned, (momentum[0] * inverse[0], momentum[1] * inverse[1], momentum[2] * inverse[2])
                    )
                    # Round-off in the axes has a bias; unchecked it adds 3e-7 of the energy a step in single precision.
                    now = mat.transpose_mul_vec(turned, spin)
                    after = quadratic(inertia, now)
                    excess = after - quadratic(inertia, w)
                    if abs(excess) < after:  # not where the squares under- or overflow
                        spin = vec.add_scaled(spin, spin, real(-0.5) * excess / after)
                else:
                    # The locks' own torque changes L, but does no work: take the free axes' Euler equation explicitly and
                    # put the energy back.
                    matrix = mat.rotated_diagonal(axes, inertia)
                    momentum = mat.sym_mul_vec(matrix, spin)
                    _, free = load_inverse_mass(bodies.inverse_mass, i)
                    changed = vec.add_scaled(spin, mat.sym_mul_vec(free, vec.cross(spin, momentum)), -h)
                    energy = vec.dot(spin, momentum)
                    turned = quat.matrix(quat.mul(quat.cayley(turn), to_world))
                    now = quadratic(inertia, mat.transpose_mul_vec(turned, changed))
                    spin = vec.scale(changed, math.sqrt(energy / now) if now > 0 else real(1))
            for k in range(3):
                motion[i, 3 + k] = spin[k]
                motion[i, 6 + k] = h * motion[i, k]
                motion[i, 9 + k] = turn[k]
                bodies.center[i, k] += motion[i, 6 + k]
            turn_body(bodies.orientation, i, turn)


@routine
def turn_body(orientation, i, turn):
    """Turn body i by the Cayley rotation of the world-axes vector ``turn``."""
    if vec.length_squared(turn) > 0:
        quat.store(orientation, i, quat.unit(quat.mul(quat.cayley(turn), quat.load(orientation, i))))


@routine
def turn_keeping_momentum(bodies, i, turn, change):
    """Turn body i, which is free to rotate, and change its spin angular momentum I ω, kept otherwise, by ``change``."""
    if vec.length_squared(turn) > 0 or vec.length_squared(change) > 0:
        motion, mass, principal = bodies.motion, bodies.mass, quat.load(bodies.principal, i)
        axes = quat.matrix(quat.mul(quat.load(bodies.orientation, i), principal))
        tensor = mat.rotated_diagonal(axes, (mass[i, 2], mass[i, 3], mass[i, 4]))
        spin = mat.sym_mul_vec(tensor, (motion[i, 3], motion[i, 4], motion[i, 5]))
        turn_body(bodies.orientation, i, turn)
        axes = quat.matrix(quat.mul(quat.load(bodies.orientation, i), principal))
        inverse = mat.rotated_diagonal(axes, (mass[i, 5], mass[i, 6], mass[i, 7]))
        spin = mat.sym_mul_vec(inverse, vec.add(spin, change))
        motion[i, 3], motion[i, 4], motion[i, 5] = spin


@routine
def place_origins(bodies, count):
    """Set each body's position from its centre of mass and orientation, at the end of a step."""
    for i in range(count):
        if bodies.kind[i] != STATIC:
            offset = mat.mul_vec(quat.matrix(quat.load(bodies.orientation, i)), vec.load(bodies.local_center, i))
            for k in range(3):
                bodies.position[i, k] = bodies.center[i, k] - offset[k]
