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

Joints (engine/joints) are solved before the contacts, by the same steps: once for positions, Δλ = −K⁻¹ (J v + C / h), where the impulses of a
substep begin at 0, and once, after the bodies have moved, for velocities, Δλ = −K⁻¹ J v, which gives back the speed that this gave them. Springs
have the compliance and damping of joints/elastic.py. Motors and friction come last in each pass: what a single sweep leaves undone of the others
is an error of positions, which the next substep sees; theirs would be lost.

docs/xpbd.md derives it, and says where it differs from the paper. What it does to eight contacts side by side is in ``xpbd_contact.py``.
"""

from dataclasses import dataclass

from atlasphys.engine.islands.colour import COLOURS, beside
from atlasphys.engine.jit import routine
from atlasphys.engine.joints.layout import no_visit
from atlasphys.engine.shapes.arguments import invalid, number
from atlasphys.engine.simd import LANES
from atlasphys.engine.simd.address import address_call, call_address
from atlasphys.engine.solvers.body_block import drive, gain_speed, move, tumble
from atlasphys.engine.solvers.locked import follow_turn
from atlasphys.engine.solvers.rolling_block import ROLL, prepare_rolling, solve_rolling, store_rolling
from atlasphys.engine.solvers.soft_contact import prepare, store_impulses
from atlasphys.engine.solvers.sweep_trace import RELAX, SOLVE, note_pass
from atlasphys.engine.solvers.xpbd_contact import (
    aim,
    begin,
    finish,
    renew,
    solve_positions,
    solve_velocities,
    spot,
)
from atlasphys.engine.state import joint_work
from atlasphys.engine.state.blocks import BOUNCES, COUNT, MANIFOLD, ROLLS
from atlasphys.engine.state.joint_work import IMPULSES
from atlasphys.engine.state.joints import (
    FIRST_BLOCK_TYPE,
    FRICTION_FORCE,
    MOTOR_FORCE,
    PHASE,
    SPRING_MASS,
    SPRING_PULL,
)
from atlasphys.engine.state.manifolds import RESTITUTION, ROLLING, TORSIONAL
from atlasphys.engine.state.work import COLOURED, JOINT_VISITS, JOINTS, PLAIN, TUMBLING
from atlasphys.engine.team import DATA

MOST_SUBSTEPS = 1000

MOST_SWEEPS = 400
"""Most sweeps over the velocities while impacts are not solved. Usually it is one; elastic piles take a hundred."""

EASED, EASE = 200, 0.95
"""After so many sweeps impacts are weakened by this factor in each. Where bodies are jammed no speeds satisfy all impacts, and impulses would
grow without end; weakened enough, all can be satisfied, and impulses that are accumulated can be taken back."""


@dataclass(frozen=True, slots=True)
class XPBD:
    """Settings of the solver ``xpbd``.

    Attributes:
        substeps: substeps a step; all errors shrink with their length. More: stiffer stacks, in proportion slower.
        compliance: give of a contact point under a force along its normal [m/N]. 0: rigid, as far as the substeps allow.
        push_out_speed: greatest speed at which overlap is pushed out, and errors of joints are taken back [m/s], for a length unit of 1 m. The paper
            has no such limit. Larger: bodies that were put into each other are thrown apart. Smaller: heavy bodies squeeze light ones out.

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
def prepare_contacts(bodies, manifolds, work, locked, ratio):
    """Write the blocks. Returns whether some contact has restitution."""
    inverse_mass, bounces = bodies.inverse_mass, False
    none = ratio - ratio
    for block in range(work.starts[1, COLOURS + 1]):
        special = prepare(4, locked, block, work.integers_many, work.blocks_many, manifolds, inverse_mass, ratio)
        begin(4, block, work.blocks_many)
        if special:
            bounces = note_materials(4, block, work.integers_many, manifolds) or bounces
            if work.integers_many[block, ROLLS, 0]:
                prepare_rolling(
                    block, work.integers_many, work.blocks_many, work.rolls_many, manifolds, inverse_mass, none
                )  # fmt: skip
    for block in range(work.starts[0, COLOURS + 1]):
        special = prepare(1, locked, block, work.integers_one, work.blocks_one, manifolds, inverse_mass, ratio)
        begin(1, block, work.blocks_one)
        if special:
            bounces = note_materials(1, block, work.integers_one, manifolds) or bounces
            if work.integers_one[block, ROLLS, 0]:
                prepare_rolling(
                    block, work.integers_one, work.blocks_one, work.rolls_one, manifolds, inverse_mass, none
                )  # fmt: skip
    return bounces


