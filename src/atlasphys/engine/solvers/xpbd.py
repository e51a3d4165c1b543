"""Extended position-based dynamics: many short substeps, each of which moves the bodies freely and then puts right where they are.

M. Müller, M. Macklin, N. Chentanez, S. Jeschke, T.-Y. Kim, "Detailed Rigid Body Simulation with Extended Position Based Dynamics", Computer Graphics
Forum 39(8), 2020. In each substep of length h:

1. *Predict.* Forces change the velocities, and velocities the poses.
2. *Solve positions.* Where two bodies overlap by c > 0 along the normal n, an impulse λ moves and turns both until they touch,

       Δλ = (c − α̃ λ) / (k + α̃),   α̃ = α / h²,   λ ≥ 0,

   with k = n · (M_a⁻¹ + M_b⁻¹) n and compliance α; static friction brings the points that stuck together back, unless that takes more than μ λ.
3. *Derive velocities* from the change of poses.
4. *Solve velocities.* Impacts end with the speed of Newton's law; other contacts give back the speed that pushing out gave them; dynamic friction.

A correction Δx of a pose in a substep changes the derived velocity by Δx / h. So step 2 works on the velocities, the pose that is corrected being
x + h v, and the bodies are moved by the result: 2 and 3 in one. This is the same to first order in h ω, and has two advantages: no speed is a
difference of nearly equal positions, which single precision would not survive at h = 1/1200 s, and bodies move by the scheme of
``body_block.py``, which conserves angular momentum to round-off and has the gyroscopic torque in it.

docs/xpbd.md derives it, and says where it differs from the paper. What it does to eight contacts side by side is in ``xpbd_contact.py``.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from atlasphys.engine.islands.colour import COLOURS, beside, block_ranges, colour_contacts, fill_blocks
from atlasphys.engine.islands.sleep import list_awake
from atlasphys.engine.jit import kernel, routine
from atlasphys.engine.math import quat
from atlasphys.engine.shapes.arguments import invalid, number
from atlasphys.engine.simd import LANES
from atlasphys.engine.simd.by_address import by_address
from atlasphys.engine.solvers.body_block import drive, gain_speed, move, tumble
from atlasphys.engine.solvers.integrate import place_origins
from atlasphys.engine.solvers.locked import follow_turn
from atlasphys.engine.solvers.rolling_block import ROLL, ROLLING_FIELDS, prepare_rolling, solve_rolling, store_rolling
from atlasphys.engine.solvers.soft_contact import prepare, store_impulses
from atlasphys.engine.solvers.xpbd_contact import (
    XpbdFields,
    aim,
    begin,
    finish,
    renew,
    solve_positions,
    solve_velocities,
    spot,
)
from atlasphys.engine.state.arrays import aligned_zeros
from atlasphys.engine.state.blocks import BOUNCES, COUNT, INTEGERS, MANIFOLD, ROLLS
from atlasphys.engine.state.bodies import DYNAMIC, STATIC
from atlasphys.engine.state.manifolds import DEPTH, POINT_COLUMNS, RESTITUTION, ROLLING, TORSIONAL
from atlasphys.engine.state.pose import ROTATION_LOCKS
from atlasphys.engine.state.state import State

MOST_SUBSTEPS = 1000

MOST_SWEEPS = 400
"""Most sweeps over the velocities while impacts are not solved. Usually it is one; elastic piles take a hundred."""

EASED, EASE = 200, 0.95
"""After so many sweeps impacts are weakened by this factor in each. Where bodies are jammed no speeds satisfy all impacts, and impulses would
grow without end; weakened enough, all can be satisfied, and impulses that are accumulated can be taken back."""

FINEST = {"f": 1e-6, "d": 1e-14}
"""Relative error of speeds that is asked for where e = 1, by NumPy's character for the precision."""


@dataclass(frozen=True, slots=True)
class XPBD:
    """Settings of the solver ``xpbd``.

    Attributes:
        substeps: substeps a step; all errors shrink with their length. More: stiffer stacks, in proportion slower.
        compliance: give of a contact point under a force along its normal [m/N]. 0: rigid, as far as the substeps allow.
        push_out_speed: greatest speed at which overlap is pushed out [m/s], for a length unit of 1 m. The paper has no such limit.
            Larger: bodies that were put into each other are thrown apart. Smaller: heavy bodies squeeze light ones out.

    Raises:
        InvalidArgumentError: a value is not of the right kind or out of range.
    """

    substeps: int = 15
    compliance: float = 0.0
    push_out_speed: float = 10.0

    def __post_init__(self) -> None:
        if type(self.substeps) is not int or not 1 <= self.substeps <= MOST_SUBSTEPS:
            raise invalid("substeps", f"an integer from 1 to {MOST_SUBSTEPS}", self.substeps)
        for name, most in (("compliance", 1e6), ("push_out_speed", 1e6)):
            if not 0 <= number(name, getattr(self, name)) <= most:
                raise invalid(name, f"a number from 0 to {most:g}", getattr(self, name))


