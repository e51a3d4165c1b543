"""What LLVM makes of the kernels: single precision stays single, and nothing in the step depends on the CPU or the C library."""

import ast
import inspect
import re
import sys

import atlasphys.world.body
import atlasphys.world.views
import atlasphys.world.world
from atlasphys.engine import jit
from tests.rules.kernels import compiled, engine_modules, kernels

FLOAT_TO_DOUBLE = {
    "broadphase.brute.test_all": "heights above planes are taken from positions",
    "broadphase.bvh.write_keys": "the curve's lattice reaches farther than single precision tells its cells apart",
    "broadphase.fat_boxes.fatten": "fat boxes lie about positions; seldom run",
    "broadphase.fat_boxes.flag_leavers": "ways from the middle of a fat box are differences of positions; seldom run",
    "broadphase.flight.keep_meeting": "ways between boxes are differences of positions; seldom run",
    "broadphase.sweep.sweep": "heights above planes are taken from positions",
    "broadphase.tree.keep_exact": "heights above planes are taken from positions",
    "broadphase.tree.pairs_with_planes": "heights above planes are taken from positions",
    "fused.detection.detection_address": "centres are positions; what stands for a plane's centre is a point of a lattice",
    "fused.generic.generic_address": "the same",
    "fused.response.response_address": "positions are centres moved by what single precision holds",
    "fused.response.response_address_with_locks": "the same",
    "fused.response.response_address_with_notes": "the same",
    "fused.positions.positions_address": "the same",
    "fused.positions.positions_address_with_locks": "the same",
    "fused.positions.positions_address_with_notes": "the same",
    "fused.steps.run_steps": "travelled ways are sums",
    "narrowphase.addresses.plane_convex_address": "distances from planes are taken from positions",
    "narrowphase.pairs.plane_convex.plane_convex": "distances from planes are taken from positions",
    "shapes.bounds.update_bounds": "bounds are positions",
    "solvers.avbd.solve": "centres and origins are positions",
    "solvers.sequential_impulse.solve": "centres and origins are positions",
    "state.pose.refresh": "centres are positions",
    "state.state.non_finite_rows": "one sum of zeros over positions and the rest",
}
"""Kernels that may take single-precision values over into double, and why."""

DOUBLE_PRODUCTS = {
    "broadphase.brute.test_all",
    "broadphase.bvh.write_keys",
    "broadphase.fat_boxes.fatten",
    "broadphase.fat_boxes.flag_leavers",
    "broadphase.flight.keep_meeting",
    "broadphase.sweep.sweep",
    "broadphase.tree.keep_exact",
    "broadphase.tree.pairs_with_planes",
    "fused.detection.detection_address",
    "fused.generic.generic_address",
    "fused.steps.run_steps",
    "narrowphase.addresses.plane_convex_address",
    "narrowphase.pairs.plane_convex.plane_convex",
    "state.state.non_finite_rows",
}
"""Those among them that may multiply there; the others only add to positions."""

CALLS = re.compile(r"^\s*(?:%\S+ = )?(?:\w+ )?(?:call|invoke) [^@(]*@\"?([\w.$]+)", re.MULTILINE)

HARMLESS = (
    "_ZN",
    "Py",
    "_Py",
    "NRT_",
    "numba_",
    "llvm.mem",
    "llvm.lifetime.",
    "llvm.experimental.noalias.scope.decl",
    "llvm.masked.",
    "llvm.prefetch.",
    "llvm.x86.atomic.",
    "llvm.x86.sse2.pause",
    "atlasphys_",
)
"""Beginnings of names of what does no arithmetic; ``atlasphys_``: waiting and clocks of threads (simd/atomic.py)."""
EXACT = re.compile(
    r"sqrtf?|llvm\.(sqrt|rint|fabs|copysign|[su]?(min|max)|ctpop|cttz|ctlz|abs|[su](add|sub|mul)\.with\.overflow)\..*"
)
"""Functions that IEEE 754 or integer arithmetic fixes to the last bit."""


