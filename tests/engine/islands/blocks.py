"""Contacts as the step keeps them."""

import numpy as np

from atlasphys.engine.simd import LANES


def in_blocks(pairs):
    """(blocks, 2, 8) rows of the two bodies of each contact; what is left of the last block is zero."""
    padded = np.zeros((-(-max(len(pairs), 1) // LANES) * LANES, 2), np.int32)
    padded[: len(pairs)] = pairs
    return np.ascontiguousarray(padded.reshape(-1, LANES, 2).transpose(0, 2, 1))
