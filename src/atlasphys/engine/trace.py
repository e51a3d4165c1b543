"""Notes that algorithms take of themselves, for those who want to see each step (``atlasphys.explainer``).

An algorithm says ``if TRACED: note("gjk.support", point=w)``. Compiled, TRACED is a constant that is false: Numba drops the branch before it looks
at what is in it, and nothing of it is left in the machine code. ``explainer/plain.py`` runs the same source as plain Python, with TRACED true and
another ``note``. So a trace is of the engine's own code, and costs nothing where none is asked for.
"""

TRACED = False
"""Whether notes are taken."""


def note(kind: str, **values: object) -> None:
    """Note what an algorithm does: ``kind`` is its name and what happened, the values are those of its variables."""
