"""Joints in scene files: a model for each kind of joint, made from its dataclass, and how a joint of a world is said."""

from __future__ import annotations

import dataclasses
import math
import re
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, JsonValue, create_model, model_validator

from atlasphys.engine.joints.kinds.ball import Ball, Target
from atlasphys.engine.joints.kinds.couplings import Gear, Pulley, RackPinion
from atlasphys.engine.joints.kinds.distance import Distance, Spring
from atlasphys.engine.joints.kinds.hinge import Fixed, Hinge
from atlasphys.engine.joints.kinds.kind import JointKind
from atlasphys.engine.joints.kinds.six_dof import SixDof
from atlasphys.engine.joints.kinds.slider import Slider, Wheel
from atlasphys.engine.joints.kinds.universal import Universal
from atlasphys.engine.joints.part import Elastic, Motor
from atlasphys.scene.model import Model, Name, Whole
from atlasphys.world.body import Body
from atlasphys.world.joint import Joint

KINDS: tuple[type[JointKind], ...] = (
    Ball, Hinge, Slider, Fixed, Distance, Spring, Universal, Wheel, SixDof, Gear, RackPinion, Pulley, Target,
)  # fmt: skip

DRIVES: dict[str, type[Elastic] | type[Motor]] = {
    "spring": Elastic,
    "spring_b": Elastic,
    "springs": Elastic,
    "motor": Motor,
    "motor_b": Motor,
    "motors": Motor,
}
"""What tables under these keys are; those with a plural s hold one for each name."""

End = Annotated[Name | Annotated[Whole, Field(ge=0)], Field(union_mode="left_to_right")]


class JointModel(Model):
    """The arguments of one of the kinds of joints, checked by making it."""

    maker: ClassVar[type[JointKind]]
    name: Name | None = None
    """Name, not given to two joints of a scene."""
    a: End | None = None
    """First body: its name, or its place among the bodies of the scene, from 0. Default: the world."""
    b: End | None = None
    """Second body, said likewise. Default: the world."""

    def make(self, a: Body | None = None, b: Body | None = None) -> JointKind:
        """The joint between two bodies.

        Raises:
            InvalidArgumentError: the arguments make none.
        """
        given = {key: _numbers(value) for key, value in self.given().items() if key not in ("type", "name", "a", "b")}
        for key, drive in DRIVES.items():
            if isinstance(value := given.get(key), dict):
                given[key] = (
                    {name: _drive(drive, f"{key}.{name}", each) for name, each in value.items()}
                    if key.endswith("s")
                    else _drive(drive, key, value)
                )
        return self.maker(a, b, **given)

    @model_validator(mode="after")
    def _can_be_made(self) -> Self:
        self.make()
        return self


def _numbers(value: Any) -> Any:
    """A value with the text "inf" and "-inf" read as numbers, which JSON does not have."""
    if isinstance(value, list):
        return [_numbers(each) for each in value]
    if isinstance(value, dict):
        return {name: _numbers(each) for name, each in value.items()}
    return float(value) if value in ("inf", "-inf") else value


def _drive(kind: type[Any], name: str, value: Any) -> Any:
    if not isinstance(value, dict):
        raise ValueError(f"{name} must be a table (got {value!r})")
    known = [field.name for field in dataclasses.fields(kind)]
    for key in value:
        if key not in known:
            raise ValueError(f"{name}: unknown key {key!r}; known: {', '.join(known)}")
    return kind(**value)


def _descriptions(kind: type[JointKind]) -> dict[str, str]:
    """What the docstrings of a kind and its bases say of each attribute."""
    found: dict[str, str] = {}
    for base in reversed(kind.__mro__):
        section = re.search(r"Attributes:\n(.*)", base.__doc__ or "", re.DOTALL)
        for names, text in re.findall(
            r"^        ([\w, ]+): (.*(?:\n {9,}.*)*)", section[1] if section else "", re.MULTILINE
        ):
            found |= dict.fromkeys(names.split(", "), re.sub(r"\s+", " ", text))
    return found


def _model(kind: type[JointKind]) -> type[JointModel]:
    texts = _descriptions(kind)
    fields: dict[str, Any] = {"type": (Literal[kind.type], Field(description="Kind of joint."))}
    for field in dataclasses.fields(kind):
        if field.name not in ("a", "b"):
            text = texts.get(field.name, "Axes that a saved joint has in those of its body, a quaternion.")
            fields[field.name] = (JsonValue, Field(default=None, description=text))
    model: type[JointModel] = create_model(
        f"{kind.__name__}Model", __base__=JointModel, __doc__=(kind.__doc__ or "").split("\n\n")[0], **fields
    )
    model.maker = kind
    return model


JOINTS: dict[str, type[JointModel]] = {kind.type: _model(kind) for kind in KINDS}
"""The model of each kind of joint by its type."""


def describe_joint(joint: Joint) -> dict[str, Any]:
    """A joint as it is now in the form of the schema: everything that its kind would not choose by itself."""
    kind = joint.settings
    entry: dict[str, Any] = {"type": kind.type, "name": joint.name, "a": _end(joint.a), "b": _end(joint.b)}
    for field in dataclasses.fields(kind):
        if field.name not in ("a", "b"):
            value = getattr(kind, field.name)
            if value != field.default and value != {}:
                entry[field.name] = _plain(value)
    return {key: value for key, value in entry.items() if value is not None}


def _end(body: Body | None) -> str | int | None:
    return None if body is None else body.name or body.row


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _plain(each) for name, each in value.items()}
    if dataclasses.is_dataclass(value):
        given = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
        defaults = {field.name: field.default for field in dataclasses.fields(value)}
        return {name: each for name, each in given.items() if each is not None and each != defaults[name]}
    if isinstance(value, tuple):
        return [_plain(each) for each in value]
    return str(value) if value in (math.inf, -math.inf) else value
