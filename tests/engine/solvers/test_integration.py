"""Motion without contact: exact laws, to round-off where the method is exact."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import atlasphys as ap
from tests.world.scenes import steps

PRECISIONS = ["single", "double"]
SUBSTEPS = {"default": 4, "classic": 1}
H = 1 / 64  # a power of two, so that h itself is exact in single precision


@pytest.fixture(params=SUBSTEPS)
def preset(request):
    return request.param


def lone(precision="double", gravity=(0, 0, 0), shape=None, preset="default", **arguments):
    world = ap.World(gravity=gravity, precision=precision, preset=preset)
    return world, world.add(shape or ap.Sphere(radius=0.5), **arguments)


def test_free_fall_is_exact(preset):
    """v = v₀ + n h g and y = y₀ + n h v₀ + ½ n (n + 1) h² g after n substeps: with numbers that round nowhere, to the last bit."""
    world, body = lone("single", gravity=(0, -8, 1), position=(1, 100, -2), velocity=(2, 4, -1), preset=preset)
    for n in range(1, 200):
        world.step(H)
        t, tt = n * H, n * (n + 1 / SUBSTEPS[preset]) * H * H / 2
        assert body.velocity.tolist() == [2, 4 - 8 * t, -1 + t]
        assert body.position.tolist() == [1 + 2 * t, 100 + 4 * t - 8 * tt, -2 - t + tt]


@pytest.mark.parametrize("precision", PRECISIONS)
def test_free_fall_at_any_step_length(precision, preset):
    h, g = 1 / 60, 9.81
    world, body = lone(precision, gravity=(0, -g, 0), position=(0, 10, 0), velocity=(0, 3, 0), preset=preset)
    steps(world, 100, h)
    eps = 6e-8 if precision == "single" else 1e-16
    assert body.velocity[1] == pytest.approx(3 - 100 * h * g, rel=200 * eps)
    assert body.position[1] == pytest.approx(
        10 + 300 * h - 100 * (100 + 1 / SUBSTEPS[preset]) / 2 * h * h * g, abs=2000 * eps
    )


@pytest.mark.parametrize("scale", [0.0, -1.0, 2.5])
def test_gravity_scale(scale):
    world, body = lone(gravity=(0, -8, 0), gravity_scale=scale)
    steps(world, 64, H)
    assert body.velocity.tolist() == [0, -8 * scale, 0]


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("spin", [(0.01, 7, 0.01), (3, -2, 5), (20, 0.1, 0), (60, 50, 40)])
def test_a_free_body_keeps_its_energy_and_angular_momentum(precision, spin, preset):
    plate = ap.Box(size=(1, 0.4, 0.2))
    world, body = lone(precision, shape=plate, orientation=(1, 2, 3, 4), angular_velocity=spin, mass=3, preset=preset)
    energy, momentum = world.energy().kinetic, world.angular_momentum()
    size = np.linalg.norm(momentum)
    loose = (1e-4 if precision == "single" else 1e-12) * SUBSTEPS[preset]
    turned = 0.0
    for _ in range(1000):
        world.step(1 / 60)
        assert world.energy().kinetic == pytest.approx(energy, rel=loose)
        np.testing.assert_allclose(world.angular_momentum(), momentum, atol=loose * size)
        turned = max(turned, np.abs(body.angular_velocity - spin).max())
    assert turned > 0.1  # ω is not what stays constant


@pytest.mark.parametrize("speed", [1e-37, 1e-22, 1e-10, 1e3])
@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_very_slow_fast_small_and_large_spins_stay_what_they_are(speed, size, preset):
    shape = ap.Box(size=(size, 0.5 * size, 0.25 * size))
    world, body = lone("single", shape=shape, angular_velocity=(0, speed, 0), preset=preset)
    steps(world, 20)
    assert body.angular_velocity == pytest.approx((0, speed, 0), rel=1e-4, abs=0)


def test_the_intermediate_axis_flips_and_the_others_do_not():
    for axis, flips in ((0, False), (1, True), (2, False)):
        spin = np.full(3, 1e-3)
        spin[axis] = 5
        world, body = lone("single", shape=ap.Box(size=(1, 0.5, 0.2)), angular_velocity=spin)
        least = 1.0
        for _ in range(1200):
            world.step(1 / 60)
            _, x, y, z = body.orientation.astype(float)
            diagonal = (1 - 2 * (y * y + z * z), 1 - 2 * (x * x + z * z), 1 - 2 * (x * x + y * y))
            least = min(least, diagonal[axis])
        assert (least < -0.9) == flips
        assert flips or least > 0.95


@pytest.mark.parametrize("precision", PRECISIONS)
def test_orientations_stay_unit_quaternions(precision):
    world, body = lone(precision, shape=ap.Box(size=(1, 0.5, 0.2)), angular_velocity=(3, 40, -7))
    other = world.add(ap.Sphere(radius=1), position=(9, 0, 0), angular_velocity=(1, 2, 3))
    turning = world.add(ap.Box(size=(1, 1, 1)), position=(0, 9, 0), kind="kinematic", angular_velocity=(0, 100, 0))
    world.run(5_000 / 60)
    for each in (body, other, turning):
        length = np.linalg.norm(each.orientation.astype(float))
        assert length == pytest.approx(1, abs=2e-7 if precision == "single" else 1e-15)


@pytest.mark.full
def test_orientations_stay_unit_quaternions_for_long():
    world, body = lone("single", shape=ap.Box(size=(1, 0.5, 0.2)), angular_velocity=(3, 40, -7))
    world.run(100_000 / 60)
    assert np.linalg.norm(body.orientation.astype(float)) == pytest.approx(1, abs=2e-7)


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("speed", [0.5, 5.0, 30.0])
def test_a_steady_spin_turns_by_its_angle(precision, speed, preset):
    """Over a substep of up to half a radian the angle is right to the fifth order; a kinematic body turns likewise."""
    for kind in ("dynamic", "kinematic"):
        world, body = lone(precision, angular_velocity=(0, speed, 0), kind=kind, preset=preset)
        steps(world, 60)
        substeps = 60 * SUBSTEPS[preset]
        x = speed / substeps
        angle = substeps * 2 * np.arctan((x + x**3 / 12 + x**5 / 120) / 2)
        assert angle == pytest.approx(speed, rel=max(x**6, 1e-12))
        wanted = [np.cos(angle / 2), 0, np.sin(angle / 2), 0]
        loose = 2e-5 if precision == "single" else 1e-12
        np.testing.assert_allclose(body.orientation * np.sign(body.orientation[0] * wanted[0]), wanted, atol=loose)
        assert body.angular_velocity == pytest.approx((0, speed, 0), rel=1e-6)


def test_damping_follows_implicit_euler(preset):
    world, body = lone(
        velocity=(1, 2, 3), angular_velocity=(3, 2, 1), linear_damping=0.5, angular_damping=2.0, preset=preset
    )
    steps(world, 100, H)
    h, n = H / SUBSTEPS[preset], 100 * SUBSTEPS[preset]
    assert body.velocity == pytest.approx(np.array([1, 2, 3]) / (1 + 0.5 * h) ** n, rel=1e-12)
    assert body.angular_velocity == pytest.approx(np.array([3, 2, 1]) / (1 + 2 * h) ** n, rel=1e-12)


def test_damping_of_any_strength_is_stable(preset):
    world, body = lone("single", velocity=(1e3, 0, 0), angular_velocity=(0, 1e3, 0), linear_damping=1e6, preset=preset)
    body.angular_damping = 1e6
    steps(world, 5, 1.0)
    assert np.abs(body.velocity).max() < 1e-3
    assert np.abs(body.angular_velocity).max() < 1e-3


@settings(max_examples=40)
@given(
    force=st.tuples(*[st.floats(-50, 50)] * 3),
    at=st.tuples(*[st.floats(-2, 2)] * 3),
    kick=st.sampled_from(["force", "impulse"]),
)
def test_forces_and_impulses_at_points(force, at, kick):
    """Δv = J / m and Δω = I⁻¹ (r × J), with r from the centre of mass, here not the origin of the body's frame."""
    world, body = lone(shape=ap.Cone(radius=0.5, height=2), mass=2, position=(1, -1, 0.5))
    inertia, arm = body.inertia, np.array(at) - body.center_of_mass
    h = 1e-3
    if kick == "force":
        body.apply_force(force, at=at)
        world.step(h)
        impulse = h * np.array(force)
    else:
        body.apply_impulse(force, at=at)
        impulse = np.array(force)
    np.testing.assert_allclose(body.velocity, impulse / 2, rtol=1e-12, atol=1e-12)
    spin = np.cross(arm, impulse) / inertia
    if kick == "impulse":
        np.testing.assert_allclose(body.angular_velocity, spin, rtol=1e-12, atol=1e-12)
    else:  # the gyroscopic part of the step acts after the force's
        np.testing.assert_allclose(body.angular_velocity, spin, atol=1e-2 * (1e-9 + np.abs(spin).max()))


