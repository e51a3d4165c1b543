"""What ``xpbd`` does with a block of eight manifolds: aim, solve positions, solve velocities, finish. Bodies over lanes.

The equations are in ``xpbd.py``, the layout of a block and its Jacobian in ``contact_block.py``.
"""

from atlasphys.engine.simd import (
    absolute,
    any_lane,
    beside,
    full,
    gather,
    load,
    maximum,
    minimum,
    select,
    simd_kernel,
    sqrt,
    store,
    vec,
)
from atlasphys.engine.solvers.contact_block import (
    COEFFICIENT,
    FAR,
    FRICTION_MATRIX,
    SLIDE,
    SLIDE_TOTAL,
    TWIST,
    TWIST_MASS,
    TWIST_RADIUS,
    TWIST_TOTAL,
    Fields,
    invert_2x2,
    reciprocal,
    solve_disk,
    sweep_normal_impulses,
    weighted,
)
from atlasphys.engine.solvers.soft_contact import Pair
from atlasphys.engine.state.blocks import COUNT, MANIFOLD
from atlasphys.engine.state.manifolds import RESTITUTION

INNER_SWEEPS = 3
"""Sweeps over the points of a manifold at each visit for positions. With 2 a tower of ten sways a hundred times as much. Velocities need one."""

COARSEST = 1e-3
"""Greatest relative error of a bounce's speed. Near e = 1 a tenth of the loss is allowed, so that no impulse gains energy."""


class XpbdFields(Fields):
    """The fields of a block, with those that only this solver has."""

    def __init__(self, points: int) -> None:
        super().__init__(points)
        self.bounce = self.number  # speed with which an impact ends; 0 at points that rest
        self.allowed = self.bounce + points  # error of that speed that is allowed
        self.anchor = self.allowed + points  # 2 along the tangents, 1 about the normal: see ``Grip``
        self.number = self.anchor + 3


class Grip:
    """Static friction: how far the anchors of the two bodies have parted along the surface, and what brings them together again.

    The *anchors* are the points of the bodies that met when the contact began to stick. Their parting is kept as an impulse, K⁻¹ (parting) / h, that
    undoes it in one substep, for that of the last step can then be carried over as impulses are.
    """

    def __init__(self, pair, blocks, inverse_h):
        self.pair, self.blocks, self.inverse_h = pair, blocks, inverse_h
        self.t1, self.t2 = vec.tangents(pair.normal)
        self.inverse = [load(blocks, pair.block, FRICTION_MATRIX + i) for i in range(4)]

    def parted(self):
        """K⁻¹ / h times what the bodies have moved on each other since the step began: along the tangents, and about the normal."""
        pair = self.pair
        at_b = vec.add(pair.b[6:9], vec.cross(pair.b[9:12], pair.centroid))
        at_a = vec.add(pair.a[6:9], vec.cross(pair.a[9:12], vec.add(pair.centroid, pair.still_span)))
        moved = vec.scale(vec.sub(at_b, at_a), self.inverse_h)
        along = self.undo(vec.dot(self.t1, moved), vec.dot(self.t2, moved))
        turned = vec.dot(pair.normal, vec.sub(pair.b[9:12], pair.a[9:12])) * self.inverse_h
        return *along, load(self.blocks, pair.block, TWIST_MASS) * turned

    def undo(self, x, y):
        """K⁻¹ (x, y)."""
        return self.inverse[0] * x + self.inverse[1] * y, self.inverse[1] * x + self.inverse[2] * y


@simd_kernel
def begin(points, block, blocks):
    """After ``soft_contact.prepare``: what it took over from the last step is how far the anchors had parted; impulses begin at zero."""
    fields = XpbdFields(points)
    for i, field in enumerate((SLIDE, SLIDE + 1, TWIST)):
        store(blocks, block, fields.anchor + i, load(blocks, block, field))
        store(blocks, block, field, full(load(blocks, block, field), 0))
    for k in range(points):
        for field in (fields.impulse, fields.bounce, fields.allowed):
            store(blocks, block, field + k, full(load(blocks, block, SLIDE), 0))


