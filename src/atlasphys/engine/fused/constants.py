"""Numbers of a run of the fused step."""

from typing import NamedTuple

from atlasphys.engine.simd.by_address import by_address


@by_address
class Constants(NamedTuple):
    """Numbers of a run, in the world's precision."""

    h: float
    """Length of a substep [s]."""
    substeps: int
    slow: float
    """Speed below which a body counts as at rest [m/s]."""
    gravity: tuple[float, float, float]
    ratio: float
    """Factor on last step's impulses."""
    soft: tuple[float, float, float, float, float, float]
    """See solvers/soft_contact.py; zeros with another solver."""
    positions: tuple[float, float, float]
    """See ``solve_positions`` in solvers/xpbd_contact.py; zeros with another solver."""
    bounce: tuple[float, float, float, float, float]
    """Threshold [m/s], lengths of the step and of a substep [s], slop [m], finest relative error; see solvers/bounce_block.py."""
    recycling: tuple[float, float, float, float, float]
    """See manifold/recycle.py."""
    margin: float
    match_distance: float
    friction_rule: int
    restitution_rule: int
    joint_sweeps: int
    """Passes over the joints in a substep, before the relax pass."""
