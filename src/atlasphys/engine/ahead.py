"""Compiling the second half of a step's kernels in another process while this one compiles the first half.

Numba compiles one kernel at a time. On the first run of all, a step needs about 25 s of compiling, half of it before the manifold
stage and half from there on. ``start`` has a child process compile the latter into the kernel cache, where the first step finds it.
"""

import subprocess
import sys
import threading

from atlasphys.engine.jit import is_compiled
from atlasphys.engine.manifold import update_manifolds
from atlasphys.engine.manifold.build import build_manifolds
from atlasphys.engine.solvers.sequential_impulse import SequentialImpulse, advance, solve
from atlasphys.engine.state.state import Environment, State


def start(precision: str) -> None:
    """Start compiling for worlds of a precision, ``"single"`` or ``"double"``, unless that has been done. The child ends by itself."""
    if is_compiled(build_manifolds) and is_compiled(solve):
        return
    command = [sys.executable, "-m", "atlasphys.engine.ahead", precision]
    quiet = subprocess.DEVNULL
    child = subprocess.Popen(command, stdin=quiet, stdout=quiet, stderr=quiet)
    threading.Thread(target=child.wait, name="compiling ahead", daemon=True).start()


def compile_second_half(precision: str) -> None:
    """Run the stages from the manifold on with an empty world."""
    environment = Environment((0.0, 0.0, 0.0), 1.0, 1.0, 0, 0)
    state = State({"single": "f", "double": "d"}[precision], environment)
    update_manifolds(state, 0)
    advance(state, SequentialImpulse(), 1.0)


if __name__ == "__main__":
    compile_second_half(sys.argv[1])
