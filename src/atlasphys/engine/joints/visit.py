"""What a solver does with a block of eight parts of a type: prepare, warm start, solve, store. Bodies over lanes.

All parts are solved alike, from their coordinates C and Jacobians J at the bodies' present poses (``PARTS``), which are worked out anew at each
visit, so that arms and axes turn with the bodies from substep to substep.

*Blocks* (point, line, axis, lock) hold a vector C at zero: λ ← −K⁻¹ (μ J v + β C) + μ λ. *Axial* parts have one row, on which up to five impulses
act, one after the other: a spring; a motor, which drives Ċ to its speed; friction, which drives it to 0; and the two limits, which only push. They
all know the velocity that the ones before them left. Forces are bounded by bounding the impulse of a substep.

Softness (μ, β) is exact for springs (elastic.py). Rigid rows and limits are soft in the ``SOLVE`` pass, so that errors are taken back without
overshoot, and rigid without correction in the ``RELAX`` pass, which takes back the speed that correction gave. Springs are left as they are there:
they are forces, not errors.
"""

from __future__ import annotations

from typing import Any

from atlasphys.engine.joints.ends import Ends, multiply, reciprocal, rotate
from atlasphys.engine.joints.halfway import CARRIED_ON, halfway
from atlasphys.engine.joints.held import HOLDERS, held_back
from atlasphys.engine.joints.parts import PARTS, TURNING, is_block
from atlasphys.engine.joints.rows import NONE, Row, combined, masses, minus, pushed, rate
from atlasphys.engine.joints.symmetric import solve_symmetric
from atlasphys.engine.simd import full, gather, load, maximum, minimum, scatter, select, simd_kernel, sqrt, store, vec
from atlasphys.engine.state.joint_work import (
    APART,
    BEFORE,
    FASTEST,
    HELD,
    IMPULSES,
    INVERSE_H,
    KEEP,
    LIVE,
    MASS,
    MOVES_A,
    MOVES_B,
    PART,
    PULL,
    RATIO,
    ROW_A,
    ROW_B,
    SLIPPED,
    TIED_A,
    TIED_B,
    TOTALS,
    H,
)
from atlasphys.engine.state.joints import (
    ARM_A,
    ARM_B,
    AT_LOWER,
    AT_UPPER,
    COUPLING,
    FRAME_A,
    FRAME_B,
    FRICTION,
    FRICTION_FORCE,
    LOWER,
    MOTOR,
    MOTOR_FORCE,
    MOTOR_TOTAL,
    PHASE,
    POINT,
    PULLEY,
    RATE,
    RATIO_A,
    REST,
    ROTATION,
    SETTING_COLUMNS,
    SPEED,
    SPRING,
    SPRING_BEFORE,
    SPRING_FORCE,
    SPRING_MASS,
    SPRING_PULL,
    TURNS_A,
)

POSE = 8
"""First of the columns of ``Bodies.geometry`` that are read; the orientation is in the last four."""

PUSH_LOSS = 16.0
"""Share by which errors are taken back more slowly than at FASTEST, over the fourth power of the angle that the two bodies turn in a substep. The
speed that correction gives along J at the beginning is taken back along J at the end. What these differ by stays, and would feed bodies on long
levers for ever that turn by half a radian and more in a step of `sequential_impulse`."""

FULL_TURN = 6.283185307179586


