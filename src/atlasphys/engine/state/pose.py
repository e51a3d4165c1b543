"""What follows from a body's state: rotation matrix, centre of mass, inverse inertia in world axes. Refreshed at the start of each step."""

from atlasphys.engine.jit import kernel, routine
from atlasphys.engine.math import mat, quat, vec
from atlasphys.engine.state.bodies import DYNAMIC, Bodies

ROTATION_LOCKS = 0b111000
"""Bits of ``Bodies.locks`` that forbid rotation."""


@routine
def free_inverse_inertia(inertia, locks):
    """The inverse of a symmetric inertia restricted to the axes about which the body may turn; 0 along the others.

    A locked axis takes its whole row and column with it: the lock supplies whatever torque it needs.
    """
    zero = inertia[0] - inertia[0]
    one = type(zero)(1)
    lock_x, lock_y, lock_z = locks & 8, locks & 16, locks & 32
    xx = one if lock_x else inertia[0]
    yy = one if lock_y else inertia[1]
    zz = one if lock_z else inertia[2]
    xy = zero if lock_x or lock_y else inertia[3]
    xz = zero if lock_x or lock_z else inertia[4]
    yz = zero if lock_y or lock_z else inertia[5]
    a, b, c = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    inverse = one / (xx * a + xy * b + xz * c)
    return (
        zero if lock_x else a * inverse,
        zero if lock_y else (xx * zz - xz * xz) * inverse,
        zero if lock_z else (xx * yy - xy * xy) * inverse,
        b * inverse,
        c * inverse,
        (xy * xz - xx * yz) * inverse,
    )


@routine
def inverse_inertia(bodies, i, orientation):
    """The inverse inertia tensor of a dynamic body about the world's axes, at an orientation; zero about its locked axes."""
    mass, locks = bodies.mass, bodies.locks[i]
    axes = quat.matrix(quat.mul(orientation, quat.load(bodies.principal, i)))
    if locks & ROTATION_LOCKS:
        return free_inverse_inertia(mat.rotated_diagonal(axes, (mass[i, 2], mass[i, 3], mass[i, 4])), locks)
    if mass[i, 2] == mass[i, 3] and mass[i, 3] == mass[i, 4]:  # the same however it is turned, to the bit
        zero = mass[i, 5] - mass[i, 5]
        return mass[i, 5], mass[i, 6], mass[i, 7], zero, zero, zero
    return mat.rotated_diagonal(axes, (mass[i, 5], mass[i, 6], mass[i, 7]))


@kernel
def refresh(bodies: Bodies, first: int, last: int) -> None:
    """Derive ``center``, ``geometry`` and ``inverse_mass`` of the rows first … last − 1 from their state and properties."""
    geometry, inverse_mass, mass = bodies.geometry, bodies.inverse_mass, bodies.mass
    for i in range(first, last):
        orientation = quat.load(bodies.orientation, i)
        rotation = quat.matrix(orientation)
        mat.store(geometry, i, rotation)
        for k in range(3):
            bodies.frame[i, k] = bodies.local_center[i, k]
        for k in range(4):
            geometry[i, 12 + k] = orientation[k]
            bodies.frame[i, 4 + k] = bodies.principal[i, k]
        isotropic = mass[i, 2] == mass[i, 3] and mass[i, 3] == mass[i, 4]
        free = bodies.kind[i] == DYNAMIC and not bodies.locks[i] & ROTATION_LOCKS
        bodies.frame[i, 3] = 1 if free and not isotropic else 0
        offset = mat.mul_vec(rotation, vec.load(bodies.local_center, i))
        for k in range(3):
            geometry[i, 9 + k] = offset[k]
            bodies.center[i, k] = bodies.position[i, k] + offset[k]
            bodies.motion[i, 6 + k] = bodies.motion[i, 9 + k] = 0
        if bodies.kind[i] == DYNAMIC:
            locks = bodies.locks[i]
            inverse = inverse_inertia(bodies, i, orientation)
            for k in range(6):
                inverse_mass[i, k] = inverse[k]
            inverse_mass[i, 6] = mass[i, 1]
            for k in range(3):
                inverse_mass[i, 8 + k] = 0 if locks & (1 << k) else mass[i, 1]
        else:
            for k in range(inverse_mass.shape[1]):
                inverse_mass[i, k] = 0
