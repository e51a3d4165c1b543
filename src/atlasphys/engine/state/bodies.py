"""Bodies: one row each, in the order in which they were added.

A body's own frame is its shape's frame. Its centre of mass may lie elsewhere, and its principal axes may be turned: the
columns ``local_center`` and ``principal`` say how. Positions are always double; the rest has the world's precision ("real").
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from atlasphys.engine.simd.by_address import by_address
from atlasphys.engine.state.arrays import aligned_zeros

STATIC, KINEMATIC, DYNAMIC = 0, 1, 2
"""Values of the column ``kind``: immovable; moved only by its own velocity; moved by forces and contacts."""

AWAKE = -1
"""Value of the column ``island`` for bodies that do not sleep."""

CHANGED = -1.0
"""Value of the column ``rest`` for static and kinematic bodies that were added, moved or given other properties since the last step."""

KINDS = {"static": STATIC, "kinematic": KINEMATIC, "dynamic": DYNAMIC}


@by_address
class Bodies(NamedTuple):
    """The table of bodies. Shapes are given for a capacity of n rows."""

    # State
    position: npt.NDArray[np.float64]
    """(n, 3) origin of the body's own frame [m]."""
    orientation: npt.NDArray[np.floating]
    """(n, 4) unit quaternion (w, x, y, z) from the body's own frame to the world's."""
    motion: npt.NDArray[np.floating]
    """(n, 16) one cache line in single precision: 0–2 velocity of the centre of mass [m/s], 3–5 angular velocity [rad/s],
    6–8 displacement and 9–11 rotation vector since the last collision detection, 12–15 unused."""
    force: npt.NDArray[np.floating]
    """(n, 8) 0–2 force [N] and 4–6 torque [N m] to act during the next step."""

    # Properties
    kind: npt.NDArray[np.int8]
    """(n,) STATIC, KINEMATIC or DYNAMIC."""
    mass: npt.NDArray[np.floating]
    """(n, 8) 0 mass [kg], 1 its inverse, 2–4 principal moments of inertia [kg m²], 5–7 their inverses; inverses are 0 unless dynamic."""
    local_center: npt.NDArray[np.floating]
    """(n, 3) centre of mass in the body's own frame [m]."""
    principal: npt.NDArray[np.floating]
    """(n, 4) unit quaternion from the principal axes of inertia to the body's own frame."""
    response: npt.NDArray[np.floating]
    """(n, 8) 0 gravity scale, 1 linear damping [1/s], 2 angular damping [1/s], 3 whether the body never sleeps."""
    locks: npt.NDArray[np.uint8]
    """(n,) bits 0–2: no motion along world x, y, z; bits 3–5: no rotation about them."""
    rest: npt.NDArray[np.floating]
    """(n,) how long the body has been at rest [s], where the world lets bodies sleep; or CHANGED, which what sleeps there must notice."""
    island: npt.NDArray[np.int32]
    """(n,) AWAKE, or lowest row of the sleeping island that the body belongs to."""
    id: npt.NDArray[np.int64]
    """(n,) identity of the body for handles, never used twice."""

    # Derived at the start of each step
    center: npt.NDArray[np.float64]
    """(n, 3) centre of mass [m]."""
    geometry: npt.NDArray[np.floating]
    """(n, 16) 0–8 rotation matrix of the body's own frame, row by row; 9–11 centre − position in world axes [m]; 12–15 the
    orientation."""
    inverse_mass: npt.NDArray[np.floating]
    """(n, 16) 0–5 inverse inertia in world axes, xx yy zz xy xz yz [1/(kg m²)]; 6 inverse mass [1/kg]; 7 unused; 8–10 inverse mass
    along world x, y, z; 11–15 unused. Inverse inertia and 8–10 are 0 along locked axes; column 6 knows no locks."""

    frame: npt.NDArray[np.floating]
    """(n, 8) 0–2 ``local_center``; 3 whether its angular velocity changes without torque (1) or not (0); 4–7 ``principal``."""
    drive: npt.NDArray[np.floating]
    """(n, 8) what a substep does to the velocities: 0–2 is added to v, which is then multiplied by 3; 4–6 and 7 likewise for ω."""


def empty_bodies(capacity: int, real: npt.DTypeLike) -> Bodies:
    """A table with room for ``capacity`` bodies."""
    n = capacity
    return Bodies(
        position=aligned_zeros((n, 3), np.float64),
        orientation=aligned_zeros((n, 4), real),
        motion=aligned_zeros((n, 16), real),
        force=aligned_zeros((n, 8), real),
        kind=aligned_zeros((n,), np.int8),
        mass=aligned_zeros((n, 8), real),
        local_center=aligned_zeros((n, 3), real),
        principal=aligned_zeros((n, 4), real),
        response=aligned_zeros((n, 8), real),
        locks=aligned_zeros((n,), np.uint8),
        rest=aligned_zeros((n,), real),
        island=np.full((n,), AWAKE, np.int32),
        id=aligned_zeros((n,), np.int64),
        center=aligned_zeros((n, 3), np.float64),
        geometry=aligned_zeros((n, 16), real),
        inverse_mass=aligned_zeros((n, 16), real),
        frame=aligned_zeros((n, 8), real),
        drive=aligned_zeros((n, 8), real),
    )
