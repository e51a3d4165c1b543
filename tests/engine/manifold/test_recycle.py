"""Contact recycling: when it ends, what it may not delay, and that it is part of the state."""

import math
import pickle

import numpy as np
import pytest

import atlasphys as ap

DT = 1 / 60
CUBE = ap.Box(size=(1, 1, 1))
WIDE = {"recycle_slip": 1.0, "recycle_speed": 1e3, "recycle_turn": 0.5, "recycle_twist": 0.5}
"""Limits beyond all that moves in these tests."""


def empty(gravity=(0, -9.81, 0), **settings) -> ap.World:
    return ap.World(preset="default", solver=ap.SoftStep(**settings), gravity=gravity, sleeping=False)


def collided(world: ap.World) -> int:
    """How many of the manifolds were collided in the last step."""
    state = world._state
    rows = slice(0, state.manifold_count)
    return int(((state.manifolds.collided[rows] == state.steps) & (state.manifolds.count[rows] > 0)).sum())


def collisions(world: ap.World, steps: int) -> list[int]:
    found = []
    for _ in range(steps):
        world.step(DT)
        found.append(collided(world))
    return found


def tower(**settings) -> ap.World:
    world = empty(**settings)
    world.add(ap.Plane())
    for level in range(5):
        world.add(CUBE, position=(0, level + 0.5, 0))
    return world


def test_pairs_at_rest_are_collided_once():
    assert collisions(tower(), 30) == [5] + 29 * [0]


def test_without_it_every_pair_is_collided_in_every_step():
    assert collisions(tower(contact_recycling=False), 30) == 30 * [5]


def test_without_it_its_limits_count_for_nothing():
    worlds = [tower(contact_recycling=False, **limits) for limits in ({}, WIDE, dict.fromkeys(WIDE, 0.0))]
    for world in worlds:
        world.run(seconds=1)
    assert len({world.state_hash() for world in worlds}) == 1


# What ends it ------------------------------------------------------------------------------------------------------------


def gliding(velocity, spin=(0, 0, 0), **settings) -> ap.World:
    """A cube that moves over a smooth plane."""
    world = empty(**WIDE | settings)
    world.add(ap.Plane(), friction=0)
    world.add(CUBE, position=(0, 0.5, 0), velocity=velocity, angular_velocity=spin, friction=0)
    return world


def test_slip_ends_it():
    assert collisions(gliding((0.008 / DT, 0, 0), recycle_slip=0.02), 9) == 3 * [1, 0, 0]
    assert collisions(gliding((0.008 / DT, 0, 0)), 9) == [1] + 8 * [0]


def test_slip_scales_with_the_length_unit():
    world = ap.World(
        preset="default", solver=ap.SoftStep(**WIDE | {"recycle_slip": 0.02}), length_unit=4.0, sleeping=False
    )
    world.add(ap.Plane(), friction=0)
    world.add(ap.Box(size=(4, 4, 4)), position=(0, 2, 0), velocity=(4 * 0.008 / DT, 0, 0), friction=0)
    assert collisions(world, 9) == 3 * [1, 0, 0]


@pytest.mark.parametrize("limit", ["recycle_turn", "recycle_twist"])
def test_turning_ends_it(limit):
    spin = (0, math.radians(1) / DT, 0)
    assert collisions(gliding((0, 0, 0), spin, **{limit: math.radians(1.5)}), 8) == 4 * [1, 0]
    assert collisions(gliding((0, 0, 0), spin), 8) == [1] + 7 * [0]


@pytest.mark.parametrize(("limit", "expected"), [("recycle_turn", 4 * [1, 0]), ("recycle_twist", [1] + 7 * [0])])
def test_turning_together_counts_as_turn_not_as_twist(limit, expected):
    spin = (0, math.radians(1) / DT, 0)
    world = empty(gravity=(0, 0, 0), **WIDE | {limit: math.radians(1.5)})
    for height in (0, 1):
        world.add(CUBE, position=(0, height, 0), angular_velocity=spin)
    assert collisions(world, 8) == expected


