"""Where the parts of joints lie for the solver: colours, and blocks of eight parts of a type.

Joints of one colour share no body that impulses move, so that eight of them at a time, and all of them on several threads, can be solved. Each joint
takes the lowest colour that neither of its bodies has used yet, in the order in which they were made. A *phase* is what is visited at a time: the
blocks of a type and colour (of a joint with two parts of a type, two phases). The parts of a joint have its colour and are visited in the order of
their types.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from atlasphys.engine.jit import routine
from atlasphys.engine.joints.addresses import ADDRESSES, tables_address
from atlasphys.engine.joints.elastic import coefficients
from atlasphys.engine.joints.held import HOLDERS
from atlasphys.engine.simd import LANES
from atlasphys.engine.simd.address import call_address
from atlasphys.engine.state.arrays import aligned_zeros
from atlasphys.engine.state.bodies import DYNAMIC
from atlasphys.engine.state.joint_work import (
    FASTEST,
    FIRST,
    HELD,
    INVERSE_H,
    JOINT_FIELDS,
    JOINT_INTEGERS,
    KEEP,
    MASS,
    NUMBERS,
    PART,
    PULL,
    RATIO,
    ROW_A,
    ROW_B,
    STOP,
    TIED_A,
    TIED_B,
    TYPE,
    H,
    JointWork,
)
from atlasphys.engine.state.joints import (
    DAMPING,
    FIRST_BLOCK_TYPE,
    FREQUENCY,
    FRICTION_FORCE,
    PART_TYPES,
    PULLEY,
    SPRING_BEFORE,
    SPRING_MASS,
    SPRING_PULL,
    WORLD,
    JointTable,
)
from atlasphys.engine.state.state import State


class Layout(NamedTuple):
    """What follows from which joints act."""

    work: JointWork
    phases: npt.NDArray[np.int64]
    """(phases, 3) type, first block and the one past the last, in the order of visits."""
    linked: npt.NDArray[np.int32]
    """(n, 2) bodies that sleep and wake together."""
    calls: npt.NDArray[np.int64]
    """(types + 1,) addresses of the code that visits parts of each type, and of that which prepares and stores them (addresses.py); 0: not known."""


def colours(body: npt.NDArray[np.int32], moves: npt.NDArray[np.bool_]) -> npt.NDArray[np.int32]:
    """Colour of each joint of a list, (n,). ``body`` (n, 2) are its bodies, ``moves`` says which bodies impulses move."""
    used: dict[int, int] = {}
    result = np.zeros(len(body), np.int32)
    for i, ends in enumerate(body.tolist()):
        ends = [end for end in ends if end != WORLD and moves[end]]
        taken = 0
        for end in ends:
            taken |= used.get(end, 0)
        bit = ~taken & (taken + 1)  # the lowest bit that is not set
        result[i] = bit.bit_length() - 1
        for end in ends:
            used[end] = used.get(end, 0) | bit
    return result


def lay_out(state: State, active: npt.NDArray[np.uint8]) -> Layout:
    """Blocks for the joints that act. ``active`` (bodies,) will say in each step which bodies are awake."""
    table = state.joints
    moves = state.bodies.kind[: max(state.count, 1)] == DYNAMIC
    acting = np.flatnonzero(table.active)
    colour = np.zeros(table.count, np.int32)
    colour[acting] = colours(table.rows.body[acting], moves)
    parts = np.flatnonzero(table.active[table.parts.joint[: table.part_count]])
    parts = parts[np.lexsort((table.parts.type[parts], table.parts.joint[parts]))]
    joint, kind = table.parts.joint[parts], table.parts.type[parts]
    again = np.zeros(len(parts), np.int64)  # parts of one type of one joint are visited one after the other
    while (repeated := (joint[1:] == joint[:-1]) & (kind[1:] == kind[:-1]) & (again[1:] <= again[:-1])).any():
        again[1:][repeated] = again[:-1][repeated] + 1
    key = (colour[joint] * np.int64(PART_TYPES) + kind) * 8 + again
    order = np.argsort(key, kind="stable")
    parts, joint, kind, key = parts[order], joint[order], kind[order], key[order]
    firsts = np.flatnonzero(np.diff(key, prepend=-1)) if len(key) else np.zeros(0, np.int64)
    sizes = np.diff(firsts, append=len(key))
    stops = np.cumsum(-(-sizes // LANES))
    starts = stops - -(-sizes // LANES)
    phases = np.stack([kind[firsts], starts, stops], axis=1).astype(np.int64)
    blocks = int(stops[-1]) if len(stops) else 0
    within = np.arange(len(key)) - np.repeat(firsts, sizes)
    block, lane = np.repeat(starts, sizes) + within // LANES, within % LANES
    integers = aligned_zeros((blocks, JOINT_INTEGERS, LANES), np.int32)
    body = table.rows.body[joint]
    some = body.max(axis=1, initial=0)  # in the place of the world: the other body
    integers[block, ROW_A, lane] = np.where(body[:, 0] == WORLD, some, body[:, 0])
    integers[block, ROW_B, lane] = np.where(body[:, 1] == WORLD, some, body[:, 1])
    integers[block, TIED_A, lane], integers[block, TIED_B, lane] = (body != WORLD).T
    integers[block, PART, lane] = parts
    integers[block, HELD, lane] = held(table)[parts]
    p = table.parts
    return Layout(
        work=JointWork(
            integers=integers,
            blocks=aligned_zeros((blocks, JOINT_FIELDS, LANES), state.real),
            numbers=aligned_zeros((NUMBERS, LANES), state.real),
            hung=(p.type == PULLEY).astype(np.uint8),
            base=p.base,
            settings=p.settings,
            impulse=p.impulse,
            total=p.total,
            active=active,
            moves=moves.astype(np.uint8),
        ),
        phases=phases,
        linked=table.linked,
        calls=np.zeros(PART_TYPES + 1, np.int64),
    )


def held(table: JointTable) -> npt.NDArray[np.bool_]:
    """(parts,) which axial parts are solved against a rigid block of their joint (joints/held.py)."""
    n = table.part_count
    kind, joint = table.parts.type[:n], table.parts.joint[:n]
    rigid = (table.parts.elastic[:n, FREQUENCY] <= 0) & ~(table.parts.settings[:n, FRICTION_FORCE] > 0)
    result = np.zeros(n, np.bool_)
    for part, holder in HOLDERS.items():
        has = np.zeros(table.count, np.bool_)
        has[joint[rigid & (kind == holder)]] = True
        result |= (kind == part) & has[joint]
    return result


def set_numbers(
    state: State, layout: Layout, h: float, ratio: float, soft: tuple[float, float], fastest: float
) -> None:
    """Set what depends on the length h of a substep [s]. ``soft`` are rate [1/s] and mass scale of rigid parts, ``fastest`` the greatest speed at
    which their errors are corrected; ``ratio`` scales last step's impulses."""
    rate, mass = soft
    numbers = layout.work.numbers
    for entry, value in (
        (H, h),
        (INVERSE_H, 1 / h),
        (RATIO, ratio),
        (MASS, mass),
        (PULL, mass * rate),
        (KEEP, 1 - mass),
        (FASTEST, fastest),
    ):
        numbers[entry] = value
    set_springs(state.joints, h)


