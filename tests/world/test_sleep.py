"""Sleep: what falls asleep, what does not, what wakes it, and that none of it is lost or depends on how the world got there."""

import copy
import pickle

import numpy as np
import pytest

import atlasphys as ap
from tests.world.scenes import steps

H = 1 / 60
CUBE = ap.Box(size=(1, 1, 1))


def at_rest(count=3, gap=0.0, x=0.0, world=None, **settings):
    """A column of cubes on a plane."""
    if world is None:
        world = ap.World(**settings)
        world.add(ap.Plane(normal=(0, 1, 0)))
    for i in range(count):
        world.add(CUBE, position=(x, 0.5 + (1 + gap) * i, 0))
    return world


def asleep(world):
    return [body.asleep for body in world.bodies if body.kind == "dynamic"]


def sleeping(world, seconds=2.0):
    """The world once all sleep."""
    world.run(seconds, H)
    assert all(asleep(world))
    return world


def events(world, kind):
    return sorted(event.a.row for event in world.events if event.kind == kind)


def test_a_pile_falls_asleep_and_then_does_not_move():
    world = at_rest(4, gap=0.2)
    seen = []
    for _ in range(180):
        world.step(H)
        seen += events(world, "sleep")
        assert not events(world, "wake")
    assert seen == [1, 2, 3, 4]
    assert all(asleep(world))
    assert not world.bodies.velocity.any()
    before = [array.copy() for array in (world.bodies.position, world.bodies.orientation, world.contacts)]
    world.run(1, H)
    for old, new in zip(before, (world.bodies.position, world.bodies.orientation, world.contacts), strict=True):
        np.testing.assert_array_equal(old, new)
    assert world.contacts.normal_impulse.sum() > 0  # what held it up is still told


def test_a_sleeping_pile_costs_next_to_nothing():
    """Fifty columns: no body is moved and no contact solved for."""
    world = ap.World()
    world.add(ap.Plane(normal=(0, 1, 0)))
    for k in range(50):
        at_rest(4, x=2.0 * k, world=world)
    world.step(H)
    status = world._state.workspace.work.status
    from atlasphys.engine.state.work import LIVE, PLAIN, TUMBLING

    assert status[LIVE] == 200
    sleeping(world)
    world.step(H)
    status = world._state.workspace.work.status
    assert status[LIVE] == 0
    assert status[PLAIN] == status[TUMBLING] == 0


def test_an_island_sleeps_as_a_whole():
    """A cube at rest that bears a rolling ball stays awake with it; one that stands apart does not."""
    world = ap.World()
    world.add(ap.Plane(normal=(0, 1, 0)))
    table = world.add(ap.Box(size=(20, 1, 2)), position=(0, 0.5, 0))
    ball = world.add(ap.Sphere(radius=0.5), position=(-9, 1.5, 0), velocity=(2, 0, 0), angular_velocity=(0, 0, -4))
    apart = world.add(CUBE, position=(0, 0.5, 5))
    for _ in range(240):
        world.step(H)
        assert not table.asleep
        assert not ball.asleep
    assert apart.asleep


WAKERS = {
    "wake": lambda world, body: body.wake(),
    "force": lambda world, body: body.apply_force((0, 1, 0)),
    "torque": lambda world, body: body.apply_torque((0, 1, 0)),
    "impulse": lambda world, body: body.apply_impulse((0, 0.1, 0)),
    "angular impulse": lambda world, body: body.apply_angular_impulse((0, 0.1, 0)),
    "position": lambda world, body: setattr(body, "position", body.position),
    "orientation": lambda world, body: setattr(body, "orientation", body.orientation),
    "velocity": lambda world, body: setattr(body, "velocity", (0.1, 0, 0)),
    "angular velocity": lambda world, body: setattr(body, "angular_velocity", (0, 0.1, 0)),
    "friction": lambda world, body: setattr(body, "friction", 0.1),
    "restitution": lambda world, body: setattr(body, "restitution", 0.1),
    "gravity scale": lambda world, body: setattr(body, "gravity_scale", 0.5),
    "damping": lambda world, body: setattr(body, "linear_damping", 0.5),
    "locks": lambda world, body: setattr(body, "locks", ("x",)),
    "mask": lambda world, body: setattr(body, "mask", 3),
    "may sleep": lambda world, body: setattr(body, "may_sleep", False),
    "bulk": lambda world, body: world.bodies.velocity.__setitem__((body.row, 0), 0.1),
}


@pytest.fixture(scope="module")
def two_columns():
    """Two columns of three cubes each, asleep: rows 1–3 and 4–6."""
    return sleeping(at_rest(3, x=5.0, world=at_rest(3)))


