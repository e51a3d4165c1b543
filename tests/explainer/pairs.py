"""Pairs of which traces are read: apart, touching and deep, of shapes of several kinds."""

import numpy as np

import atlasphys as ap

TILT = (0.92, 0.2, 0.3, 0.1)
BOX, ODD_BOX = ap.Box(size=(1, 1, 1)), ap.Box(size=(0.6, 0.8, 1.0))
PYRAMID, CYLINDER = ap.pyramid(sides=5, radius=0.6, height=0.8), ap.Cylinder(radius=0.4, length=0.8)
CAPSULE, BALL = ap.Capsule(radius=0.2, length=0.8), ap.Sphere(radius=0.5)

KINDS = {
    "separate": (BOX, ODD_BOX, (1.4, 0.3, -0.2)),
    "touching": (BOX, ODD_BOX, (0.1, 0.9, 0.05)),
    "deep": (BOX, ODD_BOX, (0.3, 0.4, 0.2)),
    "separate hulls": (PYRAMID, ap.octahedron(radius=0.5), (0.2, 1.5, 0.1)),
    "deep hulls": (PYRAMID, ap.octahedron(radius=0.5), (0.2, 0.4, 0.1)),
    "deep cylinders": (CYLINDER, CYLINDER, (0.2, 0.3, 0.1)),
    "separate cylinder and box": (BOX, CYLINDER, (0.2, 1.3, 0.1)),
    "touching capsule": (BOX, CAPSULE, (0.2, 0.8, 0.1)),
    "turned": (BOX, ODD_BOX, (0.1, 0.89, 0.05)),
    "sunk ball": (BOX, BALL, (0.2, 0.1, 0.3)),
}


def world_of(kind, **settings):
    """A world with a pair of the kind, and a third body far away."""
    first, second, place = KINDS[kind]
    turned = {"touching": (1, 0, 0, 0), "turned": (0.99, 0.005, 0.12, 0)}.get(kind, TILT)
    world = ap.World(gravity=(0, 0, 0), **settings)
    world.add(first, name="first")
    world.add(second, position=place, orientation=turned, velocity=(0, -0.5, 0), name="second")
    world.add(BALL, position=(50, 50, 50), name="far")
    return world


def story_of(kind, **settings):
    """The story of a step of the pair."""
    world = world_of(kind, **settings)
    with ap.explain(world, pair=("first", "second")) as story:
        world.step(1 / 60)
    return story


def unit(v):
    return np.asarray(v, np.float64) / np.linalg.norm(v)
