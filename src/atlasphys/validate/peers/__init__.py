"""Other engines under validation: each speaks as much of ``ap.World``'s language as the cases use, so that one case file serves all.

An engine keeps its own defaults but for what a case fixes: gravity, the time step, coefficients, masses and moments of inertia, that bounces
have no threshold speed, that nothing sleeps and nothing is damped. What its Python interface cannot express raises ``NotOfferedError``.
"""

from __future__ import annotations

import dataclasses
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any, NamedTuple, NoReturn

import numpy as np
import numpy.typing as npt

from atlasphys.engine.joints.kinds.kind import JointKind
from atlasphys.engine.shapes.mass import mass_properties
from atlasphys.engine.shapes.plane import Plane
from atlasphys.engine.shapes.shape import Shape
from atlasphys.validate.case import NotOfferedError
from atlasphys.world.rotation import conjugate, rotate
from atlasphys.world.views import Energy

Doubles = npt.NDArray[np.float64]


Vector = tuple[float, float, float]


class Item(NamedTuple):
    """A body as a case describes it."""

    shape: Any
    static: bool
    position: Vector
    orientation: tuple[float, float, float, float]
    """Unit quaternion (w, x, y, z)."""
    velocity: Vector
    angular_velocity: Vector
    mass: float
    moments: Vector
    """Of inertia about the shape's axes [kg m²]."""
    friction: float
    restitution: float
    torsional_friction: float
    rolling_friction: float


class Contacts(NamedTuple):
    """What cases read of the contacts of the last step."""

    body_a: npt.NDArray[np.int32]
    body_b: npt.NDArray[np.int32]
    """The higher row of the two."""
    depth: Doubles
    normal_impulse: Doubles
    """Over the whole step [N s]."""


class Rows(NamedTuple):
    """All bodies, in the order in which they were added."""

    position: Doubles
    orientation: Doubles
    velocity: Doubles
    angular_velocity: Doubles
    mass: Doubles
    """0 for static bodies."""

    def __len__(self) -> int:
        return len(self.position)


class PeerBody:
    """A body's handle."""

    def __init__(self, world: PeerWorld, row: int) -> None:
        self._world, self.row = world, row

    def __getattr__(self, column: str) -> Any:
        if column not in Rows._fields:
            raise AttributeError(column)
        return getattr(self._world.bodies, column)[self.row].copy()


class PeerJoint(NamedTuple):
    """A joint's handle."""

    world: Any
    native: Any

    @property
    def reaction_force(self) -> Doubles:
        """As ``Joint.reaction_force``, but for its sign."""
        return np.array(self.world._force(self.native), float)