@by_address
class Blocks(NamedTuple):
    """The contacts of a step in blocks of eight, by colour, and the lists of the bodies that move. ``_one`` holds manifolds of one point."""

    integers_one: npt.NDArray[np.int32]
    """(blocks, 8, 8) who is in which lane; see state/blocks.py."""
    integers_many: npt.NDArray[np.int32]
    contacts_one: npt.NDArray[np.floating]
    """(blocks, fields, 8) the contacts; see ``XpbdFields``."""
    contacts_many: npt.NDArray[np.floating]
    rolls_one: npt.NDArray[np.floating]
    """(blocks, 8, 8) their rolling friction; see rolling_block.py."""
    rolls_many: npt.NDArray[np.floating]
    starts: npt.NDArray[np.int64]
    """(2, 66) first block of each class (0: one point) and colour."""
    plain: npt.NDArray[np.int32]
    """(blocks, 8) rows of the moving bodies that keep their angular velocity."""
    tumbling: npt.NDArray[np.int32]
    """(blocks, 8) rows of the others."""


class Constants(NamedTuple):
    """Numbers of a step, in the world's precision."""

    gravity: tuple[float, float, float]
    h: float
    """Length of a substep [s]."""
    substeps: int
    ratio: float
    """Factor on how far anchors had parted, which is kept as an impulse: length of the last step over that of this one."""
    positions: tuple[float, float | None, float]
    """See ``solve_positions``."""
    bounce: tuple[float, float, float, float]
    """See ``spot``."""


@kernel
def colour(bodies, count, manifolds, manifold_count, body, moves, used, live, colours, sizes, starts, plain, tumbling):
    """Colour the contacts and list the bodies that move."""
    list_awake(bodies.kind, bodies.island, bodies.frame, count, plain, tumbling)
    for i in range(manifold_count):
        live[i] = i
    colour_contacts(
        manifolds.a, manifolds.b, manifolds.count, live, manifold_count, body, moves, used, colours, sizes
    )  # fmt: skip
    block_ranges(sizes, starts)


@routine
def note_materials(points, block, integers, manifolds):
    """Note in a block whether it has rolling friction, and whether it has restitution. Returns the latter."""
    for lane in range(LANES):
        if integers[block, COUNT, lane] > 0:
            i = integers[block, MANIFOLD, lane]
            if manifolds.contact[i, RESTITUTION] > 0:
                integers[block, BOUNCES, 0] = 1
            if manifolds.contact[i, ROLLING] > 0 or (points == 1 and manifolds.contact[i, TORSIONAL] > 0):
                integers[block, ROLLS, 0] = 1
    return integers[block, BOUNCES, 0] > 0


@routine
def prepare_contacts(bodies, manifolds, blocks, locked, ratio):
    """Write the blocks. Returns whether some contact has restitution."""
    inverse_mass, bounces = bodies.inverse_mass, False
    none = ratio - ratio
    for block in range(blocks.starts[1, COLOURS + 1]):
        special = prepare(4, locked, block, blocks.integers_many, blocks.contacts_many, manifolds, inverse_mass, ratio)
        begin(4, block, blocks.contacts_many)
        if special:
            bounces = note_materials(4, block, blocks.integers_many, manifolds) or bounces
            if blocks.integers_many[block, ROLLS, 0]:
                prepare_rolling(
                    block, blocks.integers_many, blocks.contacts_many, blocks.rolls_many, manifolds, inverse_mass, none
                )  # fmt: skip
    for block in range(blocks.starts[0, COLOURS + 1]):
        special = prepare(1, locked, block, blocks.integers_one, blocks.contacts_one, manifolds, inverse_mass, ratio)
        begin(1, block, blocks.contacts_one)
        if special:
            bounces = note_materials(1, block, blocks.integers_one, manifolds) or bounces
            if blocks.integers_one[block, ROLLS, 0]:
                prepare_rolling(
                    block, blocks.integers_one, blocks.contacts_one, blocks.rolls_one, manifolds, inverse_mass, none
                )  # fmt: skip
    return bounces


