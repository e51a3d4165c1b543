"""Coordinates, Jacobians and effective masses of all parts, written to a table: for solvers that use them one part at a time."""

from __future__ import annotations

from typing import Any

from atlasphys.engine.jit import kernel, routine
from atlasphys.engine.joints.ends import reciprocal
from atlasphys.engine.joints.parts import PARTS
from atlasphys.engine.joints.rows import masses
from atlasphys.engine.joints.visit import Tied
from atlasphys.engine.simd import full, simd_kernel, store
from atlasphys.engine.simd.address import address_call
from atlasphys.engine.state.joint_work import ANY
from atlasphys.engine.state.joints import (
    AXIS,
    CONE,
    COUPLING,
    CROSS,
    DISTANCE,
    LINE,
    LOCK,
    POINT,
    PULLEY,
    ROTATION,
    TRANSLATION,
)

# Fields of the table of rows (blocks, ROW_FIELDS, 8)
PUSH_A, TURN_A, PUSH_B, TURN_B = 0, 3, 6, 9  # of the first row; the next two follow, ROW_STRIDE on
ROW_STRIDE = 12
COORDINATE = 36  # 36–38 C
EFFECTIVE = 39  # 39–41 effective mass along each row by itself, 1 / K_rr
ROW_FIELDS = 96
"""The solver may use the fields from 42 on."""


@simd_kernel
def write_rows(kind, block, motion, geometry, inverse_mass, work, rows):
    """Write C, J and the effective masses of a block at the bodies' present poses."""
    tied = Tied(kind, block, motion, geometry, inverse_mass, work)
    for k, c in enumerate(PARTS[kind].measure(tied.ends)):
        store(rows, block, COORDINATE + k, c)
    like = tied.ends.arm_a[0]
    for r, row in enumerate(tied.rows):
        for k, x in enumerate(entry for side in row for entry in side):
            store(rows, block, ROW_STRIDE * r + k, filled(like, x))
    for r, line in enumerate(masses(tied.rows, *tied.inverse)):
        store(rows, block, EFFECTIVE + r, reciprocal(line[0]))


def filled(like: Any, x: Any) -> Any:
    """An entry of a row in every lane, where it may be the Python integer 0 or 1."""
    return full(like, x) if type(x) is int else x


@routine
def evaluate(arguments, mode, first, stop):
    """Write the rows of a range of blocks. ``arguments``: motion, geometry, inverse masses, the working memory of joints, the type of each block,
    and the table."""
    motion, geometry, inverse_mass, work, kinds, rows = arguments
    for block in range(first, stop):
        if work.integers[block, ANY, 0]:
            kind = kinds[block]
            if kind == POINT:
                write_rows(POINT, block, motion, geometry, inverse_mass, work, rows)
            elif kind == LINE:
                write_rows(LINE, block, motion, geometry, inverse_mass, work, rows)
            elif kind == LOCK:
                write_rows(LOCK, block, motion, geometry, inverse_mass, work, rows)
            elif kind == AXIS:
                write_rows(AXIS, block, motion, geometry, inverse_mass, work, rows)
            elif kind == DISTANCE:
                write_rows(DISTANCE, block, motion, geometry, inverse_mass, work, rows)
            elif kind == TRANSLATION:
                write_rows(TRANSLATION, block, motion, geometry, inverse_mass, work, rows)
            elif kind == PULLEY:
                write_rows(PULLEY, block, motion, geometry, inverse_mass, work, rows)
            elif kind == COUPLING:
                write_rows(COUPLING, block, motion, geometry, inverse_mass, work, rows)
            elif kind == CROSS:
                write_rows(CROSS, block, motion, geometry, inverse_mass, work, rows)
            elif kind == CONE:
                write_rows(CONE, block, motion, geometry, inverse_mass, work, rows)
            elif kind == ROTATION:
                write_rows(ROTATION, block, motion, geometry, inverse_mass, work, rows)


@kernel
def evaluate_address(arguments):
    """Address of the code of ``evaluate``, which stays where it is as long as the process lives."""
    return address_call(evaluate, arguments)[0]
