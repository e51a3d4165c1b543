"""Pairs known to be apart: they are not looked at again before their bodies have moved by the gap between them.

Each body's *travel* is the sum, over all steps, of the farthest that any of its points may have moved in the step. A pair found to be apart by
a gap can only come nearer by what its two bodies travel; so it is left alone until the sum of their travels has grown by the gap. In a pile at
rest, where bodies creep by micrometres and gaps are centimetres, that leaves next to nothing to do for pairs that do not touch.

What is left out would have given no contact: so results do not depend on it, and it is neither hashed nor part of snapshots. Sums are in
double precision, since micrometres are added to metres.
"""

import math

from atlasphys.engine.jit import routine

INEXACT = 1e-3
"""Part of the sizes of two shapes by which a gap between them is taken to be smaller than it was found to be. It covers round-off, and the edges that
the separating axis test takes for parallel (``sat.PARALLEL_SQUARED``). Smaller: a contact could begin a step late. Larger: pairs are looked at
more often."""


ROUND_OFF = 1e-5
"""The same as a part of the gap, which may be far greater than the shapes."""


@routine
def certain(gap, size):
    """A gap as a narrow phase found it, less what it may be wrong by; at least 0. ``size`` is the sum of the two shapes' extents [m]."""
    return max(gap * type(gap)(1 - ROUND_OFF) - type(gap)(INEXACT) * size, type(gap)(0))


@routine
def certain_gap(gap, shapes, pair):
    """A gap between two shapes as a narrow phase found it, less what it may be wrong by; at least 0."""
    return certain(gap, shapes.extent[pair[0]] + shapes.extent[pair[1]])


@routine
def add_travel(i, bodies, remembered, extent, travel):
    """Add to the travel of body i what the step has moved it since its pose was remembered.

    A turn by the angle θ moves a point at the distance r by 2 r sin(θ/2), which is at most 2 r |q − q'| of the unit quaternions, |q − q'| being
    2 sin(θ/4). ``extent`` is the greatest distance of a point of a body's shape from the body's position [m].
    """
    moved = turned = opposite = 0.0
    for k in range(3):
        d = bodies.position[i, k] - remembered.position[i, k]
        moved += d * d
    for k in range(4):
        now, then = float(bodies.orientation[i, k]), float(remembered.orientation[i, k])
        turned += (now - then) * (now - then)
        opposite += (now + then) * (now + then)
    travel[i] += math.sqrt(moved) + 2.0 * extent[i] * math.sqrt(min(turned, opposite))