def test_sinking_in_does_not_end_it_but_moves_the_depth():
    world = empty(**WIDE | {"recycle_slip": 0.001})
    world.add(ap.Plane())
    cube = world.add(CUBE, position=(0, 0.45, 0))
    assert collisions(world, 30) == [1] + 29 * [0]
    world.step(DT)
    low = cube.position[1] - 0.5
    world.step(DT)
    assert 0 < world.contacts.depth.max() < 0.01
    assert world.contacts.depth.max() == pytest.approx(-low, abs=2e-5)  # it was 0.05 when they were collided


@pytest.mark.parametrize(("speed", "expected"), [(0.2, [1]), (1.0, [0])])
def test_parting_fast_ends_it(speed, expected):
    world = empty(**WIDE | {"recycle_speed": speed})
    world.add(ap.Plane())
    cube = world.add(CUBE, position=(0, 0.5, 0))
    assert collisions(world, 3) == [1, 0, 0]
    cube.velocity = (0, 0.6, 0)
    world.step(DT)
    assert collisions(world, 1) == expected  # the gap is 7 mm, within the margin


def test_small_angles_are_told_apart_in_single_precision():
    """0.02° is 2e-8 away from 1 in the cosine of its half, less than single precision resolves."""
    spin = (0, math.radians(0.012) / DT, 0)
    assert collisions(gliding((0, 0, 0), spin, recycle_turn=math.radians(0.02)), 8) == 4 * [1, 0]


# What it may not delay ---------------------------------------------------------------------------------------------------


def test_a_change_of_friction_takes_effect_at_once():
    down = 9.81 * math.sin(math.radians(20))
    world = empty(gravity=(down, -9.81 * math.cos(math.radians(20)), 0))
    world.add(ap.Plane())
    cube = world.add(CUBE, position=(0, 0.5, 0))
    world.run(seconds=2)
    assert collided(world) == 0
    assert abs(cube.velocity[0]) < 1e-3
    cube.friction = 0
    world.step(DT)
    assert cube.velocity[0] == pytest.approx(down * DT, rel=1e-2)


def test_a_change_of_gravity_takes_effect_at_once():
    world = tower()
    world.run(seconds=1)
    world.gravity = (0, 9.81, 0)
    world.step(DT)
    speed = world.bodies.velocity[1:, 1] / (9.81 * DT)  # of some, more: their contacts were pressed together
    assert (speed > 0.8).all()
    assert (speed < 1.5).all()


def test_what_leaves_is_let_go():
    world = empty()
    world.add(ap.Plane())
    cube = world.add(CUBE, position=(0, 0.5, 0))
    world.run(seconds=1)
    height = cube.position[1]
    cube.velocity = (0, 2, 0)
    ended = []
    for step in range(6):
        world.step(DT)
        ended += [step for event in world.events if event.kind == "contact_end"]
    assert ended
    assert ended[0] <= 2  # 2 cm are gone after 0.6 steps
    h, n = DT / 4, 24
    assert cube.position[1] == pytest.approx(height + 2 * n * h - 0.5 * 9.81 * n * (n + 1) * h * h, abs=1e-3)


def test_a_support_that_is_drawn_away_supports_no_longer():
    world = empty()
    shelf = world.add(ap.Box(size=(2, 1, 2)), position=(0, -0.5, 0), kind="kinematic", friction=0)
    cube = world.add(CUBE, position=(0, 0.5, 0), friction=0)
    world.run(seconds=0.5)
    height = cube.position[1]
    shelf.velocity = (0, -20, 0)
    world.run(seconds=0.5)
    assert height - cube.position[1] == pytest.approx(0.5 * 9.81 * 0.25, rel=0.02)


