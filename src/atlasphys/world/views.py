"""Views of many bodies or contacts at once, and events."""

from __future__ import annotations

import reprlib
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple, overload

import numpy as np
import numpy.typing as npt

from atlasphys.engine.state.bodies import AWAKE, DYNAMIC, KINDS
from atlasphys.engine.state.manifolds import DEPTH, LOCAL_A, LOCAL_B, NORMAL, POINT_COLUMNS, live_rows
from atlasphys.engine.state.state import State
from atlasphys.errors import InvalidArgumentError
from atlasphys.world.arguments import LARGEST_COORDINATE
from atlasphys.world.body import Body
from atlasphys.world.joint import Joint
from atlasphys.world.rotation import rotate

if TYPE_CHECKING:
    from atlasphys.world.world import World


class Energy(NamedTuple):
    """Energy of all dynamic bodies [J]."""

    kinetic: float
    potential: float
    """In the world's gravity, zero where the centre of mass is at the origin."""

    @property
    def total(self) -> float:
        """Kinetic and potential energy together."""
        return self.kinetic + self.potential


class Event(NamedTuple):
    """Something that happened during the last step."""

    kind: str
    """``"contact_begin"``, ``"contact_end"``, ``"sleep"``, ``"wake"`` or ``"joint_break"``."""
    a: Body | None
    """None only where a joint broke that tied a body to the world."""
    b: Body | None = None
    """The other body of a contact or joint."""
    joint: Joint | None = None
    """The joint that broke."""


class Bodies:
    """All bodies of a world: a sequence of handles, and arrays with a row for each body in the order in which they were added.

    ``position``, ``orientation``, ``velocity`` and ``angular_velocity`` are views of live memory, to be read and written. A view is
    good until the next ``add``, ``remove`` or ``restore``. What is written is noticed and checked at the next step, which raises
    :class:`~atlasphys.errors.InvalidArgumentError` and does nothing if it is not finite or would move a static body.
    The other arrays are read-only.

    >>> import atlasphys as ap
    >>> world = ap.World()
    >>> for i in range(3):
    ...     _ = world.add(ap.Sphere(radius=0.5), position=(2 * i, 1, 0))
    >>> world.bodies.position[:, 1] += 4
    >>> world.bodies.position
    array([[0., 5., 0.],
           [2., 5., 0.],
           [4., 5., 0.]])
    """

    __slots__ = ("_world",)

    def __init__(self, world: World) -> None:
        self._world = world

    def __len__(self) -> int:
        return self._world._state.count

    @overload
    def __getitem__(self, key: int | str) -> Body: ...
    @overload
    def __getitem__(self, key: slice) -> list[Body]: ...
    def __getitem__(self, key: int | str | slice) -> Body | list[Body]:
        """The body of a row or of a name, or the bodies of a range of rows."""
        if isinstance(key, str):
            for row, info in enumerate(self._world._infos):
                if info.name == key:
                    return Body(self._world, row)
            raise KeyError(f"no body is named {key!r}")
        if isinstance(key, slice):
            return [Body(self._world, row) for row in range(len(self))[key]]
        return Body(self._world, range(len(self))[key])

    def __iter__(self) -> Iterator[Body]:
        return iter([Body(self._world, row) for row in range(len(self))])

    def __repr__(self) -> str:
        return f"<Bodies: {len(self)}>"

    def _column(self, name: str, *part: slice, writable: bool = False) -> npt.NDArray[Any]:
        state = self._world._state
        view: npt.NDArray[Any] = getattr(state.bodies, name)[(slice(0, state.count), *part)]
        if not writable:
            view = view.view()
            view.flags.writeable = False
        return view

    def _write(self, view: npt.NDArray[Any], name: str, value: npt.ArrayLike) -> None:
        try:
            given = np.broadcast_to(np.asarray(value), view.shape)
        except ValueError as error:
            raise InvalidArgumentError(f"{name} takes an array of shape {view.shape}: {error}") from None
        if given.dtype.kind not in "iuf":
            raise InvalidArgumentError(f"{name} takes an array of real numbers (got one of {given.dtype})")
        with np.errstate(over="ignore"):
            rounded = given.astype(view.dtype)
        limit = np.inf if name == "orientation" else LARGEST_COORDINATE  # quaternions are normalised
        if not (np.isfinite(rounded) & (np.abs(rounded) <= limit)).all():
            most = "" if limit == np.inf else f", at most {limit:g}"
            raise InvalidArgumentError(f"{name} takes finite numbers{most} (got {reprlib.repr(value)})")
        view[...] = rounded

    @property
    def position(self) -> npt.NDArray[np.float64]:
        """(n, 3) origins of the bodies' own frames [m]; live."""
        return self._column("position", writable=True)

    @position.setter
    def position(self, value: npt.ArrayLike) -> None:
        self._write(self.position, "position", value)

    @property
    def orientation(self) -> npt.NDArray[np.floating]:
        """(n, 4) unit quaternions (w, x, y, z); live. Written ones are normalised at the next step."""
        return self._column("orientation", writable=True)

    @orientation.setter
    def orientation(self, value: npt.ArrayLike) -> None:
        self._write(self.orientation, "orientation", value)

    @property
    def velocity(self) -> npt.NDArray[np.floating]:
        """(n, 3) velocities of the centres of mass [m/s]; live."""
        return self._column("motion", slice(0, 3), writable=True)

    @velocity.setter
    def velocity(self, value: npt.ArrayLike) -> None:
        self._write(self.velocity, "velocity", value)

    @property
    def angular_velocity(self) -> npt.NDArray[np.floating]:
        """(n, 3) angular velocities in world axes [rad/s]; live."""
        return self._column("motion", slice(3, 6), writable=True)

    @angular_velocity.setter
    def angular_velocity(self, value: npt.ArrayLike) -> None:
        self._write(self.angular_velocity, "angular_velocity", value)

    @property
    def mass(self) -> npt.NDArray[np.floating]:
        """(n,) masses [kg]; 0 for static and kinematic bodies."""
        return self._column("mass")[:, 0]

    @property
    def inertia(self) -> npt.NDArray[np.floating]:
        """(n, 3) principal moments of inertia [kg m²]; 0 for static and kinematic bodies."""
        return self._column("mass")[:, 2:5]

    @property
    def kind(self) -> npt.NDArray[np.str_]:
        """(n,) ``"dynamic"``, ``"static"`` or ``"kinematic"``."""
        names: npt.NDArray[np.str_] = np.array(list(KINDS))[self._column("kind")]
        return names

    @property
    def id(self) -> npt.NDArray[np.int64]:
        """(n,) identity of each body: stays with it when rows move up, and is never given to another body."""
        return self._column("id")

    @property
    def asleep(self) -> npt.NDArray[np.bool_]:
        """(n,) whether each body sleeps."""
        sleeping: npt.NDArray[np.bool_] = self._column("island") != AWAKE
        return sleeping

    @property
    def names(self) -> list[str | None]:
        """The bodies' names, None where a body has none."""
        return [info.name for info in self._world._infos]


