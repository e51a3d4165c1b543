"""Any two convex shapes: GJK between the cores, EPA where the cores overlap, then clipping."""

import numpy as np

from atlasphys.engine.jit import allocating_kernel, routine
from atlasphys.engine.math import vec
from atlasphys.engine.narrowphase.apart import certain_gap
from atlasphys.engine.narrowphase.clip import FACE_PREFERENCE, clip_scratch, write_contact
from atlasphys.engine.narrowphase.epa import epa, polytope_scratch
from atlasphys.engine.narrowphase.gjk import SEPARATED, gjk
from atlasphys.engine.narrowphase.pair import place
from atlasphys.engine.shapes.support import rounding
from atlasphys.engine.trace import TRACED, note


@routine
def core_contact(shapes, pair, limit, simplex, polytope):
    """Signed distance of two cores.

    Returns:
        ``normal, distance, on_a, on_b``: the unit normal from a to b, the distance (negative: overlap), and the
        points that are nearest or overlap most. Distances above ``limit`` are only known to be above it.
    """
    status, v, on_a, count = gjk(shapes, pair, pair[4], limit, simplex)
    if TRACED:
        note("gjk.result", status=status, point=v, on_a=on_a, simplex=simplex[:count])
    if status == SEPARATED:
        distance = vec.length(v)
        normal = vec.scale(v, type(distance)(-1) / distance)
    else:
        normal, depth, on_a = epa(shapes, pair, simplex, count, pair[4], polytope)
        distance = -depth
        if TRACED:
            note("epa.result", normal=normal, depth=depth, on_a=on_a)
    return normal, distance, on_a, vec.add_scaled(on_a, normal, distance)


CLEAR = 4.0
"""How much farther than asked for a distance is worked out, in margins: the gap of a pair without contact (``Contacts.gap``) is then known.
Smaller: pairs that are apart are collided more often. Larger: GJK takes more iterations for them."""


@allocating_kernel
def convex_convex(rows, bodies, colliders, shapes, margin, contacts):
    """Contacts of pairs of convex shapes of any kind."""
    real = contacts.depth.dtype.type
    margin = real(margin)
    bias = real(FACE_PREFERENCE) * margin
    simplex = np.empty((4, 7), contacts.depth.dtype)
    polytope = polytope_scratch(contacts.depth.dtype)
    scratch = clip_scratch(shapes, contacts.depth.dtype)
    for p in rows:
        pair, target = place(bodies, colliders, shapes, contacts, p)
        limit = margin + rounding(shapes, pair[0]) + rounding(shapes, pair[1])
        normal, distance, on_a, on_b = core_contact(shapes, pair, limit + real(CLEAR) * margin, simplex, polytope)
        if TRACED:
            note("core.result", normal=normal, distance=distance, on_a=on_a, on_b=on_b, limit=limit)
        if distance >= limit:
            contacts.gap[p] = certain_gap(distance - limit, shapes, pair)
        else:
            write_contact(shapes, contacts, target, pair, normal, distance, on_a, on_b, bias, margin, scratch)
