"""A turntable with hundreds of bodies: what impulses do not move never conflicts, but its velocity counts."""

import numpy as np
import pytest

import atlasphys as ap
from atlasphys.engine.state.work import COLOURED, HUBS

G, MU, COUNT, SUBSTEPS = 9.81, 0.5, 500, 4
CUBE, BALL = ap.Box(size=(0.2, 0.2, 0.2)), ap.Sphere(radius=0.1)


def turntable(shape, spin, *, moves=True, **arguments):
    """A turning square with bodies of a shape all over its middle, as they are carried round, or else not moving; and where they begin."""
    world = ap.World(sleeping=False, **arguments)
    world.add(
        ap.Box(size=(14, 1, 14)), position=(0, -0.5, 0), kind="kinematic", angular_velocity=(0, spin, 0), friction=MU
    )
    lattice = 0.33 * np.arange(-20, 21)
    places = np.stack(np.meshgrid(lattice, [0.1], lattice), axis=-1).reshape(-1, 3)
    nearest = np.argsort(np.hypot(places[:, 0], places[:, 2]), kind="stable")[:COUNT]
    for place in places[nearest]:
        carried = np.cross((0, spin, 0), place)
        # A ball that does not move, but spins, so that the table does not slip under it.
        rolls = np.array((-carried[2], 0, carried[0])) / 0.1
        world.add(
            shape, position=place, velocity=carried if moves else (0, 0, 0),
            angular_velocity=(0, spin, 0) if moves else rolls, friction=MU,
        )  # fmt: skip
    return world, places[nearest]


def turned(places, angle):
    """Places turned about the vertical axis."""
    c, s = np.cos(angle), np.sin(angle)
    return places @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])


def test_boxes_ride_on_a_turntable_within_the_limit_of_friction():
    spin, seconds = 1.0, 4
    world, start = turntable(CUBE, spin)
    radius = np.hypot(start[:, 0], start[:, 2])
    assert 0.8 < radius.max() * spin**2 / (MU * G) < 0.9
    world.run(seconds=seconds)
    status = world._state.workspace.work.status
    assert (status[COLOURED], status[HUBS]) == (1, 0)
    seen = turned(world.bodies.position[1:], -spin * seconds)
    assert np.abs(seen - start).max() < 0.01 * radius.max()
    # Nothing slips: what they creep outwards is the error of substeps of constant velocity, each a chord's length too far out.
    chords = np.sqrt(1 + (spin / (60 * SUBSTEPS)) ** 2) ** (60 * SUBSTEPS * seconds)
    places = start * (chords, 1, chords)
    assert np.abs(seen - places).max() < 1e-3
    assert world.bodies.angular_velocity[1:, 1] == pytest.approx(np.full(COUNT, spin), abs=0.01)


def test_boxes_beyond_the_limit_of_friction_slide_off():
    spin, seconds = 1.5, 4
    world, start = turntable(CUBE, spin)
    limit = MU * G / spin**2
    radius = np.hypot(start[:, 0], start[:, 2])
    world.run(seconds=seconds)
    moved = np.linalg.norm(turned(world.bodies.position[1:], -spin * seconds) - start, axis=1)
    assert (radius > 1.05 * limit).sum() > 300
    assert moved[radius > 1.05 * limit].min() > 1
    assert moved[radius < 0.95 * limit].max() < 0.02 * limit


def test_balls_roll_on_a_turntable_as_the_law_has_it():
    """A solid ball's velocity turns by 2/7 of the table's (S. Earnshaw, 1844), so one that does not move stays; whatever its place."""
    world, start = turntable(BALL, 1.0, moves=False)
    world.run(seconds=3)
    assert np.abs(world.bodies.position[1:] - start).max() < 0.02
