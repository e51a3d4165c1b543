"""The physics of ``soft_step`` on scenes with closed answers, where it differs from the classic solver: substeps, common points, bounces before the
substeps."""

import numpy as np
import pytest

import atlasphys as ap
from atlasphys.engine.state.manifolds import live_rows
from atlasphys.engine.state.pose import refresh

G, H = 9.81, 1 / 60


def world_of(**settings):
    return ap.World(preset="default", sleeping=False, **settings)


def on_plane(shape, *, slope=0.0, position=(0, 0.5, 0), precision="single", **arguments):
    """A body on a plane through the origin, inclined by turning gravity: down the slope is +x."""
    world = world_of(gravity=(G * np.sin(slope), -G * np.cos(slope), 0), precision=precision)
    world.add(ap.Plane(normal=(0, 1, 0)), friction=1.0)
    return world, world.add(shape, position=position, **arguments)


@pytest.mark.parametrize("speed", [0.0, 40.0])
def test_contact_points_move_with_the_bodies(speed):
    """A rolling ball rolls on at its speed, seen from the ground or from a train."""
    world = world_of()
    world.add(ap.Box(size=(400, 1, 4)), kind="kinematic", position=(0, -0.5, 0), velocity=(speed, 0, 0), friction=1.0)
    ball = world.add(
        ap.Sphere(radius=0.5),
        position=(0, 0.5, 0),
        velocity=(5 + speed, 0, 0),
        angular_velocity=(0, 0, -10),
        friction=1.0,
    )
    world.run(2, H)
    assert ball.velocity[0] - speed == pytest.approx(5, rel=2e-3)


def test_friction_stays_in_its_disk_and_totals_are_the_change_of_momentum():
    world, box = on_plane(ap.Box(size=(1, 0.2, 1)), position=(0, 0.1, 0), friction=0.25, velocity=(3, 0, 2), mass=2)
    box.angular_velocity = (0, 4, 0)
    sliding = 0
    for _ in range(60):
        before = 2 * box.velocity.astype(float) + (0, -2 * G * H, 0)
        world.step(H)
        contacts = world.contacts
        pushed, rubbed = contacts.normal_impulse.sum(), contacts.friction_impulse.sum(axis=0)
        given = (contacts.normal * contacts.normal_impulse[:, None] + contacts.friction_impulse).sum(axis=0)
        assert 2 * box.velocity - before == pytest.approx(given, abs=2e-5)
        assert np.linalg.norm(rubbed) <= 0.5 * pushed * (1 + 1e-4) + 1e-5
        sliding += np.linalg.norm(rubbed) > 0.49 * pushed
    assert sliding > 10
    assert np.abs(box.velocity).max() < 1e-3


@pytest.mark.parametrize("e", [0.5, 1.0])
def test_bounces_count_in_the_totals_and_in_no_warm_start(e):
    world, ball = on_plane(ap.Sphere(radius=0.5), position=(0, 0.7, 0), velocity=(1, -3, 0), restitution=e, mass=2)
    highest = 0.0
    for _ in range(30):
        before = 2 * ball.velocity.astype(float) + (0, -2 * G * H, 0)
        world.step(H)
        contacts = world.contacts
        given = (contacts.normal * contacts.normal_impulse[:, None] + contacts.friction_impulse).sum(axis=0)
        assert 2 * ball.velocity - before == pytest.approx(given, abs=2e-5)
        highest = max(highest, float(contacts.normal_impulse.sum()))
        live = live_rows(world._state.manifolds, world._state.manifold_count)
        assert world._state.manifolds.points[live].max(initial=0) < 0.2 * highest + 1
    impact = np.sqrt(9 + 2 * G * 0.2)
    assert highest == pytest.approx(2 * (1 + e) * impact, rel=0.06)  # gravity acts on to the end of the step


def test_what_carries_a_bouncing_body_holds():
    """A ball bounces off a box on a box: the boxes stay, and the ball leaves with e of its speed."""
    world = world_of(gravity=(0, 0, 0), precision="double")
    world.add(ap.Plane(normal=(0, 1, 0)))
    for y in (0.5, 1.5):
        world.add(ap.Box(size=(1, 1, 1)), position=(0, y, 0), mass=5)
    ball = world.add(ap.Sphere(radius=0.5), position=(0, 2.52, 0), velocity=(0, -4, 0), restitution=0.8, mass=1)
    world.run(0.1, H)
    assert ball.velocity == pytest.approx((0, 3.2, 0), abs=0.01)
    assert np.abs(world.bodies.velocity[1:3]).max() < 0.01


@pytest.mark.parametrize("precision", ["single", "double"])
def test_rolling_friction_stops_a_ball_and_holds_it_on_a_gentle_slope(precision):
    c, radius, speed = 0.02, 0.5, 1.0
    world, ball = on_plane(
        ap.Sphere(radius=radius), velocity=(speed, 0, 0), angular_velocity=(0, 0, -speed / radius), rolling_friction=c,
        friction=1, precision=precision,
    )  # fmt: skip
    # The torque c m g against rolling takes 7/5 m v² / 2 of energy over the distance s: c m g s / r.
    world.run(400 * H, H)
    assert np.abs(ball.velocity).max() < 1e-4
    assert ball.position[0] == pytest.approx(0.7 * speed**2 * radius / (c * G), rel=0.01)
    for tangent, holds in ((0.95, True), (1.05, False)):
        world, ball = on_plane(
            ap.Sphere(radius=radius),
            slope=np.arctan(tangent * c / radius),
            rolling_friction=c,
            friction=1,
            precision=precision,
        )
        world.run(2, H)
        assert (abs(ball.position[0]) < 1e-3) == holds


