"""Input fields for the settings of joints: how each is entered, read back, and what it means."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

from atlasphys.engine.joints.kinds.kind import JointKind
from atlasphys.engine.joints.part import Elastic, Motor
from atlasphys.errors import InvalidArgumentError
from atlasphys.viewer.gui.forms import Form

Reader = Callable[[dict[str, Any]], Any]
"""Takes the form's values to the value of a setting."""


def setting_fields(form: Form, kind: type[JointKind], values: Any) -> dict[str, Reader]:
    """Make fields for the settings that a kind of joint has; returns how each is read.

    Args:
        form: where they are made.
        kind: the kind.
        values: a joint of that kind, or a mapping from names to values, whose settings they show at first.
    """
    known = {field.name for field in dataclasses.fields(kind)}
    readers = {}
    for name, (sort, hint) in SETTINGS.items():
        if name in known:
            value = values[name] if isinstance(values, dict) else getattr(values, name)
            sort = MAPPED if name == "friction" and isinstance(value, dict) else sort
            readers[name] = SORTS[sort](form, name, value, FRICTIONS if sort == MAPPED else hint)
    return readers


def numbers(label: str, text: str, count: int) -> tuple[float, ...]:
    """Numbers from a text.

    Raises:
        InvalidArgumentError: it says none, or another count of them.
    """
    try:
        result = tuple(float(word) for word in text.replace(",", " ").split())
    except ValueError:
        result = ()
    if len(result) != count:
        wanted = ("a number", "two numbers", "three numbers")[count - 1]
        raise InvalidArgumentError(f"{label} must be {wanted} (got {text!r})")
    return result


def label_of(name: str) -> str:
    """What stands beside a field."""
    return name.replace("_", " ").capitalize()


def _text(value: Any) -> str:
    return "" if value is None else " ".join(f"{x:.7g}" for x in (value if isinstance(value, tuple) else (value,)))


def _number(form: Form, name: str, value: Any, hint: str) -> Reader:
    form.text(name, label_of(name), _text(value), hint)
    return lambda entered: numbers(name, entered[name], 1)[0]


def _number_or_none(form: Form, name: str, value: Any, hint: str) -> Reader:
    read = _number(form, name, value, hint)
    return lambda entered: read(entered) if entered[name].strip() else None


def _range(form: Form, name: str, value: Any, hint: str) -> Reader:
    form.text(name, label_of(name), _text(value), hint)
    return lambda entered: numbers(name, entered[name], 2) if entered[name].strip() else None


def _freedom(form: Form, name: str, value: Any, hint: str) -> Reader:
    form.text(name, name, value if isinstance(value, str) else _text(value), hint)

    def read(entered: dict[str, Any]) -> Any:
        text = entered[name].strip()
        return text if text in ("free", "locked") else numbers(name, text, 2)

    return read


def _vector(form: Form, name: str, value: Any, hint: str) -> Reader:
    form.vector(name, label_of(name), value, hint)
    return lambda entered: entered[name]


def _flag(form: Form, name: str, value: Any, hint: str) -> Reader:
    form.flag(name, label_of(name), value, hint)
    return lambda entered: entered[name]


def _motor(form: Form, name: str, value: Any, hint: str) -> Reader:
    drives = "nothing" if value is None else "speed" if value.position is None else "position"
    aim = 0.0 if value is None else value.speed if value.position is None else value.position
    form.choice(f"{name}.to", f"{label_of(name)} drives to", ("nothing", "speed", "position"), drives, hint)
    form.text(f"{name}.aim", f"{label_of(name)} speed or position", _text(aim), "[rad/s, m/s; rad, m]")
    greatest = "inf" if value is None else _text(value.max_force)
    form.text(f"{name}.most", f"{label_of(name)} max force", greatest, "[N, N m], or inf")

    def read(entered: dict[str, Any]) -> Motor | None:
        to = entered[f"{name}.to"]
        if to == "nothing":
            return None
        (aimed,) = numbers(f"{name} {to}", entered[f"{name}.aim"], 1)
        (most,) = numbers(f"{name} max_force", entered[f"{name}.most"], 1)
        spring = {} if value is None else {"frequency": value.frequency, "damping": value.damping}
        return Motor(**{to: aimed}, max_force=most, **spring)

    return read


def _spring(form: Form, name: str, value: Any, hint: str) -> Reader:
    form.text(f"{name}.frequency", f"{label_of(name)} frequency", "" if value is None else _text(value.frequency), hint)
    damping = 0.0 if value is None else value.damping
    form.text(f"{name}.damping", f"{label_of(name)} damping", _text(damping), "Damping ratio")

    def read(entered: dict[str, Any]) -> Elastic | None:
        if not entered[f"{name}.frequency"].strip():
            return None
        (frequency,) = numbers(f"{name} frequency", entered[f"{name}.frequency"], 1)
        (damped,) = numbers(f"{name} damping", entered[f"{name}.damping"], 1)
        kept = {} if value is None else {"rest": value.rest, "max_force": value.max_force}
        return Elastic(frequency=frequency, damping=damped, **kept)

    return read


