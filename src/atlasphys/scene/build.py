"""From a scene to a world and back."""

from __future__ import annotations

from typing import Any

from atlasphys.errors import InvalidArgumentError
from atlasphys.scene.faults import Fault, Source, argument_fault
from atlasphys.scene.schema import SHAPES, BodyModel, SceneModel, WorldModel
from atlasphys.world import World


def build_world(scene: SceneModel, source: Source, settings: dict[str, Any]) -> World:
    """A world with the scene's bodies.

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
        world = World(**(scene.world.given() | settings))
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
    if faults:
        raise source.error(faults)
    return world
