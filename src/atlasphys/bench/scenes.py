"""The scenes of the benchmark, described without any engine: what to build, and by what to judge whether it came out right.

All are y up, with g = 9.81 m/s², friction 0.5, no restitution. As in the scene library, only ``random.Random(seed).random()`` is random, so
that a scene is the same to the bit everywhere.
"""

from __future__ import annotations

import math
import random
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

from atlasphys.errors import InvalidArgumentError

DT = 1 / 60
GRAVITY = 9.81
FRICTION = 0.5
"""Coefficient of friction of every contact."""

DENSITY = 1000.0

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
IDENTITY: Quaternion = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Box:
    """A box by its half sizes [m]."""

    half: Vector


@dataclass(frozen=True)
class Sphere:
    """A sphere."""

    radius: float


@dataclass(frozen=True)
class Capsule:
    """A capsule along y; half the distance between the centres of its caps."""

    radius: float
    half_length: float


@dataclass(frozen=True)
class Hull:
    """The convex hull of points whose centre of mass is the origin."""

    points: tuple[Vector, ...]
    volume: float


Shape = Box | Sphere | Capsule | Hull


def volume(shape: Shape) -> float:
    """Volume [m³]."""
    match shape:
        case Box((x, y, z)):
            return 8 * x * y * z
        case Sphere(radius):
            return 4 / 3 * math.pi * radius**3
        case Capsule(radius, half_length):
            return math.pi * radius**2 * (4 / 3 * radius + 2 * half_length)
        case Hull():
            return shape.volume


class Item(NamedTuple):
    """A body."""

    shape: Shape
    position: Vector
    orientation: Quaternion = IDENTITY
    density: float = DENSITY


class Link(NamedTuple):
    """A ball joint. What it joins does not collide."""

    a: int | None
    """Place of the first body in the scene's list; None: the world."""
    b: int
    anchor_a: Vector
    """Where the joint is in the axes of a, from its position, or in the world [m]."""
    anchor_b: Vector


@dataclass(frozen=True)
class Scene:
    """What to build, how long to run it, and what it should do."""

    name: str
    bodies: list[Item]
    """The bodies that move."""
    expect: Literal["stands", "piles", "falls", "swings"]
    """Each body stays where it is; all stay within the walls; all fall freely; all hang by their links, and nothing collides."""
    settle: float
    """Simulated time before the measurement [s]."""
    seconds: float
    """Simulated time at which the scene is judged, settling included, and no engine is measured beyond it [s]."""
    walls: list[Item] = field(default_factory=list)
    """Static boxes."""
    ground: bool = True
    """Whether the half-space y < 0 is solid."""
    inside: float = math.inf
    """Half the distance between opposite walls [m]."""
    links: list[Link] = field(default_factory=list)
    length: float = 1.0
    """Of what swings [m]: energy is compared with the weight of all, times this."""

    @property
    def extent(self) -> float:
        """Half the side of a square of ground that is large enough [m]."""
        return max(max(abs(item.position[0]), abs(item.position[2])) for item in self.bodies) + 50.0


UNIT = Box((0.5, 0.5, 0.5))

PILE_SETTLES, PILE_JUDGED = 4.0, 20.0
"""A dropped pile has come to rest after the first [s]."""

ASIDE = 0.02
"""Greatest distance from the grid on which a pile starts, along each axis [m]."""


def _stack(name: str, places: Iterator[Vector] | list[Vector], seconds: float = 60.0) -> Scene:
    return Scene(name, [Item(UNIT, place) for place in places], "stands", settle=2.0, seconds=seconds)


def pyramid(name: str, base: int, gap: float = 0.1) -> Scene:
    """A plane pyramid of unit cubes, with gaps between those side by side."""
    step = 1 + gap
    return _stack(
        name,
        [(step * (k - 0.5 * (base - row - 1)), row + 0.5, 0.0) for row in range(base) for k in range(base - row)],
    )


def tower(name: str, height: int, seconds: float = 60.0) -> Scene:
    """Unit cubes on each other."""
    return _stack(name, [(0.0, k + 0.5, 0.0) for k in range(height)], seconds)


def towers(name: str, side: int, height: int) -> Scene:
    """A square of towers, a cube's width apart."""
    places = [2.0 * (k - 0.5 * (side - 1)) for k in range(side)]
    return _stack(name, [(x, k + 0.5, z) for x in places for z in places for k in range(height)])


