"""``avbd``: closed forms, what it alone holds up, momenta, and its state. The validation cases run elsewhere."""

import copy
import pickle

import numpy as np
import pytest

import atlasphys as ap
from atlasphys.engine.state.manifolds import PENALTY, POINT_COLUMNS
from atlasphys.validate.cases.conservation import implosion
from tests.engine.solvers.test_contacts import G, H, on_plane
from tests.world.scenes import heap, stack, steps

SLOP = 0.005


def column(*masses, **settings):
    """Unit cubes of these masses on each other, the first on the ground."""
    world = ap.World(preset="avbd", **settings)
    world.add(ap.Plane(normal=(0, 1, 0)))
    for level, mass in enumerate(masses):
        world.add(ap.Box(size=(1, 1, 1)), position=(0, 0.5 + level, 0), mass=mass)
    return world


def deepest(world, seconds, dt=H):
    """The deepest overlap in that time."""
    found = 0.0
    for _ in range(round(seconds / dt)):
        world.step(dt)
        if len(world.contacts):
            found = max(found, float(world.contacts.depth.max()))
    return found


# Masses ----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("ratio", [1, 100, 1000])
def test_heavy_on_light_stands(ratio):
    world = column(10, 10 * ratio)
    start = world.bodies.position.copy()
    assert deepest(world, 10) < SLOP
    assert np.abs(world.bodies.position - start).max() < 1e-3
    for row, mass in ((1, 10 * (1 + ratio)), (2, 10 * ratio)):
        contacts = world.contacts
        assert contacts.normal_impulse[contacts.body_b == row].sum() / H == pytest.approx(mass * G, rel=1e-4)


def test_a_column_of_alternating_masses_stands():
    world = column(1, 1000, 1, 1000, 1, 1000)
    assert deepest(world, 4) < SLOP
    assert np.abs(world.bodies.velocity).max() < 1e-3


def test_a_heavy_ball_dropped_on_a_light_box_leaves_it_standing():
    world = column(1)
    ball = world.add(ap.Sphere(radius=0.5), position=(0, 2.5, 0), mass=1000)
    assert deepest(world, 3) < 0.05
    assert ball.position[1] == pytest.approx(1.5, abs=2 * SLOP)
    assert np.abs(world.bodies.velocity).max() < 1e-2


# Stacks ----------------------------------------------------------------------------------------------------------------


def test_a_tower_of_twenty_stands():
    world = stack(20, preset="avbd")
    start = world.bodies.position.copy()
    assert deepest(world, 10) < SLOP
    assert np.abs(world.bodies.position - start).max() < 0.01
    assert np.abs(world.bodies.velocity).max() < 1e-4


def test_sweeps_end_when_nothing_changes():
    """At rest one more iteration, or a hundred, are the same."""
    few, many = (stack(3, solver=ap.AVBD(iterations=count)) for count in (20, 2000))
    steps(few, 60), steps(many, 60)
    assert np.abs(few.bodies.velocity).max() < 1e-5
    np.testing.assert_allclose(few.bodies.position, many.bodies.position, atol=1e-5)


# Friction --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("mu", [0.2, 1.0])
def test_static_friction_holds_below_and_fails_above_the_critical_angle(mu):
    critical = np.arctan(mu)
    for slope, sticks in ((0.98 * critical, True), (1.02 * critical, False)):
        box = ap.Box(size=(1, 0.4, 1))
        world, body = on_plane(box, slope=slope, position=(0, 0.2, 0), solver="avbd", friction=mu**2)
        steps(world, 120)
        if sticks:
            assert abs(body.position[0]) < 1e-4
        else:
            assert body.velocity[0] == pytest.approx(G * (np.sin(slope) - mu * np.cos(slope)) * 2, rel=0.02)


def test_friction_stays_in_its_cone_and_opposes_the_slip():
    world, body = on_plane(
        ap.Box(size=(1, 0.2, 1)), position=(0, 0.1, 0), solver="avbd", friction=0.25, velocity=(3, 0, 2)
    )
    for i in range(30):
        world.step(H)
        contacts = world.contacts
        size = np.linalg.norm(contacts.friction_impulse, axis=1)
        assert (size <= 0.5 * contacts.normal_impulse * (1 + 1e-5)).all()
        assert np.abs((contacts.friction_impulse * contacts.normal).sum(axis=1)).max() < 1e-5 * size.max()
        if i > 1:
            total = (contacts.friction_impulse * np.where(contacts.body_b == body.row, 1, -1)[:, None]).sum(axis=0)
            way = np.asarray(body.velocity, float)
            assert total @ way == pytest.approx(-np.linalg.norm(total) * np.linalg.norm(way), rel=1e-4)