class Tied:
    """The two bodies of a block's parts, and their ends."""

    def __init__(self, kind: int, block: Any, motion: Any, geometry: Any, inverse_mass: Any, work: Any) -> None:
        self.kind, self.block, self.blocks, self.integers, self.motion = kind, block, work.blocks, work.integers, motion
        sides = []
        for side, (row, tied, moves) in enumerate(((ROW_A, TIED_A, MOVES_A), (ROW_B, TIED_B, MOVES_B))):
            at = load(work.integers, block, row)
            is_body = load(work.integers, block, tied) != 0
            moved = load(work.integers, block, moves) != 0
            m = [select(is_body, x, 0) for x in gather(motion, at, 16)]
            inverse = [select(moved, x, 0) for x in gather(inverse_mass, at, 16)]
            q = gather(geometry, at, 8, POSE)[4:8]
            q = (select(is_body, q[0], 1), *(select(is_body, x, 0) for x in q[1:]))
            arm = rotate(q, self.setting(ARM_B if side else ARM_A, 3))
            frame = q
            if kind != POINT:
                frame = multiply(q, self.setting(FRAME_B if side else FRAME_A, 4))
            sides.append((at, moved, m, inverse, arm, frame))
        self.sides = sides
        (_, _, a, inverse_a, arm_a, frame_a), (_, _, b, inverse_b, arm_b, frame_b) = sides
        self.velocity = (tuple(a[0:3]), tuple(a[3:6]), tuple(b[0:3]), tuple(b[3:6]))
        self.inverse = (inverse_a[8:11], inverse_a[0:6], inverse_b[8:11], inverse_b[0:6])
        start = self.field(APART, 3)
        ropes = (start, start)
        apart = start
        if kind == PULLEY:
            ropes = (
                vec.add(vec.add(start, a[6:9]), arm_a),
                vec.add(vec.add(self.field(APART + 3, 3), b[6:9]), arm_b),
            )
        else:
            apart = vec.sub(vec.add(vec.add(start, b[6:9]), arm_b), vec.add(a[6:9], arm_a))
        turns = self.setting(TURNS_A, 2) if kind == COUPLING else (0, 0)
        phase = self.field(SLIPPED, 1)[0] if kind == COUPLING else None
        self.ends = Ends(arm_a, arm_b, apart, frame_a, frame_b, ropes, self.setting(RATIO_A, 2), turns, phase)
        self.rows: list[Row] = PARTS[kind].rows(self.ends)

    def field(self, first: int, number: int) -> Any:
        """Neighbouring fields of the block."""
        return tuple(load(self.blocks, self.block, first + k) for k in range(number))

    def setting(self, first: int, number: int = 1) -> Any:
        """Neighbouring settings of the part."""
        return self.field(first, number)

    def rates(self) -> list[Any]:
        """J v."""
        return [rate(row, *self.velocity) for row in self.rows]

    def mean_rates(self, h: Any, impulses: Any) -> list[Any]:
        """Those at which the coordinates will change over the substep (halfway.py), under the part's present impulses; J v, if the type is not
        one that is solved for them."""
        if self.kind not in CARRIED_ON:
            return self.rates()
        load = sum((x * x for x in impulses[1:]), impulses[0] * impulses[0])
        inertias = self.inverse[1], self.inverse[3]
        ends = halfway(self.kind, self.ends, self.velocity, 0.5 * h, inertias, load)
        return [rate(row, *self.velocity) for row in PARTS[self.kind].rows(ends)]

    def fastest(self, work: Any) -> Any:
        """The greatest rate at which errors are taken back."""
        _, w_a, _, w_b = self.velocity
        h = load_number(work, H)
        turned = h * h * (vec.length_squared(w_a) + vec.length_squared(w_b))
        share = 1 - PUSH_LOSS * turned * turned
        return load_number(work, FASTEST) * maximum(share, full(share, 0))

    def push(self, impulses: list[Any]) -> None:
        """Apply impulses along the rows."""
        self.velocity = pushed(combined(self.rows, impulses), *self.velocity, *self.inverse)

    def store(self) -> None:
        """Write the velocities of the bodies that impulses move."""
        v_a, w_a, v_b, w_b = self.velocity
        for (row, moved, m, *_), v, w in zip(self.sides, (v_a, v_b), (w_a, w_b), strict=True):
            scatter(self.motion, row, (*v, *w, *m[6:8]), where=moved)

    def note(self, impulses: list[Any]) -> None:
        """Add the impulses of a substep to those of the step."""
        total = combined(self.rows, impulses)
        sums = [*total.push_b, *(total.turn_b if self.kind in TURNING else NONE)]
        for k, x in enumerate(sums):
            if type(x) is not int:
                store(self.blocks, self.block, TOTALS + k, load(self.blocks, self.block, TOTALS + k) + x)


