"""Less work for Numba while it compiles a kernel.

To find what an operator means for arguments of certain types, Numba tries all definitions that anybody has given for it, a dozen for ``a + b``,
each time that it meets it in a program; so in a large kernel half the time of type inference goes into answers that were given before.
``quickly`` has them remembered. And it has no garbage collected meanwhile, of which there is little, among millions of objects to be searched.
"""

from __future__ import annotations

import gc
from collections.abc import Callable
from typing import Any

from numba.core import types as _types
from numba.core.compiler_lock import global_compiler_lock as _lock
from numba.core.targetconfig import ConfigStack

types: Any = _types  # Numba's own annotations are incomplete
lock: Any = _lock

_resolve = types.BaseFunction.get_call_type


def _resolve_once(function: Any, context: Any, arguments: Any, named: Any) -> Any:
    """What ``BaseFunction.get_call_type`` answers, asked for it once for all functions that count references alike."""
    answers = function.__dict__.setdefault("_answers", {})
    flags = ConfigStack.top_or_none()
    question = tuple(arguments), tuple(named.items()), flags is not None and flags.nrt
    if question not in answers:
        answers[question] = _resolve(function, context, arguments, named)
    return answers[question]


def quickly(compile_types: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """What compiles a function, so."""

    def compile_quickly(kinds: Any) -> Any:
        with lock:  # no other thread compiles meanwhile
            if types.BaseFunction.get_call_type is _resolve_once:  # for a function that calls this one
                return compile_types(kinds)
            collects = gc.isenabled()
            types.BaseFunction.get_call_type = _resolve_once
            gc.disable()
            try:
                return compile_types(kinds)
            finally:
                types.BaseFunction.get_call_type = _resolve
                if collects:
                    gc.enable()

    return compile_quickly
