"""Case 29: fast bodies against a thin wall. Not offered: without continuous collision a body may pass through what it crosses within one step."""

from __future__ import annotations

from atlasphys.validate.case import Case, MakeWorld


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Nothing to measure."""
    raise NotImplementedError(CASE.not_offered)


CASE = Case(
    number=29,
    name="thin wall",
    law="no body of any speed and angle passes through a wall",
    measure=measure,
    tolerances={},
    not_offered="there is no continuous collision detection: a body that crosses a wall within one step is not stopped",
)
