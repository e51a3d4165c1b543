"""Polyhedra as lists of vertices, faces and edges."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt


class Polyhedron(NamedTuple):
    """A convex polyhedron. Vertex and face numbers count from 0 within it."""

    vertices: npt.NDArray[np.float64]
    """(v, 3) [m]."""
    planes: npt.NDArray[np.float64]
    """(f, 4) outward unit normal n and offset d of each face's plane n · x = d."""
    face_sizes: npt.NDArray[np.int32]
    """(f,) number of vertices of each face."""
    face_vertices: npt.NDArray[np.int32]
    """(sum of face_sizes,) vertices of the faces, counter-clockwise as seen from outside."""
    edges: npt.NDArray[np.int32]
    """(e, 4) two vertices, the first the lower, and the faces to the left and right."""


def edges_of(faces: Sequence[Sequence[int]]) -> list[tuple[int, int, int, int]]:
    """Each edge once, in order of its vertices: (lower vertex, higher vertex, face on the left, face on the right).

    Seen from outside and walking counter-clockwise about a face, the face lies on the left. Raises KeyError unless the
    faces close up.
    """
    left: dict[tuple[int, int], int] = {}
    for face, corners in enumerate(faces):
        for k, start in enumerate(corners):
            left[corners[k - 1], start] = face
    return sorted((a, b, face, left[b, a]) for (a, b), face in left.items() if a < b)


def bluntness(polyhedron: Polyhedron) -> float:
    """Cosine of the greatest angle between a face's normal and the middle of the normals at one of its vertices: 0.58 of a box, 1 of something
    almost round, near 0 of a needle."""
    normals = polyhedron.planes[:, :3]
    vertex, face = polyhedron.face_vertices, np.repeat(np.arange(len(normals)), polyhedron.face_sizes)
    middle = np.zeros((len(polyhedron.vertices), 3))
    np.add.at(middle, vertex, normals[face])
    lengths = np.sqrt((middle**2).sum(axis=1))[vertex]
    cosines: npt.NDArray[np.float64] = (middle[vertex] * normals[face]).sum(axis=1) / np.maximum(lengths, 1e-9)
    return max(float(cosines.min()), 0.0)
