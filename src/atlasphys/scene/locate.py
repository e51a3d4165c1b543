"""Where each value of a TOML or JSON text stands, for error messages: ``tomllib`` and ``json`` do not tell.

The text must already have been accepted by the parser.
"""

from __future__ import annotations

import json
import re
import tomllib
from typing import Any

Path = tuple[str | int, ...]
"""Keys and indices from the root to a value, for example ``("bodies", 3, "shape", "radius")``."""

_BLANK = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
_STRING = re.compile(
    r'"""(?:[^"\\]|\\.|"{1,2}(?!"))*"{3,5}'
    r"|'''(?:[^']|'{1,2}(?!'))*'{3,5}"
    r'|"(?:[^"\\]|\\.)*"'
    r"|'[^']*'",
    re.DOTALL,
)
_SCALAR = re.compile(r"\d{4}-\d\d-\d\d \d\d:[^\s,\]}#]+|[^\s,\]}#]+")  # a TOML date may hold one blank


class Locations:
    """The place of every value in a text, by its path."""

    def __init__(self, text: str, *, is_json: bool) -> None:
        self.spans: dict[Path, tuple[int, int]] = {}
        """Start and end of each value's text; of a table with a header of its own, the header's."""
        self.repeated: list[Path] = []
        """Keys that a JSON object gives twice (TOML's parser refuses them)."""
        self._text = text.replace("\r\n", "\n")
        self._is_json = is_json
        self._at = 0
        self._table_arrays: dict[Path, int] = {}
        self._skip_blank()
        if is_json:
            self._value(())
        else:
            self._document()

    def line(self, path: Path) -> int:
        """The line, from 1, of the value at ``path``; if there is none, of the innermost value that would hold it."""
        while path and path not in self.spans:
            path = path[:-1]
        return self._text.count("\n", 0, self.spans[path][0]) + 1 if path in self.spans else 1

    def _document(self) -> None:
        table: Path = ()
        while self._at < len(self._text):
            start = self._at
            if self._skip("[["):
                *parents, last = self._key()
                array = (*self._resolve(parents), last)
                index = self._table_arrays[array] = self._table_arrays.get(array, -1) + 1
                table = (*array, index)
                self._skip("]]")
                self._put(table, start, self._at)
            elif self._skip("["):
                table = self._resolve(self._key())
                self._skip("]")
                self._put(table, start, self._at)
            else:
                self._pair(table)
            self._skip_blank()

    def _resolve(self, keys: list[str]) -> Path:
        """The path that a header names: a key of an array of tables means its newest table."""
        path: Path = ()
        for key in keys:
            path = (*path, key)
            if path in self._table_arrays:
                path = (*path, self._table_arrays[path])
        return path

    def _pair(self, table: Path) -> None:
        start = self._at
        path = (*table, *self._key())
        for length in range(len(table) + 1, len(path)):  # the tables that a dotted key makes
            self.spans.setdefault(path[:length], (start, self._at))
        self._skip(":" if self._is_json else "=")
        self._skip_blank()
        self._value(path)

    def _key(self) -> list[str]:
        parts: list[str] = []
        while True:
            self._skip_blank()
            if self._text[self._at] in "\"'":
                quoted = self._match(_STRING)
                parts.append(json.loads(quoted) if self._is_json else tomllib.loads(f"x = {quoted}")["x"])
            else:
                parts.append(self._match(_BARE_KEY))
            self._skip_blank()
            if self._is_json or not self._skip("."):
                return parts

    def _value(self, path: Path) -> None:
        start = self._at
        if self._text[start] == "[":
            self._items(path, "]")
        elif self._text[start] == "{":
            self._items(path, "}")
        else:
            self._match(_STRING if self._text[start] in "\"'" else _SCALAR)
        self._put(path, start, self._at)

    def _items(self, path: Path, end: str) -> None:
        """An array, or an inline table or JSON object."""
        self._at += 1
        index = 0
        self._skip_blank()
        while not self._skip(end):
            if end == "]":
                self._value((*path, index))
            else:
                self._pair(path)
            index += 1
            self._skip_blank()
            self._skip(",")
            self._skip_blank()

    def _put(self, path: Path, start: int, end: int) -> None:
        if self._is_json and path in self.spans:
            self.repeated.append(path)
        self.spans[path] = (start, end)
        for length in range(1, 0 if self._is_json else len(path)):  # tables and arrays that only headers imply
            self.spans.setdefault(path[:length], (start, end))

    def _skip(self, token: str) -> bool:
        found = self._text.startswith(token, self._at)
        self._at += len(token) * found
        return found

    def _skip_blank(self) -> None:
        self._at += len(_match(_BLANK, self._text, self._at))

    def _match(self, pattern: re.Pattern[str]) -> str:
        found = _match(pattern, self._text, self._at)
        self._at += len(found)
        return found


def _match(pattern: re.Pattern[str], text: str, position: int) -> str:
    found = pattern.match(text, position)
    if found is None:
        raise AssertionError(f"the text at {position} was not checked by a parser")
    return found[0]


def value_at(data: Any, path: Path) -> Any:
    """The value at ``path`` in parsed data.

    Raises:
        LookupError: there is none.
    """
    for key in path:
        if not isinstance(data, dict | list):
            raise LookupError(path)
        data = data[key]  # type: ignore[index]
    return data
