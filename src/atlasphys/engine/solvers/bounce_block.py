"""Restitution of eight manifolds side by side: impacts are resolved before the substeps of a step. Bodies over lanes.

In a step in which some point comes in faster than the threshold and would reach the surface, ``aim`` works out for every point how fast the bodies
shall part there, v′ ≥ target; ``strike`` is swept over all contacts until that holds, with λ ≥ 0 and λ (v′ − target) = 0; and ``depart`` takes the
points that bounced or part out of the rest of the step, which so cannot take back or add to the bounce. The substeps then go on from the new
velocities.

- A point that strikes leaves with the speed u that the law of restitution asks for *at the surface*: semi-implicit Euler with step h in a field of
  acceleration a towards the surface keeps v² + 2 a gap − a h v (v > 0 outwards), so u² + 2 a gap − a h u = e² (s² + 2 a gap + a h s) for approach
  speed s.
- A point whose impact is nearer to the step's end than to its beginning strikes in the next step, if the overlap until then is within the slop.
- A point that parts takes Moreau's form of the law, v′ ≥ −e v, where other impacts push it back. With it λ·(v′ + e v) = 0, and without friction the
  energy changes by −½ (1 − e) / (1 + e) λ · A λ ≤ 0, with A the matrix of all contacts.
- All other points hold: what lies on them cannot be driven through them.

The impulses are gathered in the fields of the totals, which they are part of, the targets in those of the impulses and the errors that are allowed in
those of the gaps, until ``depart`` writes both again.
"""

from atlasphys.engine.simd import (
    absolute,
    any_lane,
    full,
    gather,
    load,
    maximum,
    minimum,
    select,
    simd_kernel,
    sqrt,
    store,
)
from atlasphys.engine.solvers.contact_block import (
    COEFFICIENT,
    FAR,
    SLIDE_TOTAL,
    TWIST_TOTAL,
    sweep_normal_impulses,
)
from atlasphys.engine.solvers.soft_contact import Pair
from atlasphys.engine.state.blocks import COUNT, MANIFOLD
from atlasphys.engine.state.manifolds import DEPTH, NORMAL_IMPULSE, POINT_COLUMNS, RESTITUTION

BOUNCE_SWEEPS = 4
"""Sweeps over the points of a manifold at each visit."""

MOST_STRIKES = 400
"""Most visits to a contact. Elastic piles, which have no loss to spare, take a hundred; else it is a few."""

EASED, EASE = 300, 0.9
"""After so many visits all bounces are weakened by this factor: impulses not solved to the end could gain energy."""

COARSEST = 1e-3
"""Relative error of speeds that is allowed at most. Near e = 1 it is a tenth of the loss, so that no impulse gains energy."""

FINEST = {"f": 1e-6, "d": 1e-14}
"""Relative error of speeds that is asked for at e = 1, by NumPy's character for the precision."""

LATE = 2 * FAR
"""In place of the allowed error: the point strikes in the next step, until when it is left alone."""


