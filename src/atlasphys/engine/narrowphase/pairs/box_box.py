"""Two boxes: the separating axis test over fifteen axes, then clipping."""

import numpy as np

from atlasphys.engine.jit import allocating_kernel
from atlasphys.engine.narrowphase.clip import FACE_PREFERENCE, clip_scratch, write_contact
from atlasphys.engine.narrowphase.pair import place
from atlasphys.engine.narrowphase.sat import box_axes
from atlasphys.engine.trace import TRACED, note


@allocating_kernel
def box_box(rows, bodies, colliders, shapes, margin, contacts):
    """Contacts of pairs of boxes."""
    real = contacts.depth.dtype.type
    margin = real(margin)
    bias = real(FACE_PREFERENCE) * margin
    r = np.empty((5, 3), contacts.depth.dtype)
    scratch = clip_scratch(shapes, contacts.depth.dtype)
    for p in rows:
        pair, target = place(bodies, colliders, shapes, contacts, p)
        normal, distance, on_a, on_b = box_axes(shapes, pair, margin, bias, r)
        if TRACED:
            note("sat.result", normal=normal, distance=distance, on_a=on_a, on_b=on_b, limit=margin)
        if distance < margin:
            write_contact(shapes, contacts, target, pair, normal, distance, on_a, on_b, bias, margin, scratch)
