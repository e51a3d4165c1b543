"""Which routine works out which pair, and the stage's entry point.

Pairs are sorted by their routines, and all pairs of a routine are given to it in one call. So only the kernels that a scene needs are ever compiled.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations_with_replacement

import numpy as np
import numpy.typing as npt

from atlasphys.engine.narrowphase.layout import lay_out
from atlasphys.engine.narrowphase.pairs.box_box import box_box
from atlasphys.engine.narrowphase.pairs.capsule_box import capsule_box
from atlasphys.engine.narrowphase.pairs.capsule_capsule import capsule_capsule
from atlasphys.engine.narrowphase.pairs.convex_convex import convex_convex
from atlasphys.engine.narrowphase.pairs.plane_convex import plane_convex
from atlasphys.engine.narrowphase.pairs.polyhedra import polyhedra
from atlasphys.engine.narrowphase.pairs.sphere_box import sphere_box
from atlasphys.engine.narrowphase.pairs.sphere_capsule import sphere_capsule
from atlasphys.engine.narrowphase.pairs.sphere_sphere import sphere_sphere
from atlasphys.engine.shapes.table import (
    BOX,
    CAPSULE,
    CONE,
    CYLINDER,
    HULL,
    PLANE,
    SPHERE,
    Shapes,
)
from atlasphys.engine.state.bodies import Bodies
from atlasphys.engine.state.colliders import Colliders
from atlasphys.engine.state.contacts import Contacts, empty_contacts

PairKernel = Callable[[npt.NDArray[np.intp], Bodies, Colliders, Shapes, float, Contacts], None]
"""``kernel(rows, bodies, colliders, shapes, margin, contacts)`` fills in the contacts of the pairs ``rows``."""

KINDS = 7
CONVEX = (SPHERE, CAPSULE, BOX, CYLINDER, CONE, HULL)
METHODS = ("auto", "gjk_epa", "sat")

PAIR_KERNELS: dict[tuple[int, int], PairKernel] = {
    **dict.fromkeys(combinations_with_replacement(CONVEX, 2), convex_convex),
    **{(kind, PLANE): plane_convex for kind in CONVEX},
    (SPHERE, SPHERE): sphere_sphere,
    (SPHERE, CAPSULE): sphere_capsule,
    (SPHERE, BOX): sphere_box,
    (CAPSULE, CAPSULE): capsule_capsule,
    (CAPSULE, BOX): capsule_box,
    (BOX, BOX): box_box,
    (BOX, HULL): polyhedra,
    (HULL, HULL): polyhedra,
}
"""The routine of ``method="auto"`` for each kind of pair, the lower kind first."""

METHOD_KERNELS: dict[str, dict[tuple[int, int], PairKernel]] = {
    "auto": PAIR_KERNELS,
    "gjk_epa": PAIR_KERNELS | dict.fromkeys(combinations_with_replacement(CONVEX, 2), convex_convex),
    "sat": PAIR_KERNELS,
}
"""The routine for each kind of pair by method. The separating axis test serves polyhedra only, and there "auto" takes
it too."""

MOST_EDGE_PAIRS = 600
"""Above this product of numbers of edges, "auto" gives two polyhedra to GJK and EPA: the separating axis test takes
time in proportion to it. Smaller or larger: slower, nothing else."""

EDGE_LIMITS = {"auto": MOST_EDGE_PAIRS, "gjk_epa": 0, "sat": 2**31}
"""By method: product of numbers of edges above which GJK and EPA take over."""

ROUTINES: tuple[PairKernel, ...] = tuple(
    dict.fromkeys([convex_convex, plane_convex, polyhedra, *PAIR_KERNELS.values()])
)
"""Each routine once, in the order of its number; the first are those that ``layout.py`` names."""

KIND_ROUTINES: dict[str, npt.NDArray[np.int8]] = {
    method: np.array(
        [
            [ROUTINES.index(table.get((min(i, j), max(i, j)), convex_convex)) for j in range(KINDS)]
            for i in range(KINDS)
        ],
        np.int8,
    )
    for method, table in METHOD_KERNELS.items()
}
"""By method: the place in ``ROUTINES`` of the routine for each two kinds of shapes."""


def collide(
    bodies: Bodies,
    colliders: Colliders,
    shapes: Shapes,
    pairs: npt.NDArray[np.int32],
    method: str,
    margin: float,
    contacts: Contacts,
) -> Contacts:
    """Contact points of all pairs nearer to each other than ``margin``.

    Args:
        bodies: positions (double), rotation matrices and centres of mass are read.
        colliders: body and shape of each collider.
        shapes: the table of shapes.
        pairs: (P, 2) rows of colliders, the lower first; no pair of planes.
        method: "auto": the fastest right routine for each pair; "gjk_epa": GJK, EPA and clipping for all convex
            pairs; "sat": the separating axis test for all polyhedra, else as "auto".
        margin: gap under which a pair gives points, with negative depth [m].
        contacts: buffers to fill; larger ones are made where they are too small.

    Returns:
        The contacts, of which the first P rows (and slots up to ``first[P]``) are in use.
    """
    number = len(pairs)
    contacts = with_room(contacts, number, 0)
    of_pair, rows = np.empty(number, np.int8), np.empty(number, np.intp)
    starts = np.empty(len(ROUTINES) + 1, np.int64)
    while True:
        total = lay_out(
            pairs,
            colliders.shape,
            shapes.layout,
            KIND_ROUTINES[method],
            EDGE_LIMITS[method],
            contacts,
            of_pair,
            rows,
            starts,
        )
        if total <= len(contacts.depth):
            break
        contacts = with_room(contacts, number, total)
    for kernel, begin, end in zip(ROUTINES, starts[:-1], starts[1:], strict=True):
        if begin < end:
            kernel(rows[begin:end], bodies, colliders, shapes, margin, contacts)
    return contacts


def with_room(contacts: Contacts, pairs: int, points: int) -> Contacts:
    """The same buffers, or empty ones if these have no room for so many pairs and slots for points."""
    if pairs <= len(contacts.a) and points <= len(contacts.depth):
        return contacts
    return empty_contacts(_doubled(len(contacts.a), pairs), _doubled(len(contacts.depth), points), contacts.depth.dtype)


def _doubled(capacity: int, needed: int) -> int:
    capacity = max(capacity, 1)
    while capacity < needed:
        capacity *= 2
    return capacity
