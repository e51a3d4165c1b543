"""Working memory of the fused step: what does not outlive a step, or follows from the state."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from atlasphys.engine.simd import LANES
from atlasphys.engine.simd.by_address import by_address
from atlasphys.engine.state.arrays import aligned_zeros
from atlasphys.engine.state.joint_work import JointWork
from atlasphys.engine.state.joints import PART_TYPES

# Entries of ``Work.status``
PHASE = 0  # where in a step to go on
DONE = 1  # steps completed in this call
PARITY = 2  # which of the two tables of manifolds is the present one
ROWS = 3  # rows of the tables of manifolds up to the last that has ever been taken, see fused/rows.py
PAIRS = 4  # candidate pairs
PAIRS_CHANGED = 5  # the candidate pairs are not those of the last step
GENERIC = 6  # pairs that no body over lanes collides
BEGAN, ENDED = 7, 8  # contact events of the step
BLOCKS_ONE, BLOCKS_MANY = 9, 10  # blocks that the step's contacts take
FORCES = 11  # some body has a force to act in the next step
BOUNCES = 12  # some contact of this step has restitution
KEEPS = 13  # candidate pairs hold until a body leaves its fat box; else for one step
CHECKED = 14  # the candidate pairs are good for the coming step
FREE = 15  # rows of the tables of manifolds that have been given back
STEP = 16  # number of the coming step
SLEEPS = 17  # bodies may fall asleep
SLEEPERS_CHANGED = 18  # bodies were woken or put to sleep: lists of awake bodies are out of date
PLAIN, TUMBLING = 19, 20  # blocks of the two lists of awake bodies
KINEMATIC_BODIES = 21  # there are some
SLEPT, WOKEN = 22, 23  # bodies that fell asleep, or were woken by contact, in the last step
LIVE = 24  # manifolds with points between bodies of which one is active
LEFT = 25  # some body has left its fat box
WRONG = 26  # the last pass over bouncing contacts in which one was not solved for yet
BROKEN = 27  # some number of the step is not finite
COLOURED = 28  # colours of contacts up to the last that is in use
SLOTS = 29  # slots for contact points that the pairs for other routines need
EDGE_LIMIT = 30  # see dispatch.EDGE_LIMITS
HUBS, PARTS = 31, 32  # bodies that are split in the step, and their parts, see islands/split.py
LAID_OUT = 33  # there is all that the pairs for other routines need
SPLITS = 34  # bodies with many contacts are split
NOTED = 35  # notes taken of this step's sweeps
WEIGHT_FIRST = 36  # contacts that carry weight are coloured before the others
TAKEN = 37  # rows of the tables of manifolds that were taken in this step
PAIRS_BEFORE = 38  # candidate pairs of the last step, while PAIRS_CHANGED
ENTRIES = 39

# Entries of ``Work.calls``, after those of the routines for rarer pairs
ROUTINES = 3  # number of these
GENERIC_PART = 3  # see fused/generic.py
DETECTION, RESPONSE = 4, 5  # see fused/
BOUNCE = 6  # see fused/bounce.py
JOINT_VISITS = 7  # what visits all joints, see fused/joints.py
JOINT_TABLES = 8  # what prepares joints and stores their impulses, see joints/addresses.py
JOINTS = 9  # and following: what visits parts of each type
CALLS = JOINTS + PART_TYPES

# Entries of ``Work.times``: the places in ``step.STAGES``. Pairs go from the narrow phase to manifolds in blocks, and are counted with it.
BROADPHASE, NARROWPHASE, ISLANDS, SOLVER, FINISH = 0, 1, 3, 4, 6

# Values of PHASE
DETECT, DETECT_GENERIC, RESPOND = range(3)

# Lists of ``Lanes.waiting``
RECYCLE_MANY, RECYCLE_ONE, LOOK_NEARER = range(3)
TASKS = 3

CHUNK = 128
"""Pairs that a thread works on at a stretch; whole blocks."""

# Why a call returns
FINISHED, NEED_PAIRS, NEED_GENERIC, NEED_PARTS, NEED_BLOCKS, DIVERGED = range(6)


@by_address
class Lanes(NamedTuple):
    """Scratch of a thread: one block of eight pairs or bodies, and pairs that wait for one."""

    integers: npt.NDArray[np.int32]
    """(8, 8) see manifold/recycle.py."""
    pairs: npt.NDArray[np.int32]
    """(2, 8) bodies of the first and second shape."""
    delta: npt.NDArray[np.floating]
    """(3, 8) x_b − x_a."""
    place: npt.NDArray[np.floating]
    """(16, 8) see narrowphase/lanes."""
    contact: npt.NDArray[np.floating]
    """(24, 8) contact points, see narrowphase/lanes."""
    tags: npt.NDArray[np.int32]
    """(8, 8) features and number of points."""
    materials: npt.NDArray[np.floating]
    """(4, 8) combined materials."""
    features: npt.NDArray[np.int32]
    """(4, 8) features of last step's points."""
    gap: npt.NDArray[np.floating]
    """(2, 8) first row: how far apart tight boxes are, see broadphase/fat_boxes.py."""
    moved: npt.NDArray[np.floating]
    """(8, 8) see solvers/body_block.py."""
    queue: npt.NDArray[np.int32]
    """(at least kinds, 8) pairs of each kind that wait for a block to be full."""
    waiting: npt.NDArray[np.int32]
    """(TASKS, CHUNK + 8) pairs that wait to be recycled, those of several points and those of one, or looked at more nearly."""
    queued: npt.NDArray[np.int32]
    """(at least kinds + TASKS,) how many wait."""


