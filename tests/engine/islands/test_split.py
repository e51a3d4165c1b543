"""How contacts are dealt out to the parts of bodies that have many, and what comes of it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import atlasphys as ap
from atlasphys.engine.islands.split import (
    FIRST,
    HUB_COLUMNS,
    INVERSE_MASS,
    MOST_CONTACTS,
    MOST_WHOLE,
    NUMBER,
    ROW,
    deal_contacts,
    find_hubs,
)
from atlasphys.engine.jit import kernel
from atlasphys.engine.solvers.parts import join_parts
from atlasphys.engine.state.work import HUBS, PARTS
from tests.engine.islands.blocks import in_blocks

BALL = ap.Sphere(radius=0.25)
CUBE = ap.Box(size=(1, 1, 1))


@kernel
def split(pair_bodies, live, number, moves, count, inverse_mass, hub_of, hubs, heaviest, ends):
    found, parts = find_hubs(pair_bodies, live, number, moves, count, hub_of, hubs)
    if found <= len(hubs):
        deal_contacts(pair_bodies, live, number, inverse_mass, hub_of, hubs, found, heaviest, ends)
    return found, parts


@kernel
def join(hubs, found, motion):
    join_parts(hubs, found, motion)


def dealt(pairs, moves, inverse, live=None, room=8):
    """Hubs, number of parts, and the rows between which each of the live contacts is solved."""
    live = np.arange(len(pairs), dtype=np.int32) if live is None else np.array(live, np.int32)
    inverse_mass = np.zeros((len(moves), 16))
    inverse_mass[:, INVERSE_MASS] = inverse
    hubs, heaviest = np.zeros((room, HUB_COLUMNS), np.int32), np.zeros((room, MOST_WHOLE + 1))
    pair_bodies, moves = in_blocks(pairs), np.array(moves, np.uint8)
    ends = np.full_like(pair_bodies, -1)
    hub_of = np.zeros(len(moves), np.int32)
    found, parts = split(
        pair_bodies, live, len(live), moves, len(moves), inverse_mass, hub_of, hubs, heaviest, ends
    )  # fmt: skip
    rows = ends.transpose(0, 2, 1).reshape(-1, 2)
    assert (np.delete(rows, live, axis=0) == -1).all()
    return hubs[:found], parts, rows[: len(pairs)]


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1), st.integers(0, 4), st.integers(1, 300), st.booleans())
def test_every_contact_goes_to_one_part_or_to_the_whole_body(seed, immovable, neighbours, equal):
    rng = np.random.default_rng(seed)
    n = neighbours + 4
    moves = np.ones(n, np.uint8)
    moves[rng.permutation(n)[:immovable]] = 0
    inverse = np.where(moves, 1.0 if equal else rng.choice([0.25, 0.5, 1, 2, 4], n), 0)
    everything = np.array([(a, b) for a in range(4) for b in range(a + 1, n)])
    pairs = everything[rng.random(len(everything)) < rng.choice([0.1, 0.5, 1])]
    live = np.flatnonzero(rng.random(len(pairs)) < 0.9)
    hubs, parts, rows = dealt(pairs, moves, inverse, live)
    degree = np.bincount(pairs[live].ravel(), minlength=n)
    assert list(hubs[:, ROW]) == list(np.flatnonzero((degree > MOST_CONTACTS) & (moves > 0)))
    # The parts' rows follow the bodies', without a gap.
    assert parts == hubs[:, NUMBER].sum()
    assert list(hubs[:, FIRST]) == [n + hubs[:k, NUMBER].sum() for k in range(len(hubs))]
    body_of = np.concatenate([np.arange(n), np.repeat(hubs[:, ROW], hubs[:, NUMBER])])
    assert (body_of[rows[live]] == pairs[live]).all()
    assert (np.bincount(rows[live].ravel(), minlength=n + parts)[n:] <= MOST_CONTACTS).all()
    split_bodies = np.isin(pairs, hubs[:, ROW])
    whole = split_bodies.any(axis=1) & (rows == pairs).all(axis=1)
    wanted = set()
    for row in hubs[:, ROW]:
        mine = [i for i in live if row in pairs[i]]
        others = inverse[[pairs[i].sum() - row for i in mine]]
        least = np.sort(others)[MOST_WHOLE]
        own = {i for i, other in zip(mine, others, strict=True) if other < least}
        assert len(own) <= MOST_WHOLE
        wanted |= own
        counts = np.bincount(rows[mine].ravel(), minlength=n + parts)[np.arange(n + parts) >= n]
        of_parts = counts[body_of[n:] == row]
        assert of_parts.max() - of_parts.min() <= 1  # in turn
    assert wanted == set(live) & set(np.flatnonzero(whole))


def test_the_ground_under_a_plate_is_whole_and_equals_are_not():
    n = 200
    pairs = np.array([(0, 1)] + [(1, k) for k in range(2, n)])
    moves = np.ones(n)
    moves[0] = 0
    hubs, parts, rows = dealt(pairs, moves, moves)
    assert (len(hubs), parts) == (1, -(-(n - 1) // MOST_CONTACTS))
    assert tuple(rows[0]) == (0, 1)
    assert (rows[1:, 0] >= n).all()


def test_many_static_neighbours_are_in_parts():
    n = 100
    pairs = np.array([(0, k) for k in range(1, n)])
    moves = np.zeros(n)
    moves[0] = 1
    hubs, _, rows = dealt(pairs, moves, moves)
    assert list(hubs[:, ROW]) == [0]
    assert (rows[:, 0] >= n).all()


def test_hubs_without_room_are_counted():
    n = 3 + 3 * 40
    pairs = np.array([(k % 3, k) for k in range(3, n)])
    hubs, parts, rows = dealt(pairs, np.ones(n), np.ones(n), room=2)
    assert len(hubs) == 2
    assert parts == 6
    assert (rows == -1).all()


@given(st.integers(1, 200), st.integers(0, 2**32 - 1))
def test_joining_keeps_momentum(number, seed):
    rng = np.random.default_rng(seed)
    hubs = np.array([[1, 2, number, 0]], np.int32)
    motion = rng.normal(size=(2 + number, 16))
    before = motion.copy()
    before[1, :6] = motion[1, :6] = 1e3
    join(hubs, 1, motion)
    # Parts have equal masses and inertias.
    np.testing.assert_allclose(motion[1, :6], motion[2:, :6].mean(axis=0), atol=1e-12)
    motion[1, :6] = before[1, :6]
    np.testing.assert_array_equal(motion, before)


def test_joining_equal_parts_changes_no_bit():
    motion = np.full((100, 16), np.float32(0.1))
    join(np.array([[0, 1, 99, 0]], np.int32), 1, motion)
    assert (motion == np.float32(0.1)).all()


def plate_under(count, *, mass=None, kind="dynamic", size=1.0, **arguments):
    """A plate on the ground under a square of cubes, and the rows of these."""
    world = ap.World(**arguments)
    world.add(ap.Plane())
    side, pitch = int(np.sqrt(count)), 1.25
    weight = {} if mass is None else {"mass": mass}
    world.add(ap.Box(size=(pitch * side, 1, pitch * side)), position=(0, 0.5, 0), kind=kind, **weight)
    for i in range(side * side):
        x, z = pitch * (i % side - 0.5 * (side - 1)), pitch * (i // side - 0.5 * (side - 1))
        world.add(ap.Box(size=(size, size, size)), position=(x, 1 + 0.5 * size, z), mass=1)
    return world


def hubs_of(world):
    """Numbers of hubs and parts in the last step."""
    status = world._state.workspace.work.status
    return int(status[HUBS]), int(status[PARTS])


@pytest.mark.parametrize("precision", ["single", "double"])
@pytest.mark.parametrize("mass", [5000, 500])
def test_a_plate_stands_under_five_hundred_cubes(mass, precision):
    world = plate_under(529, mass=mass, sleeping=False, precision=precision)
    start = world.bodies.position.copy()
    world.run(seconds=3)
    assert hubs_of(world) == (1, 17)
    moved = world.bodies.position - start
    assert np.abs(moved[:, [0, 2]]).max() < 1e-3
    assert moved[:, 1].min() > -0.01
    assert np.abs(world.bodies.velocity).max() < 1e-3
    # The impulses that are reported are those that act: the plate bears the cubes, the ground everything.
    contacts, dt = world.contacts, 1 / 60
    ground = contacts[contacts.body_a == 0].normal_impulse.sum() / dt
    each = np.bincount(contacts.body_b, contacts.normal_impulse, minlength=531)[2:] / dt
    assert ground == pytest.approx(9.81 * (mass + 529), rel=1e-3)
    assert each == pytest.approx(np.full(529, 9.81), rel=0.02)
    assert each.sum() == pytest.approx(9.81 * 529, rel=1e-3)


def test_a_plate_and_what_is_on_it_fall_asleep():
    world = plate_under(100)
    world.run(seconds=3)
    assert all(body.asleep for body in world.bodies[1:])


def test_one_and_two_threads_give_the_same_bits():
    hashes = set()
    for threads in (1, 2):
        world = plate_under(1024, size=0.9, threads=threads)
        world.add(ap.Sphere(radius=1), position=(3, 4, 2), velocity=(0, -5, 0), restitution=0.5, rolling_friction=0.01)
        world.run(seconds=0.5)
        assert hubs_of(world)[0] == 1
        hashes.add(world.state_hash())
    assert len(hashes) == 1


def free_plate(balls, precision="double", **arguments):
    """A plate in empty space, and ``balls`` that come to it from above, all at the same time."""
    world = ap.World(gravity=(0, 0, 0), sleeping=False, precision=precision, **arguments)
    side = int(np.sqrt(balls))
    plate = world.add(ap.Box(size=(side, 1, side)), mass=20, restitution=1, friction=0)
    for i in range(side * side):
        x, z = i % side - 0.5 * (side - 1), i // side - 0.5 * (side - 1)
        world.add(BALL, position=(x, 0.8, z), velocity=(0, -2, 0), mass=1, restitution=1, friction=0)
    return world, plate


def test_elastic_balls_on_a_split_plate_bounce_as_one():
    world, plate = free_plate(100)
    world.run(seconds=0.1)
    m, n = 20.0, 100.0
    np.testing.assert_allclose(plate.velocity, (0, -2 * 2 * n / (m + n), 0), atol=1e-6)
    np.testing.assert_allclose(world.bodies.velocity[1:, 1], -2 * (n - m) / (m + n), rtol=1e-6)
    assert world.energy().kinetic == pytest.approx(0.5 * n * 4, rel=1e-9)


@pytest.mark.parametrize("restitution", [0, 0.7])
def test_momentum_and_angular_momentum_of_a_hub_are_kept(restitution):
    """A sphere in empty space, onto which 300 small ones fall from all sides, rough and rolling: no bit of momentum is lost but by round-off."""
    world = ap.World(gravity=(0, 0, 0), sleeping=False, precision="double", solver=ap.SoftStep(contact_recycling=False))
    material = {"restitution": restitution, "friction": 0.6, "rolling_friction": 0.01, "torsional_friction": 0.02}
    world.add(ap.Sphere(radius=2), density=10, angular_velocity=(1, 2, 3), **material)
    rng = np.random.default_rng(5)
    k = np.arange(300) + 0.5
    polar, turn = np.arccos(1 - 2 * k / 300), np.pi * (1 + np.sqrt(5)) * k
    outwards = np.stack([np.cos(turn) * np.sin(polar), np.sin(turn) * np.sin(polar), np.cos(polar)], axis=1)
    for direction in outwards:
        world.add(
            ap.Sphere(radius=0.15), position=2.2 * direction, density=10,
            velocity=-3 * direction + rng.normal(size=3), **material,
        )  # fmt: skip

    def momenta():
        bodies = world.bodies
        mass = bodies.mass[:, None]
        inertia = 0.4 * mass * np.where(np.arange(301) == 0, 2, 0.15)[:, None] ** 2
        linear = (mass * bodies.velocity).sum(axis=0)
        angular = (np.cross(bodies.position, mass * bodies.velocity) + inertia * bodies.angular_velocity).sum(axis=0)
        return np.concatenate([linear, angular])

    start, energy, split_steps = momenta(), world.energy().kinetic, 0
    for _ in range(40):
        world.step(1 / 60)
        split_steps += hubs_of(world)[0]
        assert world.energy().kinetic < energy * (1 + 1e-9)
        energy = world.energy().kinetic
    assert split_steps > 1
    np.testing.assert_allclose(momenta(), start, atol=1e-12 * np.abs(start).max() + 1e-10)
