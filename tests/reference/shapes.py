"""Slow and obvious: insides, surfaces and integrals of the shapes, straight from their definitions."""

import math
from itertools import pairwise

import numpy as np
from scipy.spatial import Delaunay

from atlasphys.engine.shapes.box import Box
from atlasphys.engine.shapes.capsule import Capsule
from atlasphys.engine.shapes.cone import Cone
from atlasphys.engine.shapes.cylinder import Cylinder
from atlasphys.engine.shapes.hull import ConvexHull
from atlasphys.engine.shapes.sphere import Sphere


def inside(shape, p):
    """Whether each row of p lies in the solid."""
    x, y, z = p.T
    radial = np.hypot(x, z)
    match shape:
        case Sphere(radius):
            return np.linalg.norm(p, axis=1) <= radius
        case Box(size):
            return np.all(np.abs(p) <= 0.5 * np.array(size), axis=1)
        case Capsule(radius, length):
            axial = np.maximum(np.abs(y) - 0.5 * length, 0.0)
            return np.hypot(radial, axial) <= radius
        case Cylinder(radius, length):
            return (radial <= radius) & (np.abs(y) <= 0.5 * length)
        case Cone(radius, height):
            return (np.abs(y) <= 0.5 * height) & (radial <= radius * (0.5 - y / height))
        case ConvexHull():
            return Delaunay(np.array(shape.vertices)).find_simplex(p) >= 0


def core_points(shape):
    """Points of the core among which, in every direction, one is farthest up to about 1e-5 of the radius."""
    turns = np.linspace(0.0, 2.0 * math.pi, 1440, endpoint=False)
    circle = np.stack([np.cos(turns), np.zeros_like(turns), np.sin(turns)], axis=1)
    up = np.array([0.0, 1.0, 0.0])
    match shape:
        case Sphere():
            return np.zeros((1, 3))
        case Capsule(_, length):
            return np.linspace(-0.5, 0.5, 11)[:, None] * length * up
        case Box(size):
            return 0.5 * np.array(size) * np.array([(i, j, k) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])
        case Cylinder(radius, length):
            return np.concatenate([radius * circle + 0.5 * length * up, radius * circle - 0.5 * length * up])
        case Cone(radius, height):
            return np.concatenate([radius * circle - 0.5 * height * up, [0.5 * height * up]])
        case ConvexHull():
            return np.array(shape.vertices)


def core_radius(shape):
    """The radius about the core."""
    return shape.radius if isinstance(shape, (Sphere, Capsule)) else 0.0


def grid_integrals(shape, cells=80):
    """Volume, centroid and inertia about it at unit density, by the midpoint rule over a box that holds the shape."""
    points = core_points(shape)
    lower, upper = points.min(axis=0) - core_radius(shape), points.max(axis=0) + core_radius(shape)
    step = (upper - lower) / cells
    axes = [lower[i] + step[i] * (np.arange(cells) + 0.5) for i in range(3)]
    p = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    p = p[inside(shape, p)]
    return _moments(p, np.full(len(p), np.prod(step)))


def disc_integrals(profile, breaks):
    """Volume, centroid and inertia of a solid of revolution about y whose radius at height y is profile(y).

    The sum of discs of area π ρ², moment π ρ⁴/2 about y and π ρ⁴/4 across, with Gauss–Legendre quadrature between
    breaks: exact where ρ² is a polynomial in y.
    """
    nodes, weights = np.polynomial.legendre.leggauss(12)
    y, w = [], []
    for low, high in pairwise(breaks):
        y.append(0.5 * (high - low) * nodes + 0.5 * (high + low))
        w.append(0.5 * (high - low) * weights)
    y, w = np.concatenate(y), np.concatenate(w)
    square = profile(y) ** 2
    volume = math.pi * np.sum(w * square)
    center = math.pi * np.sum(w * square * y) / volume
    along = math.pi / 2.0 * np.sum(w * square**2)
    across = math.pi * np.sum(w * (square**2 / 4.0 + square * (y - center) ** 2))
    return volume, np.array([0.0, center, 0.0]), np.diag([across, along, across])


def tetrahedra_integrals(vertices):
    """Volume, centroid and inertia of a hull, over its Delaunay tetrahedra.

    The four-point rule is exact for quadratics: Hammer and Stroud, "Numerical Integration over Simplexes", MTAC 10,
    1956.
    """
    vertices = np.asarray(vertices)
    cells = vertices[Delaunay(vertices).simplices]
    volumes = np.abs(np.linalg.det(cells[:, 1:] - cells[:, :1])) / 6.0
    far, near = (5.0 + 3.0 * math.sqrt(5.0)) / 20.0, (5.0 - math.sqrt(5.0)) / 20.0
    weights = np.full((4, 4), near) + (far - near) * np.eye(4)
    return _moments(np.einsum("kc,tcx->tkx", weights, cells).reshape(-1, 3), np.repeat(volumes / 4.0, 4))


def _moments(p, w):
    volume = np.sum(w)
    center = w @ p / volume
    q = p - center
    second = (w[:, None] * q).T @ q
    return volume, center, np.trace(second) * np.eye(3) - second


def rotation_matrix(q):
    """Rotation of v by the unit quaternion q = (w, x, y, z): v + 2 u × (u × v + w v), column by column."""
    w, u = q[0], np.asarray(q[1:])
    return np.stack([e + 2.0 * np.cross(u, np.cross(u, e) + w * e) for e in np.eye(3)], axis=1)
