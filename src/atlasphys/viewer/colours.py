"""Which colour a body has: its own or one by its number; by island; paler when asleep; marked when selected."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from atlasphys.engine.shapes.plane import Plane
from atlasphys.viewer.frame import Entry, Frame, Table

PALETTE = np.array(
    [
        (78, 121, 167), (242, 142, 43), (89, 161, 79), (225, 87, 89), (118, 183, 178), (237, 201, 72), (176, 122, 161), (255, 157, 167),
        (156, 117, 95), (105, 150, 210),
    ],
    np.uint8,
)  # fmt: skip
"""Colours of bodies that were given none, in turn."""

STATIC = (150, 156, 164)
BACKGROUND = {False: (232, 238, 244), True: (22, 25, 30)}
GROUND = {False: (203, 209, 216), True: (58, 64, 72)}
LINES = {False: ((184, 191, 200), (170, 178, 188)), True: ((72, 79, 88), (80, 88, 97))}
"""Of the grid: finer and coarser. All by whether it is dark."""

SLEEPING = np.array((112, 122, 138))
SELECTED = np.array((255, 214, 10))

JOINTS = {
    "arms": (0, 190, 200), "links": (255, 140, 0), "axes": (220, 0, 160), "idle": (130, 130, 130), "selected": (255, 200, 0),
}  # fmt: skip
"""Of the lines of joints."""

Colours = npt.NDArray[np.uint8]

_SHARE = np.arange(256) / 255
_LINEAR = np.where(_SHARE <= 0.04045, _SHARE / 12.92, ((_SHARE + 0.055) / 1.055) ** 2.4)
_TO_LINEAR: Colours = np.round(255 * _LINEAR).astype(np.uint8)


def linear(colours: Any) -> Colours:
    """sRGB colours by their share of light, as the page takes those of instances: taken for that, sRGB ones come out pale (IEC 61966-2-1)."""
    shares: Colours = _TO_LINEAR[colours]
    return shares


def own_colours(table: Table) -> Colours:
    """(n, 3) colours of the bodies by themselves."""
    colours: Colours = PALETTE[(table.ids & 0xFFFFFFFF) % len(PALETTE)]
    for row, entry in enumerate(table.entries):
        if entry.color is not None:
            colours[row] = np.round(255 * np.array(entry.color))
        elif entry.kind == "static":
            colours[row] = STATIC
    return colours


def ground(entry: Entry, dark: bool) -> tuple[int, int, int]:
    """The colour of a plane: its own or that of the ground, darker where it is steep."""
    colour = GROUND[dark] if entry.color is None else 255 * np.array(entry.color)
    assert isinstance(entry.shape, Plane)
    light = 0.85 + 0.15 * entry.shape.normal[1]
    red, green, blue = (round(float(c) * light) for c in colour)
    return red, green, blue


def island_colours(frame: Frame, own: Colours) -> Colours:
    """(n, 3) one colour for each set of dynamic bodies that touch one another; the others keep their own."""
    colours, rows = own.copy(), np.flatnonzero(frame.table.is_dynamic)
    if len(rows):
        colours[rows] = PALETTE[islands(frame)[rows] % len(PALETTE)]
    return colours


def islands(frame: Frame) -> npt.NDArray[np.int64]:
    """(n,) for each dynamic body the lowest row of those that it is connected with by contacts of dynamic bodies; for the others their own row."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    count = len(frame.table)
    lowest = np.arange(count)
    if frame.contacts is None or count == 0:
        return lowest
    a, b = frame.contacts["body_a"], frame.contacts["body_b"]
    joined = frame.table.is_dynamic[a] & frame.table.is_dynamic[b]
    graph = coo_array((np.ones(joined.sum()), (a[joined], b[joined])), shape=(count, count))
    _, label = connected_components(graph, directed=False)
    first = np.full(label.max() + 1, count)
    np.minimum.at(first, label, lowest)
    return first[label]


def shown_colours(
    frame: Frame, own: Colours, *, by_island: bool = False, mark_sleeping: bool = False, selected: int | None = None
) -> Colours:
    """(n, 3) the colours to be drawn; ``selected`` is a row."""
    colours = island_colours(frame, own) if by_island else own
    if mark_sleeping and frame.asleep.any():
        asleep = frame.asleep[:, None]
        colours = np.where(asleep, (0.3 * colours + 0.7 * SLEEPING).astype(np.uint8), colours)
    if selected is not None:
        colours = colours.copy()
        colours[selected] = (0.35 * colours[selected] + 0.65 * SELECTED).astype(np.uint8)
    return colours
