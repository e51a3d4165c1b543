"""Cases 10 and 11 share this: the motion of a torque-free body seen in its own axes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from atlasphys.engine.shapes.shape import Shape
from atlasphys.validate.case import MakeWorld

Array = npt.NDArray[np.float64]


class Spin(NamedTuple):
    """A body's free rotation, a row for every step."""

    times: Array
    """(n,) [s]."""
    body_spin: Array
    """(n, 3) angular velocity in the body's axes [rad/s]."""
    world_momentum: Array
    """(n, 3) angular momentum over mass in world axes [m²/s]."""
    energy: Array
    """(n,) kinetic energy over mass [m²/s²]."""


def rotate(q: Array, v: Array) -> Array:
    """q v q* for rows of unit quaternions and vectors."""
    t = 2 * np.cross(q[:, 1:], v)
    turned: Array = v + q[:, :1] * t + np.cross(q[:, 1:], t)
    return turned


def spin_freely(
    make_world: MakeWorld, shape: Shape, moments: Array, spin: tuple[float, float, float], seconds: float, dt: float
) -> Spin:
    """Spin a body of 1 kg, with these moments of inertia about its axes, in empty space."""
    world = make_world(gravity=(0, 0, 0))
    world.add(shape, mass=1, angular_velocity=spin)
    steps = round(seconds / dt)
    orientation, velocity = np.zeros((steps + 1, 4)), np.zeros((steps + 1, 3))
    for n in range(steps + 1):
        orientation[n], velocity[n] = world.bodies.orientation[0], world.bodies.angular_velocity[0]
        if n < steps:
            world.step(dt)
    in_body = rotate(orientation * np.array([1, -1, -1, -1]), velocity)
    momentum = rotate(orientation, moments * in_body)
    energy: Array = 0.5 * (velocity * momentum).sum(axis=1)
    times: Array = dt * np.arange(steps + 1, dtype=np.float64)
    return Spin(times, in_body, momentum, energy)


def drift(values: Array) -> float:
    """Greatest change of a quantity since the first row, relative to its size there."""
    return float(np.abs(values - values[0]).max() / np.abs(values[0]).max())
