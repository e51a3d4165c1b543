"""Cases 10 and 11 share this: the motion of a torque-free body seen in its own axes."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

import atlasphys as ap
from atlasphys.engine.shapes.shape import Shape
from atlasphys.validate.case import MakeWorld


def in_body_axes(body: ap.Body) -> npt.NDArray[np.float64]:
    """The body's angular velocity in its own axes [rad/s], (3,): q* ω q."""
    w, *xyz = body.orientation.astype(np.float64)
    u, v = -np.array(xyz), body.angular_velocity.astype(np.float64)
    t = 2 * np.cross(u, v)
    turned: npt.NDArray[np.float64] = v + w * t + np.cross(u, t)
    return turned


def spin_freely(
    make_world: MakeWorld, shape: Shape, spin: tuple[float, float, float], seconds: float, dt: float
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], float, float]:
    """Spin a body in empty space: times (n,), angular velocities in its axes (n, 3), and the greatest relative changes of E and L."""
    world = make_world(gravity=(0, 0, 0))
    body = world.add(shape, mass=1, angular_velocity=spin)
    energy, momentum = world.energy().kinetic, world.angular_momentum()
    worst_energy = worst_momentum = 0.0
    times, spins = [0.0], [in_body_axes(body)]
    for _ in range(round(seconds / dt)):
        world.step(dt)
        times.append(world.time)
        spins.append(in_body_axes(body))
        worst_energy = max(worst_energy, abs(world.energy().kinetic / energy - 1))
        off = np.abs(world.angular_momentum() - momentum).max() / np.abs(momentum).max()
        worst_momentum = max(worst_momentum, float(off))
    return np.array(times), np.array(spins), worst_energy, worst_momentum
