"""Energy and momenta of all dynamic bodies together, in double precision whatever that of the world."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from atlasphys.engine.state.bodies import DYNAMIC
from atlasphys.engine.state.state import State
from atlasphys.world.rotation import Doubles, conjugate, rotate
from atlasphys.world.views import Energy


class Moving(NamedTuple):
    """The dynamic bodies, a row each."""

    mass: Doubles
    center: Doubles
    velocity: Doubles
    spin: Doubles
    """Angular velocity [rad/s]."""
    spin_momentum: Doubles
    """Angular momentum about the centre of mass [kg m²/s]."""
    gravity_scale: Doubles


def moving(state: State, motion: npt.NDArray[Any] | None = None) -> Moving:
    """What the totals are summed from; with other velocities than the state's, if they are given."""
    rows = np.flatnonzero(state.bodies.kind[: state.count] == DYNAMIC)
    columns = ("mass", "orientation", "principal", "local_center", "response")
    mass, q, p, local, response = (getattr(state.bodies, name)[rows].astype(np.float64) for name in columns)
    speeds = (state.bodies.motion if motion is None else motion)[rows].astype(np.float64)
    spin = speeds[:, 3:6]
    in_axes = rotate(conjugate(p), rotate(conjugate(q), spin))
    return Moving(
        mass=mass[:, 0],
        center=state.bodies.position[rows] + rotate(q, local),
        velocity=speeds[:, 0:3],
        spin=spin,
        spin_momentum=rotate(q, rotate(p, mass[:, 2:5] * in_axes)),
        gravity_scale=response[:, 0],
    )


def energy(state: State) -> Energy:
    """Kinetic and potential energy [J]."""
    bodies = moving(state)
    linear, angular = _kinetic(bodies)
    height = (bodies.center * np.array(state.environment.gravity)).sum(axis=1)
    return Energy(linear + angular, math.fsum(-bodies.mass * bodies.gravity_scale * height))


def kinetic(state: State, motion: npt.NDArray[Any]) -> tuple[float, float]:
    """Energy of translation and of rotation [J] of bodies that would move as ``motion`` says: velocities and angular velocities, (n, 6)."""
    return _kinetic(moving(state, motion))


def _kinetic(bodies: Moving) -> tuple[float, float]:
    linear = 0.5 * bodies.mass * (bodies.velocity**2).sum(axis=1)
    angular = 0.5 * (bodies.spin * bodies.spin_momentum).sum(axis=1)
    return math.fsum(linear), math.fsum(angular)


def momentum(state: State) -> Doubles:
    """Linear momentum [kg m/s], (3,)."""
    bodies = moving(state)
    total: Doubles = (bodies.mass[:, None] * bodies.velocity).sum(axis=0)
    return total


def angular_momentum(state: State, about: Doubles) -> Doubles:
    """Angular momentum about a point [kg m²/s], (3,)."""
    bodies = moving(state)
    orbital = np.cross(bodies.center - about, bodies.mass[:, None] * bodies.velocity)
    total: Doubles = (orbital + bodies.spin_momentum).sum(axis=0)
    return total