@by_address
class Work(NamedTuple):
    """Working memory. P is the capacity for pairs."""

    status: npt.NDArray[np.int64]
    pairs: npt.NDArray[np.int32]
    """(P, 2) candidate pairs, ordered."""
    kinds: npt.NDArray[np.int8]
    """(P,) which routine collides the pair."""
    pair_bodies: npt.NDArray[np.int32]
    """(P / 8, 2, 8) the two bodies of each pair, in blocks."""
    copied: npt.NDArray[np.uint8]
    """(P,) whether both tables of manifolds hold the pair as it sleeps."""
    live: npt.NDArray[np.int32]
    """(P,) pairs that have contact points in this step."""
    active: npt.NDArray[np.uint8]
    """(n,) whether the body may disturb others: awake and dynamic, or kinematic and moving."""
    radius: npt.NDArray[np.floating]
    """(n,) bounding radius about the centre of mass [m]."""
    before: npt.NDArray[np.uint8]
    """(n,) whether the body was active at the start of the step."""
    parent: npt.NDArray[np.int32]
    """(n,) scratch of union–find, and for the number of a body's hub."""
    ready: npt.NDArray[np.uint8]
    """(n,) scratch."""
    island_before: npt.NDArray[np.int32]
    rest_before: npt.NDArray[np.floating]
    """(n,) ``Bodies.island`` and ``Bodies.rest`` of the bodies that were woken in this step, as they slept."""
    moves: npt.NDArray[np.uint8]
    """(n + parts,) whether impulses move the body or part."""
    plane_side: npt.NDArray[np.int8]
    """(P,) 1 if the pair's first body is a plane, 2 if its second is, else 0."""
    row: npt.NDArray[np.int32]
    """(P,) row of the pair in either table of manifolds, or 0."""
    travel: npt.NDArray[np.float64]
    """(n,) the farthest that any point of the body may have moved in all, see narrowphase/apart.py [m]."""
    extent: npt.NDArray[np.float64]
    """(n,) greatest distance of a point of the body's shape from its position [m]."""
    expiry: npt.NDArray[np.float64]
    """(P,) sum of the two bodies' travels up to which the pair is known to be apart [m]."""
    pairs_before: npt.NDArray[np.int32]
    row_before: npt.NDArray[np.int32]
    expiry_before: npt.NDArray[np.float64]
    """``pairs``, ``row`` and ``expiry`` of the last step, while PAIRS_CHANGED."""
    free: npt.NDArray[np.int32]
    """(rows,) rows of the tables of manifolds that have been given back; the last is taken first."""
    generic: npt.NDArray[np.int32]
    """(P,) pairs that no body over lanes collides; until all pairs have been looked at, marks at those pairs."""
    generic_pairs: npt.NDArray[np.int32]
    """(P, 2) their colliders."""
    generic_routine: npt.NDArray[np.int8]
    """(P,) numbers of their routines."""
    generic_rows: npt.NDArray[np.intp]
    """(P,) the entries of these lists, sorted by routine."""
    generic_starts: npt.NDArray[np.int64]
    """(routines + 1,) where those of each routine begin in ``generic_rows``."""
    routines: npt.NDArray[np.int8]
    """(kinds, kinds) routine for two kinds of shapes, see narrowphase/dispatch.py."""
    calls: npt.NDArray[np.int64]
    """(CALLS,) addresses of the three routines of narrowphase/addresses.py and of the parts of the step that are compiled apart; 0: not known."""
    phases: npt.NDArray[np.int64]
    """(phases, 3) what is visited of joints at a time, see joints/layout.py."""
    joints: JointWork
    """Working memory of joints."""
    linked: npt.NDArray[np.int32]
    """(n, 2) bodies that are joined and sleep together."""
    times: npt.NDArray[np.int64]
    """Time spent in each stage in this call [ns]."""
    began: npt.NDArray[np.int32]
    """(P, 2) pairs that began to touch in this step."""
    ended: npt.NDArray[np.int32]
    """(rows, 2) pairs that ceased to touch."""
    colours: npt.NDArray[np.int8]
    """(P,) colour of each manifold."""
    used: npt.NDArray[np.uint64]
    """(n + parts,) colours that a body or part has in use."""
    sizes: npt.NDArray[np.int64]
    starts: npt.NDArray[np.int64]
    cursor: npt.NDArray[np.int64]
    """(2, colours + 2) contacts, first block, next lane of each class and colour."""
    integers_one: npt.NDArray[np.int32]
    blocks_one: npt.NDArray[np.floating]
    """Blocks of manifolds of one point, see solvers/contact_block.py."""
    integers_many: npt.NDArray[np.int32]
    blocks_many: npt.NDArray[np.floating]
    """Blocks of manifolds of two to four points."""
    rolls_one: npt.NDArray[np.floating]
    rolls_many: npt.NDArray[np.floating]
    """Rolling friction beside these blocks, see solvers/rolling_block.py; one block if no body has any."""
    hubs: npt.NDArray[np.int32]
    heaviest: npt.NDArray[np.floating]
    """Bodies that are split in the step, see islands/split.py. Of these two and the four next arrays there is none but where there were hubs."""
    ends: npt.NDArray[np.int32]
    """(P / 8, 2, 8) like ``pair_bodies``, with the parts of hubs."""
    motion: npt.NDArray[np.floating]
    inverse_mass: npt.NDArray[np.floating]
    drives: npt.NDArray[np.floating]
    """(n + parts, …) stand for these columns of the bodies, followed by those of the parts, while there are hubs."""
    locked: npt.NDArray[np.int32]
    """Rows of the bodies whose rotation is locked about some axis."""
    plain: npt.NDArray[np.int32]
    """(blocks, 8) bodies that keep their angular velocity when free; the last one is repeated."""
    tumbling: npt.NDArray[np.int32]
    """(blocks, 8) bodies that do not."""
    room: npt.NDArray[np.floating]
    """(blocks, 8) see broadphase/fat_boxes.py."""
    lanes: Lanes
    """Each with an axis more, the first: a scratch for each thread."""
    notes: npt.NDArray[np.int32]
    """(N, 2) of each sweep that is noted what it was, see solvers/sweep_trace.py, and its substep. N is 0 unless a trace is asked for."""
    noted_motion: npt.NDArray[np.floating]
    """(N, n, 12) velocities after it, and motion since the step began."""
    noted_impulses: npt.NDArray[np.floating]
    """(N, 4 rows, 3) impulses of each contact point: along the normal and two tangents."""


