"""Position projection: nonlinear Gauss–Seidel on the overlap that remains once the bodies have moved.

Each contact's overlap is measured again where its two anchors now are (turned with their bodies, to second order in the
rotation of the step), and beyond the slop a share of it is removed by moving *and turning* both bodies as an impulse along the normal would.
Velocities are untouched, so the correction adds no kinetic energy.
"""

from atlasphys.engine.jit import routine
from atlasphys.engine.math import vec
from atlasphys.engine.solvers.common import load_velocity, store_velocity, weighted
from atlasphys.engine.solvers.integrate import turn_body


@routine
def shift(r, moved, turned):
    """By how much the end of the arm r has moved: moved + θ × r + ½ θ × (θ × r)."""
    first = vec.cross(turned, r)
    return vec.add(moved, vec.add_scaled(first, vec.cross(turned, first), type(r[0])(0.5)))


@routine
def project_positions(
    bodies, body_count, pairs, manifolds, count, points, displacement, iterations, rate, slop, max_correction
):  # fmt: skip
    """Sweep ``iterations`` times over the contacts, removing ``rate`` of each overlap beyond the slop, then move the bodies.

    ``displacement`` (n, 6) is scratch: displacement and rotation vector since the collision detection, corrections included.
    """
    motion, inverse_mass = bodies.motion, bodies.inverse_mass
    for i in range(body_count):
        for j in range(6):
            displacement[i, j] = motion[i, 6 + j]
    corrected = False
    for _ in range(iterations):
        settled = True
        for i in range(count):
            a, b = pairs[i, 0], pairs[i, 1]
            n = vec.load(manifolds.normal, i)
            moved_a, turned_a = load_velocity(displacement, a)
            moved_b, turned_b = load_velocity(displacement, b)
            touched = False
            for k in range(manifolds.count[i]):
                shift_a = shift(vec.load_at(manifolds.anchor_a, i, k), moved_a, turned_a)
                shift_b = shift(vec.load_at(manifolds.anchor_b, i, k), moved_b, turned_b)
                excess = manifolds.depth[i, k] - vec.dot(n, vec.sub(shift_b, shift_a)) - slop
                if excess > 0:
                    p = 4 * i + k
                    push = points[p, 6] * min(rate * excess, max_correction)
                    m_a, m_b = vec.load(inverse_mass, a), vec.load(inverse_mass, b)
                    moved_a = vec.add_scaled(moved_a, weighted(m_a, n), -push)
                    moved_b = vec.add_scaled(moved_b, weighted(m_b, n), push)
                    turned_a = vec.add_scaled(turned_a, vec.load(points, p), -push)
                    turned_b = vec.add_scaled(turned_b, (points[p, 3], points[p, 4], points[p, 5]), push)
                    touched = True
            if touched:
                store_velocity(displacement, a, moved_a, turned_a)
                store_velocity(displacement, b, moved_b, turned_b)
                settled = False
        if settled:
            break
        corrected = True
    if corrected:
        for i in range(body_count):
            moved, turned = load_velocity(displacement, i)
            before = (motion[i, 9], motion[i, 10], motion[i, 11])
            turn_body(bodies.orientation, i, vec.sub(turned, before))
            for j in range(3):
                bodies.center[i, j] += displacement[i, j] - motion[i, 6 + j]
            for j in range(6):
                motion[i, 6 + j] = displacement[i, j]
