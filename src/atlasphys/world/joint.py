"""The handle of one joint, and the view of all."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, overload

import numpy as np
import numpy.typing as npt

from atlasphys.engine.joints.compose import add_joint, change_joint, reactions
from atlasphys.engine.joints.frames import Pose, to_world
from atlasphys.engine.joints.kinds.kind import JointKind
from atlasphys.engine.joints.measure import coordinate
from atlasphys.engine.joints.part import Motor
from atlasphys.engine.state.bodies import DYNAMIC
from atlasphys.engine.state.joints import MOTOR_TOTAL, WORLD
from atlasphys.errors import InvalidArgumentError, RemovedJointError
from atlasphys.world.arguments import check_name
from atlasphys.world.body import Body

if TYPE_CHECKING:
    from atlasphys.world.world import World


@dataclasses.dataclass(frozen=True, slots=True)
class JointInfo:
    """What is known of a joint beside the physics."""

    kind: JointKind
    """The joint, placed; without its bodies."""
    name: str | None


class _Setting:
    """A setting of the joint's kind that may be changed while the world runs."""

    def __init__(self, doc: str) -> None:
        self.__doc__ = doc

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, joint: Any, owner: type) -> Any:
        if joint is None:
            return self
        if not hasattr(joint.settings, self._name):
            raise AttributeError(f"a {type(joint.settings).__name__} has no {self._name}")
        return getattr(joint.settings, self._name)

    def __set__(self, joint: Joint, value: Any) -> None:
        joint.change(**{self._name: value})


