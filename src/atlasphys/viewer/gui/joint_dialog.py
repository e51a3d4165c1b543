"""The dialog that changes a joint: a text for each of its settings, which may be left empty where there may be none."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from atlasphys.engine.joints.part import Elastic, Motor
from atlasphys.errors import InvalidArgumentError
from atlasphys.viewer.gui.body_dialogs import PATIENCE
from atlasphys.viewer.gui.forms import Dialog, Form

if TYPE_CHECKING:
    from atlasphys.viewer.gui.page import Page


def edit_joint_dialog(page: Page, client: Any, identity: int) -> None:
    """Change what can be changed of a joint."""

    def read(session: Any) -> tuple[Any, bool, bool]:
        joint = session.joint(identity)
        return joint.settings, joint.enabled, joint.broken

    settings, enabled, broken = page.do(read, client).result(PATIENCE)
    with Dialog(client, f"Edit {type(settings).__name__}") as dialog:
        form = Form(dialog.gui)
        form.flag("enabled", "Enabled", enabled, "Whether the joint acts")
        if broken:
            form.flag("broken", "Broken", broken, "Uncheck to mend it")
        readers = {}
        for name, (kind, hint) in SETTINGS.items():
            if hasattr(type(settings), name) and name in settings.__dataclass_fields__:
                readers[name] = KINDS[kind](form, name, getattr(settings, name), hint)
        shown = form.values()

        def apply() -> None:
            entered = form.values()
            changes = {name: entered[name] for name in ("enabled", "broken") if entered.get(name) != shown.get(name)}
            for name, reader in readers.items():
                if any(entered[key] != shown[key] for key in entered if key.split(".")[0] == name):
                    changes[name] = reader(entered)
            page.simulation.do(lambda session: session.edit_joint(identity, changes)).result(PATIENCE)

        dialog.buttons("Apply", apply)


Reader = Callable[[dict[str, Any]], Any]
"""Takes the form's values to the value of a setting."""


def _label(name: str) -> str:
    return name.replace("_", " ").capitalize()


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


def _text(value: Any) -> str:
    return "" if value is None else " ".join(f"{x:.7g}" for x in (value if isinstance(value, tuple) else (value,)))


def _number(form: Form, name: str, value: Any, hint: str) -> Reader:
    form.text(name, _label(name), _text(value), hint)
    return lambda entered: numbers(name, entered[name], 1)[0]


def _number_or_none(form: Form, name: str, value: Any, hint: str) -> Reader:
    read = _number(form, name, value, hint)
    return lambda entered: read(entered) if entered[name].strip() else None


def _range(form: Form, name: str, value: Any, hint: str) -> Reader:
    form.text(name, _label(name), _text(value), hint)
    return lambda entered: numbers(name, entered[name], 2) if entered[name].strip() else None


def _freedom(form: Form, name: str, value: Any, hint: str) -> Reader:
    form.text(name, name, value if isinstance(value, str) else _text(value), hint)

    def read(entered: dict[str, Any]) -> Any:
        text = entered[name].strip()
        return text if text in ("free", "locked") else numbers(name, text, 2)

    return read


def _vector(form: Form, name: str, value: Any, hint: str) -> Reader:
    form.vector(name, _label(name), value, hint)
    return lambda entered: entered[name]


def _flag(form: Form, name: str, value: Any, hint: str) -> Reader:
    form.flag(name, _label(name), value, hint)
    return lambda entered: entered[name]


def _motor(form: Form, name: str, value: Any, hint: str) -> Reader:
    drives = "nothing" if value is None else "speed" if value.position is None else "position"
    aim = 0.0 if value is None else value.speed if value.position is None else value.position
    form.choice(f"{name}.to", f"{_label(name)} drives to", ("nothing", "speed", "position"), drives, hint)
    form.text(f"{name}.aim", f"{_label(name)} speed or position", _text(aim), "[rad/s, m/s; rad, m]")
    greatest = "inf" if value is None else _text(value.max_force)
    form.text(f"{name}.most", f"{_label(name)} max force", greatest, "[N, N m], or inf")

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
    form.text(f"{name}.frequency", f"{_label(name)} frequency", "" if value is None else _text(value.frequency), hint)
    damping = 0.0 if value is None else value.damping
    form.text(f"{name}.damping", f"{_label(name)} damping", _text(damping), "Damping ratio")

    def read(entered: dict[str, Any]) -> Elastic | None:
        if not entered[f"{name}.frequency"].strip():
            return None
        (frequency,) = numbers(f"{name} frequency", entered[f"{name}.frequency"], 1)
        (damped,) = numbers(f"{name} damping", entered[f"{name}.damping"], 1)
        kept = {} if value is None else {"rest": value.rest, "max_force": value.max_force}
        return Elastic(frequency=frequency, damping=damped, **kept)

    return read


KINDS: dict[str, Callable[[Form, str, Any, str], Reader]] = {
    "number": _number, "number or none": _number_or_none, "range": _range, "freedom": _freedom, "vector": _vector,
    "flag": _flag, "motor": _motor, "spring": _spring,
}  # fmt: skip

RANGE = "Least and greatest [rad, m], either may be inf; empty: none"
FREEDOM = "free, locked, or least and greatest [m, rad]"
SPRING = "[Hz]; empty: no spring"
SETTINGS = {
    **dict.fromkeys(("x", "y", "z", "rx", "ry", "rz"), ("freedom", FREEDOM)),
    "limits": ("range", RANGE),
    "limits_b": ("range", RANGE),
    "cone": ("number or none", "Greatest swing [rad]; empty: any"),
    "twist": ("range", RANGE),
    "length": ("number or none", "[m]"),
    "rest_length": ("number", "[m]"),
    "target": ("vector", "[m]"),
    "motor": ("motor", "What the motor is for"),
    "motor_b": ("motor", "What the motor is for"),
    "steering": ("number", "[rad]"),
    "spring": ("spring", SPRING),
    "spring_b": ("spring", SPRING),
    "frequency": ("number", "Of the spring [Hz]"),
    "damping": ("number", "Damping ratio of the spring"),
    "max_force": ("number", "Of the spring [N], or inf"),
    "friction": ("number", "Greatest force or torque [N, N m]"),
    "friction_b": ("number", "Greatest torque [N m]"),
    "breaking_force": ("number", "[N], or inf"),
    "breaking_torque": ("number", "[N m], or inf"),
    "collide": ("flag", "Whether the two bodies collide with each other"),
}
"""Settings of joints that can be changed: how each is entered, and what it means. Those of a SixDof by name of axis are not among them."""