def events(world: World) -> list[Event]:
    """What happened in the last step."""
    state, body = world._state, world._state.colliders.body
    result = [
        Event(kind, Body(world, int(body[a])), Body(world, int(body[b])))
        for kind, pairs in (("contact_begin", state.began), ("contact_end", state.ended))
        for a, b in pairs
    ]
    for kind, rows in (("sleep", state.slept), ("wake", state.woke)):
        result += [Event(kind, Body(world, int(row))) for row in rows]
    broke = [Joint(world, int(row)) for row in state.joints.broke]
    return result + [Event("joint_break", joint.a, joint.b, joint) for joint in broke]


CONTACT = np.dtype(
    [
        ("body_a", np.int32),
        ("body_b", np.int32),
        ("point", np.float64, 3),
        ("normal", np.float64, 3),
        ("depth", np.float64),
        ("normal_impulse", np.float64),
        ("friction_impulse", np.float64, 3),
    ]
)


def contact_count(state: State) -> int:
    """Number of those records."""
    manifolds, count = state.manifolds, state.manifold_count
    return int(manifolds.count[:count][manifolds.touching[:count]].sum())


def contact_points(state: State) -> np.recarray[Any, Any]:
    """One record per contact point of the manifolds that touch."""
    manifolds, count = state.manifolds, state.manifold_count
    live = live_rows(manifolds, count)
    places, points = np.nonzero((np.arange(4) < manifolds.count[live, None]) & manifolds.touching[live, None])
    rows = live[places]
    a, b = state.colliders.body[manifolds.a[rows]], state.colliders.body[manifolds.b[rows]]
    first = POINT_COLUMNS * points
    records = np.zeros(len(rows), CONTACT)
    records["body_a"], records["body_b"] = a, b
    records["normal"] = manifolds.contact[rows, NORMAL : NORMAL + 3]
    records["depth"] = manifolds.points[rows, first + DEPTH]
    pushed = manifolds.total[rows, points].astype(np.float64)
    records["normal_impulse"] = pushed
    # Friction that acts on all points together is shared out as they are loaded.
    whole = manifolds.total[rows, :4].sum(axis=1, dtype=np.float64)
    share = np.where(whole > 0, pushed / np.where(whole > 0, whole, 1), 1 / manifolds.count[rows])
    together = manifolds.total[rows, 4:7] * share[:, None]
    records["friction_impulse"] = manifolds.friction_impulse.reshape(-1, 4, 3)[rows, points] + together
    # Seen from a body that cannot be a plane with a far-off origin
    bodies = state.bodies
    near_a = bodies.kind[a] == DYNAMIC
    body, column = np.where(near_a, a, b), first + np.where(near_a, LOCAL_A, LOCAL_B)
    arm = manifolds.local[rows[:, None], column[:, None] + np.arange(3)].astype(np.float64)
    orientation = bodies.orientation[body].astype(np.float64)
    records["point"] = bodies.position[body] + rotate(orientation, bodies.local_center[body] + arm)
    records.flags.writeable = False
    return records.view(np.recarray)
