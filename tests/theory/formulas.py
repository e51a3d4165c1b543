"""What the tests of the book share: which formula a test checks, and the engine's routines as plain Python."""

import types
from collections.abc import Callable
from typing import Any, TypeVar

Test = TypeVar("Test", bound=Callable[..., Any])


def checks(*labels: str) -> Callable[[Test], Test]:
    """Say which labelled formulas of the book a test checks. ``test_book`` finds formulas that none does."""

    def mark(test: Test) -> Test:
        test.formulas = labels  # type: ignore[attr-defined]
        return test

    return mark


def interpreted(routine: Any, known: dict[Any, Any] | None = None) -> Any:
    """The routine, and all that it calls, run by Python: it then takes symbols and exact fractions as well as floats."""
    known = {} if known is None else known
    if routine not in known:
        source = routine.py_func
        names = dict(source.__globals__)
        known[routine] = types.FunctionType(source.__code__, names, source.__name__, source.__defaults__)
        for name in source.__code__.co_names:
            value = names.get(name)
            if hasattr(value, "py_func"):
                names[name] = interpreted(value, known)
            elif isinstance(value, types.ModuleType) and value.__name__.startswith("atlasphys.engine"):
                members = {
                    key: interpreted(member, known) if hasattr(member, "py_func") else member
                    for key, member in vars(value).items()
                }
                names[name] = types.SimpleNamespace(**members)
    return known[routine]
