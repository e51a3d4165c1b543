"""What ``soft_step`` does with a block of eight manifolds: prepare, warm start, solve, bounce, store. Bodies over lanes."""

from atlasphys.engine.simd import beside, full, gather, load, maximum, minimum, scatter, select, simd_kernel, store, vec
from atlasphys.engine.solvers.contact_block import (
    CENTROID,
    COEFFICIENT,
    FAR,
    FRESH,
    FRICTION_MATRIX,
    NORMAL,
    SHARE,
    SLIDE,
    SLIDE_TOTAL,
    SPAN,
    TWIST,
    TWIST_MASS,
    TWIST_RADIUS,
    TWIST_TOTAL,
    Fields,
    invert_2x2,
    load_arms,
    load_inverse_mass,
    load_vec,
    reciprocal,
    solve_disk,
    store_vec,
    sweep_normal_impulses,
    weighted,
)
from atlasphys.engine.state.blocks import BODY_A, BODY_B, COUNT, MANIFOLD, MOVES_A, MOVES_B
from atlasphys.engine.state.manifolds import (
    ANCHOR_A,
    ANCHOR_B,
    DEPTH,
    FRICTION,
    IS_FRESH,
    NORMAL_IMPULSE,
    PATCH_FRICTION,
    PATCH_TORSION,
    POINT_COLUMNS,
    RESTITUTION,
    ROLLING,
    TORSIONAL,
)

INNER_SWEEPS = 3
"""Sweeps over the normal impulses of a manifold at each visit. With 1 a pyramid of base 40 leans by metres in 10 s; 3 cost a fifth more."""


@simd_kernel
def prepare(points, locks, block, integers, blocks, manifolds, inverse_mass, ratio) -> int:
    """Write a block from its manifolds. ``ratio`` scales last step's impulses (warm starting).

    The answer says in which lanes there is restitution, rolling friction, or torsional friction that ``solve`` leaves out.
    """
    fields = Fields(points)
    row, number = load(integers, block, MANIFOLD), load(integers, block, COUNT)
    head, table = gather(manifolds.contact, row, 16), gather(manifolds.points, row, POINT_COLUMNS * points)
    m_a, inertia_a = load_inverse_mass(inverse_mass, load(integers, block, BODY_A), locks)
    m_b, inertia_b = load_inverse_mass(inverse_mass, load(integers, block, BODY_B), locks)
    n = head[0:3]
    zero, one = full(n[0], 0), full(n[0], 1)
    none = (zero, zero, zero)
    used = number > 0
    valid = [number > k for k in range(points)]

    span = vec.sub(table[ANCHOR_A : ANCHOR_A + 3], table[ANCHOR_B : ANCHOR_B + 3])
    lever = vec.cross(span, n)
    arms = [table[POINT_COLUMNS * k + ANCHOR_B : POINT_COLUMNS * k + ANCHOR_B + 3] for k in range(points)]
    centroid = none
    for k in range(points):
        centroid = vec.add(centroid, vec.select_vec(valid[k], arms[k], none))
    share = reciprocal(number.astype(zero.dtype))
    centroid = vec.scale(centroid, share)

    along = vec.dot(n, weighted(m_a, n)) + vec.dot(n, weighted(m_b, n))
    c, turn_a, turn_b, radius = [], [], [], zero
    for k in range(points):
        arm = vec.select_vec(valid[k], vec.cross(arms[k], n), none)
        c.append(arm)
        turn_b.append(vec.sym_mul_vec(inertia_b, arm))
        turn_a.append(vec.sym_mul_vec(inertia_a, vec.add(arm, lever)))
        if points > 1:
            radius = radius + select(valid[k], vec.length(vec.sub(arms[k], centroid)), 0)
            store_vec(blocks, block, fields.arm + 3 * k, arm)
        column = POINT_COLUMNS * k
        store(blocks, block, fields.gap + k, select(valid[k], -table[column + DEPTH], FAR))
        store(blocks, block, fields.impulse + k, select(valid[k], table[column + NORMAL_IMPULSE] * ratio, 0))
        store(blocks, block, fields.total + k, zero)
    matrix = {}
    for j in range(points):
        for k in range(j, points):
            entry = along + vec.dot(c[j], turn_b[k]) + vec.dot(vec.add(c[j], lever), turn_a[k])
            matrix[j, k] = matrix[k, j] = select(valid[j] & valid[k], entry, one if j == k else zero)
    for j in range(points):
        inverse = reciprocal(matrix[j, j])
        store(blocks, block, fields.inverse + j, inverse)
        for k in range(points):
            if j != k:
                store(blocks, block, fields.coupling(j, k), matrix[j, k] * inverse)

    t1, t2 = vec.tangents(n)
    k11 = vec.dot(t1, weighted(m_a, t1)) + vec.dot(t1, weighted(m_b, t1))
    k12 = vec.dot(t1, weighted(m_a, t2)) + vec.dot(t1, weighted(m_b, t2))
    k22 = vec.dot(t2, weighted(m_a, t2)) + vec.dot(t2, weighted(m_b, t2))
    for arm, inertia in ((vec.add(centroid, span), inertia_a), (centroid, inertia_b)):
        turn1, turn2 = vec.cross(arm, t1), vec.cross(arm, t2)
        moved1, moved2 = vec.sym_mul_vec(inertia, turn1), vec.sym_mul_vec(inertia, turn2)
        k11, k12, k22 = k11 + vec.dot(turn1, moved1), k12 + vec.dot(turn1, moved2), k22 + vec.dot(turn2, moved2)
    for i, entry in enumerate(invert_2x2(k11, k12, k22)):
        store(blocks, block, FRICTION_MATRIX + i, entry)
    friction = head[PATCH_FRICTION : PATCH_FRICTION + 3]
    store_vec(blocks, block, NORMAL, n)
    store_vec(blocks, block, SPAN, span)
    store_vec(blocks, block, CENTROID, centroid)
    store(blocks, block, COEFFICIENT, select(used, head[FRICTION], 0))
    store(blocks, block, SLIDE, select(used, vec.dot(friction, t1) * ratio, 0))
    store(blocks, block, SLIDE + 1, select(used, vec.dot(friction, t2) * ratio, 0))
    store(blocks, block, FRESH, head[IS_FRESH])
    moves_a, moves_b = load(integers, block, MOVES_A) != 0, load(integers, block, MOVES_B) != 0
    store(blocks, block, SHARE, select(moves_a, select(moves_b, full(zero, 0.5), one), zero))
    twist = vec.dot(n, vec.add(vec.sym_mul_vec(inertia_a, n), vec.sym_mul_vec(inertia_b, n)))
    store(blocks, block, TWIST_MASS, reciprocal(twist))
    store(blocks, block, TWIST_RADIUS, radius * share + head[TORSIONAL])
    store(blocks, block, TWIST, select(used, head[PATCH_TORSION] * ratio, 0))
    for field in (SLIDE_TOTAL, SLIDE_TOTAL + 1, TWIST_TOTAL):
        store(blocks, block, field, zero)
    special = (head[RESTITUTION] > 0) | (head[ROLLING] > 0)
    return used & (special | (head[TORSIONAL] > 0) if points == 1 else special)