@routine
def aim_contacts(spots, bodies, manifolds, blocks, locked, bounce):
    """Find the impacts of this substep (``spots``), or the speeds with which they are to end."""
    motion, inverse_mass, drives = bodies.motion, bodies.inverse_mass, bodies.drive
    for block in range(blocks.starts[1, COLOURS + 1]):
        integers, contacts = blocks.integers_many, blocks.contacts_many
        if integers[block, BOUNCES, 0]:
            if spots:
                spot(4, locked, block, integers, contacts, motion, inverse_mass, drives, manifolds, bounce)
            else:
                aim(4, locked, block, integers, contacts, motion, inverse_mass, drives, manifolds, bounce)
    for block in range(blocks.starts[0, COLOURS + 1]):
        integers, contacts = blocks.integers_one, blocks.contacts_one
        if integers[block, BOUNCES, 0]:
            if spots:
                spot(1, locked, block, integers, contacts, motion, inverse_mass, drives, manifolds, bounce)
            else:
                aim(1, locked, block, integers, contacts, motion, inverse_mass, drives, manifolds, bounce)


@routine
def sweep_positions(bodies, blocks, locked, numbers):
    """Solve positions: visit all contacts once, colour by colour."""
    motion, inverse_mass = bodies.motion, bodies.inverse_mass
    none = numbers[0] - numbers[0]
    for c in range(COLOURS + 1):
        first, stop = blocks.starts[1, c], blocks.starts[1, c + 1]
        block = first
        while block < stop:
            other = beside(block, c, stop)
            solve_positions(
                4, locked, block, other, blocks.integers_many, blocks.contacts_many, motion, inverse_mass, numbers
            )
            block = other + 1
        for block in range(first, stop):
            if blocks.integers_many[block, ROLLS, 0]:
                blocks.rolls_many[block, ROLL : ROLL + 2] = none
                solve_rolling(
                    4, block, blocks.integers_many, blocks.contacts_many, blocks.rolls_many, motion, inverse_mass, none
                )  # fmt: skip
        first, stop = blocks.starts[0, c], blocks.starts[0, c + 1]
        block = first
        while block < stop:
            other = beside(block, c, stop)
            solve_positions(
                1, locked, block, other, blocks.integers_one, blocks.contacts_one, motion, inverse_mass, numbers
            )
            block = other + 1
        for block in range(first, stop):
            if blocks.integers_one[block, ROLLS, 0]:
                blocks.rolls_one[block, ROLL : ROLL + 2] = none
                solve_rolling(
                    1, block, blocks.integers_one, blocks.contacts_one, blocks.rolls_one, motion, inverse_mass, none
                )  # fmt: skip


@routine
def sweep_velocities(bodies, blocks, locked, inverse_h, ease):
    """Solve velocities: visit all contacts once, colour by colour. Returns whether an impact was not solved for.

    ``ease`` is a factor on the speeds with which impacts end; None if nothing bounces.
    """
    motion, inverse_mass, wrong = bodies.motion, bodies.inverse_mass, False
    none = inverse_h - inverse_h
    for c in range(COLOURS + 1):
        first, stop = blocks.starts[1, c], blocks.starts[1, c + 1]
        block = first
        while block < stop:
            other = beside(block, c, stop)
            if solve_velocities(
                4, locked, block, other, blocks.integers_many, blocks.contacts_many, motion, inverse_mass, inverse_h, ease
            ):  # fmt: skip
                wrong = True
            block = other + 1
        for block in range(first, stop):
            if blocks.integers_many[block, ROLLS, 0]:
                solve_rolling(
                    4, block, blocks.integers_many, blocks.contacts_many, blocks.rolls_many, motion, inverse_mass, none
                )  # fmt: skip
        first, stop = blocks.starts[0, c], blocks.starts[0, c + 1]
        block = first
        while block < stop:
            other = beside(block, c, stop)
            if solve_velocities(
                1, locked, block, other, blocks.integers_one, blocks.contacts_one, motion, inverse_mass, inverse_h, ease
            ):  # fmt: skip
                wrong = True
            block = other + 1
        for block in range(first, stop):
            if blocks.integers_one[block, ROLLS, 0]:
                solve_rolling(
                    1, block, blocks.integers_one, blocks.contacts_one, blocks.rolls_one, motion, inverse_mass, none
                )  # fmt: skip
    return wrong


