"""Contacts: what the narrow phase found in this step, before points are reduced and matched.

Each pair owns a range of point slots, ``first[p]`` to ``first[p + 1]``, wide enough for the most points that its two shapes can
give; the first ``count[p]`` of them are filled. So pairs can be worked on in any order and nothing is ever dropped.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from atlasphys.engine.simd.by_address import by_address
from atlasphys.engine.state.arrays import aligned_zeros


@by_address
class Contacts(NamedTuple):
    """Contact points of P pairs in K slots. The normal points from a to b."""

    a: npt.NDArray[np.int32]
    """(P,) collider row of the pair's lower row."""
    b: npt.NDArray[np.int32]
    """(P,) collider row of the pair's higher row."""
    first: npt.NDArray[np.int32]
    """(P + 1,) where each pair's slots begin."""
    count: npt.NDArray[np.int32]  # type: ignore[assignment]  # hides tuple.count
    """(P,) points found."""
    normal: npt.NDArray[np.floating]
    """(P, 3) unit normal in world axes."""
    gap: npt.NDArray[np.floating]
    """(P,) how far points of the two shapes may at least move towards each other before the pair has contact points [m]; 0: not known."""
    anchor_a: npt.NDArray[np.floating]
    """(K, 3) contact point − centre of mass of a, world axes [m]. The point is midway between the two surfaces."""
    anchor_b: npt.NDArray[np.floating]
    """(K, 3) the same point − centre of mass of b [m]."""
    depth: npt.NDArray[np.floating]
    """(K,) overlap along the normal [m]; negative where the surfaces are still apart."""
    feature: npt.NDArray[np.int32]
    """(K,) which features of the two shapes met: equal from step to step while the same ones do."""


def empty_contacts(pairs: int, points: int, real: npt.DTypeLike) -> Contacts:
    """Room for ``pairs`` pairs with ``points`` point slots in all."""
    return Contacts(
        a=aligned_zeros((pairs,), np.int32),
        b=aligned_zeros((pairs,), np.int32),
        first=aligned_zeros((pairs + 1,), np.int32),
        count=aligned_zeros((pairs,), np.int32),
        normal=aligned_zeros((pairs, 3), real),
        gap=aligned_zeros((pairs,), real),
        anchor_a=aligned_zeros((points, 3), real),
        anchor_b=aligned_zeros((points, 3), real),
        depth=aligned_zeros((points,), real),
        feature=aligned_zeros((points,), np.int32),
    )