def in_blocks(rows: npt.NDArray[Any]) -> npt.NDArray[np.int32]:
    """Row numbers in blocks of eight, the last number repeated."""
    blocks = -(-len(rows) // LANES)
    padded = np.resize(rows[-1:], blocks * LANES) if len(rows) else rows
    padded[: len(rows)] = rows
    return np.ascontiguousarray(padded.reshape(-1, LANES), np.int32)


def empty_lanes(threads: int, kinds: int, real: npt.DTypeLike) -> Lanes:
    """Scratch for so many threads and kinds of pairs that are collided in blocks. No thread shares a cache line with another."""

    def block(fields: int, dtype: npt.DTypeLike) -> npt.NDArray[Any]:
        return aligned_zeros((threads, fields, LANES), dtype)

    even = kinds + TASKS + 1 & ~1

    return Lanes(
        integers=block(8, np.int32),
        pairs=block(2, np.int32),
        delta=block(6, real),
        place=block(16, real),
        contact=block(24, real),
        tags=block(8, np.int32),
        materials=block(4, real),
        features=block(4, np.int32),
        gap=block(2, real),
        moved=block(8, real),
        queue=block(even, np.int32),
        waiting=aligned_zeros((threads, TASKS, CHUNK + LANES), np.int32),
        queued=aligned_zeros((threads, even * LANES), np.int32),
    )
