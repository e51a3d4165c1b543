"""Working memory of joints: which part is in which lane, and what the solver knows of it within a step."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from atlasphys.engine.simd.by_address import by_address

# Rows of a block's integers
ROW_A, ROW_B, TIED_A, TIED_B, PART, HELD, MOVES_A, MOVES_B, LIVE, ANY = range(10)
"""Bodies' rows (of the world: some row), whether that side is a body, row of the part (0 in an idle lane), whether its joint has the rigid
part against which it is solved (HOLDERS in joints/visit.py). As of the present step: whether impulses
move the two, whether one of them is awake; and, in lane 0, whether some lane of the block is so."""
JOINT_INTEGERS = 10

# Fields of a block, after the columns of ``Parts.settings``
SETTINGS = 0
APART = 28  # 28–30 centre of b − centre of a as the step began (of the world: its anchor); of a pulley, 28–33 centres from where the ropes hang [m]
IMPULSES = 34  # 34–38 of the present substep
SLIPPED = 39  # the phase of a coupling
BEFORE = 40  # rate of an axial part's coordinate at the end of the last substep
TOTALS = 41  # 41–47 sums over the substeps
JOINT_FIELDS = 48

# Entries of ``JointWork.numbers``
H, INVERSE_H, RATIO, MASS, PULL, KEEP, FASTEST = range(7)
"""Length of a substep [s] and its inverse; factor on last step's impulses; softness of rigid parts as that of springs (elastic.py); greatest speed at
which their errors are corrected."""
NUMBERS = 8

# Columns of ``JointWork.phases``
TYPE, FIRST, STOP = range(3)

# What a visit does
PREPARE, START, SOLVE, RELAX, KEEP_RESULTS = range(5)


@by_address
class JointWork(NamedTuple):
    """Working memory. Blocks hold eight parts of a type and colour."""

    integers: npt.NDArray[np.int32]
    """(blocks, 10, 8)"""
    blocks: npt.NDArray[np.floating]
    """(blocks, 48, 8)"""
    numbers: npt.NDArray[np.floating]
    """(8, 8) each the same in all lanes."""
    hung: npt.NDArray[np.uint8]
    """(parts,) whether a part is a pulley."""
    base: npt.NDArray[np.float64]
    settings: npt.NDArray[np.floating]
    impulse: npt.NDArray[np.floating]
    total: npt.NDArray[np.floating]
    """Columns of ``Parts``."""
    active: npt.NDArray[np.uint8]
    """(bodies,) whether a body is awake, or moves by itself."""
    moves: npt.NDArray[np.uint8]
    """(bodies,) whether impulses move it."""