@routine
def aim_contacts(spots, bodies, manifolds, work, locked, bounce):
    """Find the impacts of this substep (``spots``), or the speeds with which they are to end."""
    motion, inverse_mass, drives = bodies.motion, bodies.inverse_mass, bodies.drive
    for block in range(work.starts[1, COLOURS + 1]):
        integers, contacts = work.integers_many, work.blocks_many
        if integers[block, BOUNCES, 0]:
            if spots:
                spot(4, locked, block, integers, contacts, motion, inverse_mass, drives, manifolds, bounce)
            else:
                aim(4, locked, block, integers, contacts, motion, inverse_mass, drives, manifolds, bounce)
    for block in range(work.starts[0, COLOURS + 1]):
        integers, contacts = work.integers_one, work.blocks_one
        if integers[block, BOUNCES, 0]:
            if spots:
                spot(1, locked, block, integers, contacts, motion, inverse_mass, drives, manifolds, bounce)
            else:
                aim(1, locked, block, integers, contacts, motion, inverse_mass, drives, manifolds, bounce)


@routine
def sweep_positions(bodies, work, locked, numbers):
    """Solve positions: visit all contacts once, colour by colour."""
    motion, inverse_mass = bodies.motion, bodies.inverse_mass
    none = numbers[0] - numbers[0]
    for c in range(work.status[COLOURED]):
        first, stop = work.starts[1, c], work.starts[1, c + 1]
        block = first
        while block < stop:
            other = beside(block, c, stop)
            solve_positions(
                4, locked, block, other, work.integers_many, work.blocks_many, motion, inverse_mass, numbers
            )
            block = other + 1
        for block in range(first, stop):
            if work.integers_many[block, ROLLS, 0]:
                work.rolls_many[block, ROLL : ROLL + 2] = none
                solve_rolling(
                    4, block, work.integers_many, work.blocks_many, work.rolls_many, motion, inverse_mass, none
                )  # fmt: skip
        first, stop = work.starts[0, c], work.starts[0, c + 1]
        block = first
        while block < stop:
            other = beside(block, c, stop)
            solve_positions(1, locked, block, other, work.integers_one, work.blocks_one, motion, inverse_mass, numbers)
            block = other + 1
        for block in range(first, stop):
            if work.integers_one[block, ROLLS, 0]:
                work.rolls_one[block, ROLL : ROLL + 2] = none
                solve_rolling(
                    1, block, work.integers_one, work.blocks_one, work.rolls_one, motion, inverse_mass, none
                )  # fmt: skip


@routine
def sweep_velocities(bodies, work, locked, inverse_h, ease):
    """Solve velocities: visit all contacts once, colour by colour. Returns whether an impact was not solved for. ``ease`` is None if nothing
    bounces."""
    motion, inverse_mass, wrong = bodies.motion, bodies.inverse_mass, False
    none = inverse_h - inverse_h
    for c in range(work.status[COLOURED]):
        first, stop = work.starts[1, c], work.starts[1, c + 1]
        block = first
        while block < stop:
            other = beside(block, c, stop)
            if solve_velocities(
                4, locked, block, other, work.integers_many, work.blocks_many, motion, inverse_mass, inverse_h, ease
            ):  # fmt: skip
                wrong = True
            block = other + 1
        for block in range(first, stop):
            if work.integers_many[block, ROLLS, 0]:
                solve_rolling(
                    4, block, work.integers_many, work.blocks_many, work.rolls_many, motion, inverse_mass, none
                )  # fmt: skip
        first, stop = work.starts[0, c], work.starts[0, c + 1]
        block = first
        while block < stop:
            other = beside(block, c, stop)
            if solve_velocities(
                1, locked, block, other, work.integers_one, work.blocks_one, motion, inverse_mass, inverse_h, ease
            ):  # fmt: skip
                wrong = True
            block = other + 1
        for block in range(first, stop):
            if work.integers_one[block, ROLLS, 0]:
                solve_rolling(
                    1, block, work.integers_one, work.blocks_one, work.rolls_one, motion, inverse_mass, none
                )  # fmt: skip
    return wrong


@routine
def renew_contacts(bodies, work, locked):
    """Bring the matrices of all contacts up to date."""
    motion, inverse_mass = bodies.motion, bodies.inverse_mass
    for block in range(work.starts[1, COLOURS + 1]):
        renew(4, locked, block, work.integers_many, work.blocks_many, motion, inverse_mass)
    for block in range(work.starts[0, COLOURS + 1]):
        renew(1, locked, block, work.integers_one, work.blocks_one, motion, inverse_mass)


