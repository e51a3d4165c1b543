"""Kernels by which the tests call routines."""

from atlasphys.engine.jit import kernel
from atlasphys.engine.shapes.feature import supporting_feature
from atlasphys.engine.shapes.support import rounding, support


@kernel
def probe_support(shapes, row, x, y, z):
    """Support point in the direction (x, y, z) and the radius about the core."""
    return support(shapes, row, (x, y, z)), rounding(shapes, row)


@kernel
def probe_feature(shapes, row, x, y, z, points, ids):
    """Supporting feature in the direction (x, y, z)."""
    return supporting_feature(shapes, row, (x, y, z), points, ids)
