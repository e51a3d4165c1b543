"""The contact laws on scenes with closed answers: weight, friction, rolling, restitution, position correction."""

import numpy as np
import pytest

import atlasphys as ap
from atlasphys.engine.solvers import SOLVERS
from tests.world.scenes import stack, steps

G, H = 9.81, 1 / 60


def on_plane(shape, *, slope=0.0, position=(0, 0.5, 0), solver="sequential_impulse", gravity=G, **arguments):
    """A body on a plane through the origin, inclined by turning gravity: down the slope is +x."""
    world = ap.World(gravity=(gravity * np.sin(slope), -gravity * np.cos(slope), 0), solver=solver)
    world.add(ap.Plane(normal=(0, 1, 0)), friction=1.0, restitution=0.0)
    return world, world.add(shape, position=position, **arguments)


@pytest.mark.parametrize("height", [1, 2, 5])
def test_reported_impulses_are_the_weight_above_each_level(height):
    world = stack(height)
    steps(world, 120)
    mass = world.bodies.mass[1]
    for _ in range(5):
        world.step(H)
        contacts = world.contacts
        lower = np.minimum(contacts.body_a, contacts.body_b)
        for level in range(height):
            load = contacts.normal_impulse[lower == level].sum()
            assert load == pytest.approx((height - level) * mass * G * H, rel=2e-3)


def test_impulses_on_a_falling_body_account_for_its_change_of_momentum():
    world, ball = on_plane(ap.Sphere(radius=0.5), position=(0, 1.2, 0), velocity=(1, -3, 0), restitution=0.5, mass=2)
    hit = False
    for _ in range(60):
        before = 2 * ball.velocity.astype(float) + (0, -2 * G * H, 0)
        world.step(H)
        given = np.zeros(3)
        for contact in world.contacts:
            given += (contact.normal * contact.normal_impulse + contact.friction_impulse) * (
                1 if contact.body_b == ball.row else -1
            )
        hit = hit or bool(given.any())
        assert 2 * ball.velocity - before == pytest.approx(given, abs=2e-5)
    assert hit


@pytest.mark.parametrize("mu", [0.2, 0.5, 1.0])
@pytest.mark.parametrize("shape", [ap.Box(size=(1, 1, 1)), ap.Cylinder(radius=1, length=1)])
def test_static_friction_holds_below_and_fails_above_the_critical_angle(mu, shape):
    critical = np.arctan(mu)
    for slope, sticks in ((0.97 * critical, True), (1.03 * critical, False)):
        world, body = on_plane(shape, slope=slope, friction=mu**2, gravity=G)  # √(μ² · 1) = μ
        steps(world, 120)
        if sticks:
            assert abs(body.position[0]) < 2e-3
        else:
            expected = G * (np.sin(slope) - mu * np.cos(slope)) * 2.0
            assert body.velocity[0] == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize("angle", [0.0, 0.3, 0.7, 2.0])
def test_sliding_stops_where_it_should_and_goes_straight(angle):
    """The distance v² / (2 μ g), the same in every direction."""
    mu, speed = 0.5, 3.0
    direction = np.array([np.cos(angle), 0, np.sin(angle)])
    world, body = on_plane(ap.Box(size=(1, 0.2, 1)), position=(0, 0.1, 0), friction=mu**2, velocity=speed * direction)
    steps(world, 90)
    travelled = body.position - (0, 0.1, 0)
    assert np.linalg.norm(body.velocity) < 1e-3
    assert travelled @ direction == pytest.approx(speed**2 / (2 * mu * G), rel=0.03)
    assert abs(np.cross(travelled, direction)[1]) < 2e-3


def test_friction_stays_in_its_cone():
    """On a sliding or tumbling body |λ_t| ≤ μ λ_n, once the normal impulses have settled, and λ_t is tangential."""
    world, body = on_plane(ap.Box(size=(1, 0.2, 1)), position=(0, 0.1, 0), friction=0.25, velocity=(3, 0, 2))
    body.angular_velocity = (0, 4, 0)
    sliding = 0
    for i in range(60):
        world.step(H)
        contacts = world.contacts
        sideways = np.abs((contacts.friction_impulse * contacts.normal).sum(axis=1))
        size = np.linalg.norm(contacts.friction_impulse, axis=1)
        assert (sideways <= 1e-5 * (1 + size)).all()
        if i > 5:
            assert (size <= 0.5 * contacts.normal_impulse * 1.05 + 1e-4).all()
            sliding += bool((size >= 0.5 * contacts.normal_impulse * 0.95).all())
    assert sliding > 10