class Joint:
    """One joint of a world, made by :meth:`World.join`.

    A handle stays good while joints and bodies are added and removed, and across snapshots. Once its joint is gone (removed by itself or with one of
    its bodies) it raises :class:`~atlasphys.errors.RemovedJointError`. Joints of a kind have the settings of that kind: a hinge ``limits``, say;
    assigning to one wakes the bodies.

    >>> import atlasphys as ap
    >>> world = ap.World()
    >>> door = world.add(ap.Box(size=(1, 2, 0.05)), position=(0.5, 1, 0), mass=20, name="door")
    >>> hinge = world.join(ap.Hinge(None, door, anchor=(0, 1, 0), axis=(0, 1, 0), limits=(-1, 1)))
    >>> door.angular_velocity = (0, 3, 0)
    >>> door.velocity = (0, 0, -1.5)
    >>> world.run(seconds=2)
    >>> bool(abs(hinge.angle) < 1.01)
    True
    >>> hinge.limits = None
    """

    __slots__ = ("_id", "_row", "_world")

    def __init__(self, world: World, row: int) -> None:
        self._world = world
        self._row = row
        self._id = int(world._state.joints.rows.id[row])

    @property
    def row(self) -> int:
        """The joint's present place in ``world.joints``."""
        table = self._world._state.joints
        if self._row >= table.count or table.rows.id[self._row] != self._id:
            rows = np.flatnonzero(table.rows.id[: table.count] == self._id)
            if len(rows) == 0:
                raise RemovedJointError("this joint is no longer in its world")
            self._row = int(rows[0])
        return self._row

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Joint) and self._id == other._id and self._world is other._world

    def __hash__(self) -> int:
        return hash(self._id)

    def __repr__(self) -> str:
        try:
            row = self.row
        except RemovedJointError:
            return "<Joint: removed>"
        name = f" {self.name!r}" if self.name else f" {row}"
        ends = " to ".join("the world" if end is None else (end.name or f"body {end.row}") for end in (self.a, self.b))
        state = "broken" if self.broken else "" if self.enabled else "disabled"
        return f"<Joint{name}: {type(self.settings).__name__} of {ends}{', ' + state if state else ''}>"

    # What it is ------------------------------------------------------------------------------------------------------

    @property
    def world(self) -> World:
        """The world that the joint is in."""
        return self._world

    @property
    def id(self) -> int:
        """A number that no other joint of the world has or will have."""
        return self._id

    @property
    def name(self) -> str | None:
        """The joint's name, unique among joints of its world, or None."""
        return self._world._joint_infos[self.row].name

    @property
    def settings(self) -> JointKind:
        """The joint's kind with its present settings, anchors and axes in those of the bodies; its ``a`` and ``b`` are None."""
        return self._world._joint_infos[self.row].kind

    @property
    def a(self) -> Body | None:
        """The first body; None: the world."""
        return self._end(0)

    @property
    def b(self) -> Body | None:
        """The second body."""
        return self._end(1)

    def _end(self, side: int) -> Body | None:
        row = int(self._world._state.joints.rows.body[self.row, side])
        return None if row == WORLD else Body(self._world, row)

    @property
    def anchors(self) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Where its anchors on a and on b now are in the world [m], (3,) each. The joint holds them together, or in the relation that it allows."""
        points = [
            np.array(to_world(pose, anchor))
            for pose, anchor in zip(self._poses(), self.settings.anchors(), strict=True)
        ]
        for point in points:
            point.flags.writeable = False
        return points[0], points[1]

    # Settings --------------------------------------------------------------------------------------------------------

    def change(self, **settings: Any) -> None:
        """Give the joint other settings of its kind, several at once: ``joint.change(motor=None, friction=3)``.

        Raises:
            AttributeError: the kind has no such setting.
            InvalidArgumentError: a value is not of the right kind or out of range; the joint is unchanged.
        """
        row, info = self.row, self._world._joint_infos[self.row]
        known = {field.name for field in dataclasses.fields(info.kind)} - {"a", "b"}
        for name in settings:
            if name not in known:
                raise AttributeError(f"a {type(info.kind).__name__} has no {name}")
        kind = dataclasses.replace(info.kind, **settings).placed(*self._poses())
        self._world._joint_infos[row] = dataclasses.replace(info, kind=kind)
        change_joint(self._world._state, row, kind)

    limits = _Setting("Least and greatest value of its coordinate [rad, m], or None.")
    spring = _Setting("Spring on its coordinate: ``ap.Elastic(…)`` or None.")
    motor = _Setting("Motor on its coordinate: ``ap.Motor(…)`` or None.")
    friction = _Setting("Greatest force or torque of friction [N, N m].")
    twist = _Setting(
        "Least and greatest twist of a ball joint [rad], or None. (The present one is ``coordinate('twist')``.)"
    )
    cone = _Setting("Greatest angle of a ball joint's swing [rad], or None.")
    target = _Setting("Where a target pulls to [m], (3,).")
    steering = _Setting("Angle by which a wheel is steered [rad].")
    length = _Setting("Length of a rod or of a pulley's rope [m].")
    rest_length = _Setting("Length at which a spring does not act [m].")
    breaking_force = _Setting("Force at which the joint breaks [N].")
    breaking_torque = _Setting("Torque at which the joint breaks [N m].")
    collide = _Setting("Whether the two bodies collide with each other.")

    @property
    def motor_speed(self) -> float:
        """Speed that the motor drives to [rad/s, m/s]. Assign to change it; the joint must have a motor."""
        return float(self._motor("speed"))

    @motor_speed.setter
    def motor_speed(self, value: float) -> None:
        self.motor = dataclasses.replace(self._has_motor(), speed=value, position=None)

    @property
    def motor_position(self) -> float:
        """Position that the motor drives to [rad, m]. Assign to change it; the joint must have a motor."""
        return float(self._motor("position"))

    @motor_position.setter
    def motor_position(self, value: float) -> None:
        self.motor = dataclasses.replace(self._has_motor(), speed=None, position=value)

    @property
    def motor_max_force(self) -> float:
        """Greatest force or torque of the motor [N, N m]. Assign to change it."""
        return float(self._has_motor().max_force)

    @motor_max_force.setter
    def motor_max_force(self, value: float) -> None:
        self.motor = dataclasses.replace(self._has_motor(), max_force=value)

    def _has_motor(self) -> Motor:
        motor = self.motor
        if motor is None:
            raise InvalidArgumentError("the joint has no motor: assign ap.Motor(…) to its motor first")
        assert isinstance(motor, Motor)
        return motor

    def _motor(self, name: str) -> float:
        value = getattr(self._has_motor(), name)
        if value is None:
            raise InvalidArgumentError(f"the joint's motor drives to no {name}")
        return float(value)

    @property
    def enabled(self) -> bool:
        """Whether the joint acts. Assign to change it."""
        return bool(self._world._state.joints.rows.enabled[self.row])

    @enabled.setter
    def enabled(self, value: bool) -> None:
        if type(value) is not bool:
            raise InvalidArgumentError(f"enabled must be True or False (got {value!r})")
        row, table = self.row, self._world._state.joints
        table.rows.enabled[row] = value
        first, parts = table.rows.first[row], table.rows.parts[row]
        table.parts.impulse[first : first + parts] = 0
        table.parts.total[first : first + parts] = 0
        self._world._state.joints_changed(row)

    @property
    def broken(self) -> bool:
        """Whether the joint has broken. It stays so, and in the world, until it is removed, or mended by assigning False."""
        return bool(self._world._state.joints.rows.broken[self.row])

    @broken.setter
    def broken(self, value: bool) -> None:
        if type(value) is not bool:
            raise InvalidArgumentError(f"broken must be True or False (got {value!r})")
        row = self.row
        self._world._state.joints.rows.broken[row] = value
        self.enabled = self.enabled

    # What it does ----------------------------------------------------------------------------------------------------

    @property
    def reaction_force(self) -> npt.NDArray[np.float64]:
        """Mean force of the joint on b over the last step, all its substeps [N], world axes, (3,); on a acts its opposite."""
        return self._reaction(0)

    @property
    def reaction_torque(self) -> npt.NDArray[np.float64]:
        """Mean torque of the joint on b about b's anchor over the last step [N m], world axes, (3,)."""
        return self._reaction(3)

    @property
    def motor_force(self) -> float:
        """Mean force or torque of its motors (those that drive to a speed) over the last step [N, N m]."""
        return float(self._total()[MOTOR_TOTAL])

    def _reaction(self, column: int) -> npt.NDArray[np.float64]:
        mean = self._total()[column : column + 3]
        mean.flags.writeable = False
        return mean

    def _total(self) -> npt.NDArray[np.float64]:
        row, table = self.row, self._world._state.joints
        first = table.rows.first[row]
        total: npt.NDArray[np.float64] = table.parts.total[first : first + table.rows.parts[row]].sum(
            axis=0, dtype=np.float64
        )
        return total / table.elapsed if table.elapsed > 0 else total

    def _poses(self) -> tuple[Pose | None, Pose | None]:
        row = self.row
        a, b = (pose_of(self._world, int(end)) for end in self._world._state.joints.rows.body[row])
        return a, b

    def coordinate(self, name: str) -> float:
        """A coordinate by name [rad, m]: ``"angle"`` of a hinge, ``"rx"`` of a joint with six degrees of freedom."""
        return self._measure(name)[0]

    def rate(self, name: str) -> float:
        """Rate of a coordinate by name [rad/s, m/s]."""
        return self._measure(name)[1]

    def _measure(self, name: str) -> tuple[float, float]:
        kind, row, state = self.settings, self.row, self._world._state
        coordinates = kind.coordinates()
        if name not in coordinates:
            raise AttributeError(f"a {type(kind).__name__} has no coordinate {name!r}")
        return coordinate(state, row, coordinates[name], kind.anchors())

    @property
    def angle(self) -> float:
        """Angle of b against a about the axis, −π to π [rad]."""
        return self.coordinate("angle")

    @property
    def translation(self) -> float:
        """How far b's anchor is from a's along the axis [m]."""
        return self.coordinate("translation")

    @property
    def swing(self) -> float:
        """Angle between a ball joint's axis on a and on b [rad]."""
        return self.coordinate("swing")

    @property
    def distance(self) -> float:
        """Distance of the two anchors of a rod, rope or spring [m]."""
        return self.coordinate("length")

    @property
    def speed(self) -> float:
        """Rate of the coordinate: of the angle of a hinge or wheel, the translation of a slider, the distance of a rod or spring [rad/s, m/s]."""
        names = list(self.settings.coordinates())
        if not names:
            raise AttributeError(f"a {type(self.settings).__name__} has no coordinate")
        return self.rate("angle" if "angle" in names else names[0])