@pytest.mark.parametrize("name", WAKERS)
def test_what_is_done_to_a_body_wakes_its_island(two_columns, name):
    world = copy.deepcopy(two_columns)
    WAKERS[name](world, world.bodies[2])
    world.step(H)
    assert asleep(world) == [False] * 3 + [True] * 3


WORLD_WAKERS = {
    "gravity": lambda world: setattr(world, "gravity", (0, -5, 0)),
    "friction rule": lambda world: setattr(world, "friction_combine", "min"),
    "sleeping": lambda world: setattr(world, "sleeping", False),
    "solver": lambda world: setattr(world, "solver", "sequential_impulse"),
}


@pytest.mark.parametrize("name", WORLD_WAKERS)
def test_what_changes_for_all_wakes_all(two_columns, name):
    world = copy.deepcopy(two_columns)
    WORLD_WAKERS[name](world)
    assert not any(asleep(world))
    world.step(H)
    assert not any(asleep(world))


def test_a_body_that_hits_it_wakes_an_island(two_columns):
    world = copy.deepcopy(two_columns)
    world.add(ap.Sphere(radius=0.3), position=(0.2, 4.5, 0.1), name="ball")
    woken = []
    for _ in range(60):
        world.step(H)
        woken += events(world, "wake")
    assert woken == [1, 2, 3]
    assert asleep(world)[3:6] == [True] * 3


def test_islands_that_fall_asleep_together_wake_one_by_one(two_columns):
    """Waking one island just after another fell asleep does not wake that one too."""
    world = copy.deepcopy(two_columns)
    world.bodies[4].wake()
    while not events(world, "sleep"):
        world.step(H)
    world.add(ap.Sphere(radius=0.3), position=(0, 3.25, 0))
    world.step(H)
    assert events(world, "wake") == [1, 2, 3]
    assert asleep(world)[3:6] == [True] * 3


@pytest.mark.parametrize("lowest", [False, True])
def test_without_its_support_a_stack_falls(two_columns, lowest):
    world = copy.deepcopy(two_columns)
    world.remove(world.bodies[1] if lowest else world.bodies[0])
    world.run(0.2, H)
    assert asleep(world)[:2] == [False] * 2
    assert (world.bodies.velocity[1 if lowest else 0, 1] < -1).all()
    assert all(asleep(world)[2:]) == lowest  # the plane bore the other column too


def test_a_support_that_is_moved_wakes_what_stood_on_it():
    world = ap.World()
    shelf = world.add(ap.Box(size=(3, 0.2, 3)), kind="static", position=(0, -0.1, 0))
    at_rest(2, world=world)
    sleeping(world)
    shelf.position = (0, -5, 0)
    world.run(0.2, H)
    assert not any(asleep(world))
    assert (world.bodies.velocity[1:, 1] < -1).all()


PUT_THERE = {
    "moved": lambda world, wall: setattr(wall, "position", (0.8, 0.5, 0)),
    "in bulk": lambda world, wall: world.bodies.position.__setitem__(wall.row, (0.8, 0.5, 0)),
    "added": lambda world, wall: world.add(CUBE, kind="static", position=(0.8, 0.5, 0)),
}


@pytest.mark.parametrize("how", PUT_THERE)
@pytest.mark.parametrize("kind", ["static", "kinematic"])
@pytest.mark.parametrize("broadphase", ["tree", "brute"])
def test_a_body_that_is_put_into_a_sleeping_one_wakes_it(how, kind, broadphase):
    world = at_rest(2, broadphase=broadphase)
    wall = world.add(CUBE, kind=kind, position=(9, 0.5, 0))
    at_rest(1, x=5.0, world=world)
    sleeping(world)
    PUT_THERE[how](world, wall)
    twin = pickle.loads(pickle.dumps(world))
    world.step(H)
    assert events(world, "wake") == [1, 2]
    assert asleep(world) == [False, False, True]
    world.run(0.5, H)
    assert world.bodies.position[1, 0] < -0.1
    steps(twin, 31, H)
    assert twin.state_hash() == world.state_hash()


def test_a_platform_in_motion_keeps_what_it_carries_awake():
    world = ap.World()
    platform = world.add(ap.Box(size=(6, 0.5, 6)), kind="kinematic", velocity=(0.01, 0, 0))
    box = world.add(CUBE, position=(0, 0.75, 0))
    for _ in range(180):
        world.step(H)
        assert not box.asleep
    platform.velocity = (0, 0, 0)
    world.run(2, H)
    assert box.asleep
    platform.velocity = (0, 0.5, 0)
    world.run(0.5, H)
    assert not box.asleep
    assert box.velocity[1] == pytest.approx(0.5, abs=0.01)


