"""Axial parts solved against what holds their joint: the Schur complement, and limits from which nothing comes back."""

import numpy as np
import pytest

import atlasphys as ap
from atlasphys.engine.joints.held import AXES, HOLDERS, held_back
from atlasphys.engine.joints.parts import PARTS
from atlasphys.engine.joints.rows import NONE, Row
from atlasphys.engine.state.joints import POINT
from tests.engine.joints.test_parts import Scene, full_jacobian, lanes


@pytest.mark.parametrize("kind", HOLDERS)
@pytest.mark.parametrize("seed", range(4))
def test_no_impulse_of_the_block_shows_in_what_is_left_of_a_row(kind, seed):
    random, ends = np.random.default_rng(seed), Scene(seed).ends()
    inverse, blocks = [], []
    for _ in range(2):
        m, root = random.uniform(0.1, 3, size=3), random.normal(size=(3, 3))
        tensor = root @ root.T
        inverse += [lanes(m), lanes(tensor[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]])]
        blocks += [np.diag(m), tensor]
    mass = np.zeros((12, 12))
    for k, block in enumerate(blocks):
        mass[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = block
    row = PARTS[kind].rows(ends)[0]
    with np.errstate(all="ignore"):
        taken = held_back(kind, row, ends, inverse)
    left = full_jacobian([row]) - full_jacobian([taken])
    held = PARTS[POINT].rows(ends) if HOLDERS[kind] == POINT else [Row(NONE, e, NONE, e) for e in AXES]
    assert left @ mass @ full_jacobian(held).T == pytest.approx(0, abs=1e-9)


def door(world, speed):
    body = world.add(
        ap.Box(size=(1, 2, 0.05)),
        position=(0.5, 1, 0),
        mass=20,
        velocity=(0, 0, -0.5 * speed),
        angular_velocity=(0, speed, 0),
    )
    hinge = world.join(ap.Hinge(None, body, anchor=(0, 1, 0), axis=(0, 1, 0), limits=(-1, 1)))
    return lambda: (hinge.angle, hinge.speed)


def drawer(world, speed):
    body = world.add(ap.Box(size=(1, 1, 1)), position=(0, 1, 0), mass=20, velocity=(speed, 0, 0))
    slider = world.join(ap.Slider(None, body, anchor=(0, 0.2, 0.1), axis=(1, 0, 0), limits=(-1, 1)))
    return lambda: (slider.translation, slider.speed)


def arm(world, speed):
    body = world.add(
        ap.Box(size=(0.2, 1, 0.3)),
        position=(0, -0.5, 0),
        mass=2,
        velocity=(0.5 * speed, 0, 0),
        angular_velocity=(0, 0, speed),
    )
    ball = world.join(ap.Ball(None, body, anchor=(0, 0, 0), axis=(0, -1, 0), cone=1))
    return lambda: (ball.swing, body.angular_velocity[2])


@pytest.mark.parametrize("solver", ["soft_step", "sequential_impulse", "xpbd"])
@pytest.mark.parametrize("speed", [3, 10])
@pytest.mark.parametrize("make", [door, drawer, arm])
def test_nothing_comes_back_from_a_limit(make, speed, solver):
    world = ap.World(gravity=(0, 0, 0), solver=solver, sleeping=False)
    read, found = make(world, speed), []
    for _ in range(60):
        world.step(1 / 60)
        found.append(read())
    place, rate = np.array(found).T
    assert rate.min() > -1e-3 * speed
    assert place[-1] == pytest.approx(1, abs=2e-3)
    assert place.max() < 1.005
