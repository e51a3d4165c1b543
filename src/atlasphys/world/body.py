"""The handle of one body."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from atlasphys.engine.shapes.shape import Shape
from atlasphys.engine.state.bodies import AWAKE, DYNAMIC, KINDS, STATIC
from atlasphys.engine.state.pose import refresh
from atlasphys.errors import InvalidArgumentError, RemovedBodyError
from atlasphys.world.arguments import LOCKS, bits, bounded_vector, in_range, lock_bits, unit_quaternion

if TYPE_CHECKING:
    from atlasphys.world.world import World

FRICTION, RESTITUTION, ROLLING, TORSIONAL = range(4)
GRAVITY_SCALE, LINEAR_DAMPING, ANGULAR_DAMPING, NEVER_SLEEPS = range(4)

COEFFICIENTS = {
    "friction": (FRICTION, 0.0, 1e6),
    "restitution": (RESTITUTION, 0.0, 1.0),
    "rolling_friction": (ROLLING, 0.0, 1e6),
    "torsional_friction": (TORSIONAL, 0.0, 1e6),
}
"""Name → column in ``Colliders.material``, least and greatest value."""

RESPONSES = {
    "gravity_scale": (GRAVITY_SCALE, -1e6, 1e6),
    "linear_damping": (LINEAR_DAMPING, 0.0, 1e6),
    "angular_damping": (ANGULAR_DAMPING, 0.0, 1e6),
}
"""Name → column in ``Bodies.response``, least and greatest value."""

Vector = npt.NDArray[np.float64]


class Body:
    """One body of a world, made by :meth:`World.add`.

    A handle stays good while bodies are added and removed, and across snapshots. Once its body is gone it raises
    :class:`~atlasphys.errors.RemovedBodyError`; it never comes to mean another body. Arrays that it returns are read-only
    copies; assign to a property to change it.

    >>> import atlasphys as ap
    >>> world = ap.World()
    >>> ball = world.add(ap.Sphere(radius=0.5), position=(0, 3, 0), name="ball")
    >>> ball.velocity = (1, 0, 0)
    >>> ball
    <Body 'ball': dynamic Sphere(radius=0.5), position (0, 3, 0) m, velocity (1, 0, 0) m/s, mass 524 kg>
    """

    __slots__ = ("_id", "_row", "_world")

    def __init__(self, world: World, row: int) -> None:
        self._world = world
        self._row = row
        self._id = int(world._state.bodies.id[row])

    @property
    def row(self) -> int:
        """The body's present row in ``world.bodies`` and ``world.contacts``."""
        state = self._world._state
        if self._row >= state.count or state.bodies.id[self._row] != self._id:
            rows = np.flatnonzero(state.bodies.id[: state.count] == self._id)
            if len(rows) == 0:
                raise RemovedBodyError("this body is no longer in its world")
            self._row = int(rows[0])
        return self._row

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Body) and self._id == other._id and self._world is other._world

    def __hash__(self) -> int:
        return hash(self._id)

    def __repr__(self) -> str:
        try:
            row = self.row
        except RemovedBodyError:
            return "<Body: removed>"
        name = f" {self.name!r}" if self.name else f" {row}"
        state = f"position {_shown(self.position)} m"
        if self.kind != "static":
            state += f", velocity {_shown(self.velocity)} m/s"
        if self.kind == "dynamic":
            state += f", mass {self.mass:.3g} kg"
        return f"<Body{name}: {self.kind} {self.shape!r}, {state}>"

    # What it is ------------------------------------------------------------------------------------------------------

    @property
    def world(self) -> World:
        """The world that the body is in."""
        return self._world

    @property
    def name(self) -> str | None:
        """The body's name, unique in its world, or None."""
        return self._world._infos[self.row].name

    @property
    def color(self) -> tuple[float, float, float] | None:
        """Red, green and blue from 0 to 1, for pictures, or None."""
        return self._world._infos[self.row].color

    @property
    def kind(self) -> str:
        """``"dynamic"``, ``"static"`` or ``"kinematic"``."""
        return list(KINDS)[int(self._world._state.bodies.kind[self.row])]

    @property
    def shape(self) -> Shape:
        """The body's shape."""
        state = self._world._state
        return state.table.shapes[int(state.colliders.shape[self.row])]

    @property
    def mass(self) -> float:
        """Mass [kg]; infinite unless the body is dynamic."""
        row = self.row
        bodies = self._world._state.bodies
        return float(bodies.mass[row, 0]) if bodies.kind[row] == DYNAMIC else float("inf")

    @property
    def inertia(self) -> Vector:
        """Principal moments of inertia about the centre of mass [kg m²], (3,); infinite unless the body is dynamic."""
        row = self.row
        bodies = self._world._state.bodies
        moments = bodies.mass[row, 2:5].astype(np.float64) if bodies.kind[row] == DYNAMIC else np.full(3, np.inf)
        return _read_only(moments)

    @property
    def principal_axes(self) -> npt.NDArray[np.floating]:
        """Unit quaternion (w, x, y, z) from the principal axes of inertia, along which :attr:`inertia` is given, to the body's own frame, (4,)."""
        return _read_only(self._world._state.bodies.principal[self.row].copy())

    @property
    def center_of_mass(self) -> Vector:
        """Centre of mass in world axes [m], (3,). It differs from ``position`` for a cone, say."""
        row = self.row
        bodies = self._world._state.bodies
        refresh(bodies, row, row + 1)
        return _read_only(bodies.center[row].copy())

    # State -----------------------------------------------------------------------------------------------------------

    @property
    def position(self) -> Vector:
        """Origin of the body's own frame in world axes [m], (3,)."""
        return _read_only(self._world._state.bodies.position[self.row].copy())

    @position.setter
    def position(self, value: object) -> None:
        self._write("position", slice(None), bounded_vector("position", value))

    @property
    def orientation(self) -> npt.NDArray[np.floating]:
        """Unit quaternion (w, x, y, z) from the body's own frame to the world's, (4,). What is assigned is normalised."""
        return _read_only(self._world._state.bodies.orientation[self.row].copy())

    @orientation.setter
    def orientation(self, value: object) -> None:
        self._write("orientation", slice(None), unit_quaternion("orientation", value))

    @property
    def velocity(self) -> npt.NDArray[np.floating]:
        """Velocity of the centre of mass [m/s], (3,). That of a static body is zero and cannot be set."""
        return _read_only(self._world._state.bodies.motion[self.row, 0:3].copy())

    @velocity.setter
    def velocity(self, value: object) -> None:
        self._refuse_if_static("velocity")
        self._write("motion", slice(0, 3), bounded_vector("velocity", value))

    @property
    def angular_velocity(self) -> npt.NDArray[np.floating]:
        """Angular velocity in world axes [rad/s], (3,). That of a static body is zero and cannot be set."""
        return _read_only(self._world._state.bodies.motion[self.row, 3:6].copy())

    @angular_velocity.setter
    def angular_velocity(self, value: object) -> None:
        self._refuse_if_static("angular_velocity")
        self._write("motion", slice(3, 6), bounded_vector("angular_velocity", value))

    def _write(self, column: str, part: slice, value: tuple[float, ...]) -> None:
        row = self.row
        getattr(self._world._state.bodies, column)[row, part] = value
        self._world._state.take_over(column, row, part)

    def _refuse_if_static(self, name: str) -> None:
        if self._world._state.bodies.kind[self.row] == STATIC:
            raise InvalidArgumentError(f"{name} of a static body is always zero; make the body kinematic to move it")

    # Sleep -----------------------------------------------------------------------------------------------------------

    @property
    def asleep(self) -> bool:
        """Whether the body sleeps: it rests, with all that it touches, and is left out until something disturbs them."""
        return bool(self._world._state.bodies.island[self.row] != AWAKE)

    def wake(self) -> None:
        """Wake the body and its island. Setting its state or properties, forces, contact with a moving body and the removal of a neighbour do so
        too."""
        self._world._state.wake(self.row)

    @property
    def may_sleep(self) -> bool:
        """Whether the body may fall asleep, if its world lets bodies sleep. Assign False to keep it and what it touches awake."""
        return bool(self._world._state.bodies.response[self.row, NEVER_SLEEPS] == 0)

    @may_sleep.setter
    def may_sleep(self, value: object) -> None:
        if type(value) is not bool:
            raise InvalidArgumentError(f"may_sleep must be True or False (got {value!r})")
        self._world._state.bodies.response[self.row, NEVER_SLEEPS] = not value
        self._world._state.wake(self.row)

    # Forces ----------------------------------------------------------------------------------------------------------

    def apply_force(self, force: object, at: object = None) -> None:
        """Let a force act during the next step.

        Args:
            force: [N], world axes, (3,). Forces applied before the same step add up.
            at: point of attack in world axes [m], (3,). Default: the centre of mass.
        """
        row, vector, arm = self._push("force", force, at)
        applied = self._world._state.bodies.force
        self._world._state.forced = True
        self._world._state.wake(row)
        total = applied[row, 0:3] + np.array(vector)
        torque = applied[row, 4:7] + np.cross(arm, vector)
        self._store_finite(applied[row], "force", np.concatenate([total, [0.0], torque, [0.0]]))

    def apply_torque(self, torque: object) -> None:
        """Let a torque [N m], world axes, (3,), act during the next step. Torques applied before the same step add up."""
        row, vector, _ = self._push("torque", torque, None)
        applied = self._world._state.bodies.force
        self._world._state.forced = True
        self._world._state.wake(row)
        self._store_finite(applied[row, 4:7], "torque", applied[row, 4:7] + np.array(vector))

    def apply_impulse(self, impulse: object, at: object = None) -> None:
        """Change the velocities at once, as a blow would.

        Args:
            impulse: [N s], world axes, (3,).
            at: point of attack in world axes [m], (3,). Default: the centre of mass.
        """
        row, vector, arm = self._push("impulse", impulse, at)
        self._kick(row, "impulse", np.array(vector), np.cross(arm, vector))

    def apply_angular_impulse(self, impulse: object) -> None:
        """Change the angular velocity at once by an angular impulse [N m s], world axes, (3,)."""
        row, vector, _ = self._push("impulse", impulse, None)
        self._kick(row, "impulse", np.zeros(3), np.array(vector))

    def _push(self, name: str, value: object, at: object) -> tuple[int, tuple[float, float, float], Vector]:
        """The body's row, the checked vector, and the arm from the centre of mass to ``at``."""
        row = self.row
        if self._world._state.bodies.kind[row] != DYNAMIC:
            raise InvalidArgumentError(f"a {self.kind} body does not respond to forces; only a dynamic one does")
        vector = bounded_vector(name, value)
        if at is None:
            return row, vector, np.zeros(3)
        return row, vector, np.array(bounded_vector("at", at)) - self.center_of_mass

    def _kick(self, row: int, name: str, linear: Vector, angular: Vector) -> None:
        state = self._world._state
        refresh(state.bodies, row, row + 1)
        inverse = state.bodies.inverse_mass[row].astype(np.float64)
        tensor = inverse[[[0, 3, 4], [3, 1, 5], [4, 5, 2]]]
        turn = (tensor * angular).sum(axis=1)
        kicked = state.bodies.motion[row, 0:6] + np.concatenate([inverse[8:11] * linear, turn])
        self._store_finite(state.bodies.motion[row, 0:6], name, kicked)
        state.take_over("motion", row, slice(0, 6))

    @staticmethod
    def _store_finite(target: npt.NDArray[Any], name: str, value: Vector) -> None:
        """Store ``value`` unless it is too large for the world's precision."""
        with np.errstate(over="ignore"):
            rounded = value.astype(target.dtype)
        if not np.isfinite(rounded).all():
            raise InvalidArgumentError(f"{name} is too large: the body's state would overflow")
        target[...] = rounded

    # Properties that may change --------------------------------------------------------------------------------------

    @property
    def locks(self) -> tuple[str, ...]:
        """World axes along which (``"x"``, ``"y"``, ``"z"``) or about which (``"rx"``, ``"ry"``, ``"rz"``) the body cannot move if it is dynamic.
        A kinematic body moves with its velocity all the same."""
        value = self._world._state.bodies.locks[self.row]
        return tuple(name for bit, name in enumerate(LOCKS) if value & (1 << bit))

    @locks.setter
    def locks(self, value: object) -> None:
        self._world._state.bodies.locks[self.row] = lock_bits(value)
        self._world._state.properties_changed(self.row)

    @property
    def group(self) -> int:
        """Bits of the groups that the body belongs to, 32 of them."""
        return int(self._world._state.colliders.group[self.row])

    @group.setter
    def group(self, value: object) -> None:
        self._world._state.colliders.group[self.row] = bits("group", value)
        self._world._state.properties_changed(self.row)

    @property
    def mask(self) -> int:
        """Bits of the groups with which the body collides. Two bodies collide if each one's mask admits the other's group."""
        return int(self._world._state.colliders.mask[self.row])

    @mask.setter
    def mask(self, value: object) -> None:
        self._world._state.colliders.mask[self.row] = bits("mask", value)
        self._world._state.properties_changed(self.row)

    def _coefficient(self, name: str) -> float:
        return float(self._world._state.colliders.material[self.row, COEFFICIENTS[name][0]])

    def _set_coefficient(self, name: str, value: object) -> None:
        column, least, greatest = COEFFICIENTS[name]
        self._world._state.colliders.material[self.row, column] = in_range(name, value, least, greatest)
        self._world._state.properties_changed(self.row)

    def _response(self, name: str) -> float:
        return float(self._world._state.bodies.response[self.row, RESPONSES[name][0]])

    def _set_response(self, name: str, value: object) -> None:
        column, least, greatest = RESPONSES[name]
        self._world._state.bodies.response[self.row, column] = in_range(name, value, least, greatest)
        self._world._state.wake(self.row)

    @property
    def friction(self) -> float:
        """Coefficient of Coulomb friction μ ≥ 0, combined with the other body's by ``world.friction_combine``."""
        return self._coefficient("friction")

    @friction.setter
    def friction(self, value: object) -> None:
        self._set_coefficient("friction", value)

    @property
    def restitution(self) -> float:
        """Coefficient of restitution from 0 (no bounce) to 1 (no loss), combined by ``world.restitution_combine``."""
        return self._coefficient("restitution")

    @restitution.setter
    def restitution(self, value: object) -> None:
        self._set_coefficient("restitution", value)

    @property
    def rolling_friction(self) -> float:
        """Lever arm of rolling resistance [m]: the torque against rolling is at most this times the normal force."""
        return self._coefficient("rolling_friction")

    @rolling_friction.setter
    def rolling_friction(self, value: object) -> None:
        self._set_coefficient("rolling_friction", value)

    @property
    def torsional_friction(self) -> float:
        """Effective radius of the contact patch [m]: the torque against spinning on it is at most μ times this times the normal force."""
        return self._coefficient("torsional_friction")

    @torsional_friction.setter
    def torsional_friction(self, value: object) -> None:
        self._set_coefficient("torsional_friction", value)

    @property
    def gravity_scale(self) -> float:
        """Factor on the world's gravity; 0 floats, −1 rises."""
        return self._response("gravity_scale")

    @gravity_scale.setter
    def gravity_scale(self, value: object) -> None:
        self._set_response("gravity_scale", value)

    @property
    def linear_damping(self) -> float:
        """Rate c [1/s] at which the velocity decays, v̇ = −c v."""
        return self._response("linear_damping")

    @linear_damping.setter
    def linear_damping(self, value: object) -> None:
        self._set_response("linear_damping", value)

    @property
    def angular_damping(self) -> float:
        """Rate c [1/s] at which the angular velocity decays, ω̇ = −c ω."""
        return self._response("angular_damping")

    @angular_damping.setter
    def angular_damping(self, value: object) -> None:
        self._set_response("angular_damping", value)


def _read_only(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    array.flags.writeable = False
    return array


def _shown(vector: npt.NDArray[Any]) -> str:
    return "(" + ", ".join(f"{x:.4g}" for x in vector) + ")"
