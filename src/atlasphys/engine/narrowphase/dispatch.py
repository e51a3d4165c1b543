"""Which routine works out which pair, and the stage's entry point.

Pairs are sorted by the kinds of their two shapes, and each kind of pair present is given to its kernel in one call.
So only the kernels that a scene needs are ever compiled.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations_with_replacement

import numpy as np
import numpy.typing as npt

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
    EDGE_COUNT,
    FEATURE_POINTS,
    HULL,
    KIND,
    PLANE,
    RIM_POINTS,
    SPHERE,
    VERTEX_COUNT,
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

generic: PairKernel = convex_convex

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


def kind_pairs(colliders: Colliders, shapes: Shapes, pairs: npt.NDArray[np.int32]) -> npt.NDArray[np.int32]:
    """``KINDS * lower + higher`` of the kinds of each pair's shapes."""
    kinds = shapes.layout[colliders.shape[pairs], KIND]
    codes: npt.NDArray[np.int32] = KINDS * kinds.min(axis=1) + kinds.max(axis=1)
    return codes


def slots(colliders: Colliders, shapes: Shapes, pairs: npt.NDArray[np.int32]) -> npt.NDArray[np.int32]:
    """The most points that each pair can have.

    Clipping a feature of m corners by one of k leaves at most m + k, and one more is kept for the deepest point. On a
    plane a polyhedron may rest on all its vertices, a capsule on two points, a disc on its rim and its lowest point.
    """
    rows = colliders.shape[pairs]
    layout = shapes.layout[rows]
    count: npt.NDArray[np.int32] = layout[:, :, FEATURE_POINTS].sum(axis=1) + 1
    on_plane = (layout[:, :, KIND] == PLANE).any(axis=1)
    if on_plane.any():
        count[on_plane] = np.maximum(layout[on_plane, :, VERTEX_COUNT].max(axis=1), RIM_POINTS + 1)
    return count


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
    width = slots(colliders, shapes, pairs)
    total = int(width.sum())
    if number > len(contacts.a) or total > len(contacts.depth):
        contacts = empty_contacts(
            _doubled(len(contacts.a), number), _doubled(len(contacts.depth), total), contacts.depth.dtype
        )
    contacts.a[:number] = pairs[:, 0]
    contacts.b[:number] = pairs[:, 1]
    contacts.first[0] = 0
    np.cumsum(width, out=contacts.first[1 : number + 1])
    contacts.count[:number] = 0
    contacts.gap[:number] = 0
    table = METHOD_KERNELS[method]
    codes = kind_pairs(colliders, shapes, pairs)
    for code in np.flatnonzero(np.bincount(codes)) if number else ():
        rows = np.flatnonzero(codes == code)
        kernel = table[divmod(int(code), KINDS)]
        if kernel is polyhedra and method == "auto":
            edges = shapes.layout[colliders.shape[pairs[rows]], EDGE_COUNT].astype(np.int64).prod(axis=1)
            few = edges <= MOST_EDGE_PAIRS
            if not few.all():
                generic(rows[~few], bodies, colliders, shapes, margin, contacts)
                rows = rows[few]
        if len(rows):
            kernel(rows, bodies, colliders, shapes, margin, contacts)
    return contacts


def _doubled(capacity: int, needed: int) -> int:
    capacity = max(capacity, 1)
    while capacity < needed:
        capacity *= 2
    return capacity
