"""The dense sweep of :mod:`tests.reference.narrowphase`, compiled: many pairs at a few hundred microseconds each.

It has its own support function, one for all shapes: each is the convex hull of two level discs (of any radius, also
zero) or of a list of vertices, widened by a ball. The slow sweep checks it, and the separating axes of polyhedra,
taken one and all without any cleverness, check its refinement.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from atlasphys.engine.jit import allocating_kernel as kernel
from atlasphys.engine.jit import allocating_routine as routine
from atlasphys.engine.shapes.box import Box
from atlasphys.engine.shapes.capsule import Capsule
from atlasphys.engine.shapes.cone import Cone
from atlasphys.engine.shapes.cylinder import Cylinder
from atlasphys.engine.shapes.hull import ConvexHull
from atlasphys.engine.shapes.shape import Shape
from atlasphys.engine.shapes.sphere import Sphere
from tests.reference.narrowphase import corners, sphere_points

Array = npt.NDArray[np.float64]


class Placed(NamedTuple):
    """Pairs of shapes in world axes; pair k is the shapes 2 k and 2 k + 1."""

    size: Array
    """(2 n, 4) radius of the ball; half the distance of the discs; radius of the upper and of the lower disc."""
    rotation: Array
    """(2 n, 9)."""
    offset: Array
    """(n, 3) from the first shape's origin to the second's."""
    first: npt.NDArray[np.int64]
    """(2 n + 1) first vertex of each shape."""
    vertices: Array
    """(v, 3) vertices in the pair's own axes, as seen from each shape's origin."""


def _discs(shape: Shape) -> tuple[float, float, float, float]:
    if isinstance(shape, Sphere):
        return shape.radius, 0.0, 0.0, 0.0
    if isinstance(shape, Capsule):
        return shape.radius, 0.5 * shape.length, 0.0, 0.0
    if isinstance(shape, Cylinder):
        return 0.0, 0.5 * shape.length, shape.radius, shape.radius
    if isinstance(shape, Cone):
        return 0.0, 0.5 * shape.height, 0.0, shape.radius
    return 0.0, 0.0, 0.0, 0.0


def placed(shapes: Sequence[Shape], rotations: Sequence[Array], offsets: Sequence[Array]) -> Placed:
    """Shapes 2 k and 2 k + 1, with their rotations, are pair k, and ``offsets[k]`` leads from one to the other."""
    none = np.empty((0, 3))
    parts = [
        corners(shape) @ turn.T if isinstance(shape, (Box, ConvexHull)) else none
        for shape, turn in zip(shapes, rotations, strict=True)
    ]
    return Placed(
        np.array([_discs(shape) for shape in shapes]),
        np.array(rotations).reshape(-1, 9),
        np.array(offsets).reshape(-1, 3),
        np.cumsum([0, *map(len, parts)]),
        np.concatenate([none, *parts]),
    )


@routine
def _support(placed, row, x, y, z):
    """The point p of a shape with the greatest n · p, n = (x, y, z) of unit length."""
    first, last = placed.first[row], placed.first[row + 1]
    if last > first:
        best, farthest = first, -math.inf
        for k in range(first, last):
            along = x * placed.vertices[k, 0] + y * placed.vertices[k, 1] + z * placed.vertices[k, 2]
            if along > farthest:
                best, farthest = k, along
        return placed.vertices[best, 0], placed.vertices[best, 1], placed.vertices[best, 2]
    r = placed.rotation
    ball, half, upper, lower = placed.size[row, 0], placed.size[row, 1], placed.size[row, 2], placed.size[row, 3]
    along = x * r[row, 1] + y * r[row, 4] + z * r[row, 7]
    p, q = x * r[row, 0] + y * r[row, 3] + z * r[row, 6], x * r[row, 2] + y * r[row, 5] + z * r[row, 8]
    across = math.sqrt(p * p + q * q)
    level, disc = half, upper
    if lower * across - half * along > half * along + upper * across:
        level, disc = -half, lower
    wide = disc / across if across > 0.0 else 0.0
    p, along, q = p * (ball + wide), level + along * ball, q * (ball + wide)
    return (
        r[row, 0] * p + r[row, 1] * along + r[row, 2] * q,
        r[row, 3] * p + r[row, 4] * along + r[row, 5] * q,
        r[row, 6] * p + r[row, 7] * along + r[row, 8] * q,
    )


@routine
def _farthest(placed, k, x, y, z):
    """The point w of A − B with the greatest n · w: that is h(n)."""
    ax, ay, az = _support(placed, 2 * k, x, y, z)
    bx, by, bz = _support(placed, 2 * k + 1, -x, -y, -z)
    return ax - bx - placed.offset[k, 0], ay - by - placed.offset[k, 1], az - bz - placed.offset[k, 2]


@routine
def _overlap(placed, k, x, y, z):
    wx, wy, wz = _farthest(placed, k, x, y, z)
    return wx * x + wy * y + wz * z


@kernel
def _overlaps(placed, normals, result):
    for k in range(len(placed.offset)):
        result[k] = _overlap(placed, k, normals[k, 0], normals[k, 1], normals[k, 2])


@routine
def _centroid(polygon, count):
    """Area and centroid of a polygon."""
    area, s, t = 0.0, 0.0, 0.0
    x0, y0 = polygon[0, 0], polygon[0, 1]
    for i in range(1, count - 1):
        x1, y1, x2, y2 = polygon[i, 0] - x0, polygon[i, 1] - y0, polygon[i + 1, 0] - x0, polygon[i + 1, 1] - y0
        part = x1 * y2 - x2 * y1
        area += part
        s += part * (x1 + x2)
        t += part * (y1 + y2)
    if area > 0.0:
        return area, x0 + s / (3.0 * area), y0 + t / (3.0 * area)
    return area, x0, y0


@routine
def _halve(polygon, count, s, t, gs, gt):
    """Cut a polygon to where ``(p − (s, t)) · (gs, gt)`` is not positive; returns its number of corners."""
    kept = 0
    result = np.empty((count + 1, 2))
    for i in range(count):
        j = (i + 1) % count
        here = (polygon[i, 0] - s) * gs + (polygon[i, 1] - t) * gt
        there = (polygon[j, 0] - s) * gs + (polygon[j, 1] - t) * gt
        if here <= 0.0:
            result[kept] = polygon[i]
            kept += 1
        if (here < 0.0 < there) or (there < 0.0 < here):
            part = here / (here - there)
            for c in range(2):
                result[kept, c] = polygon[i, c] + part * (polygon[j, c] - polygon[i, c])
            kept += 1
    polygon[:kept] = result[:kept]
    return kept


@routine
def _square(x, y, z):
    """Two unit vectors u, v square to each other and to n, made from the axis that is farthest from n."""
    if abs(x) <= abs(y) and abs(x) <= abs(z):
        ux, uy, uz = 0.0, -z, y
    elif abs(y) <= abs(z):
        ux, uy, uz = z, 0.0, -x
    else:
        ux, uy, uz = -y, x, 0.0
    scale = 1.0 / math.sqrt(ux * ux + uy * uy + uz * uz)
    ux, uy, uz = scale * ux, scale * uy, scale * uz
    return ux, uy, uz, y * uz - z * uy, z * ux - x * uz, x * uy - y * ux


@routine
def _refine(placed, k, x, y, z, radius, rounds, cuts, lowest, steepest):
    """A local minimum of h near n = (x, y, z): ``h, x, y, z``. It stops once that cannot be as low as ``lowest``.

    On the plane of directions m = n + s u + t v that touches the sphere, H(m) = max over A − B of m · w is convex, and
    h = H / |m|. W. Dinkelbach ("On Nonlinear Fractional Programming", Management Science 13(7), 1967): whatever makes
    H(m) − h(n) |m| less than its value at n, zero, has a smaller h. If h(n) > 0, |m| may be 1, for it is at least that,
    and what is made small stays convex. So a square about n is halved, again and again, through its centroid
    (A. Levin, "On an algorithm for the minimization of convex functions", Soviet Math. Doklady 6, 1965), then drawn
    anew about the best direction found.
    """
    polygon = np.empty((cuts + 8, 2))
    best = _overlap(placed, k, x, y, z)
    for _ in range(rounds):
        ux, uy, uz, vx, vy, vz = _square(x, y, z)
        polygon[0, 0], polygon[0, 1], polygon[1, 0], polygon[1, 1] = -radius, -radius, radius, -radius
        polygon[2, 0], polygon[2, 1], polygon[3, 0], polygon[3, 1] = radius, radius, -radius, radius
        count = 4
        pull = max(-best, 0.0)
        moved, nx, ny, nz = 0.0, x, y, z
        s, t = 0.0, 0.0
        for _ in range(cuts):
            length = math.sqrt(1.0 + s * s + t * t)
            mx, my, mz = (x + s * ux + t * vx) / length, (y + s * uy + t * vy) / length, (z + s * uz + t * vz) / length
            wx, wy, wz = _farthest(placed, k, mx, my, mz)
            h = wx * mx + wy * my + wz * mz
            if h < best:
                best, nx, ny, nz = h, mx, my, mz
                moved = max(abs(s), abs(t))
            gs = wx * ux + wy * uy + wz * uz + pull * s / length
            gt = wx * vx + wy * vy + wz * vz + pull * t / length
            if gs == 0.0 and gt == 0.0:
                break
            count = _halve(polygon, count, s, t, gs, gt)
            if count < 3:
                break
            area, s, t = _centroid(polygon, count)
            if not area > 1e-32:
                break
        x, y, z = nx, ny, nz
        radius = min(radius, max(4.0 * moved, 0.02 * radius))
        if radius < 1e-10 or best - 4.0 * steepest * radius > lowest:
            break
    return best, x, y, z


@kernel
def _sweep(placed, directions, apart, radius, rounds, cuts, depth, normal):
    values = np.empty(len(directions))
    for k in range(len(placed.offset)):
        for i in range(len(directions)):
            values[i] = _overlap(placed, k, directions[i, 0], directions[i, 1], directions[i, 2])
        lowest, steepest = math.inf, np.max(values)  # no point of A − B is much farther than that
        for start in range(depth.shape[1]):
            i = np.argmin(values)
            if values[i] == math.inf:
                break
            x, y, z = directions[i, 0], directions[i, 1], directions[i, 2]
            depth[k, start], nx, ny, nz = _refine(placed, k, x, y, z, radius, rounds, cuts, lowest, steepest)
            lowest = min(lowest, depth[k, start])
            normal[k, start, 0], normal[k, start, 1], normal[k, start, 2] = nx, ny, nz
            # The next start lies somewhere else.
            for j in range(len(directions)):
                if x * directions[j, 0] + y * directions[j, 1] + z * directions[j, 2] > apart:
                    values[j] = math.inf


def overlaps(pairs: Placed, normals: Array) -> Array:
    """The overlap h(n) of each pair along its own unit vector."""
    result = np.empty(len(pairs.offset))
    _overlaps(pairs, normals, result)
    return result


def minima(
    pairs: Placed, directions: int = 600, starts: int = 8, rounds: int = 40, cuts: int = 40
) -> tuple[Array, Array]:
    """Local minima of the overlap of each pair, near the best of many directions: (n, starts) and (n, starts, 3).

    The least of a pair comes first; the others are in no order, and may be the same once more.
    """
    depth, normal = np.full((len(pairs.offset), starts), np.inf), np.zeros((len(pairs.offset), starts, 3))
    spacing = math.sqrt(4.0 * math.pi / directions)
    apart = math.cos(2.0 * spacing)
    _sweep(pairs, sphere_points(directions), apart, 2.0 * spacing, rounds, cuts, depth, normal)
    rows, best = np.arange(len(depth)), depth.argmin(axis=1)
    depth[rows, best], depth[:, 0] = depth[:, 0], depth[rows, best]
    normal[rows, best], normal[:, 0] = normal[:, 0], normal[rows, best]
    return depth, normal


def sweeps(pairs: Placed, directions: int = 200, starts: int = 2, rounds: int = 4) -> tuple[Array, Array]:
    """The least overlap found of each pair, and its direction, with less effort."""
    depth, normal = minima(pairs, directions, starts, rounds)
    return depth[:, 0], normal[:, 0]


@kernel
def _lowest_outside(placed, normal, directions, cosine, sine, ring, lowest):
    for k in range(len(placed.offset)):
        x, y, z = normal[k, 0], normal[k, 1], normal[k, 2]
        ux, uy, uz, vx, vy, vz = _square(x, y, z)
        lowest[k] = _overlap(placed, k, -x, -y, -z)
        for i in range(len(ring)):
            p, q = sine * ring[i, 0], sine * ring[i, 1]
            nx, ny, nz = cosine * x + p * ux + q * vx, cosine * y + p * uy + q * vy, cosine * z + p * uz + q * vz
            lowest[k] = min(lowest[k], _overlap(placed, k, nx, ny, nz))
        for i in range(len(directions)):
            if directions[i, 0] * x + directions[i, 1] * y + directions[i, 2] * z < cosine:
                overlap = _overlap(placed, k, directions[i, 0], directions[i, 1], directions[i, 2])
                lowest[k] = min(lowest[k], overlap)


def lowest_elsewhere(pairs: Placed, depth: Array, normal: Array, angle: float) -> Array:
    """The least overlap of each pair in directions farther than an angle from the best, given :func:`minima`.

    Asked are a ring of directions at that angle, those of a sweep outside it, the opposite one, and the other minima.
    """
    lowest = np.empty(len(depth))
    turns = 2.0 * math.pi * np.arange(48) / 48
    ring = np.stack([np.cos(turns), np.sin(turns)], axis=1)
    _lowest_outside(pairs, normal[:, 0], sphere_points(600), math.cos(angle), math.sin(angle), ring, lowest)
    outside = np.einsum("ksi,ki->ks", normal, normal[:, 0]) < math.cos(angle)
    return np.minimum(lowest, np.where(outside, depth, np.inf).min(axis=1))


@kernel
def _axes(placed, normals, normal_first, edges, edge_first, depth):
    for k in range(len(placed.offset)):
        depth[k] = math.inf
        for i in range(normal_first[2 * k], normal_first[2 * k + 2]):
            sign = 1.0 if i < normal_first[2 * k + 1] else -1.0
            x, y, z = sign * normals[i, 0], sign * normals[i, 1], sign * normals[i, 2]
            depth[k] = min(depth[k], _overlap(placed, k, x, y, z))
        for i in range(edge_first[2 * k], edge_first[2 * k + 1]):
            for j in range(edge_first[2 * k + 1], edge_first[2 * k + 2]):
                x = edges[i, 1] * edges[j, 2] - edges[i, 2] * edges[j, 1]
                y = edges[i, 2] * edges[j, 0] - edges[i, 0] * edges[j, 2]
                z = edges[i, 0] * edges[j, 1] - edges[i, 1] * edges[j, 0]
                length = math.sqrt(x * x + y * y + z * z)
                if length > 1e-9:
                    x, y, z = x / length, y / length, z / length
                    depth[k] = min(depth[k], _overlap(placed, k, x, y, z), _overlap(placed, k, -x, -y, -z))


def separating_axes(pairs: Placed, shapes: Sequence[Shape]) -> Array:
    """The least overlap of each pair of polyhedra over all face normals and all cross products of edges.

    That is the depth of those that overlap. For those apart it is minus the most that such an axis shows of the
    distance.
    """
    normals, edges = [], []
    for shape, turn in zip(shapes, pairs.rotation.reshape(-1, 3, 3), strict=True):
        solid = shape.polyhedron
        assert solid is not None
        normals.append(solid.planes[:, :3] @ turn.T)
        along = (solid.vertices[solid.edges[:, 1]] - solid.vertices[solid.edges[:, 0]]) @ turn.T
        edges.append(along / np.linalg.norm(along, axis=1, keepdims=True))
    depth = np.empty(len(pairs.offset))
    starts = [np.cumsum([0, *map(len, parts)]) for parts in (normals, edges)]
    _axes(pairs, np.concatenate(normals), starts[0], np.concatenate(edges), starts[1], depth)
    return depth
