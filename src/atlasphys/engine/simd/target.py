"""What the vector code is compiled for, as ``atlasphys doctor`` shows it."""

from __future__ import annotations

from numba.core.registry import cpu_target

from atlasphys.engine.simd.lanes import LANES

_SETS = (("avx512f", "AVX-512"), ("avx2", "AVX2"), ("avx", "AVX"), ("sse4.1", "SSE4.1"), ("neon", "NEON"))


def lane_count() -> int:
    """Numbers that a kernel computes at once."""
    return LANES


def instruction_set() -> str:
    """The widest vector instructions that kernels are compiled to: ``"AVX-512"``, ``"AVX2"``, ``"NEON"`` and so on.

    It follows the CPU, or Numba's settings NUMBA_CPU_NAME and NUMBA_CPU_FEATURES where they are set.
    """
    triple, _, features = cpu_target.target_context.codegen().magic_tuple()
    enabled = {feature[1:] for feature in features.split(",") if feature.startswith("+")}
    for feature, name in _SETS:
        if feature in enabled:
            return name
    if triple.startswith("x86_64"):
        return "SSE2"  # every x86-64 has it
    return "NEON" if triple.startswith(("aarch64", "arm64")) else "unknown"