def test_forces_add_up_act_once_and_reach_only_their_body():
    world, body = lone(mass=4)
    other = world.add(ap.Sphere(radius=0.5), position=(5, 0, 0), mass=4)
    body.apply_force((1, 0, 0))
    body.apply_force((0, 2, 0))
    body.apply_torque((0, 0, 0.5))
    body.apply_angular_impulse((0, 0.25, 0))
    steps(world, 1, H)
    assert body.velocity == pytest.approx((H / 4, H / 2, 0))
    assert body.angular_velocity == pytest.approx((0, 0.25 / body.inertia[1], H * 0.5 / body.inertia[2]))
    kept = body.velocity
    steps(world, 3, H)
    assert body.velocity.tolist() == kept.tolist()
    assert not other.velocity.any()


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize(
    "locks", [("x",), ("y", "z"), ("x", "y", "z"), ("rx",), ("rx", "rz"), ("rx", "ry", "rz"), ("z", "rx", "ry")]
)
def test_locks_hold_exactly(precision, locks, preset):
    world = ap.World(precision=precision, preset=preset)
    world.add(ap.Plane(normal=(0.2, 1, 0.1)), friction=0.8)
    body = world.add(
        ap.Box(size=(1, 0.6, 0.4)), position=(1, 0.4, 2), locks=locks, velocity=(1, -1, 2), angular_velocity=(3, 2, 1)
    )
    world.add(ap.Sphere(radius=0.4), position=(1.2, 1.2, 2.1), velocity=(0, -3, 0), density=5000)
    start = body.position
    for i in range(120):
        if i == 30:
            body.apply_impulse((50, 20, -30), at=(1, 1, 1))
            body.apply_force((500, 200, -300), at=(1, 1, 1))
        world.step(1 / 60)
        for k, name in enumerate(("x", "y", "z")):
            if name in locks:
                assert body.position[k] == start[k]
                assert body.velocity[k] == 0
            if "r" + name in locks:
                assert body.angular_velocity[k] == 0
    turning = [name for name in ("rx", "ry", "rz") if name not in locks]
    if len(turning) == 0:
        assert body.orientation.tolist() == [1, 0, 0, 0]
    if len(turning) == 1:  # turned about that axis alone
        k = ("rx", "ry", "rz").index(turning[0])
        assert np.delete(body.orientation[1:], k) == pytest.approx([0, 0], abs=1e-6 if precision == "single" else 1e-14)
    if set(locks) != {"x", "y", "z"}:
        assert (body.position != start).any()


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("locks", [("rx",), ("ry",), ("rx", "rz")])
def test_spinning_under_rotation_locks_keeps_the_energy(precision, locks, preset):
    plate = ap.Box(size=(1, 0.4, 0.2))
    world, body = lone(precision, shape=plate, orientation=(1, 2, -1, 0.5), locks=locks, preset=preset)
    body.angular_velocity = [0 if name in locks else w for name, w in zip(("rx", "ry", "rz"), (3, 4, 5), strict=True)]
    energy = world.energy().kinetic
    for _ in range(600):
        world.step(1 / 240)
        assert world.energy().kinetic == pytest.approx(energy, rel=5e-4 if precision == "single" else 1e-12)


