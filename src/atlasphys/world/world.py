"""The world: what a user builds, steps and reads."""

from __future__ import annotations

import copy
import dataclasses
import secrets
from collections.abc import Mapping
from importlib import import_module
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from atlasphys.engine.broadphase import BROADPHASES
from atlasphys.engine.constants import RESTITUTION_THRESHOLD
from atlasphys.engine.fused.addresses import compile_ahead
from atlasphys.engine.joints.compose import break_joints
from atlasphys.engine.joints.kinds.kind import JointKind
from atlasphys.engine.manifold.build import COMBINE_RULES
from atlasphys.engine.run import run
from atlasphys.engine.shapes.mass import mass_properties
from atlasphys.engine.shapes.plane import Plane
from atlasphys.engine.shapes.shape import Shape
from atlasphys.engine.solvers import SOLVERS
from atlasphys.engine.solvers.residuals import Residuals, Sweep, contact_residuals
from atlasphys.engine.state.bodies import DYNAMIC, KINDS, STATIC
from atlasphys.engine.state.state import Environment, State
from atlasphys.engine.step import STAGES, DivergedError, Pipeline, step
from atlasphys.errors import DivergenceError, InvalidArgumentError
from atlasphys.world import totals
from atlasphys.world.arguments import (
    bits,
    bounded_vector,
    check_name,
    choice,
    in_range,
    lock_bits,
    rgb,
    unit_quaternion,
)
from atlasphys.world.body import COEFFICIENTS, RESPONSES, Body
from atlasphys.world.html import world_html
from atlasphys.world.joint import Joint, JointInfo, Joints, join
from atlasphys.world.settings import (
    DEFAULT_PRESET,
    LONGEST_RUN,
    LONGEST_STEP,
    NARROWPHASES,
    PRECISIONS,
    PRESETS,
    SHORTEST_STEP,
    gravity_of,
    is_fused,
    sleeping_of,
    solver_of,
    threads_of,
    threshold_of,
    with_substeps,
)
from atlasphys.world.snapshot import BodyInfo, Snapshot
from atlasphys.world.trace import Records, trace_of, trace_records
from atlasphys.world.views import Bodies, Energy, Event, contact_count, contact_points, events
from atlasphys.world.watch import Watcher, advance_watched
from atlasphys.world.written import check_written