def ledge(**settings) -> float:
    """How far beyond the ledge the centre of a cube is that glides over it slowly, when it has tipped by 1°."""
    world = empty(**settings)
    world.add(ap.Box(size=(4, 1, 4)), position=(-2, -0.5, 0), kind="static", friction=0)
    cube = world.add(CUBE, position=(-0.1, 0.5, 0), velocity=(0.2, 0, 0), friction=0)
    while abs(2 * cube.orientation[3]) < math.radians(1):
        assert cube.position[0] < 1
        world.step(DT)
    return float(cube.position[0])


def test_a_cube_tips_over_a_ledge_at_most_a_slip_later():
    slip = ap.SoftStep().recycle_slip
    assert abs(ledge() - ledge(contact_recycling=False)) < slip + 0.2 * DT


@pytest.mark.parametrize("acceleration", [3.0, 8.0])
def test_a_platform_drags_a_cube_by_friction(acceleration):
    world = empty()
    platform = world.add(ap.Box(size=(60, 1, 4)), position=(0, -0.5, 0), kind="kinematic")
    cube = world.add(CUBE, position=(0, 0.5, 0))
    world.run(seconds=0.5)
    for step in range(1, 61):
        platform.velocity = (acceleration * step * DT, 0, 0)
        world.step(DT)
    assert cube.velocity[0] == pytest.approx(min(acceleration, 0.5 * 9.81), rel=0.02)
    assert abs(cube.angular_velocity).max() < 0.05


@pytest.mark.parametrize(("degrees", "slips"), [(26.3, False), (26.9, True)])
def test_a_block_slips_at_the_angle_of_friction(degrees, slips):
    angle = math.radians(degrees)
    world = empty(gravity=(9.81 * math.sin(angle), -9.81 * math.cos(angle), 0))
    world.add(ap.Plane())
    block = world.add(CUBE, position=(0, 0.5, 0))
    world.run(seconds=3)
    assert (abs(block.position[0]) > 0.1) == slips


def test_a_tower_topples_within_a_tenth_of_the_rigid_spin():
    """Eight cubes are turned about their lower edge; rigid ones topple from 0.168 rad/s on."""

    def topples(rate: float) -> bool:
        world = empty()
        world.add(ap.Plane())
        for level in range(8):
            world.add(CUBE, position=(0, level + 0.5, 0))
        arms = world.bodies.position[1:] - np.array([0.5, 0, 0])
        world.bodies.velocity[1:] = np.cross((0, 0, -rate), arms)
        world.bodies.angular_velocity[1:] = (0, 0, -rate)
        world.run(seconds=8)
        return bool(world.bodies.position[8, 1] < 6)

    r = math.hypot(0.5, 4)
    rigid = math.sqrt(2 * 9.81 * (r - 4) / (65 / 12 + r * r))
    assert rigid == pytest.approx(0.168, abs=5e-4)
    assert not topples(0.95 * rigid)
    assert topples(1.15 * rigid)


# Part of the state -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("copy", [lambda w: w.snapshot(), lambda w: pickle.loads(pickle.dumps(w)).snapshot()])
def test_a_copy_goes_on_with_the_same_bits(copy):
    world = tower()
    world.add(ap.Sphere(radius=0.3), position=(-3, 3.2, 0.1), velocity=(6, 0, 0))
    world.run(seconds=1)
    snapshot = copy(world)
    other = tower()
    other.restore(snapshot)
    assert other.state_hash() == world.state_hash()
    for _ in range(4):
        for one in (world, other):
            one.run(seconds=0.25)
        assert other.state_hash() == world.state_hash()
        assert collided(other) == collided(world)


def test_the_hash_tells_recycled_contacts_from_those_that_will_be_collided():
    world = tower()
    world.run(seconds=0.5)
    before = world.state_hash()
    world.bodies[1].friction = 0.5  # as it was, but the contacts of this body are now collided afresh
    assert world.state_hash() != before
    world.step(DT)
    assert collided(world) == 2