def test_a_kinematic_body_goes_its_way_whatever_it_meets(preset):
    world = ap.World(preset=preset)
    world.add(ap.Plane(normal=(0, 1, 0)))
    ram = world.add(ap.Box(size=(1, 1, 1)), position=(0, 0.6, 0), kind="kinematic", velocity=(2, 0, 0))
    box = world.add(ap.Box(size=(1, 1, 1)), position=(1.5, 0.5, 0), density=1e4)
    steps(world, 60)
    assert ram.velocity.tolist() == [2, 0, 0]
    assert ram.position == pytest.approx([2, 0.6, 0], abs=1e-6)
    assert box.position[0] > 2.9
    with pytest.raises(ap.InvalidArgumentError, match="kinematic"):
        ram.apply_force((1, 0, 0))


def test_a_moving_platform_carries_what_stands_on_it(preset):
    world = ap.World(preset=preset)
    platform = world.add(ap.Box(size=(4, 0.5, 4)), kind="kinematic", velocity=(1, 0.5, 0))
    box = world.add(ap.Box(size=(1, 1, 1)), position=(0, 0.75, 0), velocity=(1, 0.5, 0), friction=0.8)
    late = world.add(ap.Box(size=(0.5, 0.5, 0.5)), position=(-1, 0.5, 1), friction=0.8)  # must be brought up to speed
    steps(world, 120)
    assert box.velocity == pytest.approx(platform.velocity, abs=1e-3)
    assert late.velocity == pytest.approx(platform.velocity, abs=1e-3)
    assert box.position - platform.position == pytest.approx([0, 0.75, 0], abs=0.01)
    assert late.position[0] - platform.position[0] > -1.2


