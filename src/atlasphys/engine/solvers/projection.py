"""Position projection: nonlinear Gauss–Seidel on the overlap that remains once the bodies have moved.

Each contact's overlap is measured again where its two anchors now are (turned with their bodies, to second order in the
rotation of the step), and beyond the slop a share of it is removed by moving *and turning* both bodies as an impulse along the normal would.
Velocities are untouched, so the correction adds no kinetic energy.

Moving a body changes its angular momentum about the origin, m Δx × v. For a pair pushed apart by λ n that is λ n × (v_b − v_a) in all;
it is given back to the two bodies' spins in equal parts. Turning a body keeps its spin angular momentum, not its angular velocity. So
the projection conserves both momenta of bodies that touch only each other.
"""

from atlasphys.engine.jit import routine
from atlasphys.engine.math import vec
from atlasphys.engine.solvers.common import load_anchors, load_inverse_mass, load_velocity, store_velocity, weighted
from atlasphys.engine.solvers.integrate import turn_body, turn_keeping_momentum
from atlasphys.engine.state.bodies import DYNAMIC
from atlasphys.engine.state.manifolds import DEPTH, NORMAL, POINT_COLUMNS


@routine
def shift(r, moved, turned):
    """By how much the end of the arm r has moved: moved + θ × r + ½ θ × (θ × r)."""
    first = vec.cross(turned, r)
    return vec.add(moved, vec.add_scaled(first, vec.cross(turned, first), type(r[0])(0.5)))


@routine
def project_positions(
    bodies, body_count, pairs, manifolds, count, points, displacement, spin_change, iterations, rate, slop, max_correction
):  # fmt: skip
    """Sweep ``iterations`` times over the contacts, removing ``rate`` of each overlap beyond the slop, then move the bodies.

    ``displacement`` (n, 6) and ``spin_change`` (n, 3) are scratch: displacement and rotation vector since the collision detection,
    corrections included; and spin angular momentum to give back.
    """
    motion, inverse_mass = bodies.motion, bodies.inverse_mass
    half = type(rate)(0.5)
    for i in range(body_count):
        for j in range(6):
            displacement[i, j] = motion[i, 6 + j]
        for j in range(3):
            spin_change[i, j] = 0
    corrected = False
    for _ in range(iterations):
        settled = True
        for i in range(count):
            a, b = pairs[i, 0], pairs[i, 1]
            n = vec.load_columns(manifolds.contact, i, NORMAL)
            moved_a, turned_a = load_velocity(displacement, a)
            moved_b, turned_b = load_velocity(displacement, b)
            touched = False
            for k in range(manifolds.count[i]):
                r_a, r_b = load_anchors(manifolds.points, i, k)
                shift_a, shift_b = shift(r_a, moved_a, turned_a), shift(r_b, moved_b, turned_b)
                excess = manifolds.points[i, POINT_COLUMNS * k + DEPTH] - vec.dot(n, vec.sub(shift_b, shift_a)) - slop
                if excess > 0:
                    p = 4 * i + k
                    push = points[p, 6] * min(rate * excess, max_correction)
                    (m_a, _), (m_b, _) = load_inverse_mass(inverse_mass, a), load_inverse_mass(inverse_mass, b)
                    moved_a = vec.add_scaled(moved_a, weighted(m_a, n), -push)
                    moved_b = vec.add_scaled(moved_b, weighted(m_b, n), push)
                    share = vec.scale(vec.cross(n, vec.sub(vec.load(motion, a), vec.load(motion, b))), half * push)
                    vec.store(spin_change, a, vec.add(vec.load(spin_change, a), share))
                    vec.store(spin_change, b, vec.add(vec.load(spin_change, b), share))
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
            turn = vec.sub(turned, (motion[i, 9], motion[i, 10], motion[i, 11]))
            if bodies.kind[i] == DYNAMIC and not bodies.locks[i]:
                turn_keeping_momentum(bodies, i, turn, vec.load(spin_change, i))
            else:
                turn_body(bodies.orientation, i, turn)
            for j in range(3):
                bodies.center[i, j] += moved[j] - motion[i, 6 + j]
            for j in range(6):
                motion[i, 6 + j] = displacement[i, j]