class Approach:
    """The points of a block that can bounce: how fast they come together, faster by ``gain`` in each substep, and where they are."""

    def __init__(self, pair, integers, block, blocks, drives, manifolds, h, step):
        self.h, self.step = h, step
        head = gather(manifolds.contact, load(integers, block, MANIFOLD))
        self.restitution = select(load(integers, block, COUNT) > 0, head[RESTITUTION], 0)
        self.gaps = pair.gaps(blocks)
        self.speeds = [-speed for speed in pair.normal_velocities()]
        gain_a, gain_b = gather(drives, pair.row_a), gather(drives, pair.row_b)
        v_a, w_a, v_b, w_b = pair.v_a, pair.w_a, pair.v_b, pair.w_b
        pair.v_a, pair.w_a, pair.v_b, pair.w_b = gain_a[0:3], gain_a[4:7], gain_b[0:3], gain_b[4:7]
        self.gains = [-gain for gain in pair.normal_velocities()]
        pair.v_a, pair.w_a, pair.v_b, pair.w_b = v_a, w_a, v_b, w_b

    def leave(self, k, gap):
        """Speed with which point k leaves at ``gap``, and whether it gets away.

        Semi-implicit Euler with acceleration a towards the surface keeps v² + 2 a gap − a h v (v > 0 outwards): e² of it, as of the surface, is left.
        """
        speed, gain = self.speeds[k], self.gains[k]
        start = maximum(gap, -self.step * speed)  # deeper than it can have come in a step: an overlap of other origin
        left = self.restitution * self.restitution * (speed * speed + 2 * gain / self.h * start + gain * speed)
        leave = 0.5 * gain + sqrt(maximum(left + 0.25 * gain * gain - 2 * gain / self.h * start, full(gain, 0)))
        return leave, left > 4 * gain * gain  # else it would be back within a substep or two: it rests


@simd_kernel
def spot(points, locks, block, integers, blocks, motion, inverse_mass, drives, manifolds, bounce):
    """Mark the points that have an impact in this substep. Forces have acted, positions are not yet solved.

    They are left to ``solve_velocities``, as are those that part, for they may be pushed back by others.
    ``bounce``: threshold [m/s], lengths of the step and of the substep [s], slop [m] (unused), finest relative error.
    """
    threshold, step, h, _, _ = bounce
    pair, fields = Pair(points, locks, block, integers, blocks, motion, inverse_mass), XpbdFields(points)
    approach = Approach(pair, integers, block, blocks, drives, manifolds, h, step)
    for k, speed in enumerate(approach.speeds):
        end = approach.gaps[k] - h * speed
        fast = (approach.restitution > 0) & (absolute(speed) > threshold)
        _, away = approach.leave(k, end)
        impact = fast & ((speed < 0) | ((end < 0) & away))
        store(blocks, block, fields.bounce + k, select(impact, full(speed, 1), 0))


@simd_kernel
def aim(points, locks, block, integers, blocks, motion, inverse_mass, drives, manifolds, bounce):
    """The speeds with which the impacts that ``spot`` marked are to end, where the bodies are now."""
    _, step, h, _, finest = bounce
    pair, fields = Pair(points, locks, block, integers, blocks, motion, inverse_mass), XpbdFields(points)
    approach = Approach(pair, integers, block, blocks, drives, manifolds, h, step)
    e = approach.restitution
    size = vec.length(pair.v_a) + vec.length(pair.v_b)
    for k, (speed, gap) in enumerate(zip(approach.speeds, approach.gaps, strict=True)):
        leave, _ = approach.leave(k, gap)
        parting = minimum(select(gap > 0, -gap / h, 0), e * speed)
        target = select(speed > 0, leave, select(speed < 0, parting, -FAR))
        marked = load(blocks, block, fields.bounce + k) != 0
        allowed = absolute(speed) * minimum(0.1 * (1 - e), full(speed, COARSEST)) + finest * size
        store(blocks, block, fields.bounce + k, select(marked, target, 0))
        store(blocks, block, fields.allowed + k, allowed)


