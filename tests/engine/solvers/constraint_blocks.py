"""Random blocks of contacts and bodies, and a driver that runs each body over lanes of ``soft_step`` on them."""

from typing import Any, NamedTuple

import numpy as np

from atlasphys.engine.jit import kernel
from atlasphys.engine.solvers.body_block import drive, fly, gain_speed, move, settle, tumble
from atlasphys.engine.solvers.bounce_block import aim, depart, strike
from atlasphys.engine.solvers.contact_block import (
    Fields,
)
from atlasphys.engine.solvers.rolling_block import (
    ROLLING_FIELDS,
    prepare_rolling,
    solve_rolling,
    start_rolling,
    store_rolling,
)
from atlasphys.engine.solvers.soft_contact import prepare, solve, store_impulses, warm_start
from atlasphys.engine.solvers.soft_step import softness
from atlasphys.engine.state.blocks import BODY_A, BODY_B, COUNT, INTEGERS, MANIFOLD, MOVES_A, MOVES_B
from atlasphys.engine.state.bodies import Bodies, empty_bodies
from atlasphys.engine.state.manifolds import (
    DEPTH,
    IS_FRESH,
    NORMAL_IMPULSE,
    PATCH_FRICTION,
    POINT_COLUMNS,
    Manifolds,
    empty_manifolds,
)

BLOCKS = 3


class Scene(NamedTuple):
    """Arguments of the drivers."""

    bodies: Bodies
    manifolds: Manifolds
    locks: Any
    rows: Any
    integers: Any
    blocks: Any
    rolls: Any
    moved: Any
    soft: Any
    bounce: Any
    answers: Any


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def random_scene(points, real, seed, locks=False):
    """Three blocks, each lane with two bodies of its own: dynamic ones, static ones, idle lanes; fresh and recycled contacts."""
    rng = np.random.default_rng(seed)
    number = 8 * BLOCKS
    bodies, manifolds = empty_bodies(2 * number, real), empty_manifolds(number, real)
    n = 2 * number
    bodies.motion[:, 0:6] = rng.normal(size=(n, 6))
    bodies.motion[:, 6:12] = 0.02 * rng.normal(size=(n, 6))
    bodies.force[:] = rng.normal(size=(n, 8))
    moments = rng.uniform(0.5, 1.5, (n, 3))
    masses = rng.uniform(0.5, 2, n)
    bodies.mass[:, 0], bodies.mass[:, 1] = masses, 1 / masses
    bodies.mass[:, 2:5], bodies.mass[:, 5:8] = moments, 1 / moments
    bodies.response[:, 0:3] = rng.uniform(0, 1, (n, 3))
    orientations = unit(rng.normal(size=(n, 4)))
    bodies.geometry[:, 12:16] = orientations
    bodies.frame[:, 0:3], bodies.frame[:, 3], bodies.frame[:, 4] = rng.normal(size=(n, 3)), rng.integers(0, 2, n), 1
    spread = 0.3 * rng.normal(size=(n, 3, 3))
    inverse = np.eye(3) + spread @ spread.transpose(0, 2, 1)
    for column, (i, j) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))):
        bodies.inverse_mass[:, column] = inverse[:, i, j]
    bodies.inverse_mass[:, 6] = 1 / masses
    bodies.inverse_mass[:, 8:11] = (1 / masses)[:, None]
    if locks:
        bodies.inverse_mass[:, 8:11] *= rng.integers(0, 2, (n, 3))
    still = rng.random(n) < 0.2
    bodies.inverse_mass[still] = bodies.mass[still] = 0
    bodies.drive[:] = np.where(still[:, None], 0, 0.1 * rng.normal(size=(n, 8)))

    count = rng.integers(1, points + 1, number)
    manifolds.contact[:, 0:3] = unit(rng.normal(size=(number, 3)))
    manifolds.contact[:, 3:7] = rng.uniform(0, 0.8, (number, 4)) * rng.integers(0, 2, (number, 4))
    manifolds.contact[:, PATCH_FRICTION : PATCH_FRICTION + 7] = 0.1 * rng.normal(size=(number, 7))
    manifolds.contact[:, IS_FRESH] = rng.integers(0, 2, number)
    span = rng.normal(size=(number, 3))
    for k in range(points):
        used, first = count > k, POINT_COLUMNS * k
        arm = rng.normal(size=(number, 3))
        point = np.zeros((number, POINT_COLUMNS))
        point[:, 0:3], point[:, 3:6] = arm + span, arm
        point[:, DEPTH] = 0.02 * rng.normal(size=number)
        point[:, NORMAL_IMPULSE] = np.maximum(rng.normal(size=number), 0)
        manifolds.points[:, first : first + POINT_COLUMNS] = np.where(used[:, None], point, 0)

    integers = np.zeros((BLOCKS, INTEGERS, 8), np.int32)
    order = rng.permutation(n).reshape(2, BLOCKS, 8)
    integers[:, BODY_A], integers[:, BODY_B] = order
    integers[:, MOVES_A], integers[:, MOVES_B] = ~still[order]
    integers[:, MANIFOLD] = np.arange(number).reshape(BLOCKS, 8)
    integers[:, COUNT] = count.reshape(BLOCKS, 8)
    integers[-1, :, 5:] = 0  # idle lanes
    soft = (960.0, *softness(30.0, 10.0, 1 / 960), *softness(60.0, 10.0, 1 / 960), 3.0)
    return Scene(
        bodies=bodies,
        manifolds=manifolds,
        locks=np.zeros(1, np.int32) if locks else None,
        rows=np.arange(n, dtype=np.int32).reshape(-1, 8),
        integers=integers,
        blocks=np.zeros((BLOCKS, Fields(points).number, 8), real),
        rolls=np.zeros((BLOCKS, ROLLING_FIELDS, 8), real),
        moved=np.zeros((8, 8), real),
        soft=tuple(real(x) for x in soft),
        bounce=tuple(real(x) for x in (0.3, 1 / 240, 1 / 960, 0.005, 1e-6)),
        answers=np.zeros(8 * BLOCKS, np.int64),
    )