def by_name(title: str, text: str, read: Callable[[str, list[float]], Any]) -> dict[str, Any]:
    """A mapping from a text like ``x 2 0.5, rx 3``: a name and its numbers, between commas.

    Raises:
        InvalidArgumentError: it is not of that form.
    """
    found: dict[str, Any] = {}
    for entry in text.split(","):
        name, *words = entry.split() or [""]
        if name in found:
            raise InvalidArgumentError(f"{title}: {name} is given twice")
        if name:
            found[name] = read(f"{title} of {name}", list(numbers(f"{title} of {name}", " ".join(words), len(words))))
    return found


def _mapped(form: Form, name: str, value: Any, hint: str) -> Reader:
    """Friction of degrees of freedom by name."""
    form.text(name, label_of(name), ", ".join(f"{key} {each:.7g}" for key, each in value.items()), hint)
    return lambda entered: by_name(name, entered[name], lambda title, given: _some(title, given, "a number", 1)[0])


def _some(title: str, given: list[float], wanted: str, *counts: int) -> list[float]:
    if len(given) not in counts:
        raise InvalidArgumentError(f"{title} must be {wanted} (got {len(given)} numbers)")
    return given


def _springs(form: Form, name: str, value: Any, hint: str) -> Reader:
    text = ", ".join(f"{key} {each.frequency:.7g} {each.damping:.7g}" for key, each in value.items())
    form.text(name, label_of(name), text, hint)

    def elastic(title: str, given: list[float]) -> Elastic:
        frequency, damping = [*_some(title, given, "a frequency and a damping ratio", 1, 2), 0.0][:2]
        kept = value.get(title.rpartition(" ")[2])
        more = {} if kept is None else {"rest": kept.rest, "max_force": kept.max_force}
        return Elastic(frequency=frequency, damping=damping, **more)

    return lambda entered: by_name(name, entered[name], elastic)


def _motors(form: Form, name: str, value: Any, hint: str) -> Reader:
    held = {key: each for key, each in value.items() if each.position is not None}
    text = ", ".join(f"{key} {each.speed:.7g} {each.max_force:.7g}" for key, each in value.items() if key not in held)
    form.text(name, label_of(name), text, hint)

    def motor(title: str, given: list[float]) -> Motor:
        speed, most = [*_some(title, given, "a speed and a greatest force", 1, 2), float("inf")][:2]
        return Motor(speed=speed, max_force=most)

    return lambda entered: held | by_name(name, entered[name], motor)


MAPPED = "by name"
SORTS: dict[str, Callable[[Form, str, Any, str], Reader]] = {
    "number": _number, "number or none": _number_or_none, "range": _range, "freedom": _freedom, "vector": _vector,
    "flag": _flag, "motor": _motor, "spring": _spring, "springs": _springs, "motors": _motors, MAPPED: _mapped,
}  # fmt: skip

RANGE = "Least and greatest [rad, m], either may be inf; empty: none"
FREEDOM = "free, locked, or least and greatest [m, rad]"
SPRING = "[Hz]; empty: no spring"
FRICTIONS = "Greatest force or torque by degree of freedom: x 20, rx 3 [N, N m]"
SETTINGS = {
    **dict.fromkeys(("x", "y", "z", "rx", "ry", "rz"), ("freedom", FREEDOM)),
    "ratio": ("number", "Of a gear: a's radius to b's, negative: both turn the same way; of a pulley: rope that b takes for each metre"),
    "radius": ("number", "Of the pinion [m]"),
    "limits": ("range", RANGE),
    "limits_b": ("range", RANGE),
    "cone": ("number or none", "Greatest swing [rad]; empty: any"),
    "twist": ("range", RANGE),
    "length": ("number or none", "[m]; empty: the present one"),
    "rest_length": ("number or none", "[m]; empty: the present one"),
    "taut": ("flag", "Whether the rope keeps its length, rather than going slack"),
    "target": ("vector", "[m]"),
    "motor": ("motor", "What the motor is for"),
    "motor_b": ("motor", "What the motor is for"),
    "motors": ("motors", "Speed and greatest force by degree of freedom: x 1.5 200, rx 2 [m/s, rad/s; N, N m]"),
    "steering": ("number", "[rad]"),
    "spring": ("spring", SPRING),
    "spring_b": ("spring", SPRING),
    "springs": ("springs", "Frequency [Hz] and damping ratio by degree of freedom: x 2 0.5, rx 3"),
    "frequency": ("number", "Of the spring [Hz]"),
    "damping": ("number", "Damping ratio of the spring"),
    "max_force": ("number", "Of the spring [N], or inf"),
    "friction": ("number", "Greatest force or torque [N, N m]"),
    "friction_b": ("number", "Greatest torque [N m]"),
    "breaking_force": ("number", "[N], or inf"),
    "breaking_torque": ("number", "[N m], or inf"),
    "collide": ("flag", "Whether the two bodies collide with each other"),
}  # fmt: skip
"""Settings of joints that can be changed: how each is entered, and what it means."""