def test_a_sliding_ball_ends_rolling():
    """Whatever μ, a ball that starts with v and no spin ends with 5/7 v."""
    world, ball = on_plane(ap.Sphere(radius=0.5), velocity=(7, 0, 0), friction=0.25)
    steps(world, 180)
    assert ball.velocity[0] == pytest.approx(5, rel=5e-3)
    assert ball.angular_velocity[2] == pytest.approx(-10, rel=5e-3)


def test_a_ball_rolls_down_at_five_sevenths():
    slope = 0.3
    world, ball = on_plane(ap.Sphere(radius=0.5), slope=slope, friction=1)
    steps(world, 60)
    assert ball.velocity[0] == pytest.approx(5 / 7 * G * np.sin(slope), rel=5e-3)


def test_rolling_friction_stops_a_ball_and_holds_it_on_a_gentle_slope():
    c, radius, speed = 0.02, 0.5, 1.0
    world, ball = on_plane(
        ap.Sphere(radius=radius),
        velocity=(speed, 0, 0),
        angular_velocity=(0, 0, -speed / radius),
        rolling_friction=c,
        friction=1,
    )
    # The torque c m g against rolling takes 7/5 m v² / 2 of energy over the distance s: c m g s / r.
    steps(world, 400)
    assert np.abs(ball.velocity).max() < 1e-3
    assert ball.position[0] == pytest.approx(0.7 * speed**2 * radius / (c * G), rel=0.05)
    for tangent, holds in ((0.8 * c / radius, True), (1.3 * c / radius, False)):
        world, ball = on_plane(ap.Sphere(radius=radius), slope=np.arctan(tangent), rolling_friction=c, friction=1)
        steps(world, 120)
        assert (abs(ball.position[0]) < 1e-3) == holds
    world, ball = on_plane(ap.Sphere(radius=radius), velocity=(1, 0, 0), angular_velocity=(0, 0, -2), friction=1)
    steps(world, 400)
    assert ball.velocity[0] == pytest.approx(1, rel=1e-2)  # without it, on and on


def test_torsional_friction_stops_a_spinning_ball():
    radius, patch, mu, spin = 0.5, 0.05, 0.5, 4.0
    world, ball = on_plane(
        ap.Sphere(radius=radius), angular_velocity=(0, spin, 0), friction=mu**2, torsional_friction=patch
    )
    deceleration = mu * patch * G / (0.4 * radius**2)
    count = int(0.5 * spin / deceleration / H)
    steps(world, count)
    assert ball.angular_velocity[1] == pytest.approx(spin - deceleration * count * H, rel=0.05)
    steps(world, 2 * count)
    assert abs(ball.angular_velocity[1]) < 1e-4
    world, ball = on_plane(ap.Sphere(radius=radius), angular_velocity=(0, spin, 0))
    steps(world, 60)
    assert ball.angular_velocity[1] == pytest.approx(spin, rel=1e-3)


@pytest.mark.parametrize("e", [0.0, 0.5, 0.8, 1.0])
def test_restitution_gives_the_heights(e):
    world, ball = on_plane(ap.Sphere(radius=0.5), position=(0, 2.5, 0), restitution=e)
    drop, top, rising = 2.0, 0.0, False
    for _ in range(240):
        world.step(H)
        if ball.velocity[1] > 0.05:
            rising = True
        if rising:
            top = max(top, ball.position[1] - 0.5)
        if rising and ball.velocity[1] < 0:
            break
    assert top == pytest.approx(e * e * drop, abs=0.03)


def test_slow_impacts_do_not_bounce_and_the_threshold_may_be_changed():
    for threshold, bounces in ((1.0, False), (0.1, True)):
        world, ball = on_plane(ap.Sphere(radius=0.5), position=(0, 0.52, 0), velocity=(0, -0.5, 0), restitution=0.9)
        world.restitution_threshold = threshold
        fastest = 0.0
        for _ in range(20):
            world.step(H)
            fastest = max(fastest, float(ball.velocity[1]))
        assert (fastest > 0.2) == bounces


def test_equal_balls_swap_velocities():
    world = ap.World(gravity=(0, 0, 0))
    left = world.add(ap.Sphere(radius=0.5), velocity=(2, 0, 0), restitution=1)
    right = world.add(ap.Sphere(radius=0.5), position=(1.3, 0, 0), restitution=1)
    steps(world, 30)
    assert left.velocity == pytest.approx((0, 0, 0), abs=1e-3)
    assert right.velocity == pytest.approx((2, 0, 0), abs=1e-3)