@simd_kernel
def prepare(block, work):
    """Write a block from its parts."""
    row = load(work.integers, block, PART)
    settings, impulse = gather(work.settings, row, SETTING_COLUMNS), gather(work.impulse, row)
    for k, x in enumerate(settings[:APART]):
        store(work.blocks, block, k, x)
    ratio = full(settings[0], 1) * load_number(work, RATIO)
    for k in range(PHASE):
        store(work.blocks, block, IMPULSES + k, impulse[k] * ratio)
    store(work.blocks, block, SLIPPED, impulse[PHASE])
    store(work.blocks, block, BEFORE, impulse[RATE])
    for k in range(MOTOR_TOTAL + 1):
        store(work.blocks, block, TOTALS + k, full(settings[0], 0))


def load_number(work: Any, entry: int) -> Any:
    """A number of the step, the same in all lanes."""
    return load(work.numbers, entry)


@simd_kernel
def start(kind, block, motion, geometry, inverse_mass, work):
    """Apply the impulses that the last substep ended with."""
    tied = Tied(kind, block, motion, geometry, inverse_mass, work)
    if is_block(kind):
        tied.push(list(tied.field(IMPULSES, len(tied.rows))))
    else:
        spring, motor, friction, lower, upper = tied.field(IMPULSES, 5)
        tied.push([spring + motor + friction + lower - upper])
    tied.store()


@simd_kernel
def solve(kind, relax, block, motion, geometry, inverse_mass, work):
    """One visit. In the ``relax`` pass rows are rigid and errors are not corrected; the impulses of the substep are final then."""
    tied = Tied(kind, block, motion, geometry, inverse_mass, work)
    if is_block(kind):
        solve_block(tied, relax, work)
    else:
        solve_axial(tied, relax, work)
    tied.store()


def solve_block(tied: Tied, relax: bool, work: Any) -> None:
    """Hold a vector at zero, rigidly or by a spring, or damp its rate by friction."""
    n = len(tied.rows)
    h = load_number(work, H)
    old = tied.field(IMPULSES, n)
    rates = tied.rates() if relax else tied.mean_rates(h, old)
    spring_mass = tied.setting(SPRING_MASS)[0]
    rigid = spring_mass < 0
    if relax:
        wanted = rates
    else:
        mass = select(rigid, load_number(work, MASS), spring_mass)
        pull = select(rigid, load_number(work, PULL), tied.setting(SPRING_PULL)[0])
        fastest = select(rigid, mass * tied.fastest(work), 1e18)
        errors = PARTS[tied.kind].measure(tied.ends)
        wanted = [mass * v + maximum(minimum(pull * c, fastest), -fastest) for v, c in zip(rates, errors, strict=True)]
    change = solve_symmetric(masses(tied.rows, *tied.inverse), wanted)
    if relax:
        acts = rigid | (tied.setting(SPRING_PULL)[0] == 0)  # friction is a spring without pull
        new = [select(acts, x - y, x) for x, y in zip(old, change, strict=True)]
    else:
        keep = select(rigid, 1 - load_number(work, KEEP), spring_mass)
        new = [keep * x - y for x, y in zip(old, change, strict=True)]
    most = h * tied.setting(SPRING_FORCE)[0]
    squared = sum((x * x for x in new[1:]), new[0] * new[0])
    shrink = select(~rigid & (squared > most * most), most / sqrt(squared), 1)
    new = [x * shrink for x in new]
    tied.push([x - y for x, y in zip(new, old, strict=True)])
    for k, x in enumerate(new):
        store(tied.blocks, tied.block, IMPULSES + k, x)
    if relax:
        tied.note(new)