@simd_kernel
def aim(points, locks, block, integers, blocks, motion, inverse_mass, drives, manifolds, bounce) -> bool:
    """Write the targets. Whether any point strikes, waits to do so, or parts from an overlap.

    ``bounce``: threshold [m/s], length of the step and of a substep [s], slop [m], finest relative error.
    """
    threshold, step, h, slop, finest = bounce
    pair = Pair(points, locks, block, integers, blocks, motion, inverse_mass)
    fields = pair.fields
    head = gather(manifolds.contact, load(integers, block, MANIFOLD))
    e = select(load(integers, block, COUNT) > 0, head[RESTITUTION], 0)
    speeds = pair.normal_velocities()
    gain_a, gain_b = gather(drives, pair.row_a), gather(drives, pair.row_b)
    pair.v_a, pair.w_a, pair.v_b, pair.w_b = gain_a[0:3], gain_a[4:7], gain_b[0:3], gain_b[4:7]
    acts = e != e
    for k, (speed, gain) in enumerate(zip(speeds, pair.normal_velocities(), strict=True)):
        zero = full(speed, 0)
        gap = load(blocks, block, fields.gap + k)
        valid, fast = gap < FAR, (e > 0) & (absolute(speed) > threshold)
        approach, acceleration = -speed, -gain / h
        end = gap - step * approach - 0.5 * acceleration * step * (step + h)
        beyond = end - h * (approach + acceleration * (step + h))  # the last substep looks one substep ahead
        strikes = valid & fast & (approach > 0) & (beyond < 0)
        late = strikes & (end > -slop) & (gap > -end)
        start = maximum(gap, -approach * step)  # deeper than it can have come in a step: an overlap of other origin
        half = 0.5 * acceleration * h
        bounced = e * e * (approach * approach + 2 * acceleration * start + 2 * half * approach)
        shortest = acceleration * step  # slower it would be back within the step
        resolved = (bounced > 0) & ((bounced > shortest * shortest) | (acceleration == 0))
        leave = half + sqrt(maximum(bounced + half * half - 2 * acceleration * start, zero))
        hold = select(gap > 0, minimum(speed, -gap / step), 0)
        parts = valid & fast & (approach < 0)
        target = select(strikes & resolved, leave, select(parts, minimum(hold, e * approach), hold))
        allowed = absolute(speed) * maximum(minimum(0.1 * (1 - e), full(speed, COARSEST)), finest)
        judged = (strikes & resolved) | parts
        store(blocks, block, fields.impulse + k, select(valid & ~late, target, -FAR))
        store(blocks, block, fields.gap + k, select(late, full(gap, LATE), select(judged, allowed, FAR)))
        acts = acts | strikes | (parts & (gap < 0))
    return any_lane(acts)


@simd_kernel
def strike(points, locks, block, integers, blocks, motion, inverse_mass, ease) -> bool:
    """One visit: friction within what the normal impulses allow, then these. Whether some point was still off its target, which is ``ease`` times
    what it was."""
    pair = Pair(points, locks, block, integers, blocks, motion, inverse_mass)
    fields = pair.fields
    old = [load(blocks, block, fields.total + k) for k in range(points)]
    pair.rub(blocks, load(blocks, block, COEFFICIENT) * sum(old[1:], old[0]), SLIDE_TOTAL, TWIST_TOTAL)
    targets = [load(blocks, block, fields.impulse + k) for k in range(points)]
    excess = [v - select(t > 0, t * ease, t) for v, t in zip(pair.normal_velocities(), targets, strict=True)]
    wrong = old[0] != old[0]
    for k in range(points):
        off = absolute(excess[k]) > load(blocks, block, fields.gap + k)
        wrong = wrong | (off & ((old[k] > 0) | (excess[k] < 0)))
    wanted = [old[k] - load(blocks, block, fields.inverse + k) * excess[k] for k in range(points)]
    new = sweep_normal_impulses(fields, blocks, block, old, wanted, None, BOUNCE_SWEEPS if points > 1 else 1)
    pair.press([new[k] - old[k] for k in range(points)])
    for k in range(points):
        store(blocks, block, fields.total + k, new[k])
    pair.store()
    return any_lane(wrong)


@simd_kernel
def depart(points, locks, block, integers, blocks, motion, inverse_mass, manifolds, ratio):
    """Write gaps and impulses again as ``prepare`` did, except at points that bounced, part or wait: they are out of reach in this step."""
    pair = Pair(points, locks, block, integers, blocks, motion, inverse_mass)
    fields, count = pair.fields, load(integers, block, COUNT)
    table = gather(manifolds.points, load(integers, block, MANIFOLD), POINT_COLUMNS * points)
    for k, speed in enumerate(pair.normal_velocities()):
        allowed = load(blocks, block, fields.gap + k)
        touches = (count > k) & (allowed < LATE) & ~((allowed < FAR) & (speed > 0))
        column = POINT_COLUMNS * k
        store(blocks, block, fields.gap + k, select(touches, -table[column + DEPTH], FAR))
        store(blocks, block, fields.impulse + k, select(touches, table[column + NORMAL_IMPULSE] * ratio, 0))
