"""What is compared: a preset or solver of AtlasPhys with settings, or another engine, under a name as it is given on the command line."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from atlasphys.engine.solvers import SOLVERS
from atlasphys.errors import InvalidArgumentError
from atlasphys.validate.case import MakeWorld
from atlasphys.world.settings import PRESETS
from atlasphys.world.world import World

WORLD_SETTINGS = {"narrowphase": str, "broadphase": str, "precision": str, "threads": int}
"""Arguments of ``World`` that may be given beside a solver's settings."""


@dataclass(frozen=True, slots=True)
class Contender:
    """Something that makes worlds."""

    name: str
    """As given: ``default``, ``soft_step:substeps=8``, ``rapier``."""
    title: str
    make_world: MakeWorld
    settings: Mapping[str, Any] = field(default_factory=dict)
    """Arguments of ``World`` that it stands for."""
    is_peer: bool = False


def solvers(words: str | None) -> list[Contender]:
    """Presets and solvers by a list with commas; default: every preset, and every solver that is in none.

    Settings follow a name, each after a colon: ``soft_step:substeps=8:contact_frequency=60``.

    Raises:
        InvalidArgumentError: a name or setting is not known, or a value out of range.
    """
    if words is None:
        in_presets = {preset["solver"] for preset in PRESETS.values()}
        names = [*PRESETS, *(name for name in SOLVERS if name not in in_presets)]
    else:
        names = list(dict.fromkeys(word.strip() for word in words.split(",")))
    return [_contender(name) for name in names]


def peer(name: str, title: str) -> Contender:
    """Another engine, which must be installed."""
    from atlasphys.validate.peers import world_of

    make_world: Any = world_of(name)
    return Contender(name, title, make_world, is_peer=True)


def _contender(word: str) -> Contender:
    name, *settings = word.split(":")
    if name not in PRESETS and name not in SOLVERS:
        known = list(dict.fromkeys([*PRESETS, *SOLVERS]))
        raise InvalidArgumentError(
            f"--solver takes some of {', '.join(known)}, with settings as in soft_step:substeps=8 (got {word!r})"
        )
    preset = PRESETS.get(name)
    solver = preset["solver"] if preset else name
    given: dict[str, Any] = {"preset": name} if preset else {"solver": solver}
    fields = {entry.name: entry for entry in dataclasses.fields(SOLVERS[solver].settings)}
    changes = {}
    for setting in settings:
        key, equals, text = setting.partition("=")
        if not equals or key not in {**fields, **WORLD_SETTINGS}:
            raise InvalidArgumentError(f"{solver} takes {', '.join([*fields, *WORLD_SETTINGS])} (got {setting!r})")
        if key in fields:
            default = fields[key].default
            changes[key] = _value(f"{solver}:{key}", text, float if default is None else type(default))
        else:
            given[key] = _value(key, text, WORLD_SETTINGS[key])
    if changes:
        given["solver"] = SOLVERS[solver].settings(**changes)
    World(**given)  # so that what it refuses is said before anything runs
    title = f"{name} ({solver})" if preset and name != solver else name
    return Contender(word, ", ".join([title, *settings]), partial(World, **given), given)


def _value(name: str, text: str, kind: type) -> Any:
    try:
        if kind is bool:
            return {"true": True, "false": False}[text.lower()]
        return kind(text)
    except (KeyError, ValueError):
        wanted = {bool: "true or false", int: "an integer", float: "a number"}[kind]
        raise InvalidArgumentError(f"{name} takes {wanted} (got {text!r})") from None
