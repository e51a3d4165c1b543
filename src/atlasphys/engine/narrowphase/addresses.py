"""The routines for pairs that the fused step has no lanes for, as addresses by which it calls them.

So they are compiled once a world has such pairs, and the fused step, which every world needs, without them.
"""

from atlasphys.engine.jit import allocating_kernel, allocating_routine
from atlasphys.engine.narrowphase.pairs.convex_convex import convex_convex
from atlasphys.engine.narrowphase.pairs.plane_convex import plane_convex
from atlasphys.engine.narrowphase.pairs.polyhedra import polyhedra
from atlasphys.engine.simd.address import address_call


@allocating_routine
def _convex_convex(arguments, begin, end, _):
    rows, bodies, colliders, shapes, margin, contacts = arguments
    convex_convex(rows[begin:end], bodies, colliders, shapes, margin, contacts)


@allocating_routine
def _plane_convex(arguments, begin, end, _):
    rows, bodies, colliders, shapes, margin, contacts = arguments
    plane_convex(rows[begin:end], bodies, colliders, shapes, margin, contacts)


@allocating_routine
def _polyhedra(arguments, begin, end, _):
    rows, bodies, colliders, shapes, margin, contacts = arguments
    polyhedra(rows[begin:end], bodies, colliders, shapes, margin, contacts)


@allocating_kernel
def convex_convex_address(rows, bodies, colliders, shapes, margin, contacts):
    """Address of the code of ``convex_convex`` for arguments of these types and a range of rows."""
    return address_call(_convex_convex, (rows, bodies, colliders, shapes, margin, contacts))[0]


@allocating_kernel
def plane_convex_address(rows, bodies, colliders, shapes, margin, contacts):
    """Address of the code of ``plane_convex``."""
    return address_call(_plane_convex, (rows, bodies, colliders, shapes, margin, contacts))[0]


@allocating_kernel
def polyhedra_address(rows, bodies, colliders, shapes, margin, contacts):
    """Address of the code of ``polyhedra``."""
    return address_call(_polyhedra, (rows, bodies, colliders, shapes, margin, contacts))[0]


ADDRESSES = (convex_convex_address, plane_convex_address, polyhedra_address)
"""By number of the routine, see ``layout.py``. The code stays where it is as long as the process lives."""
