"""What cases with joints share: periods of what swings."""

from __future__ import annotations

import numpy as np

from atlasphys.validate.case import Doubles


def upward_crossings(times: Doubles, values: Doubles) -> Doubles:
    """When a quantity passes 0 upwards, interpolated linearly [s]."""
    i = np.flatnonzero((values[:-1] < 0) & (values[1:] >= 0))
    found: Doubles = times[i] - values[i] * (times[i + 1] - times[i]) / (values[i + 1] - values[i])
    return found


def mean_period(times: Doubles, values: Doubles) -> float:
    """Mean time from one passage through 0 upwards to the next [s]; infinite where there are none."""
    found = upward_crossings(times, values)
    return float((found[-1] - found[0]) / (len(found) - 1)) if len(found) > 1 else float("inf")
