"""The engine's functions as plain Python, which take notes of what they do.

A compiled function keeps the Python function that it was made of. ``plain`` makes another of the same code object, for which every name means what
it means in the engine, except that compiled functions are their plain selves, ``TRACED`` is true, and ``note`` writes into the record of
``recording``. The bits are those of the compiled code: see ``tests/world/test_determinism.py``.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, is_dataclass
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

import numpy as np

from atlasphys.engine import trace

ENGINE = "atlasphys.engine."
AS_THEY_ARE = (ENGINE + "simd", ENGINE + "jit", ENGINE + "trace")
"""Modules that run in Python as they stand."""


@dataclass(frozen=True)
class Note:
    """What the engine's code noted at one place."""

    kind: str
    """The algorithm and what happened, ``"gjk.support"``."""
    source: str
    """File and line, ``"engine/narrowphase/gjk.py:219"``."""
    values: dict[str, Any]
    """Values of the variables at that moment, vectors as arrays."""

    def __getitem__(self, name: str) -> Any:
        return self.values[name]


_notes: ContextVar[list[Note]] = ContextVar("notes")
_copies: dict[str, ModuleType] = {}


@contextmanager
def recording() -> Iterator[list[Note]]:
    """The list to which plain functions add their notes inside the block."""
    token = _notes.set([])
    try:
        with np.errstate(all="ignore"):  # as compiled code does
            yield _notes.get()
    finally:
        _notes.reset(token)


def plain(function: Callable[..., Any]) -> Callable[..., Any]:
    """An engine function, compiled or not, as plain Python that takes notes. Call it inside ``recording()``."""
    found: Callable[..., Any] = _plain(function)
    return found


def _plain(value: Any) -> Any:
    if isinstance(value, ModuleType):
        return _copy(value.__name__) if _is_copied(value.__name__) else value
    if value is trace.note:
        return _note
    if (
        isinstance(value, type)
        and _is_copied(value.__module__)
        and value.__bases__ == (object,)
        and not is_dataclass(value)
    ):
        members = {key: member for key, member in vars(value).items() if key not in ("__dict__", "__weakref__")}
        return type(value.__name__, (), {key: _plain(member) for key, member in members.items()})
    function = getattr(value, "py_func", value)
    if not isinstance(function, FunctionType) or not _is_copied(function.__module__):
        return value
    if function.__globals__ is not vars(sys.modules[function.__module__]):  # made elsewhere, by a decorator
        return value
    names = vars(_copy(function.__module__))
    made = FunctionType(function.__code__, names, function.__name__, function.__defaults__, function.__closure__)
    made.__kwdefaults__ = function.__kwdefaults__
    return made


def _is_copied(module: str) -> bool:
    return module.startswith(ENGINE) and not module.startswith(AS_THEY_ARE)


def _copy(name: str) -> ModuleType:
    """A module of the engine whose functions are plain."""
    if name not in _copies:
        copy = _copies[name] = ModuleType(name)
        for key, value in vars(sys.modules[name]).items():
            setattr(copy, key, _plain(value))
        if hasattr(copy, "TRACED"):
            vars(copy)["TRACED"] = True
    return _copies[name]


def _note(kind: str, **values: Any) -> None:
    frame = sys._getframe(1)
    file = Path(frame.f_code.co_filename)
    package = next(parent for parent in file.parents if parent.name == "atlasphys")
    source = f"{file.relative_to(package).as_posix()}:{frame.f_lineno}"
    _notes.get().append(Note(kind, source, {key: _kept(value) for key, value in values.items()}))


def _kept(value: Any) -> Any:
    """A value as it is now: arrays and vectors as arrays of their own, scalars as Python's."""
    if isinstance(value, np.ndarray | tuple):
        array = np.array(value)
        array.flags.writeable = False
        return array
    return value.item() if isinstance(value, np.generic) else value
