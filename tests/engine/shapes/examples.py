"""Shapes that the tests of this folder share."""

import math

import numpy as np

from atlasphys.engine.shapes.box import Box
from atlasphys.engine.shapes.capsule import Capsule
from atlasphys.engine.shapes.cone import Cone
from atlasphys.engine.shapes.cylinder import Cylinder
from atlasphys.engine.shapes.hull import ConvexHull, octahedron, pyramid, tetrahedron
from atlasphys.engine.shapes.sphere import Sphere


def random_hull(seed, count=20):
    """The hull of random points about a point off the origin."""
    return ConvexHull(np.random.default_rng(seed).normal((0.3, -0.2, 0.1), (1.0, 0.5, 0.7), (count, 3)))


SOLIDS = [
    Sphere(0.7),
    Capsule(0.3, 1.1),
    Capsule(2.0, 0.01),
    Box((1.0, 2.0, 0.3)),
    Box((100.0, 0.01, 1.0)),
    Cylinder(0.5, 2.0),
    Cylinder(2.0, 0.05),
    Cone(0.5, 1.5),
    Cone(3.0, 0.1),
    tetrahedron(0.8),
    octahedron(1.2),
    pyramid(3, 1.0, 0.5),
    pyramid(6, 0.5, 2.0),
    random_hull(1),
    random_hull(2, 6),
    ConvexHull([(x, y + 0.3 * x, z) for x in (-1e-3, 1e-3) for y in (0.0, 1.0) for z in (-1e3, 1e3)]),
]

PRECISIONS = [np.float32, np.float64]


def directions(seed, count=40):
    """Random unit directions and the special ones: axes, diagonals, nearly axes."""
    rng = np.random.default_rng(seed)
    random = rng.normal(size=(count, 3))
    grid = [(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if (x, y, z) != (0, 0, 0)]
    nearly = [(1e-6, 1.0, 0.0), (0.0, -1.0, -1e-6), (1.0, 1e-6, 1e-6), (math.sqrt(0.5), 1e-3, -math.sqrt(0.5))]
    all_of_them = np.concatenate([random, grid, nearly])
    return all_of_them / np.linalg.norm(all_of_them, axis=1)[:, None]