class Joints:
    """All joints of a world: a sequence of handles, in the order in which they were made, and arrays with a row for each."""

    __slots__ = ("_world",)

    def __init__(self, world: World) -> None:
        self._world = world

    def __len__(self) -> int:
        return self._world._state.joints.count

    @overload
    def __getitem__(self, key: int | str) -> Joint: ...
    @overload
    def __getitem__(self, key: slice) -> list[Joint]: ...
    def __getitem__(self, key: int | str | slice) -> Joint | list[Joint]:
        """The joint of a place or of a name, or the joints of a range of places."""
        if isinstance(key, str):
            for row, info in enumerate(self._world._joint_infos):
                if info.name == key:
                    return Joint(self._world, row)
            raise KeyError(f"no joint is named {key!r}")
        if isinstance(key, slice):
            return [Joint(self._world, row) for row in range(len(self))[key]]
        return Joint(self._world, range(len(self))[key])

    def __iter__(self) -> Iterator[Joint]:
        return iter([Joint(self._world, row) for row in range(len(self))])

    def __repr__(self) -> str:
        return f"<Joints: {len(self)}>"

    @property
    def id(self) -> npt.NDArray[np.int64]:
        """(n,) a number for each joint that no other joint of the world has or will have."""
        table = self._world._state.joints
        ids: npt.NDArray[np.int64] = _read_only(table.rows.id[: table.count])
        return ids

    @property
    def bodies(self) -> npt.NDArray[np.int32]:
        """(n, 2) rows of the two bodies of each joint; −1: the world."""
        table = self._world._state.joints
        rows: npt.NDArray[np.int32] = _read_only(table.rows.body[: table.count])
        return rows

    @property
    def acts(self) -> npt.NDArray[np.bool_]:
        """(n,) whether each joint is enabled and not broken."""
        acting: npt.NDArray[np.bool_] = _read_only(self._world._state.joints.active)
        return acting

    @property
    def reaction_force(self) -> npt.NDArray[np.float64]:
        """(n, 3) mean force of each joint on its body b over the last step [N]."""
        return self._reactions()[0]

    @property
    def reaction_torque(self) -> npt.NDArray[np.float64]:
        """(n, 3) mean torque of each joint on its body b about b's anchor over the last step [N m]."""
        return self._reactions()[1]

    def _reactions(self) -> list[npt.NDArray[np.float64]]:
        table = self._world._state.joints
        return [_read_only(sums / table.elapsed if table.elapsed > 0 else sums) for sums in reactions(table)]


