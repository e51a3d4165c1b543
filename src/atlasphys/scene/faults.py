"""What is wrong with a scene, said in a line each: file, line, path, and what would be right."""

from __future__ import annotations

import difflib
import re
import reprlib
from collections.abc import Iterable
from typing import NamedTuple

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from atlasphys.errors import SceneError
from atlasphys.scene.joints import JOINTS
from atlasphys.scene.locate import Locations, Path
from atlasphys.scene.schema import SHAPES, BodyModel, SceneModel, WorldModel


class Fault(NamedTuple):
    """One thing that is wrong."""

    path: Path
    message: str


class Source(NamedTuple):
    """Where a scene comes from."""

    name: str
    """File, or name of the scene."""
    locations: Locations | None = None
    """Lines of the values in the file."""

    def error(self, faults: Iterable[Fault]) -> SceneError:
        """The error that lists all faults in the order of the file."""
        placed = [(self.locations.line(fault.path) if self.locations else None, fault) for fault in faults]
        if self.locations:
            placed.sort(key=lambda entry: entry[0] or 0)
        return SceneError("\n".join(self._say(line, fault) for line, fault in placed))

    def _say(self, line: int | None, fault: Fault) -> str:
        parts = [self.name if line is None else f"{self.name}:{line}"]
        if fault.path:
            parts.append(spell(fault.path))
        return ": ".join([*parts, fault.message])


def spell(path: Path) -> str:
    """A path as it is written in messages: ``bodies[3].shape.radius``."""
    text = ""
    for key in path:
        if isinstance(key, int):
            text += f"[{key}]"
        else:
            plain = re.fullmatch(r"[A-Za-z0-9_-]+", key)
            text += ("." if text else "") + (key if plain else show(key))
    return text


def show(value: object) -> str:
    """A value in a few characters."""
    try:
        return reprlib.repr(value)
    except ValueError:  # Python does not print an integer of thousands of digits
        return "a huge integer"


def did_you_mean(word: object, known: Iterable[str]) -> str:
    """The nearest known word as a question, or all of them."""
    known = list(known)
    close = difflib.get_close_matches(str(word), known, n=1)
    return f"did you mean {close[0]!r}?" if close else f"known: {', '.join(known)}"


def argument_fault(path: Path, message: str, known: Iterable[str]) -> Fault:
    """The fault of a refused call: if the message begins with the name of an argument, the path leads to it."""
    found = re.match(r"(\w+)((?:\[\d+\])*) (?=must|cannot|is )", message)
    if found and found[1] in known:
        indices = (int(index) for index in re.findall(r"\d+", found[2]))
        return Fault((*path, found[1], *indices), message[found.end() :])
    return Fault(path, message)


def faults_of(error: ValidationError, root: type[BaseModel] = SceneModel) -> list[Fault]:
    """The faults that pydantic found in the data of a scene, or of another model."""
    found = [details for details in error.errors(include_url=False) if not _repeats(details)]
    return list(dict.fromkeys(_fault(details, root) for details in found))


def _repeats(details: ErrorDetails) -> bool:
    """Whether an array is called too short only because some of its entries are wrong, faults of their own."""
    wanted = details.get("ctx", {}).get("min_length", 0)
    return (
        details["type"] == "too_short"
        and isinstance(details["input"], list | tuple)
        and len(details["input"]) >= wanted
    )


def _fault(details: ErrorDetails, root: type[BaseModel]) -> Fault:
    path, model = _place(details["loc"], root)
    kind, given, context = details["type"], details["input"], details.get("ctx", {})
    if kind == "missing":
        return Fault(path, "is required")
    if kind in ("too_short", "too_long"):
        length = context.get("min_length", context.get("max_length"))
        return Fault(path, f"must have {length} entries (got {show(given)})")
    if kind == "extra_forbidden":
        what = "key" if root is SceneModel else "parameter"
        return Fault(path, f"unknown {what}; {did_you_mean(path[-1], model.model_fields)}")
    if kind == "value_error":
        return argument_fault(path, str(context["error"]), model.model_fields)
    what, types = ("joint", list(JOINTS)) if path[:1] == ("joints",) else ("shape", list(SHAPES))
    if kind == "union_tag_not_found":
        return Fault(path, f"must have a key 'type', one of {', '.join(types)}")
    if kind == "union_tag_invalid":
        return Fault((*path, "type"), f"unknown {what} {show(context['tag'])}; {did_you_mean(context['tag'], types)}")
    wanted = _WANTED.get(kind) or re.sub(r"^(Input|String|Value|Tuple) should ", "", details["msg"])
    suggestion = ""
    if kind == "literal_error" and isinstance(given, str):
        suggestion = "; " + did_you_mean(given, re.findall(r"'(\w+)'", str(context["expected"])))
    return Fault(path, f"must {wanted} (got {show(given)}){suggestion}")


_WANTED = {
    "tuple_type": "be an array",
    "model_type": "be a table",
    "model_attributes_type": "be a table",
    "float_type": "be a number",
    "int_type": "be a whole number",
    "string_type": "be text",
}


def _place(location: tuple[int | str, ...], root: type[BaseModel]) -> tuple[Path, type[BaseModel]]:
    """Path of an error, and the model that found it. Pydantic puts a shape's type between ``shape`` and its keys, and a joint's before its own."""
    if location[:1] == ("world",):
        return location, WorldModel
    if location[:1] == ("joints",) and len(location) > 2:
        return location[:2] + location[3:], JOINTS[str(location[2])]
    if location[:1] != ("bodies",) or len(location) < 3:
        return location, root
    if location[2] != "shape" or len(location) < 4:
        return location, BodyModel
    return location[:3] + location[4:], SHAPES[str(location[3])]