def test_a_turntable_carries_what_stands_on_it(preset):
    world = ap.World(preset=preset)
    table = world.add(ap.Cylinder(radius=3, length=0.5), kind="kinematic", angular_velocity=(0, 1, 0))
    box = world.add(
        ap.Box(size=(0.5, 0.5, 0.5)), position=(1, 0.5, 0), velocity=(0, 0, -1), angular_velocity=(0, 1, 0), friction=1
    )
    steps(world, 180)
    assert np.hypot(box.position[0], box.position[2]) == pytest.approx(1, abs=0.03)
    assert np.arctan2(-box.position[2], box.position[0]) == pytest.approx(3, abs=0.05)
    assert box.angular_velocity[1] == pytest.approx(1, abs=0.02)
    assert table.position.tolist() == [0, 0, 0]


def test_mass_does_not_matter_in_free_fall():
    world = ap.World(gravity=(1, -8, 3))
    for i, mass in enumerate((1e-6, 1, 1e6)):
        world.add(ap.Sphere(radius=0.5), position=(3 * i, 0, 0), mass=mass)
    steps(world, 30)
    assert (world.bodies.velocity == world.bodies.velocity[0]).all()


@pytest.mark.parametrize("threads", [1, 2])
def test_bodies_in_flight_move_alike_whether_or_not_others_touch(threads):
    """Where nothing touches, a step takes all substeps of a body at once."""

    def flight(others):
        world, rng = ap.World(threads=threads, sleeping=False), np.random.default_rng(4)
        for number in range(30):
            world.add(
                ap.Sphere(radius=0.3) if number % 2 else ap.Box(size=(0.2, 0.4, 0.6)),
                position=(3 * number, 0, 0),
                velocity=rng.normal(size=3),
                angular_velocity=5 * rng.normal(size=3),
                linear_damping=0.1 * (number % 3),
                angular_damping=0.2 * (number % 4),
                gravity_scale=number % 5 - 1,
                kind="kinematic" if number % 7 == 3 else "dynamic",
            )
        if others:
            world.add(ap.Box(size=(9, 1, 9)), position=(0, 0, 500), kind="static")
            world.add(ap.Box(size=(1, 1, 1)), position=(0, 1, 500))
        world.run(1)
        assert (len(world.contacts) > 0) == others
        bodies = world.bodies
        return [
            column[:30].copy()
            for column in (bodies.position, bodies.orientation, bodies.velocity, bodies.angular_velocity)
        ]

    for alone, beside in zip(flight(others=False), flight(others=True), strict=True):
        np.testing.assert_array_equal(alone, beside)
