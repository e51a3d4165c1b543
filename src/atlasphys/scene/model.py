"""What all parts of the scene schema are made of."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, Strict, StringConstraints

Real = Annotated[float, Strict(), Field(allow_inf_nan=False)]
"""A finite number; text and booleans are not taken for one."""
Positive = Annotated[Real, Field(gt=0)]
NotNegative = Annotated[Real, Field(ge=0)]
Whole = Annotated[int, Strict()]
Flag = Annotated[bool, Strict()]
Text = Annotated[str, Strict()]
Name = Annotated[str, Strict(), StringConstraints(min_length=1)]
Vector = Annotated[tuple[Real, ...], Field(min_length=3, max_length=3)]
Quaternion = Annotated[tuple[Real, ...], Field(min_length=4, max_length=4)]


class Model(BaseModel):
    """What all parts of a scene have in common: an unknown key is an error, and a value never changes."""

    model_config = ConfigDict(extra="forbid", use_attribute_docstrings=True, frozen=True)

    def given(self) -> dict[str, Any]:
        """The settings that were given and are not None, by name, in the order of the schema."""
        chosen = ((name, getattr(self, name)) for name in type(self).model_fields if name in self.model_fields_set)
        return {name: value for name, value in chosen if value is not None}
