"""Parts that solvers share: relative velocity at a contact, impulses on a pair of bodies, and the friction cone."""

import math

from atlasphys.engine.jit import routine
from atlasphys.engine.math import vec
from atlasphys.engine.state.manifolds import ANCHOR_A, ANCHOR_B, POINT_COLUMNS


@routine
def load_velocity(motion, i):
    """Velocity of the centre of mass and angular velocity of body i, from its row of ``Bodies.motion``."""
    return (motion[i, 0], motion[i, 1], motion[i, 2]), (motion[i, 3], motion[i, 4], motion[i, 5])


@routine
def store_velocity(motion, i, v, w):
    """Write both velocities of body i."""
    motion[i, 0], motion[i, 1], motion[i, 2] = v
    motion[i, 3], motion[i, 4], motion[i, 5] = w


@routine
def load_inverse_mass(inverse_mass, i):
    """Inverse mass along each world axis, and inverse inertia (symmetric, six numbers), of body i."""
    inertia = (
        inverse_mass[i, 0],
        inverse_mass[i, 1],
        inverse_mass[i, 2],
        inverse_mass[i, 3],
        inverse_mass[i, 4],
        inverse_mass[i, 5],
    )
    return vec.load_columns(inverse_mass, i, 8), inertia


@routine
def load_anchors(points, i, k):
    """Point k of manifold i, seen from the centres of mass of a and of b, from its row of ``Manifolds.points``."""
    first = POINT_COLUMNS * k
    return vec.load_columns(points, i, first + ANCHOR_A), vec.load_columns(points, i, first + ANCHOR_B)


@routine
def weighted(m, u):
    """diag(m) u."""
    return m[0] * u[0], m[1] * u[1], m[2] * u[2]


@routine
def relative_velocity(v_a, w_a, r_a, v_b, w_b, r_b):
    """Velocity of b against a at a contact: v_b + ω_b × r_b − v_a − ω_a × r_a."""
    return vec.sub(vec.add(v_b, vec.cross(w_b, r_b)), vec.add(v_a, vec.cross(w_a, r_a)))


@routine
def invert_2x2(k11, k12, k22):
    """The inverse of a symmetric 2×2 matrix, and of its greatest eigenvalue; all 0 where it is singular."""
    real = type(k11)
    zero = real(0)
    determinant = k11 * k22 - k12 * k12
    half_trace = real(0.5) * (k11 + k22)
    difference = real(0.5) * (k11 - k22)
    greatest = half_trace + math.sqrt(difference * difference + k12 * k12)
    step = real(1) / greatest if greatest > 0 else zero
    if determinant > real(1e-6) * half_trace * half_trace:
        inverse = real(1) / determinant
        return k22 * inverse, -k12 * inverse, k11 * inverse, step
    return step, zero, step, step  # nearly singular: descend along the gradient instead


@routine
def solve_disk(impulse, velocity, inverse, limit):
    """The impulse in a disk of radius ``limit`` that stops the sliding, or else opposes it (maximum dissipation).

    If the impulse that stops the contact, λ − K⁻¹ v, lies in the disk, it sticks. Otherwise one step of projected gradient,
    λ − v / max eig K, put back on the disk: its fixed point has λ exactly opposite to v, so that friction is isotropic even
    where K is not. Scaling λ − K⁻¹ v back would point K⁻¹ v, not v, and pull a sliding body off its course.
    """
    zero = limit - limit
    if not limit > 0:
        return zero, zero
    x = impulse[0] - (inverse[0] * velocity[0] + inverse[1] * velocity[1])
    y = impulse[1] - (inverse[1] * velocity[0] + inverse[2] * velocity[1])
    if x * x + y * y <= limit * limit:
        return x, y
    x = impulse[0] - inverse[3] * velocity[0]
    y = impulse[1] - inverse[3] * velocity[1]
    squared = x * x + y * y
    if squared <= limit * limit:
        return x, y
    ratio = limit / math.sqrt(squared)
    return x * ratio, y * ratio
