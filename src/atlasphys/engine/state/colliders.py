"""Colliders: one row for each shape on a body, in the order of the bodies."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from atlasphys.engine.simd.by_address import by_address
from atlasphys.engine.state.arrays import aligned_zeros


@by_address
class Colliders(NamedTuple):
    """The table of colliders. Shapes are given for a capacity of n rows."""

    body: npt.NDArray[np.int32]
    """(n,) row of the body."""
    shape: npt.NDArray[np.int32]
    """(n,) row in the table of shapes."""
    material: npt.NDArray[np.floating]
    """(n, 4) friction, restitution, rolling friction [m], torsional friction [m]."""
    group: npt.NDArray[np.uint32]
    """(n,) bits of the groups to which the collider belongs."""
    mask: npt.NDArray[np.uint32]
    """(n,) bits of the groups with which it collides."""

    # Derived at the start of each step
    lower: npt.NDArray[np.float64]
    """(n, 3) least corner of the world bounds, margin included [m]."""
    upper: npt.NDArray[np.float64]
    """(n, 3) greatest corner [m]."""


def empty_colliders(capacity: int, real: npt.DTypeLike) -> Colliders:
    """A table with room for ``capacity`` colliders."""
    n = capacity
    return Colliders(
        body=aligned_zeros((n,), np.int32),
        shape=aligned_zeros((n,), np.int32),
        material=aligned_zeros((n, 4), real),
        group=aligned_zeros((n,), np.uint32),
        mask=aligned_zeros((n,), np.uint32),
        lower=aligned_zeros((n, 3), np.float64),
        upper=aligned_zeros((n, 3), np.float64),
    )
