"""What users write into the bulk views of bodies, checked before the next step."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from atlasphys.engine.state.bodies import STATIC
from atlasphys.errors import InvalidArgumentError
from atlasphys.world.arguments import LARGEST_COORDINATE

if TYPE_CHECKING:
    from atlasphys.world.world import World


def check_written(world: World) -> None:
    """Check what the user has written into the bulk views since the last step."""
    state = world._state
    rows = state.written_rows()
    if len(rows) == 0:
        return
    bodies, before = state.bodies, state.remembered
    for column, now, then in (
        ("position", bodies.position[rows], before.position[rows]),
        ("orientation", bodies.orientation[rows], before.orientation[rows]),
        ("velocity", bodies.motion[rows, 0:3], before.motion[rows, 0:3]),
        ("angular_velocity", bodies.motion[rows, 3:6], before.motion[rows, 3:6]),
    ):
        # A quaternion of any length is normalised below; what was not written may have moved out of the range.
        limit = np.inf if column == "orientation" else LARGEST_COORDINATE
        wrong = rows[((now != then) & ~(np.isfinite(now) & (np.abs(now) <= limit))).any(axis=1)]
        if len(wrong):
            raise InvalidArgumentError(
                f"bodies.{column}[{wrong[0]}] was set to {getattr(world.bodies, column)[wrong[0]]}; "
                f"its numbers must be finite{'' if limit == np.inf else f' and at most {limit:g}'}"
            )
    orientation = bodies.orientation[rows].astype(np.float64)
    greatest = np.abs(orientation).max(axis=1, keepdims=True)
    wrong = rows[greatest[:, 0] == 0]
    if len(wrong):
        raise InvalidArgumentError(f"bodies.orientation[{wrong[0]}] was set to zero, which is no rotation")
    moving = rows[(bodies.kind[rows] == STATIC) & (bodies.motion[rows, 0:6] != 0).any(axis=1)]
    if len(moving):
        raise InvalidArgumentError(f"bodies.velocity[{moving[0]}]: the body is static and cannot move")
    orientation /= greatest
    lengths = np.sqrt((orientation**2).sum(axis=1, keepdims=True))
    changed = (np.abs(lengths * greatest - 1) > 1e-6)[:, 0]
    bodies.orientation[rows[changed]] = orientation[changed] / lengths[changed]
    for row in rows:
        state.wake(int(row))
    state.remember()
    state.stale = True