def set_springs(table: JointTable, h: float) -> None:
    """Bring the springs' coefficients up to date for substeps of h seconds."""
    n = table.part_count
    parts = table.parts
    settings, kind = parts.settings[:n], parts.type[:n]
    springs = np.flatnonzero(parts.elastic[:n, FREQUENCY] > 0)
    soft = coefficients(parts.elastic[springs, FREQUENCY], parts.elastic[springs, DAMPING], h)
    block = kind[springs] >= FIRST_BLOCK_TYPE
    settings[:, SPRING_MASS] = -1
    settings[springs, SPRING_MASS] = np.where(block, 1 - soft.alpha, soft.q)
    settings[springs, SPRING_PULL] = soft.beta
    settings[springs, SPRING_BEFORE] = np.where(block, 0, soft.p)
    # Friction of a block is a spring that stops but does not pull.
    rubs = (kind >= FIRST_BLOCK_TYPE) & (settings[:, FRICTION_FORCE] > 0)
    settings[rubs, SPRING_MASS] = 1


def find_code(state: State, layout: Layout) -> None:
    """Look up the addresses of the code that the layout's parts need, compiled if need be."""
    bodies = state.bodies
    given = (bodies.motion, bodies.geometry, bodies.inverse_mass, bodies.center, layout.work)
    for kind in {PART_TYPES, *layout.phases[:, 0].tolist()}:
        if layout.calls[kind] == 0:
            layout.calls[kind] = (*ADDRESSES, tables_address)[kind](given)


@routine
def no_visit(arguments, mode, first, stop):
    """Stands for code where the address of the arguments is asked for."""


@routine
def visit_all(mode, calls, data, phases):
    """One pass over all joints, by one thread."""
    for p in range(len(phases)):
        call_address(calls[phases[p, TYPE]], data, mode, phases[p, FIRST], phases[p, STOP])