def contacts_of(points):
    """A kernel that does all that is done in a step to contacts of that many points."""

    @kernel
    def run(s, half):
        b, m, k = s.bodies, s.manifolds, 0
        for i in range(len(s.blocks)):
            before = max(i - 1, 0)  # worked on together with i
            s.answers[k + 0] += prepare(points, s.locks, i, s.integers, s.blocks, m, b.inverse_mass, half)
            s.answers[k + 1] += aim(
                points, s.locks, i, s.integers, s.blocks, b.motion, b.inverse_mass, b.drive, m, s.bounce
            )
            for _ in range(3):
                s.answers[k + 2] += strike(points, s.locks, i, s.integers, s.blocks, b.motion, b.inverse_mass, half)
            depart(points, s.locks, i, s.integers, s.blocks, b.motion, b.inverse_mass, m, half)
            prepare_rolling(i, s.integers, s.blocks, s.rolls, m, b.inverse_mass, half)
            warm_start(points, s.locks, i, before, s.integers, s.blocks, b.motion, b.inverse_mass)
            start_rolling(points, i, s.integers, s.blocks, s.rolls, b.motion, b.inverse_mass)
            solve(points, s.locks, 0, i, before, s.integers, s.blocks, b.motion, b.inverse_mass, s.soft)
            solve_rolling(points, i, s.integers, s.blocks, s.rolls, b.motion, b.inverse_mass, half)
            solve(points, s.locks, 1, i, before, s.integers, s.blocks, b.motion, b.inverse_mass, s.soft)
            store_impulses(points, i, s.integers, s.blocks, m)
            store_rolling(i, s.integers, s.blocks, s.rolls, m)
            k += 8

    return run


@kernel
def all_bodies(s, h):
    """All that is done to bodies in a step of one substep."""
    b = s.bodies
    for i in range(len(s.rows)):
        drive(s.locks, i, s.rows, b.motion, b.force, b.response, b.inverse_mass, b.mass, b.drive, (h, -h, h), h)
        gain_speed(i, s.rows, b.motion, b.drive)
        move(i, s.rows, b.motion, b.geometry, h)
        fly(i, s.rows, b.motion, b.geometry, b.drive, h)
        tumble(i, s.rows, b.motion, b.geometry, b.mass, b.frame, b.inverse_mass, h)
        s.answers[i] = settle(i, s.rows, b.motion, b.geometry, b.frame, s.moved)
