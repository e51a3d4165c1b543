"""How fast a coordinate changes on average over a substep. Over lanes.

A coordinate C of bodies that move with velocities v for a time h changes by

    C(q + h v) − C(q) = h J(q + ½ h v) v + O(h³),

and by h J(q) v only to first order: an anchor that runs round at the speed u and a distance r flies off its circle by ½ h² u²/r. Where impulses along
J(q) make J(q + ½ h v) v zero, and once the bodies have moved, impulses along J(q + h v) make J(q + h v) v zero, that is the leapfrog scheme RATTLE
(H. C. Andersen, J. Comput. Phys. 52, 1983; with the velocity as of half a step earlier), which is reversible and of order 2, so that swinging bodies
keep their energy.

Only the arms of points, distances and pulleys are carried on (CARRIED_ON). Parts of rotation alone stay satisfied while both bodies turn together.
Lines and translations act on levers as long as the two anchors are apart: a slider that begins six metres off its line blew up with the mean rate.

**What substeps do not resolve.** Leapfrog schemes are not stable where something swings faster than the steps resolve. A load T on an arm r lets a
body of inertia I swing at the frequency √(T r/I): of balls in a net of a hundred rows, which bear a thousand times their weight, h² T r/I is above 1.
And what one sweep leaves of the rates after a fast turn is energy that it gained. So arms are carried on by less, the larger these are, down to J(q),
which loses energy. As the share that is left out is of second order, the order of the scheme stays.
"""

from __future__ import annotations

from typing import Any

from atlasphys.engine.joints.ends import Ends
from atlasphys.engine.simd import full, maximum, minimum, vec
from atlasphys.engine.state.joints import DISTANCE, POINT, PULLEY

CARRIED_ON = (POINT, DISTANCE, PULLEY)
"""Types of parts that are solved for their mean rate."""

MOST_SWING = 0.4
"""Value of h² T r/I up to which arms are carried on; from √2 times as much on they are not. At 0.8 a net of 100 × 100 balls stretches by a half
more."""

TURN_LOSS = 200.0
"""Share by which arms are carried on less, over the square of half the angle turned in a substep. At 50 two bodies that spin about a hinge at 25 to
50 rad/s gain some per cent of their energy a second on `soft_step` and `xpbd`; at 400 whips stretch as much as if arms were not carried on."""


def carried(arm: Any, spin: Any, half: Any, inverse_inertia: Any, load: Any) -> Any:
    """What half a substep adds to the mean of an arm, ½ (R r − r) with the turn R by h ω, to third order: t × r + t × (t × r) with t = ½ h ω.
    ``load`` is the square of the impulse that the arm bears."""
    t = vec.scale(spin, half)
    u = vec.cross(t, arm)
    lightness = half * (inverse_inertia[0] + inverse_inertia[1] + inverse_inertia[2])
    swing = lightness * lightness * load * vec.length_squared(arm) * (2 / (3 * MOST_SWING)) ** 2
    share = minimum(2 - swing, 1) - TURN_LOSS * vec.length_squared(t)
    return vec.scale(vec.add(u, vec.cross(t, u)), maximum(share, full(share, 0)))


def halfway(kind: int, ends: Ends, velocity: Any, half: Any, inertias: Any, load: Any) -> Ends:
    """The ends of a part of a type in the middle of a substep, if the bodies keep their velocities v_a, ω_a, v_b, ω_b for the time ``half``.
    ``inertias`` are the inverse ones of the two."""
    v_a, w_a, v_b, w_b = velocity
    moved_a = carried(ends.arm_a, w_a, half, inertias[0], load)
    moved_b = carried(ends.arm_b, w_b, half, inertias[1], load)
    ends = ends._replace(arm_a=vec.add(ends.arm_a, moved_a), arm_b=vec.add(ends.arm_b, moved_b))
    if kind == PULLEY:
        ropes = zip(ends.ropes, (v_a, v_b), (moved_a, moved_b), strict=True)
        ends = ends._replace(ropes=tuple(vec.add(vec.add_scaled(rope, v, half), moved) for rope, v, moved in ropes))
    elif kind != POINT:
        passed = vec.add_scaled(vec.sub(moved_b, moved_a), vec.sub(v_b, v_a), half)
        ends = ends._replace(apart=vec.add(ends.apart, passed))
    return ends
