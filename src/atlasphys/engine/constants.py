"""The tolerances of the engine in metres and metres per second: unit, reason, and what breaks if one changes.

Iteration limits and thresholds without a unit stand, with theirs, in the files that use them.

Lengths and speeds are for scenes whose bodies are about a metre across; ``World(length_unit=…)`` scales them all.
"""

from typing import NamedTuple

# Lengths [m] ---------------------------------------------------------------------------------------------------------

LINEAR_SLOP = 0.005
"""Overlap left uncorrected, so that resting contacts persist. Smaller: contacts flicker and stacks jitter. Larger: visible overlap."""

SPECULATIVE_MARGIN = 0.02
"""Gap under which a pair already gets contact points, so that the solver stops it at the surface, not below.
Smaller: fast bodies sink in before they are caught. Larger: more points to solve, and impacts felt a little early."""

MATCH_DISTANCE = 0.02
"""A contact point takes over the impulses of last step's point if no farther from it than this, measured on either body.
Smaller: warm starting is lost when feature ids flicker. Larger: a point may take over its neighbour's impulse."""

MAX_CORRECTION = 0.2
"""Greatest position correction of a contact in one iteration. Larger: deep overlaps are thrown apart instead of eased apart."""

# Speeds [m/s] --------------------------------------------------------------------------------------------------------

RESTITUTION_THRESHOLD = 1.0
"""Approach speed below which contacts do not bounce. Smaller: resting bodies rattle. Larger: slow bounces are lost."""

SLEEP_SPEED = 0.05
"""Speed below which a body counts as at rest. Smaller: piles that still creep never sleep. Larger: slow motion stops."""


class Tolerances(NamedTuple):
    """The lengths above, scaled to a world's length unit."""

    slop: float
    margin: float
    match_distance: float
    max_correction: float


def tolerances(length_unit: float) -> Tolerances:
    """The tolerances for bodies of about ``length_unit`` metres."""
    return Tolerances(
        slop=LINEAR_SLOP * length_unit,
        margin=SPECULATIVE_MARGIN * length_unit,
        match_distance=MATCH_DISTANCE * length_unit,
        max_correction=MAX_CORRECTION * length_unit,
    )