class PeerWorld:
    """A world of another engine. Its file overrides what begins with an underscore here."""

    substeps = 1
    """Steps that the engine's integrator takes in a step."""
    solver_settings = None

    def __init__(
        self,
        *,
        gravity: tuple[float, float, float] = (0.0, -9.81, 0.0),
        precision: str = "single",
        restitution_threshold: float = 0.0,
        sleeping: bool = False,
        length_unit: float = 1.0,
    ) -> None:
        self.gravity = _vector(gravity)
        self.time = 0.0
        self._items: list[Item] = []
        self._rows: Rows | None = None
        with quiet():
            self._start()

    def add(
        self,
        shape: Shape,
        *,
        position: Any = (0.0, 0.0, 0.0),
        orientation: Any = (1.0, 0.0, 0.0, 0.0),
        velocity: Any = (0.0, 0.0, 0.0),
        angular_velocity: Any = (0.0, 0.0, 0.0),
        mass: float | None = None,
        density: float | None = None,
        inertia: Any = None,
        kind: str = "dynamic",
        friction: float = 0.5,
        restitution: float = 0.0,
        torsional_friction: float = 0.0,
        rolling_friction: float = 0.0,
    ) -> PeerBody:
        """Add a body, as ``World.add`` does."""
        static = kind == "static" or isinstance(shape, Plane)
        weight, moments = 0.0, (0.0, 0.0, 0.0)
        if not static:
            properties = mass_properties(shape, mass=mass, density=_density(mass, density), inertia=inertia)
            if properties.principal != (1.0, 0.0, 0.0, 0.0) or any(properties.center):
                raise NotImplementedError("bodies whose principal axes are not their shape's")
            weight, moments = properties.mass, properties.moments
        w, x, y, z = np.array(orientation, float) / np.linalg.norm(orientation)
        item = Item(
            shape, static, _vector(position), (float(w), float(x), float(y), float(z)), _vector(velocity), _vector(angular_velocity),
            weight, moments, friction, restitution, torsional_friction, rolling_friction,
        )  # fmt: skip
        with quiet():
            self._add(item)
        self._items.append(item)
        self._rows = None
        return PeerBody(self, len(self._items) - 1)

    def join(self, joint: JointKind) -> PeerJoint:
        """Make a joint, as ``World.join`` does; its second body is one of the world's."""
        rows = [None if end is None else int(end.row) for end in (joint.a, joint.b)]
        a, b = (None if row is None else (self._items[row].position, self._items[row].orientation) for row in rows)
        placed = dataclasses.replace(joint, a=None, b=None).placed(a, b)
        assert rows[1] is not None
        with quiet():
            return PeerJoint(self, self._join(rows[0], rows[1], placed))

    def step(self, dt: float) -> None:
        """Advance by one step of dt [s]."""
        self._step(dt)
        self.time += dt
        self._rows = None

    def run(self, seconds: float, dt: float) -> None:
        """Take the steps of dt that make up the time [s]."""
        for _ in range(round(seconds / dt)):
            self.step(dt)

    @property
    def bodies(self) -> Rows:
        """All bodies' state after the last step."""
        if self._rows is None:
            n = len(self._items)
            self._rows = Rows(np.zeros((n, 3)), np.zeros((n, 4)), np.zeros((n, 3)), np.zeros((n, 3)), np.zeros(n))
            self._rows.orientation[:, 0] = 1
            for row, item in enumerate(self._items):
                if item.static:
                    self._rows.position[row], self._rows.orientation[row] = item.position, item.orientation
                else:
                    self._rows.mass[row] = item.mass
                    for column, value in zip(self._rows, self._read(row), strict=False):
                        column[row] = value
        return self._rows

    @property
    def contacts(self) -> Contacts:
        """Contact points of the last step."""
        found = self._contacts()
        columns = list(zip(*found, strict=True)) or [(), (), (), ()]
        a, b = np.array(columns[0], np.int32), np.array(columns[1], np.int32)
        return Contacts(np.minimum(a, b), np.maximum(a, b), np.array(columns[2], float), np.array(columns[3], float))

    def energy(self) -> Energy:
        """As ``World.energy``."""
        rows = self.bodies
        spin_energy = 0.5 * (rows.angular_velocity * self._spin_momentum()).sum()
        kinetic = 0.5 * (rows.mass * (rows.velocity**2).sum(axis=1)).sum() + spin_energy
        return Energy(float(kinetic), -float((rows.mass * (rows.position @ np.array(self.gravity))).sum()))

    def momentum(self) -> Doubles:
        """As ``World.momentum``."""
        total: Doubles = (self.bodies.mass[:, None] * self.bodies.velocity).sum(axis=0)
        return total

    def angular_momentum(self) -> Doubles:
        """As ``World.angular_momentum``, about the origin."""
        rows = self.bodies
        orbital = np.cross(rows.position, rows.mass[:, None] * rows.velocity)
        total: Doubles = (orbital + self._spin_momentum()).sum(axis=0)
        return total

    def _spin_momentum(self) -> Doubles:
        rows = self.bodies
        moments = np.array([item.moments for item in self._items])
        return rotate(rows.orientation, moments * rotate(conjugate(rows.orientation), rows.angular_velocity))

    # What an engine's file provides ----------------------------------------------------------------------------------

    def _start(self) -> None:
        """Make an empty world."""
        raise NotImplementedError

    def _add(self, item: Item) -> None:
        """Add a body; its row is the number of items so far."""
        raise NotImplementedError

    def _join(self, a: int | None, b: int, joint: JointKind) -> Any:
        """Make a joint, which says anchors and axes in those of the bodies' rows (None: the world); return what ``_force`` needs."""
        raise NotImplementedError

    def _force(self, joint: Any) -> Any:
        """Force of a joint on its body b in the last step [N], world axes; its sign is not relied on."""
        raise NotOfferedError("its Python interface does not tell the forces of joints")

    def _step(self, dt: float) -> None:
        raise NotImplementedError

    def _read(self, row: int) -> tuple[Any, Any, Any, Any]:
        """Position, orientation (w, x, y, z), velocity and angular velocity of a body that is not static."""
        raise NotImplementedError

    def _contacts(self) -> list[tuple[int, int, float, float]]:
        """Rows of a and b, depth and normal impulse over the step of every contact point."""
        raise NotImplementedError


def refuse_rolling(item: Item, *, torsional: bool = True) -> None:
    """Raise for an engine without rolling (and torsional) friction."""
    if item.rolling_friction:
        raise NotOfferedError("its Python interface has no rolling friction")
    if torsional and item.torsional_friction:
        raise NotOfferedError("its Python interface has no torsional friction")


def refuse_joint(joint: JointKind) -> NoReturn:
    """Raise for an engine without a kind of joint, or for settings of it that its file does not pass on."""
    raise NotOfferedError(f"its Python interface has no such {joint.type} joint")


def _density(mass: float | None, density: float | None) -> float | None:
    return 1000.0 if mass is None and density is None else density


def _vector(values: Any) -> Vector:
    x, y, z = values
    return float(x), float(y), float(z)


@contextmanager
def quiet() -> Iterator[None]:
    """Keep what native code prints off standard output, which is ours."""
    sys.stdout.flush()
    kept, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)


def world_of(name: str) -> type[PeerWorld]:
    """The class of a peer; imports what it needs."""
    with quiet():
        found: type[PeerWorld] = import_module(f"atlasphys.validate.peers.{name}").WORLD
    return found
