"""Joints in ``avbd``: rows that are springs of finite stiffness with multipliers, as its contacts are, but two-sided.

A row of a part (engine/joints) has the coordinate C and the Jacobian J, both of the step's beginning. It pushes along Jᵀ with f = λ − k s, where s is
how fast it is to be led back, or how far it is off at the step's end, over h:

    s = C(x⁻ + h v) / h − keep C(x⁻) / h.

C is taken at the poses in which the step would end, not from J, so that a link that turns within the step does not grow longer; and forces act
along Jᵀ at its beginning. Where the sweeps converge this is the scheme SHAKE (J.-P. Ryckaert, G. Ciccotti, H. J. C. Berendsen, J. Comput. Phys.
23, 1977), a leapfrog step with constraints, so that a pendulum does not lose energy as in implicit Euler. Where bodies turn far in a step J leans
towards its end (avbd_joint_aim.py). Velocities are those of leapfrog, too: means over the step, with which the bodies moved.

Between two sweeps C is taken to be linear, C(x⁻ + h v) / h = J v + bias, and after each the bias is set so that this is exact at the present v.

Springs are the exact ones of ``joints/elastic.py``, whose impulse is linear in v: λ = −(q v + p v₀ + β C₀) / (K (1 − q)) is a force with the
stiffness q / (K (1 − q)), and needs no multiplier; springs on vectors likewise, with the matrix K⁻¹. Motors and friction have multipliers with
bounds, limits such as only push.

Source of the augmented Lagrangian scheme: C. Giles, E. Diaz, C. Yuksel, "Augmented Vertex Block Descent", ACM Trans. Graph. 44 (4), 2025, section 3.
"""

import math

from atlasphys.engine.jit import routine
from atlasphys.engine.joints.evaluate import EFFECTIVE, TURN_B
from atlasphys.engine.math import vec
from atlasphys.engine.simd import LANES
from atlasphys.engine.solvers.avbd_joint_rows import (
    PENALTY,
    end_velocity,
    impulse_along,
    is_turning,
    part_force,
    row_count,
    row_rate,
    side_of,
)
from atlasphys.engine.state.joint_work import (
    BEFORE,
    IMPULSES,
    LIVE,
    PART,
    ROW_A,
    ROW_B,
    SLIPPED,
    TIED_A,
    TIED_B,
    TOTALS,
)
from atlasphys.engine.state.joints import (
    COUPLING,
    FIRST_BLOCK_TYPE,
    MOTOR,
    MOTOR_TOTAL,
    PULLEY,
)


@routine
def list_parts(body_count, joints, first, entries):
    """List each body's parts: body i has the entries ``first[i]`` to ``first[i + 1]``, twice 8 block + lane, plus 1 where it is b."""
    integers = joints.integers
    for i in range(body_count + 2):
        first[i] = 0
    for e in range(LANES * len(integers)):
        block, lane = e // LANES, e % LANES
        if integers[block, LIVE, lane]:
            for side in range(2):
                if integers[block, TIED_A + side, lane]:
                    first[integers[block, ROW_A + side, lane] + 2] += 1
    for i in range(body_count):
        first[i + 2] += first[i + 1]
    for e in range(LANES * len(integers)):
        block, lane = e // LANES, e % LANES
        if integers[block, LIVE, lane]:
            for side in range(2):
                if integers[block, TIED_A + side, lane]:
                    row = integers[block, ROW_A + side, lane] + 1
                    entries[first[row]] = 2 * e + side
                    first[row] += 1


@routine
def list_links(joints, pairs, count):
    """Write the bodies that each part ties behind the pairs in contact. Returns how many pairs there are now. A body that is tied to the world is
    paired with itself."""
    integers = joints.integers
    for e in range(LANES * len(integers)):
        block, lane = e // LANES, e % LANES
        if integers[block, LIVE, lane]:
            a, b = integers[block, ROW_A, lane], integers[block, ROW_B, lane]
            pairs[count, 0], pairs[count, 1] = a, b
            count += 1
    return count