def test_rolling_friction_holds_a_ball_on_a_gentle_slope_only():
    lever, radius = 0.02, 0.5
    for tangent, holds in ((0.9 * lever / radius, True), (1.1 * lever / radius, False)):
        world, ball = on_plane(
            ap.Sphere(radius=radius), slope=np.arctan(tangent), solver="avbd", rolling_friction=lever, friction=1
        )
        steps(world, 120)
        assert (abs(ball.position[0]) < 1e-3) == holds


def test_torsional_friction_slows_a_spinning_ball():
    radius, patch, mu, spin = 0.5, 0.05, 0.5, 4.0
    world, ball = on_plane(
        ap.Sphere(radius=radius),
        solver="avbd",
        angular_velocity=(0, spin, 0),
        friction=mu**2,
        torsional_friction=patch,
    )
    deceleration = mu * patch * G / (0.4 * radius**2)
    count = int(0.5 * spin / deceleration / H)
    steps(world, count)
    assert ball.angular_velocity[1] == pytest.approx(spin - deceleration * count * H, rel=0.02)
    steps(world, 2 * count)
    assert abs(ball.angular_velocity[1]) < 1e-3


# Impacts ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
def test_two_balls_part_as_newton_says(restitution):
    world = ap.World(preset="avbd", gravity=(0, 0, 0), precision="double")
    a = world.add(ap.Sphere(radius=0.5), mass=1, velocity=(3, 0, 0), restitution=restitution)
    b = world.add(ap.Sphere(radius=0.5), mass=50, position=(1.01, 0, 0), restitution=restitution)
    steps(world, 10)
    shared = 3 / 51
    assert a.velocity[0] == pytest.approx(shared - restitution * 3 * 50 / 51, abs=1e-5)
    assert b.velocity[0] == pytest.approx(shared + restitution * 3 * 1 / 51, abs=1e-5)


def test_a_ball_bounces_to_e_squared_of_its_height():
    world, ball = on_plane(ap.Sphere(radius=0.5), position=(0, 1.5, 0), solver="avbd", restitution=0.8)
    heights = []
    for _ in range(90):
        world.step(1 / 240)
        heights.append(float(ball.position[1]))
    for _ in range(150):
        world.step(1 / 240)
        heights.append(float(ball.position[1]))
    assert max(heights[110:]) - 0.5 == pytest.approx(0.64, rel=0.01)


def test_overlap_is_eased_out_by_alpha():
    """One step leaves α of what exceeds the slop."""
    world, ball = on_plane(ap.Sphere(radius=0.5), position=(0, 0.45, 0), solver=ap.AVBD(alpha=0.8), gravity=0)
    world.step(H)
    assert 0.5 - ball.position[1] - SLOP == pytest.approx(0.8 * (0.05 - SLOP), rel=1e-3)


# Momenta ---------------------------------------------------------------------------------------------------------------


def test_free_islands_keep_their_momenta_however_few_the_iterations():
    def make_world(**settings):
        return ap.World(precision="double", solver=ap.AVBD(iterations=1), sleeping=False, **settings)

    world = implosion(make_world, 0.0, 0.5, 28)
    momentum, spin = world.momentum(), world.angular_momentum()
    scale = np.abs(world.bodies.mass[:, None] * world.bodies.velocity).sum()
    steps(world, 40)
    assert len(world.contacts) > 100
    np.testing.assert_allclose(world.momentum(), momentum, atol=1e-13 * scale)
    np.testing.assert_allclose(world.angular_momentum(), spin, atol=1e-12 * scale)


def test_the_ground_takes_momentum():
    """What touches a static body is no free island: a box dropped on the ground stops."""
    world, box = on_plane(ap.Box(size=(1, 1, 1)), position=(0, 0.51, 0), solver="avbd", velocity=(0, -2, 0))
    steps(world, 30)
    assert np.abs(box.velocity).max() < 1e-5


