"""Bodies as meshes: a few unit meshes, scaled, that whole batches of bodies share.

A shape consists of parts: a cube is one, a capsule a tube and two balls. A sphere has a band of a darker tint, without which it could not be seen to
turn. Parts of the same mesh are drawn together as one batch of instances.
"""

from __future__ import annotations

import math
from collections.abc import Hashable
from functools import cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from atlasphys.engine.shapes.box import Box
from atlasphys.engine.shapes.capsule import Capsule
from atlasphys.engine.shapes.cone import Cone
from atlasphys.engine.shapes.cylinder import Cylinder
from atlasphys.engine.shapes.plane import Plane
from atlasphys.engine.shapes.shape import Shape
from atlasphys.engine.shapes.sphere import Sphere
from atlasphys.viewer.frame import Frame, Table
from atlasphys.world.rotation import rotate

Floats = npt.NDArray[np.float64]

SEGMENTS = 20
"""Corners of what is round."""

BAND_TINT = 0.62
"""Brightness of a sphere's band, of the sphere's."""

CHUNK = 1024
"""Most instances of a batch: what changed is sent by batches."""


class Mesh(NamedTuple):
    """Triangles, counter-clockwise as seen from outside."""

    vertices: Floats
    """(v, 3)."""
    faces: npt.NDArray[np.int64]
    """(f, 3)."""
    is_smooth: bool
    """Whether shading hides the edges between triangles that share vertices."""


class Part(NamedTuple):
    """A mesh in the frame of a body's shape."""

    mesh: Hashable
    """What :func:`mesh` takes."""
    scale: tuple[float, float, float]
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    tint: float = 1.0
    """Factor on the body's colour."""


class Batch(NamedTuple):
    """Parts of the same mesh, an instance each."""

    mesh: Hashable
    rows: npt.NDArray[np.int64]
    """(m,) the bodies' rows."""
    scale: Floats
    offset: Floats
    """(m, 3) each."""
    tint: Floats
    """(m,)."""
    is_static: bool

    def poses(self, frame: Frame) -> tuple[Floats, Floats]:
        """(m, 3) positions and (m, 4) orientations of the instances. What is not in the world is far below."""
        position, orientation = frame.position[self.rows], frame.orientation[self.rows].astype(np.float64)
        if self.offset.any():
            position = position + rotate(orientation, self.offset)
        absent = np.isnan(position[:, 0])
        if absent.any():
            position = np.where(absent[:, None], (0.0, -1e6, 0.0), position)
            orientation = np.where(absent[:, None], (1.0, 0.0, 0.0, 0.0), orientation)
        return position, orientation


def batches(table: Table) -> list[Batch]:
    """The batches that draw all bodies but planes."""
    grouped: dict[tuple[Hashable, bool], list[tuple[int, Part]]] = {}
    for row, entry in enumerate(table.entries):
        for part in parts(entry.shape):
            grouped.setdefault((part.mesh, entry.kind == "static"), []).append((row, part))
    found = []
    for (key, is_static), members in grouped.items():
        for start in range(0, len(members), CHUNK):
            chunk = members[start : start + CHUNK]
            found.append(
                Batch(
                    mesh=key,
                    rows=np.array([row for row, _ in chunk], np.int64),
                    scale=np.array([part.scale for _, part in chunk], np.float64),
                    offset=np.array([part.offset for _, part in chunk], np.float64),
                    tint=np.array([part.tint for _, part in chunk], np.float64),
                    is_static=is_static,
                )
            )
    return found


def parts(shape: Shape) -> tuple[Part, ...]:
    """What a shape is drawn with; nothing for a plane."""
    match shape:
        case Sphere(radius=r):
            return Part("ball", (r, r, r)), Part("band", (r, r, r), tint=BAND_TINT)
        case Box(size=(x, y, z)):
            return (Part("cube", (x, y, z)),)
        case Capsule(radius=r, length=length):
            ends = [Part("ball", (r, r, r), (0.0, side * length, 0.0)) for side in (-0.5, 0.5)]
            return Part("tube", (r, length, r)), *ends
        case Cylinder(radius=r, length=length):
            return (Part("cylinder", (r, length, r)),)
        case Cone(radius=r, height=height):
            return (Part("cone", (r, height, r)),)
        case Plane():
            return ()
    return (Part(shape, (1.0, 1.0, 1.0)),)