@routine
def bind_to_world(joints, kinds, parent, free):
    """Islands with a part that does not act on two bodies alike are not free."""
    integers = joints.integers
    for e in range(LANES * len(integers)):
        block, lane = e // LANES, e % LANES
        if integers[block, LIVE, lane]:
            both = integers[block, TIED_A, lane] and integers[block, TIED_B, lane]
            if not both or kinds[block] == PULLEY or kinds[block] == COUPLING:
                free[parent[integers[block, ROW_A, lane]]] = free[parent[integers[block, ROW_B, lane]]] = False


@routine
def update_parts(motion, joints, kinds, rows, h, alpha, most, beta, rise, most_penalty, fall, most_mass, length_unit):
    """λ ← f for all parts, and greater penalties where the load asks for them, as for contacts
    (``avbd.update_multipliers``). Returns the greatest error of a part [speed], angles times the length unit."""
    error = h - h
    for e in range(LANES * len(kinds)):
        block, lane = e // LANES, e % LANES
        if joints.integers[block, LIVE, lane]:
            kind, part = kinds[block], joints.integers[block, PART, lane]
            impulses, _, off = part_force(kind, block, lane, motion, joints, rows, h, alpha, most, True)
            turns = is_turning(kind)
            error = max(error, off * length_unit if turns else off)
            if off > 0:
                unit = length_unit if turns else h / h
                carried = min(math.sqrt(vec.length_squared(impulses)) * unit / fall, most_mass * unit * unit)
                mass = h - h
                for r in range(row_count(kind)):
                    mass = max(mass, rows[block, EFFECTIVE + r, lane])
                penalty = joints.impulse[part, PENALTY]
                wanted = min(beta * carried, rise * penalty)
                joints.impulse[part, PENALTY] = min(max(penalty, wanted), most_penalty * mass)
    return error


@routine
def forget_multipliers(joints):
    """Begin the next step without multipliers. Where the constraints contradict each other they grow from sweep to sweep, and are no guess."""
    for block in range(len(joints.blocks)):
        for k in range(IMPULSES, SLIPPED):
            for lane in range(LANES):
                joints.blocks[block, k, lane] = 0
        for lane in range(LANES):
            if joints.integers[block, LIVE, lane]:
                joints.impulse[joints.integers[block, PART, lane], PENALTY] = 0


@routine
def restrain(motion, inertial, body_count, first, fastest):
    """Let no joined body's velocity be changed by more than ``fastest``, as joints do that contradict each other."""
    for i in range(body_count):
        if first[i] < first[i + 1]:
            for k in (0, 3):
                before = vec.load_columns(inertial, i, k)
                change = vec.sub(vec.load_columns(motion, i, k), before)
                size = math.sqrt(vec.length_squared(change))
                if size > fastest:
                    vec.store_columns(motion, i, k, vec.add_scaled(before, change, fastest / size))


@routine
def report_parts(motion, joints, kinds, rows, h):
    """Write the impulses of the step on body b, the rates of coordinates, and how far couplings have slipped."""
    blocks = joints.blocks
    for e in range(LANES * len(kinds)):
        block, lane = e // LANES, e % LANES
        if joints.integers[block, LIVE, lane]:
            kind = kinds[block]
            turns = is_turning(kind) or kind == COUPLING
            for r in range(row_count(kind)):
                impulse = impulse_along(kind, block, lane, joints, r)
                push, turn = side_of(rows, block, lane, r, 6), side_of(rows, block, lane, r, TURN_B)
                for k in range(3):
                    blocks[block, TOTALS + k, lane] += impulse * push[k]
                    if turns:
                        blocks[block, TOTALS + 3 + k, lane] += impulse * turn[k]
            if kind < FIRST_BLOCK_TYPE:
                v_a, w_a = end_velocity(motion, joints, block, lane, 0)
                v_b, w_b = end_velocity(motion, joints, block, lane, 1)
                rate = row_rate(rows, block, lane, 0, 0, v_a, w_a, v_b, w_b)
                blocks[block, BEFORE, lane] = rate
                blocks[block, TOTALS + MOTOR_TOTAL, lane] = blocks[block, IMPULSES + MOTOR, lane]
                if kind == COUPLING:
                    blocks[block, SLIPPED, lane] += h * rate
