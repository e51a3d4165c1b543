"""Manifolds: the contact points of each touching or nearly touching pair, kept from step to step.

The classic step orders rows by (a, b), the pair's collider rows, so that two steps' manifolds are matched in one walk. In the fused step a pair keeps
its row, the same in two tables, for as long as it has points; then another pair may get it, so the order means nothing (fused/rows.py). What is
read out goes in the order of the pairs (``live_rows``).

Columns that are read together lie together, in rows of whole cache lines, so that eight manifolds load into vector registers at once.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from atlasphys.engine.simd.by_address import by_address
from atlasphys.engine.state.arrays import aligned_zeros, with_capacity

# Columns of ``contact``.
NORMAL = 0  # 0–2 unit normal in world axes, from a to b
FRICTION, RESTITUTION, ROLLING, TORSIONAL = 3, 4, 5, 6  # combined material: two coefficients, two lengths [m]
PATCH_FRICTION = 7  # 7–9 friction impulse on b that acts on the points together, world axes [N s]
PATCH_TORSION = 10  # angular impulse on b about the normal [N m s]
PATCH_ROLLING = 11  # 11–13 angular impulse of rolling friction on b, world axes [N m s]
IS_FRESH = 14  # 1: collided in this step; 0: recycled from an earlier one (manifold/recycle.py)
CONTACT_COLUMNS = 16

# Columns of a point in ``points``; point k begins at POINT_COLUMNS · k.
ANCHOR_A, ANCHOR_B = 0, 3  # contact point, midway between the surfaces, − centre of mass of a and of b, world axes [m]
DEPTH = 6  # overlap along the normal [m]; negative where the surfaces are still apart
NORMAL_IMPULSE = 7  # impulse along the normal in the last step [N s]
POINT_COLUMNS = 8

# Columns of a point in ``local``; point k begins at POINT_COLUMNS · k.
LOCAL_A, LOCAL_B = 0, 3  # the point in the axes of a and of b, from the centre of mass [m]: by it points are matched
COLLISION_DEPTH = 6  # overlap when the pair was last collided [m]
PENALTY = 7  # stiffness that avbd gives the contact, times the square of the step [kg]; 0 for other solvers

# Columns of ``reference``, which says how the pair lay when it was last collided.
TURN_A, TURN_B = 0, 4  # orientations of a and b, quaternions
NORMAL_IN_A = 8  # 8–10 the normal in a's axes
IS_RECYCLABLE = 11  # 1; 0 forces a collision in the next step


@by_address
class Manifolds(NamedTuple):
    """The table of manifolds. Shapes are given for a capacity of m rows; k is a point, 0 to 3."""

    a: npt.NDArray[np.int32]
    """(m,) collider row of the pair's lower row."""
    b: npt.NDArray[np.int32]
    """(m,) collider row of the pair's higher row."""
    count: npt.NDArray[np.int32]  # type: ignore[assignment]  # hides tuple.count
    """(m,) points in use, 0 to 4. Unused points are zero in all columns."""
    touching: npt.NDArray[np.bool_]
    """(m,) whether the pair has touched (overlapped or pushed) since the manifold began."""
    collided: npt.NDArray[np.int64]
    """(m,) number of the step in which the pair was last collided."""
    feature: npt.NDArray[np.int32]
    """(m, 4) which features of the two shapes met at the point."""
    contact: npt.NDArray[np.floating]
    """(m, 16) normal, combined material, impulses that act on the points together."""
    points: npt.NDArray[np.floating]
    """(m, 32) for each point anchors, depth, normal impulse."""
    local: npt.NDArray[np.floating]
    """(m, 32) for each point its place in either body's axes."""
    reference: npt.NDArray[np.floating]
    """(m, 16) how the pair lay when it was last collided."""
    total: npt.NDArray[np.floating]
    """(m, 8) impulses over the whole last step, all substeps: 0–3 along the normal at the points; 4–6 friction on b at their
    centroid, world axes [N s]; 7 torsion on b about the normal [N m s]."""
    friction_impulse: npt.NDArray[np.floating]
    """(m, 12) for each point friction impulse on b in the last step that acts there alone, world axes [N s]."""


def empty_manifolds(capacity: int, real: npt.DTypeLike) -> Manifolds:
    """A table with room for ``capacity`` manifolds."""
    m = capacity
    return Manifolds(
        a=aligned_zeros((m,), np.int32),
        b=aligned_zeros((m,), np.int32),
        count=aligned_zeros((m,), np.int32),
        touching=aligned_zeros((m,), np.bool_),
        collided=aligned_zeros((m,), np.int64),
        feature=aligned_zeros((m, 4), np.int32),
        contact=aligned_zeros((m, CONTACT_COLUMNS), real),
        points=aligned_zeros((m, 4 * POINT_COLUMNS), real),
        local=aligned_zeros((m, 4 * POINT_COLUMNS), real),
        reference=aligned_zeros((m, 16), real),
        total=aligned_zeros((m, 8), real),
        friction_impulse=aligned_zeros((m, 12), real),
    )


def live_rows(manifolds: Manifolds, count: int) -> npt.NDArray[np.intp]:
    """Those of the first ``count`` rows that have contact points, in the order of their pairs."""
    rows = np.flatnonzero(manifolds.count[:count])
    return rows[np.argsort((manifolds.a[rows].astype(np.int64) << 32) | manifolds.b[rows])]


def arranged(manifolds: Manifolds, rows: npt.NDArray[np.intp], first: int = 0) -> Manifolds:
    """A table of its own with copies of some rows of another one, in the given order, from row ``first`` on; the rows before it are zero."""
    table = empty_manifolds(first + len(rows), manifolds.points.dtype)
    for column, source in zip(table, manifolds, strict=True):
        column[first:] = source[rows]
    return table


def with_rows(manifolds: Manifolds, capacity: int, used: int) -> Manifolds:
    """The same table with room for ``capacity`` rows, of which the first ``used`` are kept."""
    return with_capacity(manifolds, capacity, used)