def _read_only(array: Any) -> Any:
    view = array.view()
    view.flags.writeable = False
    return view


def pose_of(world: World, row: int) -> Pose | None:
    """Position and orientation of a body; None: the world."""
    if row == WORLD:
        return None
    bodies = world._state.bodies
    x, y, z = bodies.position[row].tolist()
    w, i, j, k = bodies.orientation[row].tolist()
    return (x, y, z), (w, i, j, k)


def check_ends(world: World, kind: JointKind) -> tuple[int, int]:
    """Rows of the two bodies of a joint that is to be made.

    Raises:
        InvalidArgumentError: they are not two bodies of this world, or a body and None, one of them dynamic.
        RemovedBodyError: one has been removed.
    """
    rows = []
    for name, end in (("a", kind.a), ("b", kind.b)):
        if end is None:
            rows.append(WORLD)
        elif isinstance(end, Body) and end.world is world:
            rows.append(end.row)
        elif isinstance(end, Body):
            raise InvalidArgumentError(f"{name} must be a body of this world (got {end!r} of another one)")
        else:
            raise InvalidArgumentError(
                f"{name} must be a body of this world, or None for the world itself (got {end!r})"
            )
    a, b = rows
    if a == b:
        what = "are both None" if a == WORLD else f"are both {kind.a!r}"
        raise InvalidArgumentError(f"a joint needs two different bodies, or a body and None; a and b {what}")
    kinds = world._state.bodies.kind
    if not any(row != WORLD and kinds[row] == DYNAMIC for row in rows):
        raise InvalidArgumentError("one of the two bodies of a joint must be dynamic; these cannot be moved by forces")
    return a, b


def join(world: World, joint: JointKind, name: str | None) -> Joint:
    """Do what ``World.join`` says."""
    if not isinstance(joint, JointKind) or not joint.type:
        raise InvalidArgumentError(f"joint must be a joint such as ap.Ball(a, b, anchor=(0, 1, 0)) (got {joint!r})")
    rows = check_ends(world, joint)
    if name is not None:
        check_name(name)
        if any(info.name == name for info in world._joint_infos):
            raise InvalidArgumentError(f"name {name!r} is already taken by another joint of this world")
    a, b = (pose_of(world, row) for row in rows)
    kind = dataclasses.replace(joint, a=None, b=None).placed(a, b)
    row = add_joint(world._state, kind, (world._generation << 32) + world._serial, rows)
    world._serial += 1
    world._joint_infos.append(JointInfo(kind, name))
    return Joint(world, row)