def heavy_on_light(name: str, ratio: float) -> Scene:
    """A cube on one that is lighter by the ratio."""
    bodies = [Item(UNIT, (0.0, 0.5, 0.0)), Item(UNIT, (0.0, 1.5, 0.0), density=ratio * DENSITY)]
    return Scene(name, bodies, "stands", settle=2.0, seconds=10.0)


def resting(name: str, count: int) -> Scene:
    """Cubes side by side on the ground. Small scenes show what a step costs in itself: they are measured for long."""
    bodies = [Item(UNIT, (2.0 * (k - 0.5 * (count - 1)), 0.5, 0.0)) for k in range(count)]
    return Scene(name, bodies, "stands", settle=2.0, seconds=20_000.0)


def falling(name: str, count: int) -> Scene:
    """Cubes that fall without ever touching anything."""
    side = math.ceil(count ** (1 / 3) - 1e-9)
    cells = ((k % side, k // side // side, k // side % side) for k in range(count))
    bodies = [Item(UNIT, (3.0 * (i - 0.5 * (side - 1)), 3.0 * j, 3.0 * (k - 0.5 * (side - 1)))) for i, j, k in cells]
    return Scene(name, bodies, "falls", settle=0.2, seconds=5.0, ground=False)


def boxes(name: str, count: int) -> Scene:
    """Cubes of 0.8 m, turned at random, dropped in about ten layers between walls."""
    return _pile(name, [Box((0.4, 0.4, 0.4))] * count, 1.45, seed=1)


def spheres(name: str, count: int) -> Scene:
    """Spheres of 16 sizes, of radius 0.4 to 0.5 m, in a pit, about ten layers deep."""
    number = random.Random(2).random
    return _pile(name, [Sphere(0.4 + int(16 * number()) / 150) for _ in range(count)], 1.05, seed=3)


def mixed(name: str, count: int) -> Scene:
    """Boxes, spheres, capsules and hulls of 16 points, in turn, in a pit."""
    hulls = [_hull(16, seed) for seed in range(8)]
    cycle = (Box((0.4, 0.3, 0.35)), Sphere(0.4), Capsule(0.3, 0.25))
    shapes: list[Shape] = [cycle[k % 4] if k % 4 < 3 else hulls[k // 4 % 8] for k in range(count)]
    return _pile(name, shapes, 1.28, seed=4)


def chains(name: str, count: int, length: int) -> Scene:
    """Chains of capsules, stretched out to one side of where they hang, side by side; let go at once."""
    link, half = Capsule(0.1, 0.15), 0.25
    turned: Quaternion = (math.sqrt(0.5), 0.0, 0.0, -math.sqrt(0.5))  # y, along which a capsule lies, to x
    bodies: list[Item] = []
    links: list[Link] = []
    for chain in range(count):
        for k in range(length):
            bodies.append(Item(link, (2 * half * (k + 0.5), 0.0, 0.5 * chain), turned))
            start = (0.0, -half, 0.0)  # the end nearer to where it hangs
            if k == 0:
                links.append(Link(None, len(bodies) - 1, (0.0, 0.0, 0.5 * chain), start))
            else:
                links.append(Link(len(bodies) - 2, len(bodies) - 1, (0.0, half, 0.0), start))
    return _swinging(name, bodies, links, 2 * half * length)


def joint_grid(name: str, side: int) -> Scene:
    """A square net of balls, each joined with its neighbours, that hangs by the middle of its upper edge: Box3D's benchmark "joint grid"."""
    half, ball = 0.5, Sphere(0.4)
    bodies: list[Item] = []
    links: list[Link] = []
    held = range(side // 2 - 3, side // 2 + 4)
    for column in range(side):
        for row in range(side):
            here = len(bodies)
            bodies.append(Item(ball, (2 * half * column, -2 * half * row, 0.0)))
            if row > 0:
                links.append(Link(here - 1, here, (0.0, -half, 0.0), (0.0, half, 0.0)))
            elif column in held:
                links.append(Link(None, here, (2 * half * column, half, 0.0), (0.0, half, 0.0)))
            if column > 0:
                links.append(Link(here - side, here, (half, 0.0, 0.0), (-half, 0.0, 0.0)))
    return _swinging(name, bodies, links, 2 * half * side)


def _swinging(name: str, bodies: list[Item], links: list[Link], length: float) -> Scene:
    return Scene(name, bodies, "swings", settle=1.0, seconds=10.0, ground=False, links=links, length=length)


def _pile(name: str, shapes: list[Shape], cell: float, seed: int, layers: int = 10) -> Scene:
    """Bodies that start apart, one a cell, turned at random, with as much ground as makes the given number of layers."""
    number = random.Random(seed).random
    side = math.ceil(math.sqrt(len(shapes) / layers))
    bodies = []
    for k, shape in enumerate(shapes):
        layer, place = divmod(k, side * side)
        row, column = divmod(place, side)
        # A little beside the grid, for spheres exactly above each other would stand as a column.
        x, z = (cell * (place - 0.5 * (side - 1)) + ASIDE * (2 * number() - 1) for place in (column, row))
        position = (x, cell * (layer + 0.6), z)
        bodies.append(Item(shape, position, _turned(number)))
    inside, height, thickness = 0.5 * cell * side, cell * (layers + 2), 0.5
    offset, length = inside + thickness, inside + 2 * thickness
    along_z, along_x = Box((thickness, 0.5 * height, length)), Box((length, 0.5 * height, thickness))
    walls = [Item(along_z, (sign * offset, 0.5 * height, 0.0)) for sign in (-1, 1)]
    walls += [Item(along_x, (0.0, 0.5 * height, sign * offset)) for sign in (-1, 1)]
    return Scene(name, bodies, "piles", PILE_SETTLES, PILE_JUDGED, walls=walls, inside=inside)


def _turned(number: Callable[[], float]) -> Quaternion:
    """An orientation, all being equally likely."""
    while True:
        w, x, y, z = (2 * number() - 1 for _ in range(4))
        square = w * w + x * x + y * y + z * z
        if 0.01 < square < 1:
            length = math.sqrt(square)
            return w / length, x / length, y / length, z / length


def _hull(count: int, seed: int) -> Hull:
    """The hull of random points on a sphere of radius 0.5 m, moved so that its centre of mass is the origin."""
    from atlasphys.engine.shapes.hull import ConvexHull

    number = random.Random(seed).random
    points: list[Vector] = []
    while len(points) < count:
        x, y, z = (2 * number() - 1 for _ in range(3))
        square = x * x + y * y + z * z
        if 0.01 < square < 1:
            scale = 0.5 / math.sqrt(square)
            points.append((scale * x, scale * y, scale * z))
    whole = ConvexHull(points=points)
    a, b, c = (float(value) for value in whole.center_of_mass)
    return Hull(tuple((round(x - a, 9), round(y - b, 9), round(z - c, 9)) for x, y, z in points), float(whole.volume))


SCENES: dict[str, Callable[[str], Scene]] = {
    "one_body": lambda name: resting(name, 1),
    "ten_bodies": lambda name: resting(name, 10),
    "pyramid_20": lambda name: pyramid(name, 20),
    "pyramid_40": lambda name: pyramid(name, 40),
    "towers_100x10": lambda name: towers(name, 10, 10),
    "boxes_1000_walls": lambda name: boxes(name, 1000),
    "boxes_5000_walls": lambda name: boxes(name, 5000),
    "spheres_2000_pit": lambda name: spheres(name, 2000),
    "spheres_10000_pit": lambda name: spheres(name, 10_000),
    "falling_10000": lambda name: falling(name, 10_000),
    "mixed_1000": lambda name: mixed(name, 1000),
    "tower_20": lambda name: tower(name, 20),
    "tower_50": lambda name: tower(name, 50),
    "tower_100": lambda name: tower(name, 100, seconds=10.0),
    "heavy_on_light_100": lambda name: heavy_on_light(name, 100),
    "chains_50x20": lambda name: chains(name, 50, 20),
    "joint_grid": lambda name: joint_grid(name, 100),
}
"""Name → builder."""

FAMILIES: dict[str, Callable[[str, int], Scene]] = {"pile": boxes, "falling": falling}
"""Scenes of any number of bodies: ``pile_3000``."""

MOST_BODIES = 1_000_000


def make(name: str) -> Scene:
    """The scene of that name.

    Raises:
        InvalidArgumentError: there is none.
    """
    if name in SCENES:
        return SCENES[name](name)
    match = re.fullmatch(r"([a-z]+)_([1-9][0-9]*)", name)
    if match and match[1] in FAMILIES and int(match[2]) <= MOST_BODIES:
        return FAMILIES[match[1]](name, int(match[2]))
    families = ", ".join(f"{family}_N" for family in FAMILIES)
    raise InvalidArgumentError(
        f"no benchmark scene {name!r}; there are {', '.join(SCENES)}, and for N up to {MOST_BODIES:,} bodies {families}"
    )
