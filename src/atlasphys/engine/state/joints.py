"""Joints, and the parts that they are made of.

A joint ties two bodies, or a body and the world. It is made of a few *parts* (engine/joints): a hinge of a point that the two share and an axis. A
part has up to three rows of constraint of its own, which is all that solvers know of joints. Both tables are in the order in which joints were
made; the parts of a joint are neighbours.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from atlasphys.engine.simd.by_address import by_address
from atlasphys.engine.state.arrays import aligned_zeros, copy_rows, with_capacity

WORLD = -1
"""Stands for the row of a body where a joint is tied to the world."""

# Types of parts, in the order in which a solver visits those of one joint: what holds the bodies together has the last word.
ROTATION, CONE, CROSS, COUPLING, PULLEY, TRANSLATION, DISTANCE, AXIS, LOCK, LINE, POINT = range(11)

PART_TYPES = 11

FIRST_BLOCK_TYPE = AXIS
"""Types from here on are *blocks*: two or three rows that hold a vector at zero. Those before are *axial*: a row for a single coordinate, on which
springs, motors, friction and limits act."""

# Columns of ``Parts.settings``
ARM_A, ARM_B = 0, 3  # the part's anchors, from the centres of mass of a and b, in the axes of these bodies [m]
FRAME_A, FRAME_B = 6, 10  # the part's axes in those of a and b, unit quaternions; x is the axis of what has one
LOWER, UPPER = 14, 15  # range of the coordinate [m, rad]; equal: it is held there
REST = 16  # coordinate at which the spring does not act
SPRING_MASS, SPRING_PULL, SPRING_BEFORE = (
    17,
    18,
    19,
)  # q, β and p of the spring, see joints/elastic.py; q is −1 where there is none
SPRING_FORCE = 20  # greatest force of the spring [N, N m]
SPEED, MOTOR_FORCE = 21, 22  # what the motor drives the coordinate's rate to, and its greatest force
FRICTION_FORCE = 23  # greatest force of friction
RATIO_A, RATIO_B = 24, 25  # how the motions of a and of b count in a coupling or pulley
TURNS_A, TURNS_B = (
    26,
    27,
)  # whether a coupling counts a's, b's rotation about the axis (1), or its translation along it (0)
SETTING_COLUMNS = 32

# Columns of ``Parts.impulse``
SPRING, MOTOR, FRICTION, AT_LOWER, AT_UPPER = range(5)  # of an axial part; blocks use the first three for their rows
PHASE = 5  # of a coupling: how far it has slipped, its coordinate
RATE = 6  # of the coordinate, as the substep ended
IMPULSE_COLUMNS = 8

# Columns of ``Parts.total``
FORCE, TORQUE = 0, 3  # 0–2 on b [N s]; 3–5 on b about the anchor [N m s]
MOTOR_TOTAL = 6
TOTAL_COLUMNS = 8

# Columns of ``Parts.elastic``
FREQUENCY, DAMPING = 0, 1

UNBOUNDED = 1e18
"""Stands for infinity among settings: a limit or force that is never reached, and can be multiplied by zero. Its square is a number in single
precision."""


class Joints(NamedTuple):
    """The table of joints, a row each."""

    id: npt.NDArray[np.int64]
    """(j,) identity of the joint for handles, never used twice."""
    body: npt.NDArray[np.int32]
    """(j, 2) rows of a and b, or WORLD."""
    first: npt.NDArray[np.int32]
    """(j,) row of its first part."""
    parts: npt.NDArray[np.int32]
    """(j,) number of its parts."""
    enabled: npt.NDArray[np.bool_]
    """(j,) whether it acts."""
    broken: npt.NDArray[np.bool_]
    """(j,) whether it has broken, and acts no more."""
    collide: npt.NDArray[np.bool_]
    """(j,) whether the two bodies collide with each other."""
    strength: npt.NDArray[np.float64]
    """(j, 2) force [N] and torque [N m] at which it breaks."""


@by_address
class Parts(NamedTuple):
    """The table of parts, a row each."""

    joint: npt.NDArray[np.int32]
    """(p,) row of the joint."""
    type: npt.NDArray[np.int32]
    """(p,) POINT, AXIS, …"""
    base: npt.NDArray[np.float64]
    """(p, 8) 0–2 and 4–6: where the anchor of a and of b is, if that side is the world; of a pulley, where the two ropes hang [m]."""
    settings: npt.NDArray[np.floating]
    """(p, 32)"""
    elastic: npt.NDArray[np.float64]
    """(p, 2) frequency [Hz] and damping ratio of the spring, −1 where there is none."""
    impulse: npt.NDArray[np.floating]
    """(p, 8) impulses of the last substep [N s, N m s], kept for warm starting."""
    total: npt.NDArray[np.floating]
    """(p, 8) impulses over the whole last step."""


class JointTable:
    """Joints and parts, in tables that grow.

    Attributes:
        rows: the joints; the first ``count`` rows are in use.
        parts: their parts; the first ``part_count`` rows are in use.
        broke: rows of the joints that broke in the last step.
        elapsed: length of the last step [s]: what ``Parts.total`` is the sum over.
        layout: which part is in which lane for the solver, or None where that is out of date (joints/layout.py).
    """

    def __init__(self, real: npt.DTypeLike) -> None:
        self.real: np.dtype[Any] = np.dtype(real)
        self.rows, self.parts = _empty_joints(4), _empty_parts(8, self.real)
        self.count = self.part_count = 0
        self.broke: npt.NDArray[np.int32] = np.empty(0, np.int32)
        self.elapsed = 0.0
        self.layout: Any = None

    def append(self, parts: int) -> int:
        """Room for one more joint of a number of parts; all zero but what says which parts are whose."""
        row = self.count
        if row == len(self.rows.id):
            self.rows = with_capacity(self.rows, 2 * row)
        while self.part_count + parts > len(self.parts.joint):
            self.parts = with_capacity(self.parts, 2 * len(self.parts.joint))
        first = self.part_count
        for array in self.rows:
            array[row] = 0
        for column in self.parts:
            column[first : first + parts] = 0
        self.rows.first[row], self.rows.parts[row] = first, parts
        self.parts.joint[first : first + parts] = row
        self.count, self.part_count, self.layout = row + 1, first + parts, None
        return row

    def resize(self, row: int, parts: int) -> None:
        """Give a joint another number of parts, all zero."""
        first, before = int(self.rows.first[row]), int(self.rows.parts[row])
        behind, end = first + before, self.part_count
        while end + parts - before > len(self.parts.joint):
            self.parts = with_capacity(self.parts, 2 * len(self.parts.joint))
        for array in self.parts:
            array[first + parts : end + parts - before] = array[behind:end].copy()
            array[first : first + parts] = 0
        self.parts.joint[first : first + parts] = row
        self.rows.first[row + 1 : self.count] += parts - before
        self.rows.parts[row] = parts
        self.part_count, self.layout = end + parts - before, None

    def keep(self, kept: npt.NDArray[np.bool_]) -> None:
        """Remove the joints, (count,), that are not to be kept, and close the gaps."""
        rows = np.flatnonzero(kept)
        number = np.cumsum(kept) - 1
        parts = np.flatnonzero(kept[self.parts.joint[: self.part_count]])
        for column in self.rows:
            column[: len(rows)] = column[rows]
        for part_column in self.parts:
            part_column[: len(parts)] = part_column[parts]
        self.count, self.part_count, self.layout = len(rows), len(parts), None
        self.parts.joint[: len(parts)] = number[self.parts.joint[: len(parts)]]
        sizes = self.rows.parts[: len(rows)]
        self.rows.first[: len(rows)] = np.cumsum(sizes) - sizes
        self.broke = number[self.broke[kept[self.broke]]].astype(np.int32)

    def remove_body(self, row: int) -> npt.NDArray[np.bool_]:
        """Remove the joints of a body that is removed; bodies after it move up by a row. Returns which joints are kept, (count before,)."""
        kept: npt.NDArray[np.bool_] = (self.rows.body[: self.count] != row).all(axis=1)
        if not kept.all():
            self.keep(kept)
        self.rows.body[: self.count] -= self.rows.body[: self.count] > row
        self.layout = None
        return kept

    @property
    def active(self) -> npt.NDArray[np.bool_]:
        """(count,) which joints act."""
        acting: npt.NDArray[np.bool_] = (self.rows.enabled & ~self.rows.broken)[: self.count]
        return acting

    @property
    def apart(self) -> npt.NDArray[np.int32]:
        """(n, 2) pairs of bodies, lower row first, that do not collide because a joint that acts ties them."""
        pairs = np.sort(self.rows.body[: self.count][self.active & ~self.rows.collide[: self.count]], axis=1)
        return pairs[pairs[:, 0] != WORLD]

    @property
    def linked(self) -> npt.NDArray[np.int32]:
        """(n, 2) pairs of bodies that a joint ties and that so sleep and wake together."""
        pairs = self.rows.body[: self.count][self.active]
        return pairs[(pairs != WORLD).all(axis=1)]

    @property
    def breakable(self) -> bool:
        """Whether some joint that acts may break."""
        return self.count > 0 and bool(np.isfinite(self.rows.strength[: self.count][self.active]).any())

    def forget(self) -> None:
        """Forget the impulses for warm starting."""
        self.parts.impulse[:, :PHASE] = 0

    def copy(self) -> JointTable:
        """An independent copy, exact to the bit."""
        other = object.__new__(JointTable)
        other.__dict__.update(self.__dict__)
        other.rows, other.parts = copy_rows(self.rows), copy_rows(self.parts)
        other.broke, other.layout = self.broke.copy(), None
        return other

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"layout": None}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self.rows, self.parts = copy_rows(self.rows), copy_rows(self.parts)  # unpickled arrays are not aligned

    def bytes(self) -> bytes:
        """All that decides how the joints go on."""
        parts = self.parts
        settings = parts.settings.copy()
        settings[:, SPRING_MASS : SPRING_BEFORE + 1] = 0  # follows from ``elastic`` and the step
        used: list[npt.NDArray[Any]] = [array[: self.count] for array in self.rows[1:]]
        columns = (parts.joint, parts.type, parts.base, settings, parts.elastic, parts.impulse)
        used += [array[: self.part_count] for array in columns]
        return b"".join(np.ascontiguousarray(array).tobytes() for array in used)


def _empty_joints(count: int) -> Joints:
    return Joints(
        id=np.zeros(count, np.int64),
        body=np.zeros((count, 2), np.int32),
        first=np.zeros(count, np.int32),
        parts=np.zeros(count, np.int32),
        enabled=np.zeros(count, np.bool_),
        broken=np.zeros(count, np.bool_),
        collide=np.zeros(count, np.bool_),
        strength=np.zeros((count, 2), np.float64),
    )


def _empty_parts(count: int, real: npt.DTypeLike) -> Parts:
    return Parts(
        joint=np.zeros(count, np.int32),
        type=np.zeros(count, np.int32),
        base=aligned_zeros((count, 8), np.float64),
        settings=aligned_zeros((count, SETTING_COLUMNS), real),
        elastic=np.zeros((count, 2), np.float64),
        impulse=aligned_zeros((count, IMPULSE_COLUMNS), real),
        total=aligned_zeros((count, TOTAL_COLUMNS), real),
    )
