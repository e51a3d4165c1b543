"""Contact constraints in blocks: eight manifolds side by side, a field for each number, a lane for each manifold.

The two bodies of a contact see its points by arms r_a and r_b from their centres of mass, and since it is one point,
r_a = r_b + x_b − x_a for all points of a manifold. With c_k = r_bk × n and the *span* d = x_b − x_a, the Jacobian of point k is

    v_k = n · (v_b − v_a) − (d × n) · ω_a + c_k · (ω_b − ω_a),

three numbers a point, and the impulses λ_k turn the bodies by C = Σ λ_k c_k on b and −(C + d × n Σ λ_k) on a. Torques taken so about one
common point conserve angular momentum exactly. While the bodies move in the substeps of a step, the point moves with the one that is dynamic, or
half-way between two that are, by s Δx_a + (1 − s) Δx_b. The arms follow: r_b changes by −s (Δx_b − Δx_a), the span by Δx_b − Δx_a, which again is one
correction for all points. (A point that stayed where it was would fall behind a rolling ball, and its pressure would spin the ball up.
docs/soft_step.md)

Where a manifold is *recycled* (manifold/recycle.py), the arms stay as they were: ``FRESH`` is 0.
"""

from atlasphys.engine.simd import gather, load, maximum, select, sqrt, store, vec

# Fields of every block
NORMAL = 0  # 0–2
SPAN = 3  # 3–5 x_b − x_a as of the collision
CENTROID = 6  # 6–8 mean of the arms r_b: friction acts there
FRICTION_MATRIX = 9  # 9–11 inverse of the 2×2 matrix of the tangents, 12 inverse of its greatest eigenvalue
COEFFICIENT = 13  # of friction
SLIDE = 14  # 14–15 friction impulse along the two tangents
FRESH = 16  # 1: arms follow the bodies; 0: recycled, arms are frozen
SHARE = 17  # s above: ½ between dynamic bodies; 0 or 1 where only b or a is dynamic, and there the contact is twice as stiff
TWIST_MASS, TWIST_RADIUS, TWIST = 18, 19, 20  # torsion: inverse of k, mean lever arm of the points, impulse
SLIDE_TOTAL = 21  # 21–22 sum of SLIDE over the substeps
TWIST_TOTAL = 23
POINTS = 24  # where the fields of the points begin

FAR = 1e6
"""Gap of unused points [m]: they never push."""


class Fields:
    """Where the points' fields lie in a block of manifolds of up to ``points`` (1 or 4) points."""

    def __init__(self, points: int) -> None:
        self.points = points
        self.gap = POINTS  # separation at the start of the step, with the bodies where they were
        self.impulse = self.gap + points  # λ_k of the present substep
        self.total = self.impulse + points  # sum of λ_k over the substeps
        self.inverse = self.total + points  # 1 / K_kk
        self.couplings = self.inverse + points  # K_jk / K_jj, row by row
        self.arm = self.couplings + points * (points - 1)  # c_k; with one point it is centroid × n
        self.number = self.arm + (3 * points if points > 1 else 0)

    def coupling(self, j: int, k: int) -> int:
        """Field of K_jk / K_jj: by how much the impulse that point j wants falls for each unit of point k's."""
        return self.couplings + j * (self.points - 1) + (k if k < j else k - 1)


def load_vec(blocks, block, field):
    """Three neighbouring fields."""
    return load(blocks, block, field), load(blocks, block, field + 1), load(blocks, block, field + 2)


def store_vec(blocks, block, field, v):
    """Write three neighbouring fields."""
    for i in range(3):
        store(blocks, block, field + i, v[i])


def load_arms(fields, blocks, block, normal, centroid):
    """c_k of all points."""
    if fields.points == 1:
        return (vec.cross(centroid, normal),)
    return tuple(load_vec(blocks, block, fields.arm + 3 * k) for k in range(fields.points))


def sweep_normal_impulses(fields, blocks, block, impulses, wanted, scales, sweeps):
    """Gauss–Seidel sweeps over the normal impulses of a manifold. Returns the new ones.

    ``wanted`` is what each impulse would become if the others stayed and it might pull; it falls as the others rise, and does not depend on the
    impulse itself. Between one point and the next lie four operations, each of which waits for the one before: they take most of a visit's time.
    ``scales`` are factors on the couplings of each point, or None: a point of a soft contact wants mass_scale (λ − excess / K), as impulse_scale is
    1 − mass_scale.
    """
    points, new, wanted = fields.points, list(impulses), list(wanted)
    coupling = {}
    for j in range(points):
        for k in range(points):
            if j != k:
                entry = load(blocks, block, fields.coupling(j, k))
                coupling[j, k] = entry if scales is None else entry * scales[j]
    for sweep in range(sweeps):
        for k in range(points):
            pressed = maximum(wanted[k], 0)
            change = pressed - new[k]
            new[k] = pressed
            for j in range(points):
                if j > k or (j < k and sweep < sweeps - 1):
                    wanted[j] = wanted[j] - coupling[j, k] * change
    return new


def load_inverse_mass(inverse_mass, row, locks):
    """Inverse mass along the world's axes and inverse inertia. Where ``locks`` is None the three masses are one, and half the row is left unread."""
    columns = gather(inverse_mass, row, 8 if locks is None else 16)
    return (columns[6],) * 3 if locks is None else columns[8:11], columns[0:6]


def weighted(m, u):
    """diag(m) u."""
    return m[0] * u[0], m[1] * u[1], m[2] * u[2]


def reciprocal(x):
    """1 / x, or 0 where x is not positive."""
    return select(x > 0, 1 / x, 0)


def invert_2x2(k11, k12, k22):
    """The inverse of a symmetric 2×2 matrix, and of its greatest eigenvalue; see ``solvers/common.py``."""
    determinant = k11 * k22 - k12 * k12
    half_trace, difference = 0.5 * (k11 + k22), 0.5 * (k11 - k22)
    step = reciprocal(half_trace + sqrt(difference * difference + k12 * k12))
    inverse = 1 / determinant
    regular = determinant > 1e-6 * half_trace * half_trace
    return (
        select(regular, k22 * inverse, step),
        select(regular, -k12 * inverse, 0),
        select(regular, k11 * inverse, step),
        step,
    )


def solve_disk(impulse, velocity, inverse, limit):
    """The impulse in a disk of radius ``limit`` that stops the sliding, or else opposes it; see ``solvers/common.py``."""
    x = impulse[0] - (inverse[0] * velocity[0] + inverse[1] * velocity[1])
    y = impulse[1] - (inverse[1] * velocity[0] + inverse[2] * velocity[1])
    sticks = x * x + y * y <= limit * limit
    x = select(sticks, x, impulse[0] - inverse[3] * velocity[0])
    y = select(sticks, y, impulse[1] - inverse[3] * velocity[1])
    squared = x * x + y * y
    ratio = select(squared > limit * limit, limit / sqrt(squared), 1)
    return x * ratio, y * ratio
