"""Axial parts that are solved against what holds their joint together. Over lanes, or over plain numbers.

A hinge's limit stops the rotation of a door by a torque, and the door's middle, which still moves, then pulls at the point. Solved one after
the other, each undoes three quarters of what the other did, the impulses of a blow linger for many substeps, and the door comes back from its
limit. So an axial row J is solved as if the rigid block H of the same joint, which is visited after it, were at once solved for it: for the rate
that will be left,

    Ċ = (J − X H) v,   X = J M⁻¹ Hᵀ (H M⁻¹ Hᵀ)⁻¹,   K = (J − X H) M⁻¹ (J − X H)ᵀ,

the Schur complement of the two, in which no impulse of the block shows. K is that of the whole joint: of a door about its hinge, not its middle.
Impulses act along J as ever.
"""

from __future__ import annotations

from typing import Any

from atlasphys.engine.joints.ends import Ends
from atlasphys.engine.joints.parts import point
from atlasphys.engine.joints.rows import NONE, Row, combined, effects, masses, product
from atlasphys.engine.joints.symmetric import solve_symmetric
from atlasphys.engine.state.joints import CONE, CROSS, LOCK, POINT, ROTATION, TRANSLATION

HOLDERS = {ROTATION: POINT, CONE: POINT, CROSS: POINT, TRANSLATION: LOCK}
"""Type of the block that each type of axial part is solved against, if the joint has one that is rigid."""

AXES = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


def held_back(kind: int, row: Row, ends: Ends, inverse: Any) -> Row:
    """X H: what the block takes of an axial part's row. ``inverse`` are the inverse masses and inertias of the two bodies."""
    holders = point.rows(ends) if HOLDERS[kind] == POINT else [Row(NONE, e, NONE, e) for e in AXES]
    effect = effects(row, *inverse)
    return combined(holders, solve_symmetric(masses(holders, *inverse), [product(h, effect) for h in holders]))
