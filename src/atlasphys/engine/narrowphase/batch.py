"""Collision of eight pairs of one kind at a time: which body over lanes does it, and what it is given."""

import numpy as np

from atlasphys.engine.jit import routine
from atlasphys.engine.math import mat
from atlasphys.engine.narrowphase.lanes.box_box import box_box
from atlasphys.engine.narrowphase.lanes.capsule_box import capsule_box
from atlasphys.engine.narrowphase.lanes.capsule_capsule import capsule_capsule
from atlasphys.engine.narrowphase.lanes.common import FIRST, SECOND
from atlasphys.engine.narrowphase.lanes.plane import box_plane, capsule_plane, sphere_plane
from atlasphys.engine.narrowphase.lanes.sphere_box import sphere_box
from atlasphys.engine.narrowphase.lanes.sphere_capsule import sphere_capsule
from atlasphys.engine.narrowphase.lanes.sphere_sphere import sphere_sphere
from atlasphys.engine.shapes.table import BOX, CAPSULE, KIND, PLANE, SPHERE

BOX_BOX, SPHERE_SPHERE, SPHERE_BOX, SPHERE_CAPSULE, CAPSULE_CAPSULE, CAPSULE_BOX = range(6)
BOX_PLANE, SPHERE_PLANE, CAPSULE_PLANE = range(6, 9)
KINDS = 9
"""Kinds of pairs that are collided over lanes."""

GENERIC_KIND = -1
"""Kind of all other pairs."""

SHAPE_KINDS = 7

KIND_OF = np.full((SHAPE_KINDS, SHAPE_KINDS), GENERIC_KIND, np.int8)
"""Kind of a pair by the kinds of its two shapes, in either order."""
for _first, _second, _kind in (
    (BOX, BOX, BOX_BOX),
    (SPHERE, SPHERE, SPHERE_SPHERE),
    (SPHERE, BOX, SPHERE_BOX),
    (SPHERE, CAPSULE, SPHERE_CAPSULE),
    (CAPSULE, CAPSULE, CAPSULE_CAPSULE),
    (CAPSULE, BOX, CAPSULE_BOX),
    (BOX, PLANE, BOX_PLANE),
    (CAPSULE, PLANE, CAPSULE_PLANE),
    (SPHERE, PLANE, SPHERE_PLANE),
):
    KIND_OF[_first, _second] = KIND_OF[_second, _first] = _kind


@routine
def place_lane(lane, kind, a, b, body_a, body_b, bodies, shape, shapes, lanes):
    """Fill a lane of ``pairs`` and ``place`` for the pair of colliders a and b. Returns 1 if b is the first shape, else 0.

    A plane is seen from the other body, in double precision, since its origin may be far off.
    """
    swapped = 0
    if shapes.layout[shape[a], KIND] > shapes.layout[shape[b], KIND]:
        a, b = b, a
        body_a, body_b = body_b, body_a
        swapped = 1
    lanes.pairs[0, lane], lanes.pairs[1, lane] = body_a, body_b
    size_a, size_b = shape[a], shape[b]
    for k in range(4):
        lanes.place[FIRST + k, lane] = shapes.size[size_a, k]
        lanes.place[SECOND + k, lane] = shapes.size[size_b, k]
    if kind >= BOX_PLANE:
        rotation = mat.load(bodies.geometry, body_b)
        n = mat.mul_vec(rotation, (shapes.size[size_b, 0], shapes.size[size_b, 1], shapes.size[size_b, 2]))
        height = -np.float64(shapes.size[size_b, 3])
        for k in range(3):
            height += np.float64(n[k]) * (bodies.center[body_a, k] - bodies.position[body_b, k])
            lanes.place[k, lane] = n[k]
        lanes.place[3, lane] = height
    else:
        for k in range(3):
            lanes.place[k, lane] = -lanes.delta[k, lane] if swapped else lanes.delta[k, lane]
    return swapped


@routine
def collide_lanes(kind, geometry, margin, lanes):
    """Collide the eight pairs in the scratch block."""
    if kind == BOX_BOX:
        box_box(lanes.pairs, geometry, lanes.place, margin, lanes.contact, lanes.tags)
    elif kind == SPHERE_SPHERE:
        sphere_sphere(lanes.pairs, geometry, lanes.place, margin, lanes.contact, lanes.tags)
    elif kind == SPHERE_BOX:
        sphere_box(lanes.pairs, geometry, lanes.place, margin, lanes.contact, lanes.tags)
    elif kind == SPHERE_CAPSULE:
        sphere_capsule(lanes.pairs, geometry, lanes.place, margin, lanes.contact, lanes.tags)
    elif kind == CAPSULE_CAPSULE:
        capsule_capsule(lanes.pairs, geometry, lanes.place, margin, lanes.contact, lanes.tags)
    elif kind == CAPSULE_BOX:
        capsule_box(lanes.pairs, geometry, lanes.place, margin, lanes.contact, lanes.tags)
    elif kind == BOX_PLANE:
        box_plane(lanes.pairs, geometry, lanes.place, margin, lanes.contact, lanes.tags)
    elif kind == SPHERE_PLANE:
        sphere_plane(lanes.pairs, geometry, lanes.place, margin, lanes.contact, lanes.tags)
    else:
        capsule_plane(lanes.pairs, geometry, lanes.place, margin, lanes.contact, lanes.tags)