def test_a_spinning_body_does_not_sleep():
    world = ap.World()
    world.add(ap.Plane(normal=(0, 1, 0)), friction=0.0)
    top = world.add(ap.Cylinder(radius=0.5, length=0.2), position=(0, 0.1, 0), angular_velocity=(0, 5, 0), friction=0.0)
    floating = world.add(CUBE, position=(9, 9, 9), gravity_scale=0, angular_velocity=(0, 1, 0))
    world.run(3, H)
    assert not top.asleep
    assert not floating.asleep
    assert top.angular_velocity[1] > 4


def test_a_ball_at_its_apex_does_not_sleep():
    world = ap.World(gravity=(0, -0.5, 0))
    ball = world.add(ap.Sphere(radius=0.5), position=(0, 5, 0), velocity=(0, 0.5, 0))
    for _ in range(180):
        world.step(H)
        assert not ball.asleep
    assert ball.velocity[1] == pytest.approx(0.5 - 0.5 * 3, abs=1e-3)


def test_a_body_that_may_not_sleep_keeps_its_island_awake():
    world = at_rest(2, x=5.0, world=at_rest(2))
    body = world.bodies[2]
    assert body.may_sleep
    body.may_sleep = False
    world.run(3, H)
    assert not body.may_sleep
    assert asleep(world) == [False, False, True, True]
    body.may_sleep = True
    sleeping(world)
    with pytest.raises(ap.InvalidArgumentError, match="may_sleep"):
        body.may_sleep = 1


def test_sleep_can_be_turned_off_and_on():
    world = at_rest(2, sleeping=False)
    world.run(3, H)
    assert not any(asleep(world))
    assert not world.sleeping
    world.sleeping = True
    world.step(H)
    assert not any(asleep(world))  # the time at rest counts from now
    sleeping(world)
    world.sleeping = False
    world.run(3, H)
    assert not any(asleep(world))
    with pytest.raises(ap.InvalidArgumentError, match="sleeping"):
        world.sleeping = "no"
    with pytest.raises(ap.InvalidArgumentError, match="only soft_step"):
        ap.World(preset="classic", sleeping=True)
    assert not ap.World(preset="classic").sleeping


COPIES = {
    "snapshot": lambda world: restored(world.snapshot()),
    "deepcopy": copy.deepcopy,
    "pickle": lambda world: pickle.loads(pickle.dumps(world)),
}


def restored(snapshot):
    world = ap.World()
    world.restore(snapshot)
    return world


@pytest.mark.parametrize("how", COPIES)
@pytest.mark.parametrize("moment", [0.3, 0.55, 2.0])
def test_copies_sleep_and_wake_alike(how, moment):
    world = at_rest(3, x=5.0, world=at_rest(2, gap=0.02))
    world.run(moment, H)
    twin = COPIES[how](world)
    assert twin.state_hash() == world.state_hash()
    assert asleep(twin) == asleep(world)
    assert [event.kind for event in twin.events] == [event.kind for event in world.events]
    for each in (world, twin):
        each.add(ap.Sphere(radius=0.4), position=(0.3, 5, 0), density=5000)
    for _ in range(90):
        world.step(H)
        twin.step(H)
        assert twin.state_hash() == world.state_hash()
        assert [(e.kind, e.a.row) for e in twin.events] == [(e.kind, e.a.row) for e in world.events]
    assert not any(asleep(world)[:2])


def test_sleep_does_not_depend_on_the_broad_phase_or_on_the_length_of_runs():
    worlds = [at_rest(3, gap=0.1, broadphase=name) for name in ("tree", "brute", "sweep", "tree")]
    for world in worlds:
        world.add(ap.Sphere(radius=0.3), position=(0.2, 40, 0))  # comes back after they sleep
        world.add(CUBE, position=(1.05, 0.5, 0))  # near, but not touching
    for _ in range(20):
        for world in worlds[:3]:
            steps(world, 12, H)
        worlds[3].run(0.2, H)
        assert len({world.state_hash() for world in worlds}) == 1
    assert worlds[0].time > 3


def test_bodies_removed_take_their_events_with_them():
    world = at_rest(3)
    while not events(world, "sleep"):
        world.step(H)
    world.remove(world.bodies[1])
    assert events(world, "sleep") == [1, 2]
    assert [event.a.position[1] > 1 for event in world.events if event.kind == "sleep"] == [True, True]


def test_a_static_body_has_no_sleep():
    world = at_rest(1)
    ground = world.bodies[0]
    assert not ground.asleep
    sleeping(world)
    ground.wake()  # whatever rests on it
    assert asleep(world) == [False]
