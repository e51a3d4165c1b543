"""Fat boxes that move with bodies in flight, at a constant velocity, for some steps ahead.

A body in flight, with neither contacts nor joints, goes on as it moves, or falls: all its box needs is room for what it turns and for the bend
of its way. The tree holds all that the box sweeps. Of two boxes whose sweeps overlap most never meet, those of bodies that fall one behind the other,
say; such pairs are left out. (Bounding volumes that move with time: S. Saltenis, C. S. Jensen, S. T. Leutenegger and M. A. Lopez, "Indexing the
positions of continuously moving objects", 2000.)

What is found holds until a body leaves its moving box, or a box has moved for as long as it was made for.
"""

import numpy as np

from atlasphys.engine.jit import kernel, routine

STEPS_OF_FLIGHT = 24
"""A fat box moves for at most so many steps, for fewer where there are pairs. Fewer: pairs are looked for more often. More: more bodies may meet in
that time."""

FEWEST_STEPS = 8
"""A fat box moves for so many steps however many pairs there are, unless the body is very fast: one that stays holds as long."""

LONGEST_FLIGHT = 0.4
"""Longest time that a fat box moves [s]. Less than a body must rest before it sleeps (``sleep.TIME_TO_SLEEP``): no step asks whether a sleeping body
is in its box."""

LEAST_SHARE = 0.95
"""Fat boxes move only if more than this part of the bodies that may move are in flight. Where bodies meet, a box that moves is left at the first
touch, and what it sweeps meets much; one that is stretched and stays holds its body longer."""

LONGEST_SWEEP = 24.0
"""A fat box sweeps at most so many bounding radii along an axis, or else moves for fewer steps: long boxes make a tree slow."""

ROUNDING = 1 + 2.0**-20
"""Factor on the sizes of boxes that are compared, for the rounding of their places."""

FOREVER = 2.0**100
"""How long a fat box holds that stays where it is [s]."""


def longest_flight(share: float, crowd: float, h: float) -> float:
    """For how long fat boxes are to move at most [s], in steps of ``h`` seconds, if ``share`` of the bodies are in flight and there were ``crowd``
    pairs for each. 0: they are to stay."""
    return min(max(STEPS_OF_FLIGHT / (1 + crowd), FEWEST_STEPS) * h, LONGEST_FLIGHT) if share > LEAST_SHARE else 0.0


@kernel
def note_flight(a, b, points, body, joined, flying):
    """Note in ``flying`` which bodies have neither contacts nor joints: all but those of the pairs of colliders ``a``, ``b`` that have ``points``,
    and those that are ``joined``, (n, 2) rows, −1 for the world."""
    flying[:] = 1
    for p in range(len(points)):
        if points[p] > 0:
            flying[body[a[p]]] = flying[body[b[p]]] = 0
    for joint in range(len(joined)):
        for end in range(2):
            if joined[joint, end] >= 0:
                flying[joined[joint, end]] = 0


@routine
def time_of_flight(speed, reach, longest, h, fattening):
    """How long the box of a body of that greatest speed along an axis and that bounding radius is to move [s], at most about ``longest``; 0: it is to
    stay.

    The box holds at the beginning of the step after that many whole steps of ``h`` seconds, also with round-off in the sum of them.
    """
    if not speed * longest > fattening:
        return 0.0
    return h * (int(min(longest, LONGEST_SWEEP * reach / speed) / h) + 0.25)


@kernel
def keep_meeting(pairs, fat):
    """Move those pairs to the front whose fat boxes may meet while both are good; return how many there are. The clock has just been started.

    Boxes that lie apart along an axis, on the same side now and at the end, do not meet: their way is straight.
    """
    found = 0
    for p in range(len(pairs)):
        a, b = pairs[p, 0], pairs[p, 1]
        time, apart = np.float64(min(fat.half[a, 6], fat.half[b, 6])), False
        for k in range(3):
            now = fat.center[b, k] - fat.center[a, k]
            then = now + (np.float64(fat.half[b, 3 + k]) - fat.half[a, 3 + k]) * time
            sizes = (np.float64(fat.half[a, k]) + fat.half[b, k]) * ROUNDING
            apart = apart or (now > sizes and then > sizes) or (now < -sizes and then < -sizes)
        pairs[found, 0], pairs[found, 1] = a, b
        found += 0 if apart else 1
    return found