@cache
def mesh(key: Hashable) -> Mesh:
    """The mesh of a name, or of a polyhedron."""
    if isinstance(key, Shape):
        return _polyhedron(key)
    makers = {
        "ball": _ball,
        "coarse ball": _coarse_ball,
        "band": _band,
        "coarse band": lambda: _band(10),
        "cube": _cube,
        "tube": _tube,
        "cylinder": _cylinder,
        "cone": _cone,
    }
    return makers[str(key)]()


def _polyhedron(shape: Shape) -> Mesh:
    solid = shape.polyhedron
    if solid is None:
        raise ValueError(f"{shape!r} has no mesh")
    triangles, first = [], 0
    for size in solid.face_sizes.tolist():
        corners = solid.face_vertices[first : first + size].tolist()
        triangles += [(corners[0], corners[k], corners[k + 1]) for k in range(1, size - 1)]
        first += size
    return Mesh(np.asarray(solid.vertices), np.array(triangles, np.int64), False)


def _cube() -> Mesh:
    return _polyhedron(Box(size=(1, 1, 1)))


def _grid(rows: int, columns: int) -> npt.NDArray[np.int64]:
    """Triangles of a sheet of (rows + 1) × (columns + 1) vertices, stored row by row."""
    i, j = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    a = (i * (columns + 1) + j).ravel()
    b, c, d = a + 1, a + columns + 1, a + columns + 2
    return np.concatenate([np.stack([a, c, d], 1), np.stack([a, d, b], 1)])


def _sphere_sheet(radius: float, polar: Floats, azimuth: Floats) -> Mesh:
    """Part of a sphere about y, between angles from +y and angles about y."""
    theta, phi = np.meshgrid(polar, azimuth, indexing="ij")
    points = np.stack([np.sin(theta) * np.sin(phi), np.cos(theta), np.sin(theta) * np.cos(phi)], -1)
    return Mesh(radius * points.reshape(-1, 3), _grid(len(polar) - 1, len(azimuth) - 1), True)


def _ball() -> Mesh:
    return _sphere_sheet(1.0, np.linspace(0, math.pi, SEGMENTS // 2 + 1), np.linspace(0, 2 * math.pi, SEGMENTS + 1))


def _coarse_ball() -> Mesh:
    """For shadows, and balls that are small in a picture."""
    return _sphere_sheet(1.0, np.linspace(0, math.pi, 6), np.linspace(0, 2 * math.pi, 13))


def _band(segments: int = SEGMENTS) -> Mesh:
    """A band about the equator and half a band over a pole, a little above the unit sphere."""
    width, radius = 0.16, 1.012 if segments == SEGMENTS else 1.03
    around = np.linspace(0, 2 * math.pi, segments + 1)
    breadth = math.pi / 2 + np.linspace(-width, width, 3 if segments == SEGMENTS else 2)
    equator = _sphere_sheet(radius, breadth, around)
    half = _sphere_sheet(radius, breadth, np.linspace(0, math.pi, segments // 2 + 1))
    over = half.vertices @ np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # a quarter turn about z
    vertices = np.concatenate([equator.vertices, over])
    return Mesh(vertices, np.concatenate([equator.faces, half.faces + len(equator.vertices)]), True)


def _rings(profile: list[tuple[float, float]]) -> Mesh:
    """A surface of revolution about y through (radius, height) pairs from the bottom to the top, each two of them a sheet with edges."""
    around = np.linspace(0, 2 * math.pi, SEGMENTS + 1)
    vertices, faces, count = [], [], 0
    for (r0, y0), (r1, y1) in pairwise(profile):
        rows = [
            np.stack([r * np.sin(around), np.full(SEGMENTS + 1, y), r * np.cos(around)], -1)
            for r, y in ((r1, y1), (r0, y0))
        ]
        vertices.append(np.concatenate(rows))
        faces.append(_grid(1, SEGMENTS) + count)
        count += 2 * (SEGMENTS + 1)
    return Mesh(np.concatenate(vertices), np.concatenate(faces), True)


def _tube() -> Mesh:
    return _rings([(1.0, -0.5), (1.0, 0.5)])


def _cylinder() -> Mesh:
    return _rings([(0.0, -0.5), (1.0, -0.5), (1.0, 0.5), (0.0, 0.5)])


def _cone() -> Mesh:
    return _rings([(0.0, -0.5), (1.0, -0.5), (0.0, 0.5)])