@simd_kernel
def renew(points, locks, block, integers, blocks, motion, inverse_mass):
    """The matrices of a block where the bodies are now: before impacts are swept many times, which with those of the start of the step could diverge
    where bodies have turned far."""
    pair, fields = Pair(points, locks, block, integers, blocks, motion, inverse_mass), XpbdFields(points)
    n, t = pair.normal, vec.tangents(pair.normal)
    valid = [load(integers, block, COUNT) > k for k in range(points)]
    along = vec.dot(n, weighted(pair.m_a, n)) + vec.dot(n, weighted(pair.m_b, n))
    arms_b = [vec.sub(c, pair.shift) for c in pair.arms]
    arms_a = [vec.add(c, pair.lever) for c in arms_b]
    turns_b = [vec.sym_mul_vec(pair.inertia_b, c) for c in arms_b]
    turns_a = [vec.sym_mul_vec(pair.inertia_a, c) for c in arms_a]
    for j in range(points):
        inverse = reciprocal(
            select(valid[j], along + vec.dot(arms_b[j], turns_b[j]) + vec.dot(arms_a[j], turns_a[j]), 1)
        )
        store(blocks, block, fields.inverse + j, inverse)
        for k in range(points):
            if j != k:
                entry = along + vec.dot(arms_b[j], turns_b[k]) + vec.dot(arms_a[j], turns_a[k])
                store(blocks, block, fields.coupling(j, k), select(valid[j] & valid[k], entry * inverse, 0))
    matrix = []
    for i, j in ((0, 0), (0, 1), (1, 1)):
        entry = vec.dot(t[i], weighted(pair.m_a, t[j])) + vec.dot(t[i], weighted(pair.m_b, t[j]))
        for arm, inertia in ((pair.arm_a, pair.inertia_a), (pair.arm_b, pair.inertia_b)):
            entry = entry + vec.dot(vec.cross(arm, t[i]), vec.sym_mul_vec(inertia, vec.cross(arm, t[j])))
        matrix.append(entry)
    for i, entry in enumerate(invert_2x2(*matrix)):
        store(blocks, block, FRICTION_MATRIX + i, entry)
    twist = vec.dot(n, vec.add(vec.sym_mul_vec(pair.inertia_a, n), vec.sym_mul_vec(pair.inertia_b, n)))
    store(blocks, block, TWIST_MASS, reciprocal(twist))


@simd_kernel
def solve_positions(points, locks, block, other, integers, blocks, motion, inverse_mass, numbers):
    """Push overlapping points apart, and bring anchors together where friction holds: in two blocks of a colour, or twice the same.

    ``numbers``: inverse substep length [1/s]; compliance / h² [1/kg]; greatest speed at which overlap is pushed out [m/s].
    """
    block = beside(block, other)
    pair, fields = Pair(points, locks, block, integers, blocks, motion, inverse_mass), XpbdFields(points)
    inverse_h, compliance, fastest = numbers
    wanted, scales = [], []
    for k, (speed, gap) in enumerate(zip(pair.normal_velocities(), pair.gaps(blocks), strict=True)):
        rests, inverse = load(blocks, block, fields.bounce + k) == 0, load(blocks, block, fields.inverse + k)
        scales.append(1 / (1 + compliance * inverse))
        wanted.append(-inverse * scales[k] * select(rests, speed + maximum(gap * inverse_h, -fastest), FAR))
    zero = full(wanted[0], 0)
    new = sweep_normal_impulses(
        fields, blocks, block, [zero] * points, wanted, scales, INNER_SWEEPS if points > 1 else 1
    )
    pair.press(new)
    for k in range(points):  # those of the last substep are final now
        store(
            blocks,
            block,
            fields.total + k,
            load(blocks, block, fields.total + k) + load(blocks, block, fields.impulse + k),
        )
        store(blocks, block, fields.impulse + k, new[k])
    for total, field in ((SLIDE_TOTAL, SLIDE), (SLIDE_TOTAL + 1, SLIDE + 1), (TWIST_TOTAL, TWIST)):
        store(blocks, block, total, load(blocks, block, total) + load(blocks, block, field))

    grip = Grip(pair, blocks, inverse_h)
    parted = grip.parted()
    anchor = [load(blocks, block, fields.anchor + i) for i in range(3)]
    limit = load(blocks, block, COEFFICIENT) * sum(new[1:], new[0])
    twist = zero
    if points > 1:
        most = limit * load(blocks, block, TWIST_RADIUS)
        slip = load(blocks, block, TWIST_MASS) * vec.dot(pair.normal, vec.sub(pair.w_b, pair.w_a))
        held = anchor[2] - parted[2] - slip
        sticks = absolute(held) <= most
        twist = select(sticks, held, maximum(minimum(-slip, most), -most))
        store(blocks, block, fields.anchor + 2, select(sticks, anchor[2], parted[2]))
        pair.twist(twist)
    store(blocks, block, TWIST, twist)
    slip = pair.slip()
    slip = vec.dot(grip.t1, slip), vec.dot(grip.t2, slip)
    x, y = grip.undo(*slip)
    x, y = anchor[0] - parted[0] - x, anchor[1] - parted[1] - y
    sticks = x * x + y * y <= limit * limit
    slides = solve_disk((zero, zero), slip, grip.inverse, limit)
    slide = select(sticks, x, slides[0]), select(sticks, y, slides[1])
    pair.drag(vec.add_scaled(vec.scale(grip.t1, slide[0]), grip.t2, slide[1]))
    for i in range(2):
        store(blocks, block, SLIDE + i, slide[i])
        store(blocks, block, fields.anchor + i, select(sticks, anchor[i], parted[i]))
    pair.store()


