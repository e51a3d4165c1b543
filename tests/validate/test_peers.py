"""Other engines, as far as they are installed: units, axes and signs of what they are told and tell."""

import math

import numpy as np
import pytest

import atlasphys as ap
from atlasphys.validate import CASES, NotOfferedError

PACKAGES = {"rapier": "rapier3d", "box3d": "robox3d", "pybullet": "pybullet", "mujoco": "mujoco"}
H, G = 1 / 240, 9.81


@pytest.fixture(params=list(PACKAGES))
def make_world(request):
    pytest.importorskip(PACKAGES[request.param])
    from atlasphys.validate.peers import world_of

    return world_of(request.param)


def test_free_flight(make_world):
    """Position, orientation, velocities and totals of a spinning ball, against our own world."""
    worlds = [make(gravity=(0.5, -G, 0)) for make in (make_world, ap.World)]
    for world in worlds:
        world.add(
            ap.Sphere(radius=0.4),
            position=(1, 2, 3),
            orientation=(2, 0, 0, 2),
            velocity=(1, 0.5, -2),
            angular_velocity=(0.3, -1, 2),
            mass=3,
        )
        world.run(seconds=0.5, dt=H)
    for column in ("position", "orientation", "velocity", "angular_velocity", "mass"):
        found, expected = (getattr(world.bodies, column)[0] for world in worlds)
        assert found == pytest.approx(expected, abs=0.01 if column == "position" else 1e-3), column
    for total in ("momentum", "angular_momentum"):
        found, expected = (getattr(world, total)() for world in worlds)
        assert found == pytest.approx(expected, rel=1e-2), total
    assert worlds[0].energy().kinetic == pytest.approx(worlds[1].energy().kinetic, rel=1e-3)
    assert worlds[0].energy().potential == pytest.approx(worlds[1].energy().potential, rel=2e-2)
    assert worlds[0].time == pytest.approx(0.5)


def test_inertia_is_as_given(make_world):
    world = make_world(gravity=(0, 0, 0))
    world.add(ap.Box(size=(1, 0.5, 0.2)), mass=2, angular_velocity=(0, 0, 3))
    expected = 0.5 * (2 / 12 * (1 + 0.25)) * 9
    world.step(H)
    assert world.energy().kinetic == pytest.approx(expected, rel=1e-3)
    assert world.angular_momentum() == pytest.approx((0, 0, expected * 2 / 3), abs=1e-4)


def test_contacts_carry_the_weight(make_world):
    world = make_world(gravity=(0, -G, 0))
    world.add(ap.Plane(normal=(0, 1, 0)))
    for level in range(2):
        world.add(ap.Box(size=(1, 1, 1)), position=(0, 0.5 + level, 0), mass=4)
    world.run(seconds=2, dt=H)
    contacts = world.contacts
    assert (contacts.body_a < contacts.body_b).all()
    for row, weight in ((1, 8 * G), (2, 4 * G)):
        assert contacts.normal_impulse[contacts.body_b == row].sum() / H == pytest.approx(weight, rel=0.01)
    assert np.abs(contacts.depth).max() < 0.02


def test_planes_may_slope(make_world):
    world = make_world(gravity=(0, -G, 0))
    sine, cosine = 0.6, 0.8
    world.add(ap.Plane(normal=(sine, cosine, 0)), friction=0)
    ball = world.add(ap.Sphere(radius=0.5), position=(0.5 * sine, 0.5 * cosine, 0), friction=0)
    world.run(seconds=0.5, dt=H)
    assert ball.velocity[0] == pytest.approx(G * sine * 0.5 * cosine, rel=0.03)
    assert math.hypot(*ball.velocity) == pytest.approx(G * sine * 0.5, rel=0.03)


def test_a_ball_joint_holds(make_world):
    """A ball hangs from one that hangs from the world, and swings out by the force of a tilted gravity."""
    world = make_world(gravity=(1, -G, 0))
    bodies = [world.add(ap.Sphere(radius=0.2), position=(0, -k - 1, 0), mass=2) for k in range(2)]
    for above, body, height in ((None, bodies[0], -0.5), (bodies[0], bodies[1], -1.5)):
        world.join(ap.Ball(above, body, anchor=(0, height, 0)))
    farthest = 0.0
    for _ in range(480):
        world.step(H)
        farthest = max(farthest, world.bodies.position[1, 0])
    assert farthest > 0.05
    x, y, _ = world.bodies.position[0]
    assert math.hypot(x, y + 0.5) == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize(("package", "name"), [("rapier3d", "rapier"), ("robox3d", "box3d")])
@pytest.mark.parametrize("number", [14, 23])
def test_joints_of_peers(package, name, number):
    pytest.importorskip(package)
    from atlasphys.validate.peers import world_of

    if (name, number) == ("rapier", 23):
        with pytest.raises(NotOfferedError, match="forces of joints"):
            CASES[number].run(world_of(name))
    else:
        assert CASES[number].run(world_of(name)).passed


def test_a_simple_case_runs(make_world):
    result = CASES[25].run(make_world)
    assert result.passed


def test_what_is_not_offered_is_said():
    for package, name, number in (("rapier3d", "rapier", 18), ("robox3d", "box3d", 7), ("mujoco", "mujoco", 5)):
        pytest.importorskip(package)
        from atlasphys.validate.peers import world_of

        with pytest.raises(NotOfferedError, match="no "):
            CASES[number].run(world_of(name))
