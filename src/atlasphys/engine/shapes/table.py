"""The table of shapes that kernels read: each distinct shape once, however many colliders use it.

A polyhedron (box or hull) lists its vertices, faces and edges; every shape has four size parameters.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

SPHERE, CAPSULE, BOX, CYLINDER, CONE, HULL, PLANE = range(7)
"""Values of the column KIND. The order is that of the roles in a pair: sphere before capsule before box …; planes come last."""

KIND, FIRST_VERTEX, VERTEX_COUNT, FIRST_FACE, FACE_COUNT, FIRST_EDGE, EDGE_COUNT, FEATURE_POINTS = range(8)
"""Columns of ``Shapes.layout``. FEATURE_POINTS is the most points that one supporting feature (face, edge or vertex) can have."""


class Shapes(NamedTuple):
    """The shapes of a world. All coordinates are in the shape's own frame."""

    layout: npt.NDArray[np.int32]
    """(s, 8) the columns KIND to FEATURE_POINTS."""
    size: npt.NDArray[np.floating]
    """(s, 4) sphere: radius. Capsule: radius, half length (along y). Box: half sizes x, y, z. Cylinder: radius, half length (along y).
    Cone: radius, half height (along y; the apex at +half height). Plane: unit normal, offset. Hull: none. Unused ones are 0."""
    vertices: npt.NDArray[np.floating]
    """(v, 3) vertices of the polyhedra [m]."""
    faces: npt.NDArray[np.floating]
    """(f, 4) outward unit normal n and offset d of each face's plane n · x = d."""
    face_range: npt.NDArray[np.int32]
    """(f, 2) first entry in ``face_vertices`` and number of entries of each face."""
    face_vertices: npt.NDArray[np.int32]
    """(k,) vertex rows of the faces, counter-clockwise as seen from outside."""
    edges: npt.NDArray[np.int32]
    """(e, 4) two vertex rows and the rows of the faces to the left and right of the edge (as seen from outside, from the first vertex to the second)."""
