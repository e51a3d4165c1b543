"""The library of named scenes: one file each, a function with typed parameters and a line that says what it shows."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from functools import cache
from importlib import import_module
from typing import Any, NamedTuple, get_type_hints

from pydantic import BaseModel, ConfigDict, ValidationError, create_model

from atlasphys.scene.faults import Source, faults_of
from atlasphys.scene.library.parts import Layout
from atlasphys.scene.scene import Scene

_NAMES = (
    "demo",
    "two_boxes",
    "tower",
    "pyramid",
    "wall",
    "dominoes",
    "incline",
    "bouncing_balls",
    "newtons_cradle",
    "dzhanibekov",
    "mixed_shapes",
    "polyhedra",
    "sphere_pit",
    "heavy_on_light",
    "card_house",
    "polygons",
    "pendulum",
    "double_pendulum",
    "four_bar",
    "chain",
    "bridge",
    "rope_heavy",
    "wrecking_ball",
    "cradle_strings",
    "gear_train",
    "suspension",
    "ragdoll",
    "ragdoll_pile",
    "joint_grid",
)


class Entry(NamedTuple):
    """A scene of the library."""

    name: str
    description: str
    """What it shows, in a line."""
    parameters: type[BaseModel]
    """The parameters' names, types, ranges and defaults."""
    function: Callable[..., Layout]

    def usage(self) -> str:
        """The parameters with their defaults, as for ``--set``."""
        return " ".join(f"{name}={field.default}" for name, field in self.parameters.model_fields.items())


def names() -> tuple[str, ...]:
    """Names of all scenes, simple ones first."""
    return _NAMES


@cache
def entry(name: str) -> Entry:
    """The scene of that name."""
    function = getattr(import_module(f"atlasphys.scene.library.{name}"), name)
    hints = get_type_hints(function, include_extras=True)
    fields: dict[str, Any] = {
        key: (hints[key], parameter.default) for key, parameter in inspect.signature(function).parameters.items()
    }
    config = ConfigDict(extra="forbid", allow_inf_nan=False)
    description = inspect.cleandoc(function.__doc__).splitlines()[0]
    return Entry(name, description, create_model(name, __config__=config, **fields), function)


def make(name: str, parameters: Mapping[str, Any]) -> Scene:
    """The scene of that name.

    Args:
        name: one of :func:`names`.
        parameters: values of its parameters, as numbers or as text.

    Raises:
        SceneError: a parameter is not known or out of range; all of them are listed.
    """
    found = entry(name)
    try:
        values = found.parameters(**parameters)
    except ValidationError as error:
        raise Source(name).error(faults_of(error, found.parameters)) from None
    layout = found.function(**dict(values))
    return Scene(**layout._asdict(), name=name, description=found.description)