def solve_axial(tied: Tied, relax: bool, work: Any) -> None:
    """Spring, motor, friction and limits of one coordinate."""
    h, inverse_h = load_number(work, H), load_number(work, INVERSE_H)
    spring, motor, friction, lower, upper = old = tied.field(IMPULSES, 5)
    speed = tied.rates()[0] if relax else tied.mean_rates(h, old)[0]
    row = tied.rows[0]
    full_k = k = masses(tied.rows, *tied.inverse)[0][0]
    if tied.kind in HOLDERS:
        taken = held_back(tied.kind, row, tied.ends, tied.inverse)
        left = Row(*(tuple(map(minus, side, other)) for side, other in zip(row, taken, strict=True)))
        held = load(tied.integers, tied.block, HELD) != 0
        k = select(held, masses([left], *tied.inverse)[0][0], k)
        speed = speed - select(held, rate(taken, *tied.velocity), 0)
    if relax and tied.kind == COUPLING:  # the bodies have just moved with these velocities
        store(tied.blocks, tied.block, SLIPPED, load(tied.blocks, tied.block, SLIPPED) + h * speed)
        tied.ends = tied.ends._replace(phase=load(tied.blocks, tied.block, SLIPPED))
    inverse = reciprocal(k)
    c = PARTS[tied.kind].measure(tied.ends)[0]
    if not relax:
        elastic = tied.setting(SPRING_MASS)[0]
        error = c - tied.setting(REST)[0]
        if tied.kind == ROTATION:  # the shorter way round
            error = error - select(error > 0.5 * FULL_TURN, full(error, FULL_TURN), 0)
            error = error + select(error < -0.5 * FULL_TURN, full(error, FULL_TURN), 0)
        before = tied.setting(SPRING_BEFORE)[0]
        wanted = elastic * speed + tied.setting(SPRING_PULL)[0] * error + before * tied.field(BEFORE, 1)[0]
        most = h * tied.setting(SPRING_FORCE)[0]
        share = k * reciprocal(full_k)
        new = (elastic * share * spring - reciprocal(full_k) * wanted) / (1 - elastic + elastic * share)
        new = select(elastic < 0, 0, maximum(minimum(new, most), -most))
        speed = speed + k * (new - spring)
        spring = new
    drives = []
    for impulse, force, goal in ((motor, MOTOR_FORCE, SPEED), (friction, FRICTION_FORCE, None)):
        most = h * tied.setting(force)[0]
        beyond = speed if goal is None else speed - tied.setting(goal)[0]
        new = maximum(minimum(impulse - inverse * beyond, most), -most)
        speed = speed + k * (new - impulse)
        drives.append(new)
    motor, friction = drives

    least, most = tied.setting(LOWER, 2)
    held = least == most
    fastest, pull = tied.fastest(work), load_number(work, PULL)
    mass, keep = (full(c, 1), full(c, 0)) if relax else (load_number(work, MASS), load_number(work, KEEP))
    limits = []
    for impulse, sign, gap in ((lower, 1, c - least), (upper, -1, most - c)):
        free = (gap > 0) & ~held
        correction = full(gap, 0) if relax else maximum(minimum(pull * gap, mass * fastest), -mass * fastest)
        wanted = select(free, sign * speed + gap * inverse_h, mass * (sign * speed) + correction)
        new = impulse - select(free, 0, keep) * impulse - inverse * wanted
        pressed = maximum(new, 0)
        new = select(held, new, pressed) if sign > 0 else select(held, 0, pressed)
        speed = speed + k * (sign * (new - impulse))
        limits.append(new)
    lower, upper = limits
    new = (spring, motor, friction, lower, upper)
    changes = [x - y for x, y in zip(new, old, strict=True)]
    tied.push([changes[SPRING] + changes[MOTOR] + changes[FRICTION] + changes[AT_LOWER] - changes[AT_UPPER]])
    for i, x in enumerate(new):
        store(tied.blocks, tied.block, IMPULSES + i, x)
    if relax:
        tied.note([spring + motor + friction + lower - upper])
        store(tied.blocks, tied.block, BEFORE, speed)
        field = TOTALS + MOTOR_TOTAL
        store(tied.blocks, tied.block, field, load(tied.blocks, tied.block, field) + motor)


@simd_kernel
def keep_results(block, work):
    """Write the impulses of the last substep (for warm starting) and of the whole step (to report) to the parts. Sleeping ones keep theirs."""
    row, live = load(work.integers, block, PART), load(work.integers, block, LIVE) != 0
    impulse = list(gather(work.impulse, row))
    for k in range(PHASE):
        impulse[k] = load(work.blocks, block, IMPULSES + k)
    impulse[PHASE], impulse[RATE] = load(work.blocks, block, SLIPPED), load(work.blocks, block, BEFORE)
    total = [load(work.blocks, block, TOTALS + k) for k in range(MOTOR_TOTAL + 1)]
    scatter(work.impulse, row, tuple(impulse), where=live)
    scatter(work.total, row, (*total, full(total[0], 0)), where=live)