class Pair:
    """The two bodies of a block's manifolds: velocities, masses, and the block's geometry as it is now."""

    def __init__(self, points, locks, block, integers, blocks, motion, inverse_mass):
        self.fields = Fields(points)
        self.integers, self.block, self.motion = integers, block, motion
        self.row_a, self.row_b = load(integers, block, BODY_A), load(integers, block, BODY_B)
        self.a, self.b = gather(motion, self.row_a, 16), gather(motion, self.row_b, 16)
        self.v_a, self.w_a, self.v_b, self.w_b = self.a[0:3], self.a[3:6], self.b[0:3], self.b[3:6]
        self.m_a, self.inertia_a = load_inverse_mass(inverse_mass, self.row_a, locks)
        self.m_b, self.inertia_b = load_inverse_mass(inverse_mass, self.row_b, locks)
        self.normal = load_vec(blocks, block, NORMAL)
        self.centroid = load_vec(blocks, block, CENTROID)
        self.arms = load_arms(self.fields, blocks, block, self.normal, self.centroid)
        self.still_span = load_vec(blocks, block, SPAN)
        self.share = load(blocks, block, SHARE)
        parted = vec.scale(vec.sub(self.b[6:9], self.a[6:9]), load(blocks, block, FRESH))
        behind = vec.scale(parted, self.share)
        self.span = vec.add(self.still_span, parted)
        self.lever = vec.cross(self.span, self.normal)
        self.shift = vec.cross(behind, self.normal)
        self.arm_b = vec.sub(self.centroid, behind)
        self.arm_a = vec.add(self.arm_b, self.span)

    def normal_velocities(self):
        """Relative velocity along the normal at each point; positive where they part."""
        turn = vec.sub(self.w_b, self.w_a)
        shared = (
            vec.dot(self.normal, vec.sub(self.v_b, self.v_a))
            - vec.dot(self.lever, self.w_a)
            - vec.dot(self.shift, turn)
        )
        return [shared + vec.dot(c, turn) for c in self.arms]

    def gaps(self, blocks):
        """Separation at each point, to first order in the bodies' motion since the start of the step."""
        turned_a, turned = self.a[9:12], vec.sub(self.b[9:12], self.a[9:12])
        lever = vec.cross(self.still_span, self.normal)
        shared = vec.dot(self.normal, vec.sub(self.b[6:9], self.a[6:9])) - vec.dot(lever, turned_a)
        return [
            shared + vec.dot(c, turned) + load(blocks, self.block, self.fields.gap + k) for k, c in enumerate(self.arms)
        ]

    def press(self, impulses):
        """Apply impulses along the normal at the points."""
        total = sum(impulses[1:], impulses[0])
        turn = vec.scale(self.shift, -total)
        for c, impulse in zip(self.arms, impulses, strict=True):
            turn = vec.add_scaled(turn, c, impulse)
        push = vec.scale(self.normal, total)
        self.v_a, self.v_b = vec.sub(self.v_a, weighted(self.m_a, push)), vec.add(self.v_b, weighted(self.m_b, push))
        self.w_b = vec.add(self.w_b, vec.sym_mul_vec(self.inertia_b, turn))
        turn = vec.add_scaled(turn, self.lever, total)
        self.w_a = vec.sub(self.w_a, vec.sym_mul_vec(self.inertia_a, turn))

    def drag(self, impulse):
        """Apply an impulse at the centroid."""
        self.v_a, self.v_b = (
            vec.sub(self.v_a, weighted(self.m_a, impulse)),
            vec.add(self.v_b, weighted(self.m_b, impulse)),
        )
        self.w_a = vec.sub(self.w_a, vec.sym_mul_vec(self.inertia_a, vec.cross(self.arm_a, impulse)))
        self.w_b = vec.add(self.w_b, vec.sym_mul_vec(self.inertia_b, vec.cross(self.arm_b, impulse)))

    def twist(self, impulse):
        """Apply an angular impulse about the normal."""
        turn = vec.scale(self.normal, impulse)
        self.w_a = vec.sub(self.w_a, vec.sym_mul_vec(self.inertia_a, turn))
        self.w_b = vec.add(self.w_b, vec.sym_mul_vec(self.inertia_b, turn))

    def slip(self):
        """Velocity of b against a at the centroid."""
        at_b = vec.add(self.v_b, vec.cross(self.w_b, self.arm_b))
        return vec.sub(at_b, vec.add(self.v_a, vec.cross(self.w_a, self.arm_a)))

    def rub(self, blocks, limit, slide_field, twist_field):
        """Bring the impulses of friction that the two fields hold up to date, within ``limit``. Returns them: slide, twist."""
        block, twist = self.block, None
        if self.fields.points > 1:
            old = load(blocks, block, twist_field)
            most = limit * load(blocks, block, TWIST_RADIUS)
            spin = vec.dot(self.normal, vec.sub(self.w_b, self.w_a))
            twist = maximum(minimum(old - load(blocks, block, TWIST_MASS) * spin, most), -most)
            self.twist(twist - old)
            store(blocks, block, twist_field, twist)
        t1, t2 = vec.tangents(self.normal)
        slip = self.slip()
        was = load(blocks, block, slide_field), load(blocks, block, slide_field + 1)
        inverse = [load(blocks, block, FRICTION_MATRIX + i) for i in range(4)]
        now = solve_disk(was, (vec.dot(t1, slip), vec.dot(t2, slip)), inverse, limit)
        self.drag(vec.add_scaled(vec.scale(t1, now[0] - was[0]), t2, now[1] - was[1]))
        store(blocks, block, slide_field, now[0])
        store(blocks, block, slide_field + 1, now[1])
        return now, twist

    def store(self):
        """Write the velocities of the bodies that are moved by impulses."""
        moves_a, moves_b = load(self.integers, self.block, MOVES_A), load(self.integers, self.block, MOVES_B)
        scatter(self.motion, self.row_a, (*self.v_a, *self.w_a, *self.a[6:8]), where=moves_a)
        scatter(self.motion, self.row_b, (*self.v_b, *self.w_b, *self.b[6:8]), where=moves_b)