@routine
def renew_contacts(bodies, blocks, locked):
    """Bring the matrices of all contacts up to date."""
    motion, inverse_mass = bodies.motion, bodies.inverse_mass
    for block in range(blocks.starts[1, COLOURS + 1]):
        renew(4, locked, block, blocks.integers_many, blocks.contacts_many, motion, inverse_mass)
    for block in range(blocks.starts[0, COLOURS + 1]):
        renew(1, locked, block, blocks.integers_one, blocks.contacts_one, motion, inverse_mass)


@routine
def store_contacts(bodies, manifolds, manifold_count, blocks, locked, inverse_h):
    """Write the impulses to the manifolds, and note which pairs touch."""
    motion, inverse_mass = bodies.motion, bodies.inverse_mass
    for block in range(blocks.starts[1, COLOURS + 1]):
        finish(4, locked, block, blocks.integers_many, blocks.contacts_many, motion, inverse_mass, inverse_h)
        store_impulses(4, block, blocks.integers_many, blocks.contacts_many, manifolds)
        if blocks.integers_many[block, ROLLS, 0]:
            store_rolling(block, blocks.integers_many, blocks.contacts_many, blocks.rolls_many, manifolds)
    for block in range(blocks.starts[0, COLOURS + 1]):
        finish(1, locked, block, blocks.integers_one, blocks.contacts_one, motion, inverse_mass, inverse_h)
        store_impulses(1, block, blocks.integers_one, blocks.contacts_one, manifolds)
        if blocks.integers_one[block, ROLLS, 0]:
            store_rolling(block, blocks.integers_one, blocks.contacts_one, blocks.rolls_one, manifolds)
    for i in range(manifold_count):
        for k in range(manifolds.count[i]):
            if manifolds.total[i, k] > 0 or manifolds.points[i, POINT_COLUMNS * k + DEPTH] >= 0:
                manifolds.touching[i] = True


@kernel
def solve(bodies, count, body, moves, manifolds, manifold_count, live, colours, cursor, blocks, locked, constants):
    """One step for all bodies: ``constants.substeps`` substeps."""
    motion, geometry, inverse_mass = bodies.motion, bodies.geometry, bodies.inverse_mass
    h, inverse_h = constants.h, constants.positions[0]
    fill_blocks(
        manifolds.a, manifolds.b, manifolds.count, live, manifold_count, body, moves, colours, blocks.starts, cursor,
        blocks.integers_one, blocks.integers_many,
    )  # fmt: skip
    for rows in (blocks.plain, blocks.tumbling):
        for block in range(len(rows)):
            drive(
                locked, block, rows, motion, bodies.force, bodies.response, inverse_mass, bodies.mass, bodies.drive,
                constants.gravity, h,
            )  # fmt: skip
    bounces = prepare_contacts(bodies, manifolds, blocks, locked, constants.ratio)
    for _ in range(constants.substeps):
        for rows in (blocks.plain, blocks.tumbling):
            for block in range(len(rows)):
                gain_speed(block, rows, motion, bodies.drive)
        if bounces:
            aim_contacts(True, bodies, manifolds, blocks, locked, constants.bounce)
        sweep_positions(bodies, blocks, locked, constants.positions)
        for block in range(len(blocks.plain)):
            move(block, blocks.plain, motion, geometry, h)
        for block in range(len(blocks.tumbling)):
            tumble(block, blocks.tumbling, motion, geometry, bodies.mass, bodies.frame, inverse_mass, h)
        follow_turn(locked, bodies.locks, motion, geometry, inverse_mass, bodies.mass, bodies.frame, h)
        if not bounces:
            sweep_velocities(bodies, blocks, locked, inverse_h, None)
            continue
        aim_contacts(False, bodies, manifolds, blocks, locked, constants.bounce)
        ease = type(h)(1)
        for s in range(MOST_SWEEPS):
            if not sweep_velocities(bodies, blocks, locked, inverse_h, ease):
                break
            if s >= EASED:
                ease *= type(h)(EASE)
            if s == 0:
                renew_contacts(bodies, blocks, locked)
    store_contacts(bodies, manifolds, manifold_count, blocks, locked, inverse_h)
    for i in range(count):
        if bodies.kind[i] != STATIC:
            quat.store(
                bodies.orientation, i, quat.unit((geometry[i, 12], geometry[i, 13], geometry[i, 14], geometry[i, 15]))
            )
            for k in range(3):
                bodies.center[i, k] += motion[i, 6 + k]
    place_origins(bodies, count)


