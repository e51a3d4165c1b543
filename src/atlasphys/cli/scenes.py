"""``atlasphys scenes``: what the library holds."""

from __future__ import annotations

import json as json_format
from typing import Annotated

from cyclopts import Parameter


def scenes(
    *, json: Annotated[bool, Parameter(negative=())] = False, schema: Annotated[bool, Parameter(negative=())] = False
) -> int:
    """List the scenes of the library with their parameters.

    Parameters
    ----------
    json
        Print one JSON object instead of a table.
    schema
        Print the JSON Schema of scene files instead.
    """
    from atlasphys.scene import library

    if schema:
        from atlasphys.scene.schema import SceneModel

        print(json_format.dumps(SceneModel.model_json_schema(), indent=2))
        return 0
    entries = [library.entry(name) for name in library.names()]
    if json:
        listed = {
            entry.name: {
                "description": entry.description,
                "parameters": entry.parameters.model_json_schema().get("properties", {}),
            }
            for entry in entries
        }
        print(json_format.dumps(listed, ensure_ascii=False))
        return 0
    for entry in entries:
        print(f"{entry.name:15} {entry.description:72} {entry.usage()}".rstrip())
    return 0
