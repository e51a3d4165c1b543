"""Write a scene as TOML: one table a body or joint, short values in one line."""

from __future__ import annotations

import json
import re
from typing import Any


def to_toml(data: dict[str, Any]) -> str:
    """TOML text of a scene's data."""
    lines = _pairs({key: value for key, value in data.items() if key not in ("world", "bodies", "joints")})
    if data.get("world"):
        lines += ["", "[world]", *_pairs(data["world"])]
    for body in data.get("bodies", ()):
        lines += ["", "[[bodies]]", *_pairs(body)]
    for joint in data.get("joints", ()):
        lines += ["", "[[joints]]", *_pairs(joint)]
    return "\n".join(lines) + "\n"


def _pairs(table: dict[str, Any]) -> list[str]:
    return [f"{_key(key)} = {_value(value)}" for key, value in table.items()]


def _key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else _value(key)


def _value(value: Any) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(_pairs(value)) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return json.dumps(value)  # numbers and booleans are written alike; floats with all the digits that they need
