"""Contact recycling: a pair that has barely moved since it was last collided keeps its contact points, with *frozen arms*.

A soft contact is a spring, and a tower of springs buckles under its own weight (docs/soft_step.md). The weight's overturning moment comes in
through the arms from the centres of mass to the contact points, which shift as the tower leans. Kept as they were at the last full collision, they
hold the tower up; and a pair at rest need not be collided again. What changes each step is the normal, which turns with body a, and the
depth, from where the two bodies' copies of the contact point now are: depth₀ − n · e with e = (x_b + R_b l_b) − (x_a + R_a l_a).

A pair is collided afresh once the part of e across the normal exceeds ``slip`` at any of its points, either body has turned by more than ``turn``, or
they have by more than ``twist`` against each other. (The part along the normal changes nothing but the depth, which is kept up to date; the lowest
contacts of tall towers give way by centimetres.) So it is when they come together or part faster than ``speed``: frozen arms are for pairs at rest
relative to each other, and would cost an impact's angular momentum. Angles are compared by the distance of unit quaternions,
|p − q| = 2 sin(θ / 4), in which small ones do not lose their digits as they do in the cosine p · q.
"""

from atlasphys.engine.simd import (
    absolute,
    any_lane,
    full,
    gather,
    load,
    maximum,
    scatter,
    select,
    simd_kernel,
    store,
    vec,
    when,
)
from atlasphys.engine.state.manifolds import (
    COLLISION_DEPTH,
    DEPTH,
    IS_FRESH,
    IS_RECYCLABLE,
    LOCAL_A,
    LOCAL_B,
    NORMAL_IN_A,
    POINT_COLUMNS,
    TURN_A,
    TURN_B,
)

# Rows of the integers of a block of pairs: (8, 8)
PAIR_A, PAIR_B, OLD_ROW, NEW_ROW, OLD_COUNT, SWAPPED, RESULT, HAS_COPY = range(8)

QUATERNION = 12
"""First of the columns of ``Bodies.geometry`` that hold the orientation."""


def conjugate_mul(p, q):
    """p* q of quaternions: the turn that leads from p to q."""
    return (
        p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3],
        p[0] * q[1] - p[1] * q[0] - p[2] * q[3] + p[3] * q[2],
        p[0] * q[2] - p[2] * q[0] - p[3] * q[1] + p[1] * q[3],
        p[0] * q[3] - p[3] * q[0] - p[1] * q[2] + p[2] * q[1],
    )


def distance_squared(p, q):
    """|p − q|² of quaternions."""
    w, x, y, z = (p[k] - q[k] for k in range(4))
    return w * w + x * x + y * y + z * z


@simd_kernel
def recycle(points_each, integers, delta, geometry, old, new, limits):
    """Carry eight manifolds of up to ``points_each`` (1 or 4) points over, row by row, where they may be recycled; RESULT of ``integers`` says
    for which that was done.

    ``delta`` (3, 8) is x_b − x_a. ``limits``: slip² [m²]; (2 sin(θ / 4))² of turn and of twist; gap beyond which there is no contact [m]; change
    of depth in a step [m].
    """
    slip_squared, turn_squared, twist_squared, margin, change = limits
    width = POINT_COLUMNS * points_each
    row, count = load(integers, OLD_ROW), load(integers, OLD_COUNT)
    frame_a, frame_b = gather(geometry, load(integers, PAIR_A), 16), gather(geometry, load(integers, PAIR_B), 16)
    reference, local = gather(old.reference, row, 16), gather(old.local, row, width)
    head, points = gather(old.contact, row, 16), list(gather(old.points, row, width))
    turn_a, turn_b = frame_a[QUATERNION:16], frame_b[QUATERNION:16]
    then_a, then_b = reference[TURN_A : TURN_A + 4], reference[TURN_B : TURN_B + 4]
    keeps = (
        (reference[IS_RECYCLABLE] > 0)
        & (distance_squared(turn_a, then_a) <= turn_squared)
        & (distance_squared(turn_b, then_b) <= turn_squared)
        & (distance_squared(conjugate_mul(turn_a, turn_b), conjugate_mul(then_a, then_b)) <= twist_squared)
    )
    n = vec.mat_mul_vec(frame_a, reference[NORMAL_IN_A : NORMAL_IN_A + 3])
    between = load(delta, 0), load(delta, 1), load(delta, 2)
    deepest = full(n[0], -1e6)
    for k in range(points_each):
        first = POINT_COLUMNS * k
        at_a = vec.mat_mul_vec(frame_a, local[first + LOCAL_A : first + LOCAL_A + 3])
        at_b = vec.mat_mul_vec(frame_b, local[first + LOCAL_B : first + LOCAL_B + 3])
        moved = vec.sub(vec.add(between, at_b), at_a)
        valid = count > k
        along = vec.dot(n, moved)
        depth = local[first + COLLISION_DEPTH] - along
        slipped = vec.length_squared(vec.add_scaled(moved, n, -along))
        rests = (slipped <= slip_squared) & (absolute(depth - points[first + DEPTH]) <= change)
        keeps = keeps & (~valid | rests)
        points[first + DEPTH] = select(valid, depth, 0)
        deepest = select(valid, maximum(depth, deepest), deepest)
    keeps = keeps & (deepest >= -margin)
    head = (*n, *head[3:IS_FRESH], full(n[0], 0), *head[IS_FRESH + 1 :])
    scatter(new.contact, row, head, where=keeps)
    scatter(new.points, row, tuple(points), where=keeps)
    lacking = keeps & (load(integers, HAS_COPY) == 0)

    def copy():
        unused = (full(n[0], 0),) * (4 * POINT_COLUMNS - width)
        scatter(new.local, row, (*local, *unused), where=lacking)
        if unused:
            scatter(new.points, row, unused, width, where=lacking)
        scatter(new.reference, row, reference, where=lacking)

    when(any_lane(lacking), copy)
    store(integers, RESULT, select(keeps, full(row, 1), 0))
