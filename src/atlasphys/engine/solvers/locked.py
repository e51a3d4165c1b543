"""Bodies whose rotation is locked about some axes, in a substep."""

import math

from atlasphys.engine.jit import routine
from atlasphys.engine.math import mat, quat, vec
from atlasphys.engine.state.pose import free_inverse_inertia


@routine
def follow_turn(locked, locks, motion, geometry, inverse_mass, mass, frame, h):
    """After ``body_block.move``: the inverse inertia of the rows ``locked`` follows their turn, and so does the angular velocity about free axes.

    The locks' own torque changes the angular momentum but does no work: Euler's equation of the free axes is taken explicitly, and the energy is
    put back.
    """
    if locked is None:
        return
    real = type(h)
    for i in locked:
        spin = (motion[i, 3], motion[i, 4], motion[i, 5])
        angle = h * h * vec.length_squared(spin)
        turn = vec.scale(spin, h * (real(1) + angle / real(12) + angle * angle / real(120)))
        after = (geometry[i, 12], geometry[i, 13], geometry[i, 14], geometry[i, 15])
        before = quat.mul(quat.conjugate(quat.cayley(turn)), after)
        principal = (frame[i, 4], frame[i, 5], frame[i, 6], frame[i, 7])
        inertia = (mass[i, 2], mass[i, 3], mass[i, 4])
        tensor = mat.rotated_diagonal(quat.matrix(quat.unit(quat.mul(before, principal))), inertia)
        momentum = mat.sym_mul_vec(tensor, spin)
        free = (
            inverse_mass[i, 0],
            inverse_mass[i, 1],
            inverse_mass[i, 2],
            inverse_mass[i, 3],
            inverse_mass[i, 4],
            inverse_mass[i, 5],
        )
        changed = vec.add_scaled(spin, mat.sym_mul_vec(free, vec.cross(spin, momentum)), -h)
        tensor = mat.rotated_diagonal(quat.matrix(quat.unit(quat.mul(after, principal))), inertia)
        energy, now = vec.dot(spin, momentum), vec.dot(changed, mat.sym_mul_vec(tensor, changed))
        scale = math.sqrt(energy / now) if now > 0 else real(1)
        inverse = free_inverse_inertia(tensor, locks[i])
        for k in range(3):
            motion[i, 3 + k] = changed[k] * scale
        for k in range(6):
            inverse_mass[i, k] = inverse[k]
