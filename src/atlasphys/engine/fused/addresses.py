"""Addresses of the parts of the fused step that are compiled apart, and what they are called with."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from atlasphys.engine import ahead
from atlasphys.engine.fused.bounce import bounce_address, bounce_address_with_locks
from atlasphys.engine.fused.constants import Constants
from atlasphys.engine.fused.detection import detection_address
from atlasphys.engine.fused.generic import generic_address
from atlasphys.engine.fused.joints import joints_address
from atlasphys.engine.fused.positions import (
    positions_address,
    positions_address_with_locks,
    positions_address_with_notes,
)
from atlasphys.engine.fused.response import response_address, response_address_with_locks, response_address_with_notes
from atlasphys.engine.fused.steps import run_steps
from atlasphys.engine.fused.workspace import locks_of
from atlasphys.engine.jit import call
from atlasphys.engine.joints.layout import find_code, set_numbers
from atlasphys.engine.narrowphase.addresses import ADDRESSES
from atlasphys.engine.narrowphase.dispatch import with_room
from atlasphys.engine.solvers.soft_step import SoftStep, joint_softness
from atlasphys.engine.solvers.xpbd import XPBD
from atlasphys.engine.state.arrays import aligned_zeros
from atlasphys.engine.state.joints import PART_TYPES
from atlasphys.engine.state.manifolds import RESTITUTION
from atlasphys.engine.state.state import State
from atlasphys.engine.state.work import (
    BOUNCE,
    DETECTION,
    GENERIC,
    GENERIC_PART,
    JOINT_TABLES,
    JOINT_VISITS,
    JOINTS,
    RESPONSE,
    SLOTS,
)
from atlasphys.engine.team import SYNC_LENGTH

RESPONSES = {
    "soft_step": (response_address, response_address_with_locks, response_address_with_notes),
    "xpbd": (positions_address, positions_address_with_locks, positions_address_with_notes),
}
"""The solver stage of each solver of the fused step: for bodies without locks, with locks, and with notes of the sweeps."""


NO_SYNC: npt.NDArray[np.int64] = aligned_zeros((SYNC_LENGTH,), np.int64)
"""Stands for the ``sync`` of a team of threads."""


PRECISIONS = {"f": "single", "d": "double"}


def tables(state: State) -> tuple[Any, Any, Any, Any, Any, Any]:
    """The tables of the state with which the arguments of the step's kernels begin."""
    return (
        state.bodies, state.colliders, state.table.arrays, state.manifolds, state.next_manifolds, state.remembered,
    )  # fmt: skip


def part_arguments(state: State, values: Constants) -> tuple[Any, ...]:
    """Arguments of the kernels that give the addresses of the parts of the step that are compiled apart."""
    space = state.workspace
    return (*tables(state), space.tree.fat, values, space.work, NO_SYNC, state.contacts, space.kept)


def job_of(address: Callable[..., Any]) -> str:
    """Name of the job that compiles a part of the step (``atlasphys.warmup``)."""
    return address.__name__.replace("_address", "").replace("_", "-")


def compile_ahead(state: State, response: Callable[..., Any] = response_address) -> None:
    """The first time of all, have another process begin to compile parts of the step."""
    kernels = (response, detection_address)
    ahead.start({job_of(kernel): kernel for kernel in kernels}, PRECISIONS[state.real.char])


def has_restitution(state: State) -> bool:
    """Whether a contact of the next steps may bounce."""
    colliders, manifolds = state.colliders.material[: state.count], state.manifolds.contact[: state.manifold_count]
    return bool((colliders[:, 1] > 0).any() or (manifolds[:, RESTITUTION] > 0).any())


def find_parts(state: State, values: Constants) -> None:
    """Addresses of the parts of the step that are compiled apart. The first time of all another process compiles one of them in the meantime."""
    space, before = state.workspace, tables(state)
    work, fat = space.work, space.tree.fat
    locked, real = locks_of(state).any(), state.real.char
    plain, with_locks, with_notes = RESPONSES[space.solver]
    response = with_notes if state.trace is not None else with_locks if locked else plain
    compile_ahead(state, response)
    call(run_steps, real, *before, state.contacts, space.kept, state.count, fat, values, work, 0, NO_SYNC)
    ahead.wait()
    work.calls[DETECTION] = call(detection_address, real, *part_arguments(state, values))
    work.calls[RESPONSE] = call(response, real, *part_arguments(state, values))
    if space.solver == "soft_step" and has_restitution(state):
        bounce = bounce_address_with_locks if locked else bounce_address
        work.calls[BOUNCE] = call(bounce, real, *part_arguments(state, values))
    space.takes_notes = state.trace is not None


def make_generic_ready(state: State, values: Constants) -> None:
    """Room for the contacts of the pairs that no body over lanes collides, and the addresses of the routines that do, compiled if need be."""
    work = state.workspace.work
    state.contacts = with_room(state.contacts, int(work.status[GENERIC]), int(work.status[SLOTS]))
    if work.calls[GENERIC_PART] == 0:
        work.calls[GENERIC_PART] = call(generic_address, state.real.char, *part_arguments(state, values))
    for k, address_of in enumerate(ADDRESSES):
        if work.calls[k] == 0 and work.status[SLOTS] > 0 and work.generic_starts[k] < work.generic_starts[k + 1]:
            work.calls[k] = address_of(
                work.generic_rows, state.bodies, state.colliders, state.table.arrays, values.margin, state.contacts
            )


def ready_joints(state: State, settings: SoftStep | XPBD, values: Constants) -> None:
    """Numbers and code for the joints of a run."""
    space = state.workspace
    if len(space.joints.phases) == 0:
        return
    h, unit = float(values.h), state.environment.length_unit
    if isinstance(settings, XPBD):
        soft, fastest = (1 / h, 1.0), settings.push_out_speed  # all of an error, in each substep
    else:
        soft, fastest = joint_softness(settings, h), settings.joint_push_out_speed
    set_numbers(state, space.joints, h, float(values.ratio), soft, fastest * unit)
    find_code(state, space.joints)
    space.work.calls[JOINTS : JOINTS + PART_TYPES] = space.joints.calls[:PART_TYPES]
    space.work.calls[JOINT_TABLES] = space.joints.calls[PART_TYPES]
    if space.work.calls[JOINT_VISITS] == 0:
        space.work.calls[JOINT_VISITS] = call(joints_address, state.real.char, *part_arguments(state, values))