@pytest.mark.parametrize("correction", ["projection", "baumgarte"])
def test_overlap_is_removed_down_to_the_slop(correction):
    world, box = on_plane(
        ap.Box(size=(1, 1, 1)), position=(0, 0.4, 0), solver=ap.SequentialImpulse(position_correction=correction)
    )
    steps(world, 240)
    assert 0.5 - box.position[1] == pytest.approx(0.005, abs=0.004)
    assert np.abs(box.velocity).max() < 0.01


def test_projection_adds_no_kinetic_energy_where_baumgarte_does():
    fastest = {}
    for correction in ("projection", "baumgarte"):
        world = ap.World(gravity=(0, 0, 0), solver=ap.SequentialImpulse(position_correction=correction))
        a = world.add(ap.Box(size=(1, 1, 1)))
        b = world.add(ap.Box(size=(1, 1, 1)), position=(0.8, 0.1, 0.05), orientation=(1, 0.1, 0, 0.05))
        fastest[correction] = 0.0
        for _ in range(60):
            world.step(H)
            fastest[correction] = max(fastest[correction], world.energy().kinetic)
        assert np.linalg.norm(b.position - a.position) > 0.95
    assert fastest["projection"] == 0
    assert fastest["baumgarte"] > 1


def test_projection_turns_bodies_too():
    """A box whose one edge is sunk in is lifted at that edge, not as a whole."""
    world, box = on_plane(
        ap.Box(size=(2, 0.5, 1)), position=(0, 0.3, 0), orientation=(np.cos(0.05), 0, 0, np.sin(0.05)), gravity=0
    )
    steps(world, 1)
    assert abs(box.orientation[3]) < np.sin(0.05)
    steps(world, 60)
    assert box.position[1] < 0.34


@pytest.mark.parametrize("ratio", [0.001, 0.1, 10])
def test_unequal_masses_rest_on_each_other(ratio):
    world = ap.World()
    world.add(ap.Plane(normal=(0, 1, 0)))
    world.add(ap.Box(size=(1, 1, 1)), position=(0, 0.5, 0), mass=1)
    world.add(ap.Box(size=(1, 1, 1)), position=(0, 1.5, 0), mass=ratio)
    steps(world, 180)
    assert world.bodies.position[1:, 1] == pytest.approx([0.5, 1.5], abs=0.02)
    assert np.abs(world.bodies.velocity).max() < 0.02


@pytest.mark.parametrize("warm", [True, False])
def test_warm_starting_is_a_choice(warm):
    world = ap.World(solver=ap.SequentialImpulse(warm_starting=warm))
    world.add(ap.Plane(normal=(0, 1, 0)))
    for i in range(8):
        world.add(ap.Box(size=(1, 1, 1)), position=(0, 0.5 + i, 0))
    steps(world, 60)
    sag = 7.5 - world.bodies.position[8, 1]
    assert (sag < 0.06) == warm
    assert sag < 1.5


def test_changing_the_step_length_does_not_shake_a_stack():
    world = stack(4)
    steps(world, 60)
    for i in range(60):
        world.step(1 / 60 if i % 2 else 1 / 240)
        assert np.abs(world.bodies.velocity).max() < 0.1


@pytest.mark.parametrize("other", [1e-5, 1e-3])
def test_changing_the_step_length_a_thousandfold_does_not_topple_a_stack(other):
    world = stack(8)
    steps(world, 60)
    for i in range(200):
        world.step(1 / 60 if i % 2 else other)
    assert world.energy().kinetic < 100
    assert world.bodies.position[1:, 1] == pytest.approx(np.arange(8) + 0.5, abs=0.2)


def test_towers_of_ten_stand():
    world = stack(10)
    steps(world, 300)
    assert world.bodies.position[1:, 1] == pytest.approx(np.arange(10) + 0.5, abs=0.06)
    assert np.abs(world.bodies.position[:, [0, 2]]).max() < 0.01


def test_collisions_keep_momentum_and_angular_momentum():
    rng = np.random.default_rng(5)
    world = ap.World(gravity=(0, 0, 0), precision="double")
    for _ in range(8):
        where = rng.uniform(-1, 1, 3)
        world.add(
            ap.Box(size=(1, 0.7, 0.5)), position=3 * where, velocity=-3 * where, angular_velocity=rng.normal(size=3)
        )
    momentum, angular = world.momentum(), world.angular_momentum()
    scale = world.bodies.mass.sum() * 3
    steps(world, 120)
    np.testing.assert_allclose(world.momentum(), momentum, atol=1e-10 * scale)
    np.testing.assert_allclose(world.angular_momentum(), angular, atol=0.02 * scale)


def test_every_solver_is_documented():
    for name, entry in SOLVERS.items():
        assert entry.settings.__doc__
        assert ap.World(solver=entry.settings()).solver == name