def test_the_scenes_call_the_kernels():
    assert len(compiled()) >= 12
    assert set(FLOAT_TO_DOUBLE) <= set(kernels())


def test_single_precision_stays_single():
    found = {name for name, code in compiled().items() if re.search(r"fpext [^,]*float", code)}
    assert found <= set(FLOAT_TO_DOUBLE)
    found = {name for name, code in compiled().items() if re.search(r"(fmul|fdiv) [^%\n]*double|sqrt\.\w*f64\(", code)}
    assert found <= DOUBLE_PRODUCTS


def test_no_call_depends_on_the_c_library():
    for name, code in compiled().items():
        called = {called for called in CALLS.findall(code) if not called.startswith(HARMLESS)}
        assert {call for call in called if not EXACT.fullmatch(call)} == set(), name
        assert re.search(r"sqrt", code) or name not in ("manifold.build.build_manifolds",)  # the pattern finds calls


def test_arithmetic_is_strict():
    for name, code in compiled().items():
        assert not re.search(r"llvm\.fmuladd|llvm\.fma\.", code), name
        assert not re.search(r"\bf(add|sub|mul|div|cmp|neg) (fast|nnan|ninf|nsz|arcp|contract|afn|reassoc)\b", code), (
            name
        )


def test_python_never_calls_a_routine():
    """A routine has no wrapper for Python: such a call crashes the process."""
    routines = {
        id(value)
        for module in engine_modules()
        for value in vars(module).values()
        if getattr(value, "targetoptions", {}).get("no_cpython_wrapper")
    }
    assert len(routines) > 50
    world = atlasphys.world
    for module in (*engine_modules(), world.body, world.views, world.world):
        for node in ast.parse(inspect.getsource(module)).body:
            decorated = isinstance(node, ast.FunctionDef) and {
                ast.unparse(decorator).split("(")[0] for decorator in node.decorator_list
            } & {"kernel", "allocating_kernel", "routine", "allocating_routine", "inlined"}
            if decorated:
                continue
            for call in (each for each in ast.walk(node) if isinstance(each, ast.Call)):
                name = ast.unparse(call.func)
                try:
                    called = eval(name, vars(module).copy()) if re.fullmatch(r"[\w.]+", name) else None
                except (NameError, AttributeError):
                    continue
                assert id(called) not in routines, f"{module.__name__}: {name}"


def imported(module):
    """The engine modules that a module imports when it runs, by its syntax tree."""
    for node in ast.parse(inspect.getsource(module)).body:
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("atlasphys.engine"):
            names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
            yield from (name for name in names if name in sys.modules)


def test_the_key_of_the_kernel_cache_covers_every_import():
    """Its search through the text finds what the syntax tree holds, so no edit of a helper leaves stale code."""
    for module in engine_modules():
        assert jit._read(module.__name__)[1] == set(imported(module)), module.__name__


def test_the_key_of_the_kernel_cache_follows_imports_of_imports():
    solver = "atlasphys.engine.solvers.sequential_impulse"
    before = jit._source_hash(solver)
    assert "atlasphys.engine.math.vec" in jit._read(solver)[1]
    original = jit._read
    changed = {"atlasphys.engine.jit": "a line more\n"}
    jit._source_hash.cache_clear()
    try:
        jit._read = lambda name: (changed.get(name, "") + original(name)[0], original(name)[1])
        assert jit._source_hash(solver) != before
    finally:
        jit._read = original
        jit._source_hash.cache_clear()
    assert jit._source_hash(solver) == before


def test_imports_take_the_form_that_the_key_understands():
    for module in engine_modules():
        for node in ast.walk(ast.parse(inspect.getsource(module))):
            if isinstance(node, ast.Import):
                assert not any(alias.name.startswith("atlasphys") for alias in node.names), module.__name__
            if isinstance(node, ast.ImportFrom):
                assert node.level == 0, module.__name__
            if isinstance(node, ast.FunctionDef):
                inner = [each for each in ast.walk(node) if isinstance(each, ast.ImportFrom)]
                assert not any((each.module or "").startswith("atlasphys") for each in inner), node.name
