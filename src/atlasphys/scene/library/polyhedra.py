"""The solids of the articles' second version."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field

from atlasphys.scene.library.parts import Body, Layout, body, ground, turned

SOLIDS: list[tuple[str, str, dict[str, Any]]] = [
    ("cube", "box", {"size": (1, 1, 1)}),
    ("rectangular prism", "box", {"size": (1.4, 0.5, 0.8)}),
    ("tetrahedron", "tetrahedron", {"radius": 0.7}),
    ("square pyramid", "pyramid", {"sides": 4, "radius": 0.7, "height": 0.9}),
    ("pentagonal pyramid", "pyramid", {"sides": 5, "radius": 0.7, "height": 0.9}),
    ("hexagonal pyramid", "pyramid", {"sides": 6, "radius": 0.7, "height": 0.9}),
    ("octahedron", "octahedron", {"radius": 0.7}),
]


def polyhedra(copies: Annotated[int, Field(ge=1, le=200)] = 2) -> Layout:
    """Every solid of the articles' second version falls on a plane."""
    bodies: list[Body] = [ground()]
    for copy in range(copies):
        for k, (name, kind, sizes) in enumerate(SOLIDS):
            position = (1.6 * (k - 3) + 0.3 * copy, 1.5 + 1.8 * copy, 0.1 * copy)
            tilt = turned((0.6, 0.0, 0.8), 20.0 * k + 35.0 * copy)
            bodies.append(body(kind, position, sizes, orientation=tilt, name=f"{name} {copy}"))
    return Layout(bodies)