@simd_kernel
def warm_start(points, locks, block, other, integers, blocks, motion, inverse_mass):
    """Apply the impulses that the last substep ended with, in two blocks of a colour, or twice the same."""
    block = beside(block, other)
    pair = Pair(points, locks, block, integers, blocks, motion, inverse_mass)
    fields = pair.fields
    pair.press([load(blocks, block, fields.impulse + k) for k in range(points)])
    t1, t2 = vec.tangents(pair.normal)
    pair.drag(vec.add_scaled(vec.scale(t1, load(blocks, block, SLIDE)), t2, load(blocks, block, SLIDE + 1)))
    if points > 1:
        pair.twist(load(blocks, block, TWIST))
    pair.store()


@simd_kernel
def solve(points, locks, relax, block, other, integers, blocks, motion, inverse_mass, soft):
    """One visit of two blocks of a colour, or twice the same: normal impulses, then friction within what they allow. (Friction in the relax
    pass alone would save an eighth of the step, but lets
    frictional piles gain energy: 1e-5 in a step of case 28.)

    ``soft``: inverse substep length [1/s]; rate and mass scale of contacts between dynamic bodies; the same of those with others; greatest speed
    at which overlap is pushed out [m/s]. In the ``relax`` pass contacts are rigid and do not push out, which takes back
    the speed that pushing gave; the impulses of the substep are final then and added to the totals.
    """
    block = beside(block, other)
    pair = Pair(points, locks, block, integers, blocks, motion, inverse_mass)
    fields = pair.fields
    inverse_h, rate, mass_scale, stiff_rate, stiff_mass_scale, fastest = soft
    stiff = pair.share != 0.5
    rate, mass_scale = select(stiff, stiff_rate, rate), select(stiff, stiff_mass_scale, mass_scale)

    speeds, gaps, wanted, scales = pair.normal_velocities(), pair.gaps(blocks), [], []
    old = [load(blocks, block, fields.impulse + k) for k in range(points)]
    for k in range(points):
        apart = gaps[k] > 0
        bias = select(apart, gaps[k] * inverse_h, 0 if relax else maximum(rate * gaps[k], -fastest))
        wanted.append(old[k] - load(blocks, block, fields.inverse + k) * (speeds[k] + bias))
        if not relax:
            scales.append(select(apart, 1, mass_scale))
            wanted[k] = wanted[k] * scales[k]
    new = sweep_normal_impulses(
        fields, blocks, block, old, wanted, None if relax else scales, INNER_SWEEPS if points > 1 else 1
    )
    pair.press([new[k] - old[k] for k in range(points)])
    load_total = sum(new[1:], new[0])
    for k in range(points):
        store(blocks, block, fields.impulse + k, new[k])
        if relax:
            store(blocks, block, fields.total + k, load(blocks, block, fields.total + k) + new[k])

    slide, twist = pair.rub(blocks, load(blocks, block, COEFFICIENT) * load_total, SLIDE, TWIST)
    if relax:
        store(blocks, block, SLIDE_TOTAL, load(blocks, block, SLIDE_TOTAL) + slide[0])
        store(blocks, block, SLIDE_TOTAL + 1, load(blocks, block, SLIDE_TOTAL + 1) + slide[1])
        if points > 1:
            store(blocks, block, TWIST_TOTAL, load(blocks, block, TWIST_TOTAL) + twist)
    pair.store()


