"""Plain Python kernel bodies as vector code: eight lanes at once, compiled or read by NumPy, with the same bits.

``docs/simd.md`` explains how it works and how to write a body.
"""

from atlasphys.engine.simd.kernel import SimdKernel, simd_kernel
from atlasphys.engine.simd.lanes import (
    LANES,
    Lanes,
    Mask,
    absolute,
    all_lanes,
    any_lane,
    full,
    maximum,
    minimum,
    select,
    sqrt,
    when,
)
from atlasphys.engine.simd.memory import Table, beside, gather, load, scatter, store
from atlasphys.engine.simd.target import instruction_set, lane_count

__all__ = [
    "LANES",
    "Lanes",
    "Mask",
    "SimdKernel",
    "Table",
    "absolute",
    "all_lanes",
    "any_lane",
    "beside",
    "full",
    "gather",
    "instruction_set",
    "lane_count",
    "load",
    "maximum",
    "minimum",
    "scatter",
    "select",
    "simd_kernel",
    "sqrt",
    "store",
    "when",
]