@simd_kernel
def solve_velocities(points, locks, block, other, integers, blocks, motion, inverse_mass, inverse_h, ease) -> bool:
    """Where the bodies are now: end impacts, take back the speed that pushing out gave, and let friction act within what the impulses of the
    substep allow; in two blocks of a colour, or twice the same. Whether some impact was still off its speed, which is ``ease`` times what it
    was; if ``ease`` is None, nothing bounces."""
    block = beside(block, other)
    pair, fields = Pair(points, locks, block, integers, blocks, motion, inverse_mass), XpbdFields(points)
    old = [load(blocks, block, fields.impulse + k) for k in range(points)]
    gaps, excess = pair.gaps(blocks), pair.normal_velocities()
    wanted, wrong = [], old[0] != old[0]
    for k in range(points):
        apart = select(old[k] > 0, -gaps[k] * inverse_h, -FAR)  # what has not been pushed may come on
        target = select(gaps[k] > 0, apart, 0)
        if ease is None:
            excess[k] = excess[k] - target
        else:
            bounce = load(blocks, block, fields.bounce + k)
            bounce = select(bounce > 0, bounce * ease, bounce)
            excess[k] = excess[k] - select(bounce == 0, target, bounce)
            off = (bounce != 0) & (absolute(excess[k]) > load(blocks, block, fields.allowed + k))
            wrong = wrong | (off & ((old[k] > 0) | (excess[k] < 0)))
        wanted.append(old[k] - load(blocks, block, fields.inverse + k) * excess[k])
    new = sweep_normal_impulses(fields, blocks, block, old, wanted, None, INNER_SWEEPS if points > 1 else 1)
    pair.press([new[k] - old[k] for k in range(points)])
    for k in range(points):
        store(blocks, block, fields.impulse + k, new[k])
    pair.rub(blocks, load(blocks, block, COEFFICIENT) * sum(new[1:], new[0]), SLIDE, TWIST)
    pair.store()
    return any_lane(wrong)


@simd_kernel
def finish(points, locks, block, integers, blocks, motion, inverse_mass, inverse_h):
    """What ``soft_contact.store_impulses`` is to write: the impulses of the whole step, and how far the anchors have parted."""
    pair, fields = Pair(points, locks, block, integers, blocks, motion, inverse_mass), XpbdFields(points)
    for k in range(points):
        whole = load(blocks, block, fields.total + k) + load(blocks, block, fields.impulse + k)
        store(blocks, block, fields.total + k, whole)
        store(blocks, block, fields.impulse + k, whole)
    for total, field in ((SLIDE_TOTAL, SLIDE), (SLIDE_TOTAL + 1, SLIDE + 1), (TWIST_TOTAL, TWIST)):
        store(blocks, block, total, load(blocks, block, total) + load(blocks, block, field))
    used = load(integers, block, COUNT) > 0
    for i, (field, parted) in enumerate(
        zip((SLIDE, SLIDE + 1, TWIST), Grip(pair, blocks, inverse_h).parted(), strict=True)
    ):
        anchor = load(blocks, block, fields.anchor + i)
        store(blocks, block, field, select(used, anchor - parted, 0))
