"""Case 4: friction is isotropic.

Coulomb's cone is round: a block sent off in any direction goes as far, straight on, without turning. (A pyramid instead of the cone
lets it go √2 less far along the diagonals, and bends its path.)
"""

from __future__ import annotations

import math

from atlasphys.validate.case import Case, MakeWorld, relative
from atlasphys.validate.cases.sliding_block import STOPPING_DISTANCE, STOPPING_TIME, sliding_block

HEADINGS = 16


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Slide to rest in 16 headings, the block always facing x."""
    distance = drift = yaw = 0.0
    for i in range(HEADINGS):
        angle = 2 * math.pi * i / HEADINGS
        x, z = round(math.cos(angle), 15), round(math.sin(angle), 15)
        world, block = sliding_block(make_world, x, z)
        world.run(seconds=STOPPING_TIME + 0.5, dt=dt)
        along = block.position[0] * x + block.position[2] * z
        across = block.position[0] * z - block.position[2] * x
        distance = max(distance, relative(along, STOPPING_DISTANCE))
        drift = max(drift, abs(across / along))
        yaw = max(yaw, 2 * abs(block.orientation[2] / block.orientation[0]))
    return {"distance": distance, "sideways drift [rad]": drift, "yaw [rad]": yaw}


CASE = Case(
    number=4,
    name="isotropic friction",
    law="same distance in 16 headings; no yaw, no sideways drift",
    measure=measure,
    tolerances={"distance": 0.01, "sideways drift [rad]": 1e-3, "yaw [rad]": 1e-3},
)