def in_blocks(state: State, rolls: bool) -> tuple[Blocks, dict[str, npt.NDArray[np.generic]]]:
    """Room for the blocks of a step, kept from step to step, the contacts coloured; and what ``solve`` needs besides to fill them."""
    bodies, manifolds, n, m = state.bodies, state.next_manifolds, state.count, state.next_count
    kind = bodies.kind[:n]
    tumbles = int(np.count_nonzero(bodies.frame[:n, 3] > 0))
    plain, tumbling = (
        np.zeros((-(-rows // LANES), LANES), np.int32)
        for rows in (int(np.count_nonzero(kind != STATIC)) - tumbles, tumbles)
    )
    moves = (kind == DYNAMIC).astype(np.uint8)
    live, colours, used = np.empty(m, np.int32), np.empty(m, np.int8), np.empty(n, np.uint64)
    sizes, cursor = np.empty((2, 2, COLOURS + 1), np.int64)
    starts = np.empty((2, COLOURS + 2), np.int64)
    colour(
        bodies, n, manifolds, m, state.colliders.body, moves, used, live, colours, sizes, starts, plain, tumbling
    )  # fmt: skip
    one, many = (int(number) for number in starts[:, COLOURS + 1])
    blocks = state.workspace
    if not isinstance(blocks, Blocks) or min(len(blocks.integers_one) - one, len(blocks.integers_many) - many) < 0:
        blocks = empty_blocks(one + one // 4 + 1, many + many // 4 + 1, state.real)
    if rolls and len(blocks.rolls_one) + len(blocks.rolls_many) == 2:
        blocks = blocks._replace(
            rolls_one=aligned_zeros((len(blocks.integers_one), ROLLING_FIELDS, LANES), state.real),
            rolls_many=aligned_zeros((len(blocks.integers_many), ROLLING_FIELDS, LANES), state.real),
        )
    state.workspace = blocks = blocks._replace(starts=starts, plain=plain, tumbling=tumbling)
    return blocks, {"moves": moves, "live": live, "colours": colours, "cursor": cursor}


def empty_blocks(one: int, many: int, real: npt.DTypeLike) -> Blocks:
    """Room for numbers of blocks of manifolds of one point and of more; none yet for rolling friction."""
    return Blocks(
        integers_one=aligned_zeros((one, INTEGERS, LANES), np.int32),
        integers_many=aligned_zeros((many, INTEGERS, LANES), np.int32),
        contacts_one=aligned_zeros((one, XpbdFields(1).number, LANES), real),
        contacts_many=aligned_zeros((many, XpbdFields(4).number, LANES), real),
        rolls_one=aligned_zeros((1, ROLLING_FIELDS, LANES), real),
        rolls_many=aligned_zeros((1, ROLLING_FIELDS, LANES), real),
        starts=np.zeros((2, COLOURS + 2), np.int64),
        plain=np.zeros((0, LANES), np.int32),
        tumbling=np.zeros((0, LANES), np.int32),
    )


def advance(state: State, settings: XPBD, h: float) -> None:
    """Advance all bodies by one step of length h [s]."""
    real, environment, n = state.real.type, state.environment, state.count
    sub = h / settings.substeps
    weight = float(np.linalg.norm(environment.gravity))
    constants = Constants(
        gravity=tuple(real(g) for g in environment.gravity),
        h=real(sub),
        substeps=settings.substeps,
        ratio=real(state.last_h / h),
        positions=(
            real(1 / sub),
            real(settings.compliance / sub**2) if settings.compliance else None,
            real(settings.push_out_speed * environment.length_unit),
        ),
        bounce=(
            real(max(environment.restitution_threshold, 2 * weight * sub)),
            real(sub),
            real(h),
            real(FINEST[state.real.char]),
        ),
    )
    locks = np.where(state.bodies.kind[:n] == DYNAMIC, state.bodies.locks[:n], 0)
    locked = np.flatnonzero(locks & ROTATION_LOCKS).astype(np.int32) if locks.any() else None
    rolls = bool((state.colliders.material[:n, 2:4] > 0).any())
    blocks, scratch = in_blocks(state, rolls)
    solve(
        state.bodies, n, state.colliders.body, scratch["moves"], state.next_manifolds, state.next_count,
        scratch["live"], scratch["colours"], scratch["cursor"], blocks, locked, constants,
    )  # fmt: skip