def test_rolling_friction_of_line_contacts():
    c, radius = 0.05, 0.5
    for tangent, holds in ((0.8, True), (1.2, False)):
        world, drum = on_plane(
            ap.Cylinder(radius=radius, length=1), slope=np.arctan(tangent * c / radius), orientation=(1, 1, 0, 0),
            rolling_friction=c, friction=1,
        )  # fmt: skip
        world.run(2, H)
        assert (abs(drum.position[0]) < 1e-3) == holds


def test_torsional_friction_stops_a_spinning_ball():
    radius, patch, mu, spin = 0.5, 0.05, 0.5, 4.0
    world, ball = on_plane(
        ap.Sphere(radius=radius), angular_velocity=(0, spin, 0), friction=mu**2, torsional_friction=patch
    )
    deceleration = mu * patch * G / (0.4 * radius**2)
    count = int(0.5 * spin / deceleration / H)
    world.run(count * H, H)
    assert ball.angular_velocity[1] == pytest.approx(spin - deceleration * count * H, rel=1e-3)
    torsion = world._state.copy().manifolds.total[0, 7]
    assert abs(torsion) == pytest.approx(mu * patch * ball.mass * G * H, rel=1e-3)
    world.run(2 * count * H, H)
    assert abs(ball.angular_velocity[1]) < 1e-4


def test_locked_axes_stay_and_the_rest_moves():
    world = world_of(precision="double")
    world.add(ap.Plane())
    box = world.add(
        ap.Box(size=(1, 0.5, 0.3)), position=(0, 2, 0), orientation=(1, 0.3, 0.2, 0.1), velocity=(1, 0, 1),
        angular_velocity=(1, 2, 3), locks=("x", "rx", "rz"),
    )  # fmt: skip
    world.run(1, H)
    assert box.position[0] == 0
    assert box.angular_velocity[0] == box.angular_velocity[2] == 0
    assert 0 < box.position[1] < 0.7
    assert box.position[2] > 0.3


def test_the_inverse_inertia_of_a_body_with_a_locked_axis_follows_it():
    world = world_of(gravity=(0, 0, 0), precision="double")
    box = world.add(
        ap.Box(size=(1, 0.5, 0.3)), angular_velocity=(1, 2, 0), orientation=(1, 0.3, 0.2, 0.1), locks=("rz",)
    )
    energy = world.energy().kinetic
    world.run(5, H)
    assert world.energy().kinetic == pytest.approx(energy, rel=1e-12)
    assert box.angular_velocity[2] == 0
    kept = world._state.bodies.inverse_mass[0].copy()
    refresh(world._state.bodies, 0, 1)
    np.testing.assert_allclose(kept, world._state.bodies.inverse_mass[0], atol=1e-12)


def test_a_conveyor_carries_and_is_moved_by_nothing():
    world = world_of()
    belt = world.add(ap.Box(size=(20, 1, 4)), position=(0, -0.5, 0), kind="kinematic", velocity=(1, 0, 0))
    box = world.add(ap.Box(size=(1, 1, 1)), position=(0, 0.5, 0), mass=1e4)
    world.run(2, H)
    assert belt.velocity.tolist() == [1, 0, 0]
    assert belt.position == pytest.approx((2, -0.5, 0), abs=1e-6)
    assert box.velocity == pytest.approx((1, 0, 0), abs=1e-3)
    # μ g until they move alike: the box falls behind by v² / (2 μ g)
    assert 2 - box.position[0] == pytest.approx(1 / (2 * 0.5 * G), rel=0.03)


def test_a_turntable_carries_round():
    world = world_of()
    table = world.add(
        ap.Cylinder(radius=5, length=1), position=(0, -0.5, 0), kind="kinematic", angular_velocity=(0, 1, 0)
    )
    box = world.add(
        ap.Box(size=(0.5, 0.5, 0.5)), position=(2, 0.25, 0), velocity=(0, 0, -2), angular_velocity=(0, 1, 0)
    )
    world.run(3, H)
    assert box.position == pytest.approx((2 * np.cos(3), 0.25, -2 * np.sin(3)), abs=0.03)
    assert box.angular_velocity == pytest.approx((0, 1, 0), abs=0.05)
    assert table.angular_velocity.tolist() == [0, 1, 0]
    assert table.position.tolist() == [0, -0.5, 0]


@pytest.mark.parametrize("recycling", [False, True])
def test_collisions_keep_momentum_and_angular_momentum(recycling):
    rng = np.random.default_rng(5)
    world = world_of(gravity=(0, 0, 0), precision="double", solver=ap.SoftStep(contact_recycling=recycling))
    for _ in range(12):
        where = rng.uniform(-1, 1, 3)
        world.add(
            ap.Box(size=(1, 0.7, 0.5)), position=3 * where, velocity=-3 * where, angular_velocity=rng.normal(size=3)
        )
    momentum, angular = world.momentum(), world.angular_momentum()
    scale = world.bodies.mass.sum() * 3
    world.run(2, H)
    np.testing.assert_allclose(world.momentum(), momentum, atol=1e-13 * scale)
    np.testing.assert_allclose(world.angular_momentum(), angular, atol=(1e-2 if recycling else 1e-13) * scale)
