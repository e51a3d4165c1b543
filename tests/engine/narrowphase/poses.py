"""Pairs of shapes in random and degenerate poses, and what the narrow phase says of them."""

from __future__ import annotations

import math
from functools import cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from atlasphys.engine.narrowphase.dispatch import collide
from atlasphys.engine.shapes.box import Box
from atlasphys.engine.shapes.capsule import Capsule
from atlasphys.engine.shapes.cone import Cone
from atlasphys.engine.shapes.cylinder import Cylinder
from atlasphys.engine.shapes.hull import ConvexHull, octahedron, pyramid, tetrahedron
from atlasphys.engine.shapes.shape import Shape
from atlasphys.engine.shapes.sphere import Sphere
from atlasphys.engine.shapes.table import Shapes, ShapeTable
from atlasphys.engine.state.bodies import Bodies, empty_bodies
from atlasphys.engine.state.colliders import Colliders, empty_colliders
from atlasphys.engine.state.contacts import Contacts, empty_contacts
from tests.reference.narrowphase import rotation
from tests.reference.sweep import placed, sweeps

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


def _hull(form: int, s: Array, rng: np.random.Generator) -> ConvexHull:
    if form == 0:
        return tetrahedron(0.6 * s[2])
    if form == 1:
        return octahedron(0.6 * s[2])
    if form == 2:
        return pyramid(int(rng.integers(3, 8)), 0.5 * s[0], s[1])
    return ConvexHull(rng.normal(size=(12, 3)) * 0.4 * s)


@cache
def _hulls(number: int, size: float, thin: bool) -> ConvexHull:
    """One of the hulls that are made once and used in many pairs, for Qhull takes its time."""
    rng = np.random.default_rng(number)
    return _hull(number % 4, _sizes(rng, size, thin), rng)


def _sizes(rng: np.random.Generator, size: float, thin: bool) -> Array:
    s = size * rng.uniform(0.5, 1.5, 3)
    if thin:
        s[rng.integers(2)] *= 1e-3
    return s


def random_shape(kind: str, rng: np.random.Generator, size: float = 1.0, thin: bool = False) -> Shape:
    """A shape about ``size`` across; a thin one is a thousandth of that one way."""
    if kind == "hull":
        return _hulls(int(rng.integers(240)), size, thin)
    s = _sizes(rng, size, thin)
    if kind == "sphere":
        return Sphere(0.5 * s[0])
    if kind == "capsule":
        return Capsule(0.3 * s[0], s[1])
    if kind == "box":
        return Box((s[0], s[1], s[2]))
    if kind == "cylinder":
        return Cylinder(0.5 * s[0], s[1])
    assert kind == "cone"
    return Cone(0.5 * s[0], s[1])


def scale_of(case: str) -> float:
    """About how large the shapes of a case are [m]."""
    return {"tiny": 1e-3, "huge": 1e3}.get(case, 1.0)


def _random_shapes(kind_a: str, kind_b: str, rng: np.random.Generator, case: str) -> tuple[Shape, Shape]:
    a = random_shape(kind_a, rng, scale_of(case), case == "thin")
    if kind_a == kind_b and (case == "identical" or (case == "parallel" and kind_a == "hull")):
        return a, a
    if case == "aligned" and kind_a == kind_b == "box":
        half, other = 0.5 * rng.integers(1, 4, (2, 3))
        return Box(tuple(half)), Box(tuple(other))
    return a, random_shape(kind_b, rng, scale_of(case), case == "thin")


def _turns(a: Shape, rng: np.random.Generator, case: str) -> tuple[Array, Array]:
    if case in ("aligned", "identical"):
        turn = CUBE_TURNS[rng.integers(7)]
        return turn, turn if case == "identical" else CUBE_TURNS[rng.integers(7)]
    turn = turned(rng)
    if case != "parallel":
        return turn, turned(rng)
    axis = np.eye(3)[rng.integers(3)]
    if isinstance(a, ConvexHull):
        i, j = a.polyhedron.edges[0, :2]
        axis = np.subtract(a.vertices[j], a.vertices[i])
        axis /= np.linalg.norm(axis)
    angle = rng.uniform(0.0, 3.0)
    return turn, turn @ rotation((math.cos(angle), *(math.sin(angle) * axis)))


def random_poses(kind_a: str, kind_b: str, rng: np.random.Generator, case: str, number: int = 1) -> list[Pose]:
    """Pairs of shapes, overlapping unless the case says otherwise.

    Cases: random; deep; aligned (axes along axes, offsets in quarters); parallel (turned about an edge or axis of the
    first); identical (the same shape at the same place); concentric (turned about the same point); touching (moved
    apart to an overlap of zero by the sweep's answer); near (a gap of up to 1e-3 of the size, as often an overlap);
    apart (a gap of up to a fifth of the size); tiny; huge; thin.
    """
    size = scale_of(case)
    shapes: list[Shape] = []
    turns: list[Array] = []
    for _ in range(number):
        shapes += _random_shapes(kind_a, kind_b, rng, case)
        turns += _turns(shapes[-2], rng, case)
    if case == "aligned":
        offsets = 0.25 * rng.integers(-3, 4, (number, 3))
    elif case in ("identical", "concentric"):
        offsets = np.zeros((number, 3))
    else:
        # Push b in from outside along a random direction.
        depth, n = sweeps(placed(shapes, turns, np.zeros((number, 3))))
        u = rng.uniform(size=(number, 1))
        depth = depth[:, None]
        aside = rng.normal(size=(number, 3))
        aside /= np.linalg.norm(aside, axis=1, keepdims=True)
        if case == "deep":
            offsets = 0.3 * depth * aside
        elif case == "touching":
            offsets = depth * n
        elif case == "near":
            offsets = (depth + 1e-3 * (2.0 * u - 1.0)) * n
        elif case == "apart":
            # Along another direction the gap shows another place of the surfaces.
            pairs = placed(shapes, turns, (depth + 0.2) * n + 0.3 * depth * aside)
            gap, n = sweeps(pairs)
            offsets = pairs.offset + (gap[:, None] + 0.2 * u) * n
        else:
            offsets = depth * (u * 0.4 + 0.6) * n + 0.1 * depth * aside
    positions = size * rng.uniform(-1, 1, (number, 3))
    return [
        Pose(shapes[2 * k], shapes[2 * k + 1], position, position + offset, turns[2 * k], turns[2 * k + 1])
        for k, (position, offset) in enumerate(zip(positions, offsets, strict=True))
    ]


KINDS = ("sphere", "capsule", "box", "cylinder", "cone", "hull")
CASES = (
    "random",
    "deep",
    "aligned",
    "parallel",
    "identical",
    "concentric",
    "touching",
    "near",
    "apart",
    "tiny",
    "huge",
    "thin",
)
