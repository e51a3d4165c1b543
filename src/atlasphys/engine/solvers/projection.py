"""Position projection: nonlinear Gauss–Seidel on the overlap that remains once the bodies have moved.

Each contact's overlap is measured again where its two anchors now are (turned with their bodies, to second order in the
rotation of the step), and beyond the slop a share of it is removed by moving *and turning* both bodies as an impulse along the normal would.
Velocities are untouched, so the correction adds no kinetic energy.
"""

from atlasphys.engine.jit import routine
from atlasphys.engine.math import vec
from atlasphys.engine.solvers.common import load_inverse_mass
from atlasphys.engine.solvers.integrate import turn_body


@routine
def shift(r, moved, turned):
    """By how much the end of the arm r has moved: moved + θ × r + ½ θ × (θ × r)."""
    first = vec.cross(turned, r)
    return vec.add(moved, vec.add_scaled(first, vec.cross(turned, first), type(r[0])(0.5)))


@routine
def project_positions(
    bodies, body_count, colliders, manifolds, count, points, displacement, iterations, rate, tolerances
):  # fmt: skip
    """Sweep ``iterations`` times over the contacts, removing ``rate`` of each overlap beyond the slop, then move the bodies.

    ``displacement`` (n, 6) is scratch: displacement and rotation vector since the collision detection, corrections included.
    """
    for i in range(body_count):
        for j in range(6):
            displacement[i, j] = bodies.motion[i, 6 + j]
    corrected = False
    for _ in range(iterations):
        settled = True
        for i in range(count):
            row_a = displacement[colliders.body[manifolds.a[i]]]
            row_b = displacement[colliders.body[manifolds.b[i]]]
            n = vec.load(manifolds.normal, i)
            for k in range(manifolds.count[i]):
                r_a, r_b = vec.load(manifolds.anchor_a[i], k), vec.load(manifolds.anchor_b[i], k)
                shift_a = shift(r_a, (row_a[0], row_a[1], row_a[2]), (row_a[3], row_a[4], row_a[5]))
                shift_b = shift(r_b, (row_b[0], row_b[1], row_b[2]), (row_b[3], row_b[4], row_b[5]))
                excess = manifolds.depth[i, k] - vec.dot(n, vec.sub(shift_b, shift_a)) - tolerances.slop
                if excess > 0:
                    m_a, _ = load_inverse_mass(bodies, colliders.body[manifolds.a[i]])
                    m_b, _ = load_inverse_mass(bodies, colliders.body[manifolds.b[i]])
                    point = points[i, k]
                    push = point[6] * min(rate * excess, tolerances.max_correction)
                    for j in range(3):
                        row_a[j] -= m_a[j] * n[j] * push
                        row_b[j] += m_b[j] * n[j] * push
                        row_a[3 + j] -= point[j] * push
                        row_b[3 + j] += point[3 + j] * push
                    settled = False
        if settled:
            break
        corrected = True
    if corrected:
        for i in range(body_count):
            row, motion = displacement[i], bodies.motion[i]
            turn_body(bodies, i, (row[3] - motion[9], row[4] - motion[10], row[5] - motion[11]))
            for j in range(3):
                bodies.center[i, j] += row[j] - motion[6 + j]
                motion[6 + j], motion[9 + j] = row[j], row[3 + j]
