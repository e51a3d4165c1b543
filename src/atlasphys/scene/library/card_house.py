"""A house of cards: thin bodies that stand by friction alone."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from atlasphys.scene.library.parts import Body, Layout, box, cosine, ground, sine, turned

THICKNESS, LENGTH, WIDTH = 0.03, 1.0, 0.7
"""Size of a card [m]."""


def card_house(
    levels: Annotated[int, Field(ge=1, le=20)] = 3,
    lean: Annotated[float, Field(ge=5, le=40)] = 20.0,
    friction: Annotated[float, Field(ge=0, le=10)] = 0.8,
) -> Layout:
    """Pairs of cards lean on each other, with level cards between storeys."""
    s, c = sine(lean), cosine(lean)
    size = (THICKNESS, LENGTH, WIDTH)
    rise = LENGTH * c + THICKNESS * s  # of a leaning card
    to_middle = 0.5 * (
        THICKNESS * c + LENGTH * s
    )  # from a leaning card's centre to where its upper edge meets the other's
    period = 2 * (THICKNESS * c + LENGTH * s) + 0.02
    bodies: list[Body] = [ground(friction=friction)]
    for level in range(levels):
        floor = level * (rise + THICKNESS)
        pairs = levels - level
        for k in range(pairs):
            x = period * (k - 0.5 * (pairs - 1))
            for side, sign in (("left", -1), ("right", 1)):
                bodies.append(
                    box(
                        size,
                        (x + sign * to_middle, floor + 0.5 * rise, 0),
                        orientation=turned((0, 0, 1), sign * lean),
                        friction=friction,
                        name=f"card {level}.{k} {side}",
                    )
                )
        for k in range(pairs - 1):
            x = period * (k - 0.5 * (pairs - 2))
            flat = (period - 0.005, THICKNESS, WIDTH)
            bodies.append(
                box(flat, (x, floor + rise + 0.5 * THICKNESS, 0), friction=friction, name=f"level card {level}.{k}")
            )
    return Layout(bodies)
