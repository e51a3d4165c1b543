"""Read a scene from a file, or make one of the library's."""

from __future__ import annotations

import json
import re
import tomllib
from os import PathLike
from pathlib import Path
from typing import Any

from atlasphys.errors import SceneError
from atlasphys.scene import library
from atlasphys.scene.faults import Fault, Source, did_you_mean, show
from atlasphys.scene.locate import Locations
from atlasphys.scene.scene import Scene
from atlasphys.scene.schema import VERSION


def load_scene(name_or_path: str | PathLike[str], /, **parameters: Any) -> Scene:
    """A scene from the library or from a file.

    Args:
        name_or_path: name of a scene of the library; else a TOML or JSON file (JSON if its name ends in ``.json``).
        parameters: values of the library scene's parameters; text is read as on the command line.

    Raises:
        SceneError: there is no such scene or file, or it is wrong: every fault is listed with file, line and path.

    >>> load_scene("tower", height=3)
    Scene('tower', 4 bodies, 10 s at dt 0.01667 s)
    """
    if isinstance(name_or_path, str) and name_or_path in library.names():
        return library.make(name_or_path, parameters)
    path = Path(name_or_path)
    looks_like_a_name = isinstance(name_or_path, str) and re.fullmatch(r"[A-Za-z0-9_-]+", name_or_path)
    if looks_like_a_name and not path.exists():
        suggestion = did_you_mean(name_or_path, library.names())
        raise SceneError(f"{name_or_path}: neither a scene of the library nor a file; {suggestion}")
    if parameters:
        raise SceneError(f"{path}: a scene file has no parameters (got {', '.join(parameters)})")
    return read_scene(path)


def read_scene(path: Path) -> Scene:
    """The scene in a TOML or JSON file.

    Raises:
        SceneError: the file cannot be read or is wrong: every fault is listed with file, line and path.
    """
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise SceneError(f"{path}: is not UTF-8 text (byte {error.start})") from None
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        raise SceneError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    return parse_scene(text, name=str(path), is_json=path.suffix.lower() == ".json")


def parse_scene(text: str, *, name: str, is_json: bool) -> Scene:
    """The scene in a TOML or JSON text; ``name`` stands for the file in messages.

    Raises:
        SceneError: every fault is listed with line and path.
    """
    data = _parse(text, name, is_json)
    source = Source(name, Locations(text, is_json=is_json))
    if not isinstance(data, dict):
        raise source.error([Fault((), f"must be an object with the keys of a scene (got {show(data)})")])
    if not data:
        raise SceneError(f"{name}: is empty; a scene begins with version = {VERSION}")
    version = data.get("version")
    if isinstance(version, int) and not isinstance(version, bool) and version != VERSION:
        raise source.error(
            [
                Fault(
                    ("version",), f"is {show(version)}, and this version of AtlasPhys reads scenes of version {VERSION}"
                )
            ]
        )
    if source.locations and source.locations.repeated:
        raise source.error(Fault(path, "is given twice") for path in source.locations.repeated)
    return Scene.from_data(data, source)


def _parse(text: str, name: str, is_json: bool) -> Any:
    kind = "JSON" if is_json else "TOML"
    try:
        return json.loads(text) if is_json else tomllib.loads(text)
    except json.JSONDecodeError as error:
        raise SceneError(f"{name}:{error.lineno}:{error.colno}: not valid JSON: {error.msg}") from None
    except tomllib.TOMLDecodeError as error:
        message, line, column = str(error), text.count("\n") + 1, 1
        if found := re.fullmatch(r"(.*) \(at (?:line (\d+), column (\d+)|end of document)\)", message, re.DOTALL):
            message = found[1]
            line, column = int(found[2] or line), int(found[3] or len(text) - text.rfind("\n"))
        raise SceneError(f"{name}:{line}:{column}: not valid TOML: {message}") from None
    except RecursionError:
        raise SceneError(f"{name}: not valid {kind} for a scene: nested too deeply") from None
    except ValueError:  # Python does not read an integer of thousands of digits
        raise SceneError(f"{name}: not valid {kind} for a scene: a number has too many digits") from None
