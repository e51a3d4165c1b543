"""Input fields that are made from values or from the scene schema, and read back together."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from pydantic.fields import FieldInfo

from atlasphys.errors import AtlasPhysError, InvalidArgumentError

DIGITS = 6
"""Decimals that can be typed."""


class Form:
    """Input fields by name. Made where viser's present container is.

    Args:
        gui: of the server or of one client.
    """

    def __init__(self, gui: Any) -> None:
        self._gui = gui
        self._read: dict[str, Callable[[], Any]] = {}
        self.handles: dict[str, Any] = {}

    def values(self) -> dict[str, Any]:
        """What has been entered, by name.

        Raises:
            InvalidArgumentError: a text does not say what it should.
        """
        return {name: read() for name, read in self._read.items()}

    def _keep(self, name: str, handle: Any, read: Callable[[], Any] | None = None) -> Any:
        self.handles[name] = handle
        self._read[name] = read or (lambda: handle.value)
        return handle

    def number(self, name: str, label: str, value: float, hint: str | None = None, step: float = 0.1) -> Any:
        """A number."""
        handle = self._gui.add_number(label, float(value), step=step, hint=hint)
        handle.precision = DIGITS
        return self._keep(name, handle, lambda: float(handle.value))

    def whole(self, name: str, label: str, value: int, hint: str | None = None) -> Any:
        """A whole number."""
        handle = self._gui.add_number(label, int(value), step=1, hint=hint)
        return self._keep(name, handle, lambda: int(handle.value))

    def vector(self, name: str, label: str, value: Any, hint: str | None = None) -> Any:
        """Three numbers."""
        handle = self._gui.add_vector3(label, tuple(float(x) for x in value), step=0.1, hint=hint)
        handle.precision = DIGITS
        return self._keep(name, handle, lambda: tuple(float(x) for x in handle.value))

    def choice(self, name: str, label: str, options: tuple[str, ...], value: str, hint: str | None = None) -> Any:
        """One of some names."""
        return self._keep(name, self._gui.add_dropdown(label, options, initial_value=value, hint=hint))

    def flag(self, name: str, label: str, value: bool, hint: str | None = None) -> Any:
        """Yes or no."""
        return self._keep(name, self._gui.add_checkbox(label, bool(value), hint=hint))

    def text(self, name: str, label: str, value: str, hint: str | None = None) -> Any:
        """A text."""
        return self._keep(name, self._gui.add_text(label, value, hint=hint))

    def colour(self, name: str, label: str, value: tuple[int, int, int]) -> Any:
        """A colour, read as ``#rrggbb``."""
        handle = self._gui.add_rgb(label, value)
        return self._keep(name, handle, lambda: "#{:02x}{:02x}{:02x}".format(*handle.value))

    def rotation(self, name: str, label: str, quaternion: Any = (1.0, 0.0, 0.0, 0.0)) -> Any:
        """Angles about x, then y, then z [°], read as a quaternion (w, x, y, z)."""
        hint = "Rotation about the world's x, then y, then z axis [°]"
        handle = self._gui.add_vector3(label, degrees_of(quaternion), step=5.0, hint=hint)
        handle.precision = 3
        return self._keep(name, handle, lambda: quaternion_of(handle.value))

    def points(self, name: str, label: str, value: str, hint: str | None = None) -> Any:
        """Points, a line each."""
        handle = self._gui.add_text(label, value, multiline=True, hint=hint)
        return self._keep(name, handle, lambda: parse_points(handle.value))

    def from_schema(self, name: str, field: FieldInfo, value: Any = None) -> Any:
        """A field of a shape, or of a library scene's parameters, of the kind that its type asks for."""
        label, hint = name.replace("_", " ").capitalize(), field.description
        default: Any = value if value is not None else START.get(name, field.default)
        kind = str(field.annotation)
        if name == "points":
            return self.points(name, label, str(default), hint)
        if name in ("size", "normal") or isinstance(default, tuple | list):
            return self.vector(name, label, default, hint)
        if isinstance(default, bool):
            return self.flag(name, label, default, hint)
        if "int" in kind:
            return self.whole(name, label, default, hint)
        return self.number(name, label, default, hint)


START = {
    "size": (1.0, 1.0, 1.0), "radius": 0.5, "length": 1.0, "height": 1.0, "sides": 4, "normal": (0.0, 1.0, 0.0), "offset": 0.0,
    "points": "0 0 0\n1 0 0\n0 1 0\n0 0 1",
}  # fmt: skip
"""Sizes that a new body starts with."""


def parse_points(text: str) -> list[tuple[float, ...]]:
    """Points from lines of three numbers.

    Raises:
        InvalidArgumentError: a line is none.
    """
    points: list[tuple[float, ...]] = []
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip():
            continue
        try:
            x, y, z = (float(word) for word in line.replace(",", " ").split())
        except ValueError:
            raise InvalidArgumentError(f"points: line {number} must be three numbers (got {line!r})") from None
        points.append((x, y, z))
    return points


def quaternion_of(degrees: Any) -> tuple[float, float, float, float]:
    """The rotation about the world's x, then y, then z axis."""
    (cx, sx), (cy, sy), (cz, sz) = ((math.cos(a), math.sin(a)) for a in (math.radians(d) / 2 for d in degrees))
    return (
        cz * cy * cx + sz * sy * sx,
        cz * cy * sx - sz * sy * cx,
        cz * sy * cx + sz * cy * sx,
        sz * cy * cx - cz * sy * sx,
    )


def degrees_of(quaternion: Any) -> tuple[float, float, float]:
    """Angles that :func:`quaternion_of` takes back to the rotation."""
    w, x, y, z = (float(c) for c in quaternion)
    about_x = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    about_y = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
    about_z = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return math.degrees(about_x), math.degrees(about_y), math.degrees(about_z)


class Dialog:
    """A window in front of the page of one client. It stays open until its action succeeds or it is cancelled.

    Args:
        client: whose page.
        title: what it is for.
    """

    def __init__(self, client: Any, title: str) -> None:
        self.client, self.gui = client, client.gui
        self._modal = client.gui.add_modal(title)

    def __enter__(self) -> Dialog:
        self._modal.__enter__()
        return self

    def __exit__(self, *error: Any) -> None:
        self._modal.__exit__(*error)

    def buttons(self, label: str, act: Callable[[], Any], **more: Callable[[], Any]) -> None:
        """The button of the action, others, and Cancel. What an action refuses is said in the dialog."""
        self._refusal = self.gui.add_markdown("", visible=False)
        for name, action in {label: act, **more}.items():
            button = self.gui.add_button(name, color="blue" if name == label else None)
            button.on_click(lambda _, action=action: self._try(action))
        self.gui.add_button("Cancel", color="gray").on_click(lambda _: self.close())

    def _try(self, action: Callable[[], Any]) -> None:
        try:
            action()
        except AtlasPhysError as error:
            lines = str(error).splitlines()
            self._refusal.content = "**Not possible:**\n\n" + "\n".join(f"- {_escaped(line)}" for line in lines)
            self._refusal.visible = True
        else:
            self.close()

    def close(self) -> None:
        """Close it."""
        self._modal.close()


def _escaped(text: str) -> str:
    """Text that Markdown shows as it is."""
    return "".join("\\" + c if c in "\\`*_{}[]<>#" else c for c in text)