def test_locked_bodies_move_along_their_free_axes_only():
    world = ap.World(preset="avbd", gravity=(0, -G, 0))
    world.add(ap.Plane(normal=(0, 1, 0)))
    slider = world.add(ap.Box(size=(1, 1, 1)), position=(0, 3, 0), locks=("y", "rx", "rz"), friction=0)
    striker = world.add(ap.Box(size=(1, 1, 1)), position=(-1.2, 3.2, 0.3), velocity=(4, 0, 0), gravity_scale=0)
    steps(world, 60)
    assert slider.velocity[0] > 1
    assert slider.position[1] == 3
    assert slider.angular_velocity[0] == slider.angular_velocity[2] == 0
    assert abs(slider.angular_velocity[1]) > 0.1
    total = slider.mass * slider.velocity[0] + striker.mass * striker.velocity[0]
    assert total == pytest.approx(4 * striker.mass, rel=1e-4)


# State -----------------------------------------------------------------------------------------------------------------


def test_what_the_next_step_starts_from_is_state():
    world = stack(4, preset="avbd")
    steps(world, 20)
    local = world._state.manifolds.local
    assert (local[:4, PENALTY::POINT_COLUMNS] > 0).all()
    twins = [copy.deepcopy(world), pickle.loads(pickle.dumps(world)), ap.World(preset="avbd")]
    twins[2].restore(world.snapshot())
    before = world.state_hash()
    local[0, PENALTY] *= 2
    assert world.state_hash() != before
    local[0, PENALTY] /= 2
    assert {steps(twin, 20) for twin in twins} == {steps(world, 20)}


def test_another_solver_forgets_the_penalties():
    world = stack(4, preset="avbd")
    steps(world, 5)
    world.solver = "soft_step"
    assert not world._state.manifolds.local[:, PENALTY::POINT_COLUMNS].any()
    steps(world, 5)
    world.solver = ap.AVBD(iterations=5)
    steps(world, 60)
    assert np.abs(world.bodies.velocity).max() < 1e-3


@pytest.mark.parametrize("precision", ["single", "double"])
def test_reruns_and_broad_phases_are_equal(precision):
    hashes = {
        steps(heap(5, preset="avbd", precision=precision, broadphase=name), 60) for name in ("sweep", "tree", "brute")
    }
    assert len(hashes) == 1


@pytest.mark.parametrize("seed", range(8))
def test_random_scenes_stay_finite(seed):
    world = heap(seed, preset="avbd", spread=(0.1, 0.5, 1.5, 4.0)[seed % 4])
    for _ in range(150):
        world.step(H)
        assert np.abs(world.bodies.velocity).max() < 100
    assert (world.contacts.normal_impulse >= 0).all()


@pytest.mark.parametrize("unit", [2.0**-6, 2.0**5])
def test_scaling_lengths_scales_the_trajectory(unit):
    def pile(size):
        world = ap.World(preset="avbd", gravity=(0, -8 * size, 0), length_unit=size)
        world.add(ap.Plane(normal=(0, 1, 0)))
        for i in range(5):
            world.add(ap.Box(size=(size, size, size)), position=(0.25 * i * size, (0.75 + 1.25 * i) * size, 0))
        steps(world, 90)
        return world

    np.testing.assert_array_equal(pile(unit).bodies.position, unit * pile(1.0).bodies.position)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"iterations": 0}, "iterations must be an integer from 1 to"),
        ({"iterations": 2.0}, "iterations must be an integer"),
        ({"alpha": 1.5}, "alpha must be a number from 0 to 1"),
        ({"gamma": -0.1}, "gamma must be"),
        ({"beta": float("nan")}, "beta must be"),
        ({"least_penalty": 0}, "least_penalty must be a number from 0.001 to 1000"),
        ({"smoothing": "much"}, "smoothing must be"),
        ({"tolerance": -1}, "tolerance must be"),
    ],
)
def test_settings_out_of_range_are_refused(settings, message):
    with pytest.raises(ap.InvalidArgumentError, match=message):
        ap.AVBD(**settings)


def test_scene_files_take_it():
    scene = ap.Scene(world={"solver": "avbd", "solver_settings": {"iterations": 7, "alpha": 0.9}})
    assert scene.build().solver_settings == ap.AVBD(iterations=7, alpha=0.9)
    assert ap.World(preset="avbd").solver == "avbd"
