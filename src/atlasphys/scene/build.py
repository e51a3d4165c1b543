"""From a scene to a world and back."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from atlasphys.engine.shapes.hull import ConvexHull
from atlasphys.engine.shapes.plane import Plane
from atlasphys.engine.shapes.shape import Shape
from atlasphys.engine.solvers import SOLVERS
from atlasphys.errors import InvalidArgumentError
from atlasphys.scene.faults import Fault, Source, argument_fault, did_you_mean
from atlasphys.scene.schema import SHAPES, BodyModel, SceneModel, WorldModel
from atlasphys.world.body import Body
from atlasphys.world.settings import DEFAULT_PRESET, PRESETS
from atlasphys.world.world import World


def build_world(scene: SceneModel, source: Source, settings: dict[str, Any]) -> World:
    """A world with the scene's bodies and joints.

    Args:
        scene: the scene.
        source: where it comes from, for messages.
        settings: arguments of the world that replace the scene's.

    Raises:
        InvalidArgumentError: the world refuses one of ``settings``.
        SceneError: the world refuses some of the scene's settings or bodies; all of them are listed.
    """
    faults: list[Fault] = []
    try:
        world = _make_world(scene.world, settings)
    except InvalidArgumentError as error:
        fault = argument_fault(("world",), str(error), WorldModel.model_fields)
        if len(fault.path) > 1 and fault.path[1] in settings:
            raise
        faults.append(fault)
        world = World()  # to find what is wrong with the bodies, too
    for row, body in enumerate(scene.bodies):
        try:
            world.add(body.shape.make(), **{name: value for name, value in body.given().items() if name != "shape"})
        except InvalidArgumentError as error:
            faults.append(argument_fault(("bodies", row), str(error), BodyModel.model_fields))
    found = len(faults)
    for row, joint in enumerate(scene.joints):
        path = ("joints", row)
        ends = [_body_row(scene, getattr(joint, side), (*path, side), faults) for side in ("a", "b")]
        if found or len(faults) > found:
            continue  # without all its bodies the world can make no joints
        a, b = (None if end is None else world.bodies[end] for end in ends)
        try:
            world.join(joint.make(a, b), name=joint.name)
        except InvalidArgumentError as error:
            faults.append(argument_fault(path, str(error), type(joint).model_fields))
    if faults:
        raise source.error(faults)
    return world


def _body_row(scene: SceneModel, end: str | int | None, path: tuple[str | int, ...], faults: list[Fault]) -> int | None:
    """Place of the body that a joint's end names; None: the world."""
    if isinstance(end, str):
        names = [body.name for body in scene.bodies]
        if end not in names:
            known = [name for name in names if name is not None]
            faults.append(Fault(path, f"names no body of the scene (got {end!r}); {did_you_mean(end, known)}"))
            return None
        return names.index(end)
    if end is not None and end >= len(scene.bodies):
        faults.append(Fault(path, f"must be less than {len(scene.bodies)}, the number of bodies (got {end})"))
        return None
    return end


_OF_SOLVER = ("solver", "solver_settings", "position_correction", "substeps")
_OF_PRESET = (*_OF_SOLVER, "narrowphase", "broadphase")
"""Settings of a scene that make no sense, or are not wanted, once another solver or preset is asked for."""


def _make_world(model: WorldModel, settings: dict[str, Any]) -> World:
    replaced = _OF_PRESET if "preset" in settings else _OF_SOLVER if "solver" in settings else ()
    arguments = {name: value for name, value in model.given().items() if name not in replaced} | settings
    solver_settings = arguments.pop("solver_settings", None)
    if solver_settings:
        solver = arguments.get("solver") or PRESETS.get(arguments.get("preset", ""), PRESETS[DEFAULT_PRESET])["solver"]
        if solver not in SOLVERS:
            raise InvalidArgumentError(
                f"solver must be one of {', '.join(SOLVERS)} where it has settings (got {solver!r})"
            )
        maker = SOLVERS[solver].settings
        known = [field.name for field in dataclasses.fields(maker)]
        for name in solver_settings:
            if name not in known:
                raise InvalidArgumentError(f"solver_settings: {solver} has no {name!r}; {did_you_mean(name, known)}")
        arguments["solver"] = maker(**solver_settings)
    return World(**arguments)


def describe_world(world: World) -> dict[str, Any]:
    """A world's settings in the form of the schema."""
    return {
        "gravity": world.gravity.tolist(),
        "solver": world.solver,
        "solver_settings": dataclasses.asdict(world.solver_settings),
        "narrowphase": world.narrowphase,
        "broadphase": world.broadphase,
        "precision": world.precision,
        "length_unit": world.length_unit,
        "restitution_threshold": world.restitution_threshold,
        "friction_combine": world.friction_combine,
        "restitution_combine": world.restitution_combine,
    }


def describe_body(body: Body) -> dict[str, Any]:
    """A body as it is now in the form of the schema: everything that ``World.add`` would not choose by itself."""
    entry: dict[str, Any] = {
        "name": body.name,
        "shape": describe_shape(body.shape),
        "kind": body.kind,
        "color": body.color,
    }
    entry |= {"position": body.position.tolist(), "orientation": body.orientation.tolist()}
    if body.kind != "static":
        entry |= {"velocity": body.velocity.tolist(), "angular_velocity": body.angular_velocity.tolist()}
    if body.kind == "dynamic":
        entry |= {"mass": body.mass, "inertia": _given_inertia(body)}
    names = ("friction", "restitution", "rolling_friction", "torsional_friction", "linear_damping", "angular_damping")
    entry |= {name: getattr(body, name) for name in (*names, "gravity_scale")}
    entry |= {"locks": body.locks, "group": body.group, "mask": body.mask}
    plain: dict[str, Any] = World.add.__kwdefaults__ or {}
    kind = "static" if isinstance(body.shape, Plane) else "dynamic"
    defaults = plain | {"kind": kind, "mask": 2**32 - 1, "locks": ()}
    return {
        name: value
        for name, value in entry.items()
        if value is not None and (name not in defaults or value != _as_list(defaults[name]))
    }


def describe_shape(shape: Shape) -> dict[str, Any]:
    """A shape in the form of the schema."""
    if isinstance(shape, ConvexHull):
        return {"type": "convex_hull", "points": shape.vertices}
    kind = next(kind for kind, model in SHAPES.items() if model.maker.endswith(f".{type(shape).__name__}"))
    return {"type": kind, **{field.name: getattr(shape, field.name) for field in dataclasses.fields(shape)}}  # type: ignore[arg-type]


def _given_inertia(body: Body) -> list[list[float]] | None:
    """The body's inertia tensor in the axes of its shape, or None if it is that of the shape at uniform density."""
    w, x, y, z = body.principal_axes.tolist()
    axes = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    tensor = (axes * body.inertia) @ axes.T
    uniform = np.array(body.shape.inertia(body.mass / body.shape.volume))
    if np.allclose(tensor, uniform, rtol=0, atol=1e-5 * np.abs(uniform).max()):
        return None
    rows: list[list[float]] = (0.5 * (tensor + tensor.T)).tolist()
    return rows


def _as_list(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) and value else value
