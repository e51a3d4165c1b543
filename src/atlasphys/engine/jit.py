"""How kernels are compiled: the only module of the scalar engine that imports Numba.

Two decorators:

- ``@kernel`` marks a function that Python calls. Its machine code is kept in a cache folder between runs.
- ``@routine`` marks a function that only kernels call. It is compiled into each of them.

Neither may make arrays: Numba then counts no references to the arrays that it passes about, which would cost more than the
arithmetic. The few that make scratch arrays are ``allocating_kernel`` and ``allocating_routine``.

Both compile strict IEEE arithmetic (no ``fastmath``, so no fused multiply-add and no reordering): the same bits on
every CPU. Both release the interpreter lock, check no bounds, and let division by zero give infinity as NumPy does.

The cache folder's name holds a hash of the kernel's source file and of every engine file that it imports, directly or
not. Numba itself looks only at the file that holds the kernel, and would run stale code after an edit of a helper
elsewhere. The folder is ``$ATLASPHYS_CACHE_DIR`` or the user's cache folder, or, where that cannot be written, a
temporary one.
"""

from __future__ import annotations

import hashlib
import os
import re
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numba
import platformdirs
from numba.core.dispatcher import Dispatcher as _Dispatcher

from atlasphys.engine.simd.compiling import quickly
from atlasphys.engine.simd.inlining import IngredientCompiler, KernelCompiler

Function = TypeVar("Function", bound=Callable[..., Any])

_IMPORT = re.compile(r"^from (atlasphys\.engine[\w.]*) import (\([^)]*\)|[^\n(]*)", re.MULTILINE)

# Numba's own annotations do not know these options.
_njit: Any = numba.njit
_config: Any = numba.config
_types: Any = numba.types
Dispatcher: Any = _Dispatcher

IS_COMPILED = not _config.DISABLE_JIT
"""Whether kernels are compiled at all; with NUMBA_DISABLE_JIT=1 Python runs them."""

_OPTIONS = {"nogil": True, "error_model": "numpy", "boundscheck": False, "fastmath": False}


@cache
def _source_hash(module: str) -> str:
    """Hash of a module's source and of every engine module that it imports, directly or not."""
    reached = {module}
    waiting = [module]
    while waiting:
        found = _read(waiting.pop())[1] - reached
        reached |= found
        waiting += found
    return hashlib.sha256("".join(_read(name)[0] for name in sorted(reached)).encode()).hexdigest()


@cache
def _read(module: str) -> tuple[str, frozenset[str]]:
    """A loaded module's source, and the names of the engine modules that it imports."""
    file = sys.modules[module].__file__
    assert file is not None
    text = Path(file).read_text(encoding="utf-8")
    named: set[str] = set()
    for package, names in _IMPORT.findall(text):
        named |= {package, *(f"{package}.{name}" for name in re.findall(r"\w+", names))}
    return text, frozenset(name for name in named if name in sys.modules)


@cache
def cache_root() -> Path:
    """The writable folder under which compiled kernels are kept."""
    wanted = os.environ.get("ATLASPHYS_CACHE_DIR") or platformdirs.user_cache_dir("atlasphys", appauthor=False)
    user = os.getuid() if hasattr(os, "getuid") else None
    for folder in (Path(wanted), Path(tempfile.gettempdir()) / f"atlasphys-{user}"):
        try:
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            if user != (folder.stat().st_uid if user is not None else None):
                continue  # another user's: Numba would run what it finds there
            with tempfile.TemporaryFile(dir=folder):
                return folder
        except OSError:
            continue
    return Path(tempfile.mkdtemp(prefix="atlasphys-"))


def kernel(function: Function) -> Function:
    """Compile a function that Python calls, once per combination of argument types, and keep the code between runs."""
    return _kernel(function, allocates=False)


def allocating_kernel(function: Function) -> Function:
    """A kernel that makes arrays, or calls a routine that does."""
    return _kernel(function, allocates=True)


def _kernel(function: Function, allocates: bool) -> Function:
    folder = cache_root() / "kernels" / f"{numba.__version__}-{_source_hash(function.__module__)[:16]}"
    # Numba reads this setting when a function's cache is set up, in this call; other packages' kernels keep theirs.
    previous, _config.CACHE_DIR = _config.CACHE_DIR, str(folder)
    try:
        compiled = _njit(cache=True, no_cfunc_wrapper=True, _nrt=allocates, pipeline_class=KernelCompiler, **_OPTIONS)(
            function
        )
    finally:
        _config.CACHE_DIR = previous
    return _with_fewer_types(compiled)


_entries: dict[tuple[Any, str], Callable[..., Any]] = {}


def call(compiled: Callable[..., Any], precision: str, *arguments: Any) -> Any:
    """Call a kernel whose arguments have the same types in all worlds of a precision, NumPy's character for which is given.

    Numba looks at all arrays of all tables to find the code for their types, which can take longer than the kernel; this does it once. Called with
    other types, the code would read and write anywhere.
    """
    entry = _entries.get((compiled, precision))
    if entry is None:
        entry = compiled
        if isinstance(compiled, Dispatcher):
            kinds = tuple(map(compiled.typeof_pyval, arguments))
            compiled.compile(kinds)
            entry = compiled.overloads[kinds].entry_point
        _entries[compiled, precision] = entry
    return entry(*arguments)


def is_compiled(compiled: Callable[..., Any]) -> bool:
    """Whether the cache holds code of a kernel, for some types of arguments."""
    cached = getattr(compiled, "_cache", None)  # absent where NUMBA_DISABLE_JIT is set
    return cached is None or any(
        Path(cached.cache_path).glob(f"{compiled.__module__.rpartition('.')[2]}.{compiled.__name__}-*.nbi")
    )


def routine(function: Function) -> Function:
    """Compile a function that only kernels call. Called from Python it crashes: it has no wrapper for that."""
    return _routine(function)


def allocating_routine(function: Function) -> Function:
    """A routine that makes arrays, or calls one that does."""
    return _routine(function, allocates=True)


def inlined(function: Function) -> Function:
    """Compile a function into each place where a kernel or routine calls it.

    For small functions of large tables in the innermost loops: each array of a table is nine arguments to pass, which
    takes longer than the function itself.
    """
    return _routine(function, forceinline=True)


def _routine(function: Function, forceinline: bool = False, allocates: bool = False) -> Function:
    compiled = _njit(
        no_cpython_wrapper=True,
        no_cfunc_wrapper=True,
        forceinline=forceinline,
        _nrt=allocates,
        pipeline_class=IngredientCompiler,
        **_OPTIONS,
    )(function)
    return _with_fewer_types(compiled)


def _with_fewer_types(compiled: Any) -> Any:
    if isinstance(compiled, Dispatcher):  # not where NUMBA_DISABLE_JIT is set
        compile_types = quickly(compiled.compile)
        compiled.compile = lambda types: compile_types(tuple(map(_passed_as, types)))
    return compiled


def _passed_as(kind: Any) -> Any:
    """The type that a routine takes for an argument of a type. Numba would compile f(0), f(1), f(i) and f(array[i]) one by one: each literal is a
    type of its own, and the integers of arrays are shorter."""
    kind = _types.unliteral(kind)
    return _types.int64 if isinstance(kind, _types.Integer) and kind.signed else kind