@routine
def store_contacts(bodies, manifolds, work, locked, inverse_h):
    """Write the impulses to the manifolds, and note which pairs touch."""
    motion, inverse_mass = bodies.motion, bodies.inverse_mass
    for block in range(work.starts[1, COLOURS + 1]):
        finish(4, locked, block, work.integers_many, work.blocks_many, motion, inverse_mass, inverse_h)
        store_impulses(4, block, work.integers_many, work.blocks_many, manifolds)
        if work.integers_many[block, ROLLS, 0]:
            store_rolling(block, work.integers_many, work.blocks_many, work.rolls_many, manifolds)
    for block in range(work.starts[0, COLOURS + 1]):
        finish(1, locked, block, work.integers_one, work.blocks_one, motion, inverse_mass, inverse_h)
        store_impulses(1, block, work.integers_one, work.blocks_one, manifolds)
        if work.integers_one[block, ROLLS, 0]:
            store_rolling(block, work.integers_one, work.blocks_one, work.rolls_one, manifolds)


@routine
def is_driven(kind, block, blocks):
    """Whether a block of parts has a motor or friction."""
    for lane in range(LANES):
        if kind >= FIRST_BLOCK_TYPE:  # friction is a spring that stops, but does not pull
            if blocks[block, SPRING_MASS, lane] > 0 and blocks[block, SPRING_PULL, lane] == 0:
                return True
        elif blocks[block, MOTOR_FORCE, lane] > 0 or blocks[block, FRICTION_FORCE, lane] > 0:
            return True
    return False


@routine
def forget_impulses(blocks):
    """Let the impulses of all joints begin at 0."""
    for block in range(len(blocks)):
        for k in range(PHASE):
            for lane in range(LANES):
                blocks[block, IMPULSES + k, lane] = 0


@routine
def solve_joints(mode, bodies, work):
    """One pass over all joints. Motors and friction come last, when they know their loads: what they left undone no positions would remember."""
    joints, phases = work.joints, work.phases
    data = address_call(no_visit, (bodies.motion, bodies.geometry, bodies.inverse_mass, bodies.center, joints))[1]
    for driven in (False, True):
        for p in range(len(phases)):
            kind = phases[p, joint_work.TYPE]
            for block in range(phases[p, joint_work.FIRST], phases[p, joint_work.STOP]):
                if is_driven(kind, block, joints.blocks) == driven:
                    call_address(work.calls[JOINTS + kind], data, mode, block, block + 1)


@routine
def respond(bodies, locked, constants, manifolds, work, sync, noted):
    """The solver stage: ``constants.substeps`` substeps. ``locked`` are the rows of the bodies whose rotation is locked about some axis, None if no
    body has any locks; ``noted`` is ``work`` if notes are to be taken of the sweeps, else None."""
    motion, geometry, inverse_mass, status = bodies.motion, bodies.geometry, bodies.inverse_mass, work.status
    h, inverse_h = constants.h, constants.positions[0]
    for rows, stop in ((work.plain, status[PLAIN]), (work.tumbling, status[TUMBLING])):
        for block in range(stop):
            drive(
                locked, block, rows, motion, bodies.force, bodies.response, inverse_mass, bodies.mass, bodies.drive,
                constants.gravity, h,
            )  # fmt: skip
    bounces = prepare_contacts(bodies, manifolds, work, locked, constants.ratio)
    if len(work.phases) > 0:
        call_address(work.calls[JOINT_VISITS], sync[DATA], joint_work.PREPARE, 0, 1)
    for substep in range(constants.substeps):
        for rows, stop in ((work.plain, status[PLAIN]), (work.tumbling, status[TUMBLING])):
            for block in range(stop):
                gain_speed(block, rows, motion, bodies.drive)
        if bounces:
            aim_contacts(True, bodies, manifolds, work, locked, constants.bounce)
        forget_impulses(work.joints.blocks)
        solve_joints(joint_work.SOLVE, bodies, work)
        sweep_positions(bodies, work, locked, constants.positions)
        if noted is not None:
            note_pass(SOLVE, substep, motion, noted)
        for block in range(status[PLAIN]):
            move(block, work.plain, motion, geometry, h)
        for block in range(status[TUMBLING]):
            tumble(block, work.tumbling, motion, geometry, bodies.mass, bodies.frame, inverse_mass, h)
        follow_turn(locked, bodies.locks, motion, geometry, inverse_mass, bodies.mass, bodies.frame, h)
        solve_joints(joint_work.RELAX, bodies, work)
        if bounces:
            aim_contacts(False, bodies, manifolds, work, locked, constants.bounce)
            ease = type(h)(1)
            for s in range(MOST_SWEEPS):
                if not sweep_velocities(bodies, work, locked, inverse_h, ease):
                    break
                if s >= EASED:
                    ease *= type(h)(EASE)
                if s == 0:
                    renew_contacts(bodies, work, locked)
        else:
            sweep_velocities(bodies, work, locked, inverse_h, None)
        if noted is not None:
            note_pass(RELAX, substep, motion, noted)
    store_contacts(bodies, manifolds, work, locked, inverse_h)