@simd_kernel
def store_impulses(points, block, integers, blocks, manifolds):
    """Write the impulses of the last substep (for warm starting) and of the whole step (to report) to the manifolds."""
    fields = Fields(points)
    row, number = load(integers, block, MANIFOLD), load(integers, block, COUNT)
    used = number > 0
    head = gather(manifolds.contact, row, 16)
    table = list(gather(manifolds.points, row, POINT_COLUMNS * points))
    zero = full(head[0], 0)
    total = [zero] * 8
    for k in range(points):
        table[POINT_COLUMNS * k + NORMAL_IMPULSE] = load(blocks, block, fields.impulse + k)
        total[k] = load(blocks, block, fields.total + k)
    t1, t2 = vec.tangents(load_vec(blocks, block, NORMAL))
    slide = vec.add_scaled(vec.scale(t1, load(blocks, block, SLIDE)), t2, load(blocks, block, SLIDE + 1))
    total[4:7] = vec.add_scaled(
        vec.scale(t1, load(blocks, block, SLIDE_TOTAL)), t2, load(blocks, block, SLIDE_TOTAL + 1)
    )
    total[7] = load(blocks, block, TWIST_TOTAL)
    twist = load(blocks, block, TWIST)
    scatter(manifolds.contact, row, (*head[:PATCH_FRICTION], *slide, twist, *head[PATCH_TORSION + 1 :]), where=used)
    scatter(manifolds.points, row, tuple(table), where=used)
    scatter(manifolds.total, row, tuple(total), where=used)