class World:
    """A world of rigid bodies.

    SI units, right-handed axes, y up unless gravity says otherwise.

    Args:
        gravity: acceleration of free fall [m/s²], (3,).
        preset: a named set of the arguments below; explicit ones override it. ``"default"``: tree, auto, soft_step. ``"classic"``: sweep and prune,
            GJK + EPA, sequential impulses with position projection. ``"xpbd"``: tree, separating axis test, extended position-based dynamics.
            ``"avbd"``: tree, auto, avbd, for extreme ratios of masses.
        solver: name of a solver, ``"soft_step"``, ``"sequential_impulse"``, ``"xpbd"`` or ``"avbd"``, or its settings,
            ``ap.SoftStep(contact_recycling=False)``.
        narrowphase: ``"gjk_epa"`` or ``"sat"`` forces one method for all convex pairs that it can serve; ``"auto"`` picks the
            fastest right one per pair.
        broadphase: ``"tree"`` (bounding volume hierarchies over fat boxes, kept from step to step), ``"sweep"`` (sweep and prune) or ``"brute"`` (all
            pairs; for few bodies, and the reference). They find the same contacts.
        position_correction: ``"projection"`` or ``"baumgarte"``: how overlap is removed; see :class:`SequentialImpulse`.
        substeps: solver steps per step. Default: 4, with ``xpbd`` 15; ``sequential_impulse`` takes 1.
        threads: number of threads that share the work of a step, for ``soft_step``. Worth it from about a thousand contacts on. Default: 1. The
            results are the same to the bit for any number.
        precision: ``"single"`` (faster) or ``"double"``, for all but positions, which are always double.
        sleeping: whether resting bodies are left out of the computation until something disturbs them. Default: True with ``soft_step``, which
            alone can do so. See :meth:`Body.wake`.
        length_unit: typical size of a body [m]. All tolerances that are lengths, and ``restitution_threshold``'s default, scale with
            it: set 0.01 for a scene of marbles, 100 for one of houses.
        restitution_threshold: approach speed below which contacts do not bounce [m/s]. Default: 1 m/s × ``length_unit`` / m.
        friction_combine, restitution_combine: how the coefficients of two bodies make that of their contact:
            ``"geometric_mean"``, ``"average"``, ``"min"``, ``"max"`` or ``"multiply"``.

    Raises:
        InvalidArgumentError: a value is not of the right kind, out of range, given twice, or names what does not exist.

    >>> import atlasphys as ap
    >>> world = ap.World()
    >>> ground = world.add(ap.Plane(normal=(0, 1, 0)))
    >>> crate = world.add(ap.Box(size=(1, 1, 1)), position=(0, 0.5, 0), mass=10, name="crate")
    >>> world.run(seconds=1, dt=1 / 60)
    >>> bool(abs(crate.position[1] - 0.5) < 0.005)
    True
    >>> round(float(world.contacts.normal_impulse.sum() / (1 / 60)), 2)  # the crate's weight [N]
    98.1
    """

    def __init__(
        self,
        *,
        gravity: object = (0.0, -9.81, 0.0),
        preset: str | None = None,
        solver: object = None,
        narrowphase: str | None = None,
        broadphase: str | None = None,
        position_correction: str | None = None,
        substeps: int | None = None,
        threads: int | None = None,
        precision: str = "single",
        sleeping: bool | None = None,
        length_unit: float = 1.0,
        restitution_threshold: float | None = None,
        friction_combine: str = "geometric_mean",
        restitution_combine: str = "max",
    ) -> None:
        chosen = PRESETS[DEFAULT_PRESET if preset is None else choice("preset", preset, PRESETS)]
        unit = in_range("length_unit", length_unit, 1e-3, 1e3)
        self._precision = choice("precision", precision, PRECISIONS)
        name, settings = solver_of(chosen["solver"] if solver is None else solver)
        if position_correction is not None:
            if dataclasses.is_dataclass(solver):
                raise InvalidArgumentError(
                    "position_correction is given twice: as an argument and in the solver's settings"
                )
            if not hasattr(settings, "position_correction"):
                raise InvalidArgumentError(f"position_correction is a setting of sequential_impulse, not of {name}")
            settings = dataclasses.replace(settings, position_correction=position_correction)
        settings = with_substeps(name, settings, substeps, dataclasses.is_dataclass(solver))
        self._pipeline = Pipeline(
            broadphase=choice("broadphase", chosen["broadphase"] if broadphase is None else broadphase, BROADPHASES),
            narrowphase=choice(
                "narrowphase", chosen["narrowphase"] if narrowphase is None else narrowphase, NARROWPHASES
            ),
            solver=name,
            solver_settings=settings,
            sleeping=sleeping_of(name, sleeping),
            threads=threads_of(name, 1 if threads is None else threads),
        )
        environment = Environment(
            gravity=gravity_of(gravity),
            length_unit=unit,
            restitution_threshold=threshold_of(
                RESTITUTION_THRESHOLD * unit if restitution_threshold is None else restitution_threshold
            ),
            friction_rule=COMBINE_RULES[choice("friction_combine", friction_combine, COMBINE_RULES)],
            restitution_rule=COMBINE_RULES[choice("restitution_combine", restitution_combine, COMBINE_RULES)],
        )
        self._state = State(PRECISIONS[self._precision], environment)
        self._infos: list[BodyInfo] = []
        self._joint_infos: list[JointInfo] = []
        self._profile: dict[str, float] = dict.fromkeys(STAGES, 0.0)
        self._tracing = False
        self._trace: list[Records] = []
        self._sweeps: list[Sweep] = []
        self._watchers: list[Watcher] = []
        self._serial = 0
        self._start_generation()

    def _start_generation(self) -> None:
        """Ids given from now on differ from those given in any other branch of this world's history."""
        self._generation = secrets.randbits(31)

    def __setattr__(self, name: str, value: Any) -> None:
        if not name.startswith("_") and not isinstance(getattr(type(self), name, None), property):
            raise AttributeError(f"a world has no setting {name!r}")
        super().__setattr__(name, value)

    # Settings --------------------------------------------------------------------------------------------------------

    @property
    def gravity(self) -> npt.NDArray[np.float64]:
        """Acceleration of free fall [m/s²], (3,). Assign to change it."""
        value = np.array(self._state.environment.gravity)
        value.flags.writeable = False
        return value

    @gravity.setter
    def gravity(self, value: object) -> None:
        self._set_environment(gravity=gravity_of(value))
        self._state.wake()

    @property
    def solver(self) -> str:
        """Name of the solver. Assign a name or a solver's settings to change it between steps."""
        return self._pipeline.solver

    @solver.setter
    def solver(self, value: object) -> None:
        name, settings = solver_of(value)
        if name != self._pipeline.solver:
            self._state.solver_changed()
            if not SOLVERS[name].shares:
                self._state.wake()
        sleeping, threads = self._pipeline.sleeping, self._pipeline.threads
        if not SOLVERS[name].shares:
            sleeping, threads = False, 1
        self._pipeline = dataclasses.replace(
            self._pipeline, solver=name, solver_settings=settings, sleeping=sleeping, threads=threads
        )

    @property
    def solver_settings(self) -> Any:
        """The solver's settings, a frozen dataclass."""
        return self._pipeline.solver_settings

    @property
    def narrowphase(self) -> str:
        """``"auto"``, ``"gjk_epa"`` or ``"sat"``."""
        return self._pipeline.narrowphase

    @narrowphase.setter
    def narrowphase(self, value: str) -> None:
        self._pipeline = dataclasses.replace(self._pipeline, narrowphase=choice("narrowphase", value, NARROWPHASES))

    @property
    def broadphase(self) -> str:
        """``"sweep"`` or ``"brute"``."""
        return self._pipeline.broadphase

    @broadphase.setter
    def broadphase(self, value: str) -> None:
        self._pipeline = dataclasses.replace(self._pipeline, broadphase=choice("broadphase", value, BROADPHASES))

    @property
    def restitution_threshold(self) -> float:
        """Approach speed below which contacts do not bounce [m/s]."""
        return self._state.environment.restitution_threshold

    @restitution_threshold.setter
    def restitution_threshold(self, value: float) -> None:
        self._set_environment(restitution_threshold=threshold_of(value))

    @property
    def friction_combine(self) -> str:
        """Rule by which two bodies' friction makes that of their contact."""
        return list(COMBINE_RULES)[self._state.environment.friction_rule]

    @friction_combine.setter
    def friction_combine(self, value: str) -> None:
        self._set_environment(friction_rule=COMBINE_RULES[choice("friction_combine", value, COMBINE_RULES)])

    @property
    def restitution_combine(self) -> str:
        """Rule by which two bodies' restitution makes that of their contact."""
        return list(COMBINE_RULES)[self._state.environment.restitution_rule]

    @restitution_combine.setter
    def restitution_combine(self, value: str) -> None:
        self._set_environment(restitution_rule=COMBINE_RULES[choice("restitution_combine", value, COMBINE_RULES)])

    def _set_environment(self, **change: Any) -> None:
        self._state.environment = dataclasses.replace(self._state.environment, **change)
        if change.keys() & {"friction_rule", "restitution_rule"}:
            self._state.properties_changed()

    @property
    def precision(self) -> str:
        """``"single"`` or ``"double"``."""
        return self._precision

    @property
    def length_unit(self) -> float:
        """Typical size of a body [m]."""
        return self._state.environment.length_unit

    @property
    def substeps(self) -> int:
        """Solver steps per step."""
        return int(getattr(self._pipeline.solver_settings, "substeps", 1))

    @property
    def threads(self) -> int:
        """Number of threads that share the work. Assign to change it. The results are the same to the bit."""
        return self._pipeline.threads

    @threads.setter
    def threads(self, value: int) -> None:
        self._pipeline = dataclasses.replace(self._pipeline, threads=threads_of(self.solver, value))

    @property
    def sleeping(self) -> bool:
        """Whether resting bodies are put to sleep. Assign to change it: False wakes all."""
        return self._pipeline.sleeping

    @sleeping.setter
    def sleeping(self, value: bool) -> None:
        self._pipeline = dataclasses.replace(self._pipeline, sleeping=sleeping_of(self.solver, value))
        if not value:
            self._state.wake()
            self._state.bodies.rest[: self._state.count] = 0

    @property
    def trace_solver(self) -> bool:
        """Whether ``solver_trace`` is kept. Default: False. It changes no result; steps take a multiple of their time while it is kept."""
        return self._tracing

    @trace_solver.setter
    def trace_solver(self, value: bool) -> None:
        if type(value) is not bool:
            raise InvalidArgumentError(f"trace_solver must be True or False (got {value!r})")
        self._tracing, self._trace = value, []

    # Bodies ----------------------------------------------------------------------------------------------------------

    def add(
        self,
        shape: Shape,
        *,
        position: object = (0.0, 0.0, 0.0),
        orientation: object = (1.0, 0.0, 0.0, 0.0),
        velocity: object = (0.0, 0.0, 0.0),
        angular_velocity: object = (0.0, 0.0, 0.0),
        mass: float | None = None,
        density: float | None = None,
        inertia: Any = None,
        kind: str | None = None,
        friction: float = 0.5,
        restitution: float = 0.0,
        rolling_friction: float = 0.0,
        torsional_friction: float = 0.0,
        linear_damping: float = 0.0,
        angular_damping: float = 0.0,
        gravity_scale: float = 1.0,
        locks: object = None,
        group: int = 1,
        mask: int = ~0,
        color: object = None,
        name: str | None = None,
    ) -> Body:
        """Add a body and return its handle.

        Args:
            shape: its shape, ``ap.Box(size=(1, 1, 1))`` for instance. Many bodies may share one.
            position: origin of the shape's own frame [m], (3,).
            orientation: quaternion (w, x, y, z), (4,); normalised.
            velocity: velocity of the centre of mass [m/s], (3,).
            angular_velocity: [rad/s], world axes, (3,).
            mass: mass [kg]; or give
            density: [kg/m³]. Default: 1000. Without effect on static and kinematic bodies.
            inertia: about the centre of mass [kg m²]: three moments about the shape's axes, or a 3×3 tensor in those axes. Default: that of
                the shape at uniform density.
            kind: ``"dynamic"`` (moved by forces and contacts), ``"static"`` (never moves) or ``"kinematic"`` (moves with the velocity it
                is given, whatever it meets). Default: dynamic; planes are static.
            friction: coefficient of Coulomb friction, ≥ 0.
            restitution: coefficient of restitution, 0 to 1.
            rolling_friction: lever arm of rolling resistance [m], ≥ 0.
            torsional_friction: effective radius of the contact patch [m], ≥ 0.
            linear_damping, angular_damping: rates at which velocities decay [1/s], ≥ 0.
            gravity_scale: factor on the world's gravity.
            locks: axes of the world along which ("x", "y", "z") or about which ("rx", "ry", "rz") the body cannot move, if dynamic.
            group: bits of the groups that the body belongs to.
            mask: bits of the groups with which it collides. Two bodies collide if each one's mask admits the other's group.
            color: for pictures: ``"#rrggbb"`` or red, green and blue from 0 to 1.
            name: a name, unique in the world.

        Raises:
            InvalidArgumentError: a value is not of the right kind or out of range; the world is unchanged.
        """
        if not isinstance(shape, Shape):
            raise InvalidArgumentError(f"shape must be a shape such as ap.Box(size=(1, 1, 1)) (got {shape!r})")
        is_plane = isinstance(shape, Plane)
        code = KINDS[choice("kind", ("static" if is_plane else "dynamic") if kind is None else kind, KINDS)]
        if is_plane and code != STATIC:
            raise InvalidArgumentError(f"a plane is always static (got kind={kind!r})")
        where = bounded_vector("position", position)
        turned = unit_quaternion("orientation", orientation)
        moving = bounded_vector("velocity", velocity) + bounded_vector("angular_velocity", angular_velocity)
        if code == STATIC and any(moving):
            raise InvalidArgumentError("a static body has no velocity; make it kinematic to move it")
        properties = None
        if is_plane:
            for key, value in (("mass", mass), ("density", density), ("inertia", inertia)):
                if value is not None:
                    raise InvalidArgumentError(f"{key} cannot be given for a plane, which is static (got {value!r})")
        else:
            density = 1000.0 if mass is None and density is None else density
            properties = mass_properties(shape, mass=mass, density=density, inertia=inertia)
        given = {
            "friction": friction,
            "restitution": restitution,
            "rolling_friction": rolling_friction,
            "torsional_friction": torsional_friction,
            "linear_damping": linear_damping,
            "angular_damping": angular_damping,
            "gravity_scale": gravity_scale,
        }
        material = [in_range(key, given[key], low, high) for key, (_, low, high) in COEFFICIENTS.items()]
        response = [in_range(key, given[key], low, high) for key, (_, low, high) in RESPONSES.items()]
        locked, group_bits, mask_bits = lock_bits(locks), bits("group", group), bits("mask", mask)
        info = BodyInfo(self._checked_name(name), rgb(color))

        state = self._state
        row = state.append()
        bodies, colliders = state.bodies, state.colliders
        bodies.position[row], bodies.orientation[row], bodies.motion[row, 0:6] = where, turned, moving
        bodies.kind[row], bodies.locks[row], bodies.response[row, 0:3] = code, locked, response
        bodies.principal[row, 0] = 1.0
        if properties is not None:
            bodies.local_center[row], bodies.principal[row] = properties.center, properties.principal
            if code == DYNAMIC:
                values = (properties.mass, *properties.moments)
                bodies.mass[row] = (values[0], 1 / values[0], *values[1:], *(1 / moment for moment in values[1:]))
        colliders.body[row], colliders.shape[row] = row, state.table.row_of(shape)
        colliders.material[row], colliders.group[row], colliders.mask[row] = material, group_bits, mask_bits
        bodies.id[row] = (self._generation << 32) + self._serial
        self._serial += 1
        self._infos.append(info)
        if row == 0 and is_fused(self._pipeline.solver):
            compile_ahead(state)
        state.refreshed(row)
        return Body(self, row)

    def _checked_name(self, name: str | None) -> str | None:
        if name is None:
            return None
        check_name(name)
        if any(info.name == name for info in self._infos):
            raise InvalidArgumentError(f"name {name!r} is already taken by another body of this world")
        return name

    def remove(self, body: Body | Joint) -> None:
        """Remove a body, with all its joints, or a joint, which wakes its bodies. The rows after it move up by one; its handles raise from now on.

        Raises:
            InvalidArgumentError: the body or joint belongs to another world.
            RemovedBodyError, RemovedJointError: it has been removed before.
        """
        if not isinstance(body, (Body, Joint)) or body.world is not self:
            raise InvalidArgumentError(f"body must be a body or joint of this world (got {body!r})")
        row = body.row
        if isinstance(body, Joint):
            self._state.joints_changed(row)
            self._state.joints.keep(np.arange(self._state.joints.count) != row)
            del self._joint_infos[row]
            return
        kept = self._state.remove(row)
        del self._infos[row]
        self._joint_infos = [info for info, keep in zip(self._joint_infos, kept, strict=True) if keep]

    def join(self, joint: JointKind, *, name: str | None = None) -> Joint:
        """Join two bodies, or a body and the world, and return the joint's handle.

        Args:
            joint: what joins them: ``ap.Hinge(a, b, anchor=(0, 1, 0), axis=(0, 1, 0), limits=(-1, 1))``, for instance. docs/joints.md has all kinds.
                Anchors and axes are said in the world, where the bodies now are, or in the bodies' own axes.
            name: a name, unique among the joints of the world.

        Raises:
            InvalidArgumentError: not a joint; its bodies are not of this world, the same, or none of them dynamic; or where they are there can be no
                such joint. The world is unchanged.
            RemovedBodyError: one of the bodies has been removed.
        """
        return join(self, joint, name)

    @property
    def joints(self) -> Joints:
        """All joints, as a sequence of handles and as arrays."""
        return Joints(self)

    @property
    def bodies(self) -> Bodies:
        """All bodies, as a sequence of handles and as arrays."""
        return Bodies(self)

    # Stepping --------------------------------------------------------------------------------------------------------

    def step(self, dt: float) -> None:
        """Advance the world by one step of ``dt`` seconds.

        Raises:
            InvalidArgumentError: dt is out of range, or what was written into ``world.bodies`` is not finite or moves a static body.
            DivergenceError: a body's state would no longer be finite. In both cases the world is as it was before the step.
        """
        self._advance(in_range("dt", dt, SHORTEST_STEP, LONGEST_STEP), 1)

    def _advance(self, h: float, steps: int) -> None:
        check_written(self)
        if self._watchers:
            advance_watched(self, h, steps)
            return
        try:
            if self._tracing:
                self._advance_traced(h, steps)
            else:
                self._take_steps(h, steps)
        except DivergedError as error:
            names = tuple(self._infos[row].name or f"body {row}" for row in error.rows)
            shown = ", ".join(names[:5]) + (f" and {len(names) - 5} more" if len(names) > 5 else "")
            raise DivergenceError(
                f"the step from {self.time:.6g} s gave non-finite positions or velocities for {shown}; "
                "the world is as it was before it. Look for huge speeds, forces or mass ratios, or take a shorter step",
                names,
            ) from None

    def _take_steps(self, h: float, steps: int) -> None:
        """Take steps, as many at a time as the solver can; one by one where joints may break."""
        state, joints = self._state, self._state.joints
        together = steps if is_fused(self._pipeline.solver) and not joints.breakable else 1
        for _ in range(steps // together if steps else 0):
            if is_fused(self._pipeline.solver):
                self._profile = run(state, self._pipeline, h, together)
            else:
                self._profile = step(state, self._pipeline, h)
            if joints.count:
                break_joints(joints)
                for row in joints.broke:
                    state.joints_changed(int(row))

    def _advance_traced(self, h: float, steps: int) -> None:
        """Take steps one by one and note how each was solved."""
        self._trace = []
        state = self._state
        for _ in range(steps):
            state.trace = []
            try:
                self._take_steps(h, 1)
                self._trace.append(trace_of(state))
                self._sweeps = state.trace
            finally:
                state.trace = None

    def run(self, seconds: float, dt: float = 1 / 60) -> None:
        """Take as many steps of ``dt`` seconds as it takes to simulate ``seconds``, rounded to the nearest number of steps.

        Raises:
            InvalidArgumentError, DivergenceError: as :meth:`step`; the steps before the failing one remain.
        """
        length = in_range("seconds", seconds, 0, LONGEST_RUN)
        h = in_range("dt", dt, SHORTEST_STEP, LONGEST_STEP)
        if steps := round(length / h):
            self._advance(h, steps)

    # Reading ---------------------------------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._state.time

    @property
    def steps(self) -> int:
        """Number of steps taken."""
        return self._state.steps

    @property
    def contacts(self) -> np.recarray[Any, Any]:
        """Contact points of the last step, one record each; read-only.

        ``body_a``, ``body_b`` are rows of ``world.bodies``; ``point`` [m] lies midway between the surfaces as they met and has moved with
        body a since (with b where a is not dynamic); ``normal`` from a to b; ``depth`` [m], negative where the surfaces are a little apart;
        ``normal_impulse`` [N s] and ``friction_impulse`` (3,) [N s], applied to b, and their opposites to a.
        """
        return contact_points(self._state)

    @property
    def contact_count(self) -> int:
        """Number of contact points of the last step: the length of :attr:`contacts`, without making it."""
        return contact_count(self._state)

    @property
    def events(self) -> list[Event]:
        """What happened in the last step: contacts that began and ended, bodies that fell asleep or were woken by a contact, joints that broke. A
        body that is removed takes its contacts with it without an event."""
        return events(self)

    @property
    def profile(self) -> Mapping[str, float]:
        """Seconds spent in each stage of the last step."""
        return MappingProxyType(self._profile)

    def residuals(self) -> Residuals:
        """What the end of the last step lacks from the laws of contact, for any solver: ``complementarity`` [N s], ``cone`` [N s], ``work`` [J] and
        ``depth`` [m], an entry for each contact point, those of pairs that are only near included. See ``solver_trace`` for what they are.
        """
        return contact_residuals(self._state)

    @property
    def solver_trace(self) -> np.recarray[Any, Any]:
        """How the solver fared in the last call of ``step`` or ``run``, a record a sweep and a record at the end of each step; read-only. Empty
        unless ``trace_solver`` is set.

        ``step``; ``sweep``, counted from 0, −1 at the end of the step; ``colour`` of the contacts that it visited, −1 for all; ``substep``;
        ``kind``: ``"sweep"`` of ``sequential_impulse`` and ``avbd`` (the first before all sweeps), ``"solve"`` and ``"relax"`` of ``soft_step``,
        ``"positions"`` and ``"velocities"`` of ``xpbd``, ``"end"``. The greatest
        ``complementarity`` residual |min(w/k, λ)| [N s] and ``cone`` violation max(0, |λ_t| − μ λ) [N s] of a contact point, and the sum of
        ``work`` |λ w| [J], with w the speed that the gap does not allow (in sweeps: that the solver's constraint does not), k the contact's
        inverse mass, λ the normal and λ_t the friction impulse, of the substep where there are some; at the end of a step of the whole step. Energy
        by kind [J]: ``translation``, ``rotation``, ``potential`` (in the world's gravity; positions change at the end of a step). ``depth``:
        deepest overlap [m].

        The first traced step of ``soft_step`` and ``xpbd`` compiles their solver stage once more; one thread does it. Impacts of ``soft_step`` are
        resolved before its substeps, and not noted; of the sweeps over velocities that impacts take in ``xpbd`` the last is.
        """
        return trace_records(self._trace)

    def energy(self) -> Energy:
        """Kinetic and potential energy of the dynamic bodies [J]."""
        return totals.energy(self._state)

    def momentum(self) -> npt.NDArray[np.float64]:
        """Total linear momentum of the dynamic bodies [kg m/s], (3,)."""
        return totals.momentum(self._state)

    def angular_momentum(self, about: object = (0.0, 0.0, 0.0)) -> npt.NDArray[np.float64]:
        """Total angular momentum of the dynamic bodies about a point [kg m²/s], (3,)."""
        return totals.angular_momentum(self._state, np.array(bounded_vector("about", about)))

    def state_hash(self) -> str:
        """A digest of the state, 32 hexadecimal digits: equal for worlds that will go on equally."""
        return self._state.hash()

    def __repr__(self) -> str:
        return (
            f"<World: {self._state.count} bodies at {self.time:.6g} s, {self.solver}, {self.narrowphase}, {self.broadphase}, "
            f"{self.precision} precision>"
        )

    def _repr_html_(self) -> str:
        return world_html(self)

    def view(self, *, inline: str = "auto", seconds: float = 5.0, port: int = 0, height: int = 600) -> Any:
        """Show a copy of the world on an interactive page: in the notebook where there is one, else at the address that is printed.

        The copy is stopped, and goes on in the page only; the world itself stays as it is and may be stepped meanwhile. Ask again to see it as it
        then is.

        Args:
            inline: ``"page"``, which a browser reaches only on the machine of the kernel; ``"proxy"``, the same page through jupyter-server-proxy
                of a notebook server elsewhere; ``"picture"`` or ``"film"``, made here and shown in the notebook, wherever that is read. Default:
                the page, or what reaches a JupyterHub or Colab: the proxy where it is installed, else a picture.
            seconds: length of a film, for which the copy runs [s].
            port: port of the page on this machine. Default: any that is free.
            height: height of the frame, picture or film in a notebook [pixels].

        Returns:
            The page; its ``url`` is the address, ``close()`` ends it. None for a picture or a film.

        Raises:
            MissingExtraError: viser is not installed; for a picture or a film, pyvista or imageio-ffmpeg.
            InvalidArgumentError: the port is in use, or a picture or film is asked for where there is no notebook.
        """
        # By name, for the viewer stands above the world.
        show = import_module("atlasphys.viewer.notebook").show
        return show(copy.deepcopy(self), inline=inline, seconds=seconds, port=port, height=height)

    # Copies ----------------------------------------------------------------------------------------------------------

    def snapshot(self) -> Snapshot:
        """The whole state, exact to the bit: bodies, contacts with their impulses, clock and settings."""
        return Snapshot(self._state.copy(), list(self._infos), list(self._joint_infos), self._pipeline)

    def restore(self, snapshot: Snapshot) -> None:
        """Return to a snapshot. Handles of bodies that are in it stay good; those of other bodies raise.

        The snapshot may be one of another world, which this one then goes on from.

        Raises:
            InvalidArgumentError: not a snapshot, or one of a world of another precision.
        """
        if not isinstance(snapshot, Snapshot):
            raise InvalidArgumentError(f"restore takes what World.snapshot() gave (got {snapshot!r})")
        if snapshot._state.real != self._state.real:
            raise InvalidArgumentError(f"the snapshot's precision is not this world's, {self.precision!r}")
        self._state = snapshot._state.copy()
        self._infos, self._pipeline = list(snapshot._infos), snapshot._pipeline
        self._joint_infos = list(snapshot._joint_infos)
        self._start_generation()

    def __copy__(self) -> World:
        return copy.deepcopy(self)  # two worlds on one state would give the same ids to different bodies

    def __deepcopy__(self, memo: dict[int, Any]) -> World:
        other = object.__new__(World)
        memo[id(self)] = other
        other.__dict__.update(self.__dict__)
        other._state, other._infos, other._watchers = self._state.copy(), list(self._infos), []
        other._joint_infos = list(self._joint_infos)
        other._start_generation()
        return other

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"_watchers": []}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._start_generation()
