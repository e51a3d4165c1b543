"""Constraint parts, one a file: each says its coordinate C (``measure``) and its Jacobian (``rows``) at given ends. ``PARTS`` has them by type."""

from types import ModuleType

from atlasphys.engine.joints.parts import (
    axis,
    cone,
    coupling,
    cross,
    distance,
    line,
    lock,
    point,
    pulley,
    rotation,
    translation,
)
from atlasphys.engine.state.joints import AXIS, CONE, COUPLING, CROSS, FIRST_BLOCK_TYPE, LOCK, ROTATION

PARTS: tuple[ModuleType, ...] = (
    rotation,
    cone,
    cross,
    coupling,
    pulley,
    translation,
    distance,
    axis,
    lock,
    line,
    point,
)
"""By type, see ``state/joints.py``."""

TURNING = frozenset({ROTATION, CONE, CROSS, COUPLING, AXIS, LOCK})
"""Types of parts whose turns are torques about the anchors, rather than forces at them."""


def is_block(kind: int) -> bool:
    """Whether a part of a type holds a vector at zero, rather than driving one coordinate."""
    return kind >= FIRST_BLOCK_TYPE
