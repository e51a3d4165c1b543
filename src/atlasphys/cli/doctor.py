"""``atlasphys doctor``: what a report of a problem should say about the machine."""

from __future__ import annotations

import os
import platform
from importlib.metadata import PackageNotFoundError, version

PACKAGES = ("atlasphys", "numpy", "numba", "llvmlite", "scipy", "pydantic", "cyclopts", "rich", "h5py")


def doctor() -> int:
    """Show versions, processor, vector instructions and the folder of compiled kernels."""
    from atlasphys.engine.jit import cache_root
    from atlasphys.engine.simd.target import instruction_set, lane_count

    folder = cache_root()
    files = [file for file in folder.rglob("*") if file.is_file()]
    size = sum(file.stat().st_size for file in files) / 1e6
    machine = f"{platform.system()} {platform.machine()}, {os.cpu_count()} processors"
    print(f"Python     {platform.python_version()} on {machine}")
    print(f"vectors    {lane_count()} lanes, {instruction_set()}")
    for package in PACKAGES:
        print(f"{package:10} {_version(package)}")
    print(f"kernels    {folder}: {sum(file.suffix == '.nbc' for file in files)} compiled, {size:.1f} MB")
    return 0


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"
