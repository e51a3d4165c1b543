"""Pairs of shapes in random and degenerate poses, and what the narrow phase says of them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from atlasphys.engine.narrowphase.dispatch import collide
from atlasphys.engine.shapes.box import Box
from atlasphys.engine.shapes.capsule import Capsule
from atlasphys.engine.shapes.cone import Cone
from atlasphys.engine.shapes.cylinder import Cylinder
from atlasphys.engine.shapes.hull import ConvexHull, octahedron, pyramid, tetrahedron
from atlasphys.engine.shapes.plane import Plane
from atlasphys.engine.shapes.shape import Shape
from atlasphys.engine.shapes.sphere import Sphere
from atlasphys.engine.shapes.table import Shapes, ShapeTable
from atlasphys.engine.state.bodies import Bodies, empty_bodies
from atlasphys.engine.state.colliders import Colliders, empty_colliders
from atlasphys.engine.state.contacts import Contacts, empty_contacts
from tests.reference.narrowphase import rotation, sweep

Array = npt.NDArray[np.float64]


class Pose(NamedTuple):
    """Two placed shapes."""

    a: Shape
    b: Shape
    position_a: Array
    position_b: Array
    rotation_a: Array
    rotation_b: Array


class State(NamedTuple):
    """A world of pairs as the engine sees it: bodies 2 k and 2 k + 1 are pair k."""

    bodies: Bodies
    colliders: Colliders
    shapes: Shapes
    pairs: npt.NDArray[np.int32]


def state_of(poses: list[Pose], real: npt.DTypeLike) -> State:
    table = ShapeTable(real)
    bodies, colliders = empty_bodies(2 * len(poses), real), empty_colliders(2 * len(poses), real)
    for k, pose in enumerate(poses):
        for row, shape, position, turn in (
            (2 * k, pose.a, pose.position_a, pose.rotation_a),
            (2 * k + 1, pose.b, pose.position_b, pose.rotation_b),
        ):
            bodies.position[row] = position
            bodies.geometry[row, :9] = turn.ravel()
            colliders.body[row] = row
            colliders.shape[row] = table.row_of(shape)
    pairs = np.arange(2 * len(poses), dtype=np.int32).reshape(-1, 2)
    return State(bodies, colliders, table.arrays, pairs)


def contacts_of(poses: list[Pose], real: npt.DTypeLike, method: str = "auto", margin: float = 1e-6) -> Contacts:
    state = state_of(poses, real)
    return collide(*state, method, margin, empty_contacts(1, 1, real))


class Contact(NamedTuple):
    """One pair's contact in double precision; the points are in world coordinates."""

    normal: Array
    points: Array
    depth: Array
    feature: npt.NDArray[np.int32]


def contact(contacts: Contacts, k: int, pose: Pose) -> Contact:
    begin = int(contacts.first[k])
    rows = slice(begin, begin + int(contacts.count[k]))
    return Contact(
        contacts.normal[k].astype(float),
        contacts.anchor_a[rows].astype(float) + pose.position_a,
        contacts.depth[rows].astype(float),
        contacts.feature[rows].copy(),
    )


def turned(rng: np.random.Generator) -> Array:
    return rotation(rng.normal(size=4))


CUBE_TURNS = [
    rotation(q)
    for q in ((1, 0, 0, 0), (1, 1, 0, 0), (1, 0, 1, 0), (1, 0, 0, 1), (1, 1, 1, 1), (0, 1, 0, 0), (0, 1, 1, 0))
]
"""Turns that bring a cube's axes onto its axes."""


def random_shape(kind: str, rng: np.random.Generator, size: float = 1.0, thin: bool = False) -> Shape:
    """A shape about ``size`` across; a thin one is a thousandth of that one way."""
    s = size * rng.uniform(0.5, 1.5, 3)
    if thin:
        s[rng.integers(2)] *= 1e-3
    if kind == "sphere":
        return Sphere(0.5 * s[0])
    if kind == "capsule":
        return Capsule(0.3 * s[0], s[1])
    if kind == "box":
        return Box((s[0], s[1], s[2]))
    if kind == "cylinder":
        return Cylinder(0.5 * s[0], s[1])
    if kind == "cone":
        return Cone(0.5 * s[0], s[1])
    assert kind == "hull"
    form = rng.integers(4)
    if form == 0:
        return tetrahedron(0.6 * s[2])
    if form == 1:
        return octahedron(0.6 * s[2])
    if form == 2:
        return pyramid(int(rng.integers(3, 8)), 0.5 * s[0], s[1])
    return ConvexHull(rng.normal(size=(12, 3)) * 0.4 * s)


def random_pose(kind_a: str, kind_b: str, rng: np.random.Generator, case: str) -> Pose:
    """A pair of overlapping shapes (unless ``case`` is "apart").

    Cases: random; deep; apart; aligned (axes along axes, offsets in quarters); identical (the same shape at the same
    place); concentric (turned about the same point); touching (moved apart to an overlap of zero by the sweep's
    answer); tiny; huge; thin.
    """
    size = {"tiny": 1e-3, "huge": 1e3}.get(case, 1.0)
    thin = case == "thin"
    a = random_shape(kind_a, rng, size, thin)
    b = a if case == "identical" and kind_a == kind_b else random_shape(kind_b, rng, size, thin)
    if case == "aligned" and kind_a == "box" and kind_b == "box":
        a, b = (Box(tuple(rng.integers(1, 4, 3) * 0.5)) for _ in range(2))
    aligned = case in ("aligned", "identical")
    turn_a = CUBE_TURNS[rng.integers(7)] if aligned else turned(rng)
    turn_b = CUBE_TURNS[rng.integers(7)] if aligned else turned(rng)
    if case == "identical":
        turn_b = turn_a
    direction = rng.normal(size=3)
    direction /= np.linalg.norm(direction)
    if case == "aligned":
        offset = rng.integers(-3, 4, 3) * 0.25
    elif case in ("identical", "concentric"):
        offset = np.zeros(3)
    else:
        # Push b in from outside along a random direction.
        offset = np.zeros(3)
        depth, n = sweep(a, b, turn_a, turn_b, offset, starts=2, rounds=20)
        if case == "deep":
            offset = direction * 0.3 * depth
        elif case == "apart":
            offset = n * (depth + size * rng.uniform(0.0, 1.0)) + 0.2 * size * rng.normal(size=3)
        elif case == "touching":
            offset = n * depth
        else:
            offset = n * depth * rng.uniform(0.6, 1.0) + 0.1 * depth * direction
    position_a = size * rng.uniform(-1, 1, 3)
    return Pose(a, b, position_a, position_a + offset, turn_a, turn_b)


KINDS = ("sphere", "capsule", "box", "cylinder", "cone", "hull")
CASES = ("random", "deep", "aligned", "identical", "concentric", "touching", "tiny", "huge", "thin", "apart")
PLANE = Plane
