"""A world with its controls, without a window: commands in, frames out. One thread at a time may use it."""

from __future__ import annotations

import dataclasses
import os
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from atlasphys.engine.joints.kinds.kind import JointKind
from atlasphys.engine.shapes.plane import Plane
from atlasphys.errors import AtlasPhysError, InvalidArgumentError, SceneError
from atlasphys.scene.build import describe_body
from atlasphys.scene.joints import describe_joint
from atlasphys.scene.load import load_scene, parse_scene
from atlasphys.scene.scene import Scene
from atlasphys.viewer.frame import Entry, Frame, Table
from atlasphys.viewer.grab import Grab
from atlasphys.viewer.history import History
from atlasphys.viewer.joints import JointsNow, JointTable, state_of
from atlasphys.viewer.meter import Meter
from atlasphys.world.arguments import bounded_vector, in_range
from atlasphys.world.body import Body
from atlasphys.world.joint import Joint
from atlasphys.world.rotation import conjugate, rotate
from atlasphys.world.settings import LONGEST_STEP, SHORTEST_STEP
from atlasphys.world.world import World

SLOWEST, FASTEST = 0.01, 100.0
"""Range of the speed factor."""

TOTALS_AGE = 0.19
"""How old energy and momentum in a frame may be while time runs [s]."""

EDITABLE = (
    "position", "orientation", "velocity", "angular_velocity", "friction", "restitution", "rolling_friction", "torsional_friction",
    "linear_damping", "angular_damping", "gravity_scale", "locks",
)  # fmt: skip
"""What can be changed of a body once it is there."""

WORLD_SETTINGS = ("gravity", "solver", "narrowphase", "broadphase", "threads", "sleeping")
EMPTY = {"bodies": [{"shape": {"type": "plane"}, "name": "ground"}], "name": "empty"}
"""What is there when no scene is loaded: the ground."""


