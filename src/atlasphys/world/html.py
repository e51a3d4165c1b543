"""What a notebook shows of a world."""

from __future__ import annotations

import html
from collections import Counter
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from atlasphys.world.world import World


def world_html(world: World) -> str:
    """A small table: time, bodies by shape, contacts, energy, settings."""
    shapes = Counter(type(body.shape).__name__ for body in world.bodies)
    energy, asleep = world.energy(), int(world.bodies.asleep.sum())
    bodies = ", ".join(f"{count} {name}" for name, count in shapes.most_common()) or "none"
    gravity = "(" + ", ".join(f"{g:g}" for g in world.gravity) + ")"
    rows = [
        ("time", f"{world.time:.6g} s, {world.steps} steps"),
        ("bodies", bodies + (f"; {asleep} asleep" if asleep else "")),
        ("contact points", str(world.contact_count)),
        ("energy", f"{energy.kinetic:.5g} J kinetic, {energy.potential:.5g} J potential"),
        ("gravity", f"{gravity} m/s²"),
        ("stages", f"{world.broadphase}, {world.narrowphase}, {world.solver}, {world.precision} precision"),
    ]
    cells = "".join(
        f"<tr><th style='text-align:left'>{name}</th><td>{html.escape(text)}</td></tr>" for name, text in rows
    )
    return f"<table><caption style='text-align:left'><b>atlasphys.World</b></caption>{cells}</table>"
