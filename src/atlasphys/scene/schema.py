"""What a scene file may hold, as pydantic models: version 1 of the schema.

A setting that is left out has the default of :class:`atlasphys.World` or of ``World.add``; none is repeated here.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, PrivateAttr, Strict, StringConstraints, model_validator

import atlasphys.engine.shapes as shapes
from atlasphys.engine.shapes.shape import Shape
from atlasphys.errors import InvalidArgumentError
from atlasphys.scene.locate import Locations

VERSION = 1
"""Version of the schema that is written, and the newest that is read."""

Real = Annotated[float, Strict(), Field(allow_inf_nan=False)]
"""A finite number; text and true or false are not taken for one."""
Positive = Annotated[Real, Field(gt=0)]
Fraction = Annotated[Real, Field(ge=0)]
NotNegative = Annotated[Real, Field(ge=0)]
Whole = Annotated[int, Strict()]
Text = Annotated[str, Strict()]
Name = Annotated[str, Strict(), StringConstraints(min_length=1, max_length=200)]
Vector = tuple[Real, Real, Real]
Quaternion = tuple[Real, Real, Real, Real]


class Model(BaseModel):
    """What all parts of a scene have in common: unknown keys, infinities and NaN are refused."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True, frozen=True)

    def given(self) -> dict[str, Any]:
        """The settings that were given, as Python values."""
        return {name: getattr(self, name) for name in self.model_fields_set if getattr(self, name) is not None}


class ShapeModel(Model):
    """A shape: the arguments of one of the public shapes, checked by making it."""

    maker: ClassVar[str]
    """Name of the class or factory in :mod:`atlasphys`."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        self.make()
        return self

    def make(self) -> Shape:
        """The shape.

        Raises:
            InvalidArgumentError: the arguments make none.
        """
        maker = getattr(shapes, self.maker)
        return maker(**{name: value for name, value in self.given().items() if name != "type"})  # type: ignore[no-any-return]
