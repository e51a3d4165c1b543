"""All kernels of the engine, with the machine-independent code that LLVM made of them for a world of single precision."""

import importlib
import pkgutil
from functools import cache

import atlasphys as ap
import atlasphys.engine
from atlasphys.engine.state.bodies import Bodies
from tests.world.scenes import heap, steps


def engine_modules():
    """Every module of the engine, imported."""
    names = [info.name for info in pkgutil.walk_packages(atlasphys.engine.__path__, "atlasphys.engine.")]
    return [importlib.import_module(name) for name in names]


def kernels():
    """``{"module.function": dispatcher}`` of all kernels: those that Python can call."""
    found = {}
    for module in engine_modules():
        for name, value in vars(module).items():
            options = getattr(value, "targetoptions", None)
            if options and not options.get("no_cpython_wrapper") and value.py_func.__module__ == module.__name__:
                found[f"{module.__name__.removeprefix('atlasphys.engine.')}.{name}"] = value
    return found


def is_single(signature):
    """Whether a kernel was compiled for worlds of single precision. Boxes of the tree are single in all worlds."""
    bodies = [kind for kind in signature if getattr(kind, "table", None) is Bodies]
    return "float32" in str(bodies[0] if bodies else signature)


@cache
def compiled():
    """Optimised LLVM code of each kernel that stepping a few single-precision scenes calls, by the kernel's name."""
    steps(heap(21), 20)
    for method in ("auto", "gjk_epa"):
        world = heap(21, preset="classic", narrowphase=method)
        world.solver = ap.SequentialImpulse(position_correction="baumgarte")
        steps(world, 20)
        world.broadphase = "brute"
        steps(world, 2)
        world.solver = ap.AVBD()
        steps(world, 2)
    steps(heap(21, preset="xpbd"), 2)
    code = {}
    for name, kernel in kernels().items():
        for signature, result in kernel.overloads.items():
            if is_single(signature):
                code[name] = str(result.library._get_module_for_linking())
    return code
