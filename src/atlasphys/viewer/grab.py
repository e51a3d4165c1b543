"""Dragging a body: a damped spring between a point of it and the pointer."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from atlasphys.world.rotation import conjugate, rotate

if TYPE_CHECKING:
    from atlasphys.world.body import Body

FREQUENCY = 12.0
"""Natural angular frequency of the spring with the body's mass [rad/s]. Larger: the body follows the pointer more tightly."""

LARGEST_TURN = 0.3
"""Most of that frequency times the step; beyond 1 an explicit spring is unstable."""

SPIN_DAMPING = 3.0
"""Rate at which the grabbed body's rotation decays [1/s]."""

LARGEST_ACCELERATION = 1000.0
"""Of the body by the spring [m/s²]: a pull from afar shall not make it tunnel."""

Vector = npt.NDArray[np.float64]


class Grab:
    """A body held at a point.

    Args:
        body: a dynamic body.
        point: where it is held, world axes [m].
    """

    def __init__(self, body: Body, point: Vector) -> None:
        self.body = body
        self.target = point
        """Where the point is pulled to [m]."""
        q = np.asarray(body.orientation, np.float64)[None]
        self._local = rotate(conjugate(q), (point - body.position)[None])[0]

    @property
    def point(self) -> Vector:
        """Where the point now is [m]."""
        q = np.asarray(self.body.orientation, np.float64)[None]
        return np.asarray(self.body.position + rotate(q, self._local[None])[0])

    def pull(self, dt: float, gravity: Vector) -> None:
        """Apply the spring's force for the next step of ``dt`` seconds. It also carries the body's weight."""
        body = self.body
        point = self.point
        velocity = body.velocity + np.cross(body.angular_velocity, point - body.center_of_mass)
        omega = min(FREQUENCY, LARGEST_TURN / dt)
        acceleration = omega**2 * (self.target - point) - 2 * omega * velocity
        size = float(np.sqrt((acceleration**2).sum()))
        if size > LARGEST_ACCELERATION:
            acceleration *= LARGEST_ACCELERATION / size
        body.apply_force(body.mass * acceleration, at=point)
        body.apply_force(-body.mass * body.gravity_scale * gravity)
        body.apply_torque(-min(SPIN_DAMPING, 0.5 / dt) * float(body.inertia.min()) * body.angular_velocity)