class Session:
    """A world, its clock and what can be done to it.

    Time is simulated in fixed steps: :meth:`advance` collects the wall time that has passed and takes as many whole steps as fit into it. If the
    world is slower than that, time is dropped rather than owed.

    Args:
        world: the world. The session alone may use it from now on.
        title: name of what is shown.
        dt: length of a step [s].
    """

    def __init__(self, world: World, *, title: str = "world", dt: float = 1 / 60) -> None:
        self.contacts_wanted = self.totals_wanted = False
        """Whether frames shall hold contacts, and energy and momentum, which cost time."""
        self.joint_wanted: int | None = None
        """Id of the joint whose state frames shall hold."""
        self.body_wanted: int | None = None
        """Id of the body whose kinetic energy they shall hold."""
        self.speed = 1.0
        """Simulated seconds per second that are aimed at."""
        self.changes = 0
        """Grows with every change that a frame would show."""
        self._take_over(world, title, dt)

    @classmethod
    def from_scene(cls, scene: Scene, **settings: Any) -> Session:
        """A session of a scene's world, at its beginning. ``settings`` are arguments of ``World`` that replace the scene's."""
        return cls(scene.build(**settings), title=scene.name, dt=scene.dt)

    @classmethod
    def empty(cls) -> Session:
        """A session of a world with nothing but the ground."""
        return cls.from_scene(Scene(EMPTY["bodies"], name="empty"))  # type: ignore[arg-type]

    def _take_over(self, world: World, title: str, dt: float) -> None:
        self.world, self.title, self.dt = world, title, dt
        self.running, self.error = False, ""
        self.history, self.meter = History(), Meter()
        self.grab_held: Grab | None = None
        self._owed = 0.0
        self._initial = world.snapshot()
        self._changed_by_hand = True
        self._velocity_before = np.array(world.bodies.velocity)
        self._table: Table | None = None
        self._joint_table: JointTable | None = None
        self._last_totals: tuple[float, int, Any] = (0.0, -1, None)
        self.changes += 1

    # Time ------------------------------------------------------------------------------------------------------------

    def start(self) -> None:
        """Let time run."""
        self.running, self.error, self._owed = True, "", 0.0
        self.meter.restart()
        self.changes += 1

    def stop(self) -> None:
        """Stop time."""
        self.running = False
        self.meter.restart()
        self.changes += 1

    def step(self, count: int = 1) -> None:
        """Stop, and take single steps.

        Raises:
            AtlasPhysError: a step failed; the world is as it was before it.
        """
        self.stop()
        self.error = ""
        for _ in range(count):
            self._step()

    def step_back(self) -> None:
        """Stop, and return to the state before the last step.

        Raises:
            InvalidArgumentError: there is none, or it is too long ago.
        """
        self.stop()
        self.error = ""
        if self.world.steps == 0:
            raise InvalidArgumentError("this is the beginning: there is no step to go back")
        dt = self.history.step_back(self.world)
        if dt is None:
            raise InvalidArgumentError("cannot go back: the states of so long ago are no longer kept")
        self.dt = dt
        self._edited()

    def reset(self) -> None:
        """Stop, and return to the state before the first step. Settings stay as they are."""
        world, kept = self.world, self._world_settings()
        world.restore(self._initial)
        for name, value in self._world_settings().items():
            if value != kept[name]:
                setattr(world, name, kept[name])
        self._take_over(world, self.title, self.dt)

    def _world_settings(self) -> dict[str, Any]:
        values = {name: getattr(self.world, name) for name in WORLD_SETTINGS}
        return values | {"gravity": tuple(self.world.gravity.tolist()), "solver": self.world.solver_settings}

    def advance(self, elapsed: float, budget: float = 1 / 40) -> None:
        """Let ``elapsed`` seconds of wall time pass. Stepping ends after ``budget`` seconds of wall time, done or not.

        A step that fails stops time; the reason is in ``error``, and the world is as it was before that step.
        """
        if not self.running:
            return
        self._owed += elapsed * self.speed
        deadline = time.perf_counter() + budget
        while self._owed >= self.dt:
            try:
                self._step()
            except AtlasPhysError as error:
                self.stop()
                self.error = str(error)
                return
            self._owed -= self.dt
            if time.perf_counter() >= deadline:
                self._owed = min(self._owed, self.dt)
        self.meter.note_time(time.perf_counter(), self.world.time)

    @property
    def until_next_step(self) -> float:
        """Wall time until a step is due [s]."""
        return max(0.0, (self.dt - self._owed) / self.speed) if self.running else float("inf")

    def _step(self) -> None:
        held, world = self.grab_held, self.world
        self.history.before_step(world, self.dt, self._changed_by_hand or held is not None)
        before = np.array(world.bodies.velocity)
        if held is not None:
            held.pull(self.dt, world.gravity)
        world.step(self.dt)
        self._velocity_before, self._changed_by_hand = before, False
        self.meter.note_step(world.profile)
        self.changes += 1

    def set_speed(self, factor: float) -> None:
        """Set how many seconds are simulated in one, 0.01 to 100."""
        self.speed = in_range("speed", factor, SLOWEST, FASTEST)
        self.meter.restart()
        self.changes += 1

    # Settings --------------------------------------------------------------------------------------------------------

    def configure(self, **settings: Any) -> None:
        """Change settings of the world by name, or ``dt`` [s], between steps.

        Raises:
            InvalidArgumentError: one is refused; those named before it are changed.
        """
        for name, value in settings.items():
            if name == "dt":
                self.dt = in_range("dt", value, SHORTEST_STEP, LONGEST_STEP)
            elif name not in WORLD_SETTINGS:
                raise InvalidArgumentError(f"the viewer has no setting {name!r}")
            else:
                before = self.world.solver
                setattr(self.world, name, value)
                if before != self.world.solver == "soft_step":
                    self.world.sleeping = True  # its default, which the other could not keep
        self._edited()

    def configure_solver(self, **settings: Any) -> None:
        """Change settings of the present solver by name.

        Raises:
            InvalidArgumentError: one is refused; nothing is changed.
        """
        self.world.solver = dataclasses.replace(self.world.solver_settings, **settings)
        self._edited()

    def settings(self) -> dict[str, Any]:
        """All settings as plain values."""
        solver = {"solver": self.world.solver, "solver_settings": dataclasses.asdict(self.world.solver_settings)}
        return self._world_settings() | {"dt": self.dt, "speed": self.speed} | solver

    # Bodies ----------------------------------------------------------------------------------------------------------

    def add(self, entry: Mapping[str, Any]) -> int:
        """Add a body, given as in a scene file. Returns its id.

        Raises:
            InvalidArgumentError: something is wrong with it, all of it is said; the world is unchanged.
        """
        try:
            model = Scene([dict(entry)]).bodies[0]
        except SceneError as error:
            raise InvalidArgumentError(_plainly(str(error))) from None
        given = model.given()
        del given["shape"]
        row = self.world.add(model.shape.make(), **given).row
        self._edited(bodies=True)
        return int(self.world.bodies.id[row])

    def body(self, identity: int) -> Body:
        """The handle of a body.

        Raises:
            InvalidArgumentError: it is not there.
        """
        rows = np.flatnonzero(self.world.bodies.id == identity)
        if len(rows) == 0:
            raise InvalidArgumentError("this body is no longer there")
        return self.world.bodies[int(rows[0])]

    def remove(self, identity: int) -> None:
        """Delete a body."""
        if self.grab_held is not None and self.grab_held.body == self.body(identity):
            self.grab_held = None
        self.world.remove(self.body(identity))
        self._edited(bodies=True)

    def duplicate(self, identity: int) -> int:
        """Add a copy of a body beside it, without its name. Returns the copy's id."""
        body = self.body(identity)
        if isinstance(body.shape, Plane):
            raise InvalidArgumentError("a second plane in the same place would change nothing")
        entry = describe_body(body)
        entry.pop("name", None)
        width = 1.1 * 2 * np.cbrt(body.shape.volume)
        entry["position"] = (body.position + (width, 0, 0)).tolist()
        return self.add(entry)

    def clear(self) -> None:
        """Delete everything but planes."""
        self.grab_held = None
        for body in list(self.world.bodies):
            if not isinstance(body.shape, Plane):
                self.world.remove(body)
        self._edited(bodies=True)

    def edit(self, identity: int, changes: Mapping[str, Any]) -> None:
        """Change properties of a body by name.

        Raises:
            InvalidArgumentError: one cannot be changed or is refused; nothing is changed.
        """
        body = self.body(identity)
        unknown = [name for name in changes if name not in EDITABLE]
        if unknown:
            raise InvalidArgumentError(f"{unknown[0]} of a body cannot be changed")
        before = {name: getattr(body, name) for name in changes}
        try:
            for name, value in changes.items():
                setattr(body, name, value)
        except InvalidArgumentError:
            for name, value in before.items():
                if not (body.kind == "static" and name in ("velocity", "angular_velocity")):
                    setattr(body, name, value)
            raise
        self._edited()

    def grab(self, identity: int, point: object) -> None:
        """Take hold of a dynamic body at a point in world axes [m]; a spring pulls it after :meth:`drag`. Others are left alone."""
        body = self.body(identity)
        if body.kind == "dynamic":
            self.grab_held = Grab(body, np.array(bounded_vector("point", point)))
            self.changes += 1

    def drag(self, target: object) -> None:
        """Pull the body that is held towards a point [m]."""
        if self.grab_held is not None:
            self.grab_held.target = np.array(bounded_vector("target", target))
            self.changes += 1

    def let_go(self) -> None:
        """Let go of the body that is held; it keeps its velocity, so that it can be thrown."""
        if self.grab_held is not None:
            self.grab_held = None
            self._edited()

    # Joints ----------------------------------------------------------------------------------------------------------

    def joint(self, identity: int) -> Joint:
        """The handle of a joint.

        Raises:
            InvalidArgumentError: it is not there.
        """
        row = self.joints().table.row(identity)
        if row is None:
            raise InvalidArgumentError("this joint is no longer there")
        return self.world.joints[row]

    def join(self, kind: type[JointKind], a: int | None, b: int | None, name: str = "", **settings: Any) -> int:
        """Join two bodies, given by id, or a body and the world, which is None. Returns the joint's id.

        Raises:
            InvalidArgumentError: there can be no such joint; the world is unchanged.
        """
        ends = [None if end is None else self.body(end) for end in (a, b)]
        joint = self.world.join(kind(*ends, **settings), name=name or None)
        self._edited()
        return joint.id

    def edit_joint(self, identity: int, changes: Mapping[str, Any]) -> None:
        """Change settings of a joint by name, and whether it is ``enabled`` or ``broken``.

        Raises:
            InvalidArgumentError: one cannot be changed or is refused; nothing is changed.
        """
        joint = self.joint(identity)
        flags = {name: changes[name] for name in ("broken", "enabled") if name in changes}
        for name, value in flags.items():
            if type(value) is not bool:
                raise InvalidArgumentError(f"{name} must be True or False (got {value!r})")
        settings = {name: value for name, value in changes.items() if name not in flags}
        try:
            joint.change(**settings)
        except AttributeError as error:
            raise InvalidArgumentError(f"{error} to be changed") from None
        for name, value in flags.items():
            setattr(joint, name, value)
        self._edited()

    def remove_joint(self, identity: int) -> None:
        """Delete a joint; its bodies stay."""
        self.world.remove(self.joint(identity))
        self._edited()

    def joints(self) -> JointsNow:
        """All joints, at the present moment."""
        joints = self.world.joints
        if self._joint_table is None or len(self._joint_table) != len(joints):
            self._joint_table = JointTable.of_world(self.world)
        row = self._joint_table.row(self.joint_wanted)
        selected = None if row is None else state_of(joints[row])
        return JointsNow(self._joint_table, np.array(joints.bodies), np.array(joints.acts), selected)

    # Scenes ----------------------------------------------------------------------------------------------------------

    def load(self, name_or_path: str | os.PathLike[str], **parameters: Any) -> None:
        """Put a scene of the library or of a file in the place of the present one.

        Raises:
            SceneError: there is none, or it is wrong; the present one stays.
        """
        self._use(load_scene(name_or_path, **parameters))

    def load_text(self, text: str, name: str) -> None:
        """The same with the contents of a scene file."""
        self._use(parse_scene(text, name=name, is_json=name.lower().endswith(".json")))

    def unload(self) -> None:
        """Put a world with nothing but the ground in its place."""
        self._use(Scene(EMPTY["bodies"], name="empty"))  # type: ignore[arg-type]

    def _use(self, scene: Scene) -> None:
        self._take_over(scene.build(), scene.name, scene.dt)

    def scene(self) -> Scene:
        """The world as it is now, as a scene."""
        scene = Scene.from_world(self.world, name=self.title)
        joints = [describe_joint(joint) for joint in self.world.joints if joint.enabled and not joint.broken]
        return Scene(scene.bodies, joints=joints, world=scene.data().get("world"), name=self.title, dt=self.dt)

    def save(self, path: str | os.PathLike[str], *, replace: bool = False) -> None:
        """Write the world as it is now to a scene file.

        Raises:
            SceneError: it cannot be written, or is there and ``replace`` is not set.
        """
        if not str(path).strip():
            raise SceneError("give the name of a file")
        if Path(path).exists() and not replace:
            raise SceneError(f"{path}: is there already; it is replaced only if you say so")
        self.scene().save(Path(path))

    # What is shown ---------------------------------------------------------------------------------------------------

    def _edited(self, *, bodies: bool = False) -> None:
        """Note that the world was changed by hand between steps; ``bodies``: some came or went."""
        self._changed_by_hand = True
        self._joint_table = None
        if bodies or (self._table is not None and len(self._table) != len(self.world.bodies)):
            self._table = None
        if self.world.steps == 0:
            self._initial = self.world.snapshot()
        self._velocity_before = np.array(self.world.bodies.velocity)
        self.changes += 1

    def table(self) -> Table:
        """What does not move of all bodies."""
        bodies = self.world.bodies
        if self._table is None or not np.array_equal(self._table.ids, bodies.id):
            self._table = Table(
                tuple(
                    Entry(identity, body.name, body.shape, body.kind, body.color, body.mass)
                    for identity, body in zip(bodies.id.tolist(), bodies, strict=True)
                )
            )
        return self._table

    def _totals(self) -> Any:
        """Energy and momentum; while time runs, they may be some steps old, for in large worlds they cost more than a step."""
        now, (at, changes, totals) = time.perf_counter(), self._last_totals
        if totals is None or (changes != self.changes and (not self.running or now - at > TOTALS_AGE)):
            energy = self.world.energy()
            bodies, dynamic = self.world.bodies, self.table().is_dynamic
            momentum = bodies.mass[dynamic].astype(np.float64) @ bodies.velocity[dynamic].astype(np.float64)
            totals = (energy.kinetic, energy.potential), momentum
            self._last_totals = now, self.changes, totals
        return totals

    def _kinetic(self) -> tuple[int, float] | None:
        identity = self.body_wanted
        row = self.table().row(identity)
        if identity is None or row is None or not self.table().is_dynamic[row]:
            return None
        body = self.world.bodies[row]
        axes, orientation, spin = (
            np.array([v], np.float64) for v in (body.principal_axes, body.orientation, body.angular_velocity)
        )
        about = rotate(conjugate(axes), rotate(conjugate(orientation), spin))[0]
        velocity = body.velocity.astype(np.float64)
        return identity, 0.5 * float(body.mass * (velocity @ velocity) + body.inertia @ about**2)

    def frame(self) -> Frame:
        """The present moment."""
        world, bodies = self.world, self.world.bodies
        velocity = np.array(bodies.velocity)
        energy, momentum = self._totals() if self.totals_wanted else (None, None)
        return Frame(
            table=self.table(),
            time=world.time,
            steps=world.steps,
            position=np.array(bodies.position),
            orientation=np.array(bodies.orientation),
            velocity=velocity,
            angular_velocity=np.array(bodies.angular_velocity),
            acceleration=(velocity - self._velocity_before) / self.dt,
            asleep=bodies.asleep,
            gravity=world.gravity,
            dt=self.dt,
            contacts=np.array(world.contacts) if self.contacts_wanted else None,
            contact_count=world.contact_count,
            joints=self.joints(),
            kinetic=self._kinetic(),
            running=self.running,
            settings=self.settings(),
            energy=energy,
            momentum=momentum,
            stages=dict(self.meter.stages),
            real_time_factor=self.meter.real_time_factor if self.running else 0.0,
            error=self.error,
            title=self.title,
        )


def _plainly(message: str) -> str:
    """A scene's message about its only body, without saying so."""
    return "\n".join(line.removeprefix("scene: ").removeprefix("bodies[0].") for line in message.splitlines())
