"""Manifolds: the contact points of each touching or nearly touching pair, kept from step to step.

Rows are ordered by (a, b), the pair's collider rows, so that two steps' manifolds are matched in one walk.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from atlasphys.engine.state.arrays import aligned_zeros


class Manifolds(NamedTuple):
    """The table of manifolds. Shapes are given for a capacity of m rows; k is a point, 0 to 3. The normal points from a to b."""

    a: npt.NDArray[np.int32]
    """(m,) collider row of the pair's lower row."""
    b: npt.NDArray[np.int32]
    """(m,) collider row of the pair's higher row."""
    count: npt.NDArray[np.int32]  # type: ignore[assignment]  # hides tuple.count
    """(m,) points in use, 1 to 4."""
    touching: npt.NDArray[np.bool_]
    """(m,) whether the pair has touched (overlapped or pushed) since the manifold began."""
    normal: npt.NDArray[np.floating]
    """(m, 3) unit normal in world axes."""
    material: npt.NDArray[np.floating]
    """(m, 4) combined friction, restitution, rolling friction [m], torsional friction [m]."""
    feature: npt.NDArray[np.int32]
    """(m, 4) which features of the two shapes met at the point."""
    point: npt.NDArray[np.float64]
    """(m, 4, 3) contact point, midway between the two surfaces, world axes [m]."""
    anchor_a: npt.NDArray[np.floating]
    """(m, 4, 3) contact point − centre of mass of a, world axes [m]."""
    anchor_b: npt.NDArray[np.floating]
    """(m, 4, 3) the same point − centre of mass of b [m]."""
    local_a: npt.NDArray[np.floating]
    """(m, 4, 3) the point in a's own axes, from a's centre of mass [m]: by it points are matched."""
    local_b: npt.NDArray[np.floating]
    """(m, 4, 3) the point in b's own axes, from b's centre of mass [m]."""
    depth: npt.NDArray[np.floating]
    """(m, 4) overlap along the normal [m]; negative where the surfaces are still apart."""
    normal_impulse: npt.NDArray[np.floating]
    """(m, 4) impulse along the normal in the last step [N s]."""
    friction_impulse: npt.NDArray[np.floating]
    """(m, 4, 3) friction impulse on b in the last step, world axes [N s]."""
    rolling_impulse: npt.NDArray[np.floating]
    """(m, 3) angular impulse of rolling friction on b [N m s]."""
    torsional_impulse: npt.NDArray[np.floating]
    """(m,) angular impulse of torsional friction on b, about the normal [N m s]."""


def empty_manifolds(capacity: int, real: npt.DTypeLike) -> Manifolds:
    """A table with room for ``capacity`` manifolds."""
    m = capacity
    return Manifolds(
        a=aligned_zeros((m,), np.int32),
        b=aligned_zeros((m,), np.int32),
        count=aligned_zeros((m,), np.int32),
        touching=aligned_zeros((m,), np.bool_),
        normal=aligned_zeros((m, 3), real),
        material=aligned_zeros((m, 4), real),
        feature=aligned_zeros((m, 4), np.int32),
        point=aligned_zeros((m, 4, 3), np.float64),
        anchor_a=aligned_zeros((m, 4, 3), real),
        anchor_b=aligned_zeros((m, 4, 3), real),
        local_a=aligned_zeros((m, 4, 3), real),
        local_b=aligned_zeros((m, 4, 3), real),
        depth=aligned_zeros((m, 4), real),
        normal_impulse=aligned_zeros((m, 4), real),
        friction_impulse=aligned_zeros((m, 4, 3), real),
        rolling_impulse=aligned_zeros((m, 3), real),
        torsional_impulse=aligned_zeros((m,), real),
    )
