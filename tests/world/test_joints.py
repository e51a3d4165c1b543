"""Joints in worlds: closed forms, conservation, bits, errors, and what handles say."""

import copy
import math
import pickle
import random

import numpy as np
import pytest
from scipy.special import ellipk

import atlasphys as ap

SOLVERS = ("soft_step", "sequential_impulse", "xpbd", "avbd")
GRAVITY = 9.81


def chain(solver="soft_step", links=6, **settings):
    world = ap.World(solver=solver, **settings)
    before = None
    for k in range(links):
        body = world.add(ap.Capsule(radius=0.05, length=0.3), position=(0, -0.2 - 0.4 * k, 0), mass=1)
        world.join(ap.Ball(before, body, anchor=(0, -0.4 * k, 0)))
        before = body
    return world


def bodies(world, count=2, mass=1.0):
    return [world.add(ap.Box(size=(1, 0.5, 0.3)), position=(1.2 * k, 0, 0), mass=mass) for k in range(count)]


# Closed forms ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "solver"),
    [
        ("hinge", "soft_step"),
        ("ball", "soft_step"),
        ("rod", "soft_step"),
        ("hinge", "xpbd"),
        ("hinge", "avbd"),
        ("rod", "avbd"),
    ],
)
def test_a_pendulum_has_its_period(kind, solver):
    """T = 4 √(I / (m g d)) K(sin²(θ₀/2)), of a rod of 1 m that swings through 1 rad."""
    precision = "single" if solver == "xpbd" else "double"
    world = ap.World(solver=solver, precision=precision, sleeping=False)
    start = 1.0
    where = (0.5 * math.sin(start), -0.5 * math.cos(start), 0)
    turned = (math.cos(start / 2), 0, 0, math.sin(start / 2))
    body = world.add(
        ap.Box(size=(0.05, 1, 0.05)), position=where, orientation=turned, mass=2, inertia=(0.2, 0.001, 0.2)
    )
    inertia = 0.2 + 2 * 0.25
    if kind == "hinge":
        world.join(ap.Hinge(None, body, anchor=(0, 0, 0), axis=(0, 0, 1)))
    elif kind == "ball":
        world.join(ap.Ball(None, body, anchor=(0, 0, 0)))
    else:
        world = ap.World(solver=solver, precision=precision, sleeping=False)
        body = world.add(ap.Sphere(radius=0.1), position=where, mass=2)
        world.join(ap.Distance(None, body))
        inertia = 2 * 0.25
    period = 4 * math.sqrt(inertia / (2 * GRAVITY * 0.5)) * ellipk(math.sin(start / 2) ** 2)
    crossings, h, before = [], 1 / 480, where[0]
    while len(crossings) < 4:
        world.step(h)
        now = body.position[0]
        if before * now < 0:
            crossings.append(world.time - h * now / (now - before))
        before = now
    assert (crossings[3] - crossings[1]) == pytest.approx(period, rel=1e-3)


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_hanging_chain_bears_the_weight_below(solver):
    world = chain(solver)
    world.run(3)
    for k, joint in enumerate(world.joints):
        assert joint.reaction_force == pytest.approx([0, GRAVITY * (6 - k), 0], abs=0.01 * GRAVITY * (6 - k))
    assert np.array_equal(world.joints.reaction_force[2], world.joints[2].reaction_force)


def test_avbd_holds_a_heavy_ball_on_a_light_chain():
    """A hundredfold weight on a chain of ten that falls from the horizontal, jerks and swings: no stretch to be seen, and no energy gained."""
    world = ap.World(solver="avbd", sleeping=False)
    before, lying = None, (1, 0, 0, 1)
    for k in range(10):
        link = world.add(ap.Capsule(radius=0.05, length=0.3), position=(0.2 + 0.4 * k, 0, 0), orientation=lying, mass=1)
        world.join(ap.Ball(before, link, anchor=(0.4 * k, 0, 0)))
        before = link
    ball = world.add(ap.Sphere(radius=0.3), position=(4.3, 0, 0), mass=100)
    world.join(ap.Ball(before, ball, anchor=(4, 0, 0)))
    start, worst, most = world.energy().total, 0.0, 0.0
    for _ in range(240):
        world.step(1 / 60)
        worst = max(worst, *(np.abs(np.subtract(*joint.anchors)).max() for joint in world.joints))
        most = max(most, world.energy().total - start)
    assert worst < 1e-3
    assert most < 0.02 * 110 * GRAVITY * 4


@pytest.mark.parametrize(("frequency", "damping"), [(2.0, 0.1), (5.0, 0.02), (1.0, 0.5)])
def test_a_spring_swings_and_decays_as_it_should(frequency, damping):
    world = ap.World(gravity=(0, 0, 0), precision="double", sleeping=False)
    body = world.add(ap.Sphere(radius=0.1), position=(1.5, 0, 0), mass=3)
    joint = world.join(ap.Spring(None, body, frequency=frequency, damping=damping, rest_length=1))
    h, steps = 1 / 240, int(240 * 2 / frequency)
    stretch = []
    for _ in range(steps):
        world.step(h)
        stretch.append(joint.distance - 1)
    omega = 2 * math.pi * frequency
    swing = omega * math.sqrt(1 - damping**2)
    time = h * np.arange(1, steps + 1)
    exact = (
        0.5 * np.exp(-damping * omega * time) * (np.cos(swing * time) + damping * omega / swing * np.sin(swing * time))
    )
    assert np.abs(np.array(stretch) - exact).max() < 0.02 * 0.5
    tops = [k for k in range(1, steps - 1) if stretch[k - 1] < stretch[k] > stretch[k + 1]]
    if len(tops) > 1:
        decrement = math.log(stretch[tops[0]] / stretch[tops[1]])
        assert decrement == pytest.approx(2 * math.pi * damping / math.sqrt(1 - damping**2), rel=0.01)


@pytest.mark.parametrize("damping", [0.0, 0.7, 3.0])
def test_a_loaded_spring_stretches_by_hookes_law(damping):
    world = ap.World(sleeping=False)
    body = world.add(ap.Box(size=(0.3, 0.3, 0.3)), mass=2)
    joint = world.join(ap.Slider(None, body, axis=(0, 1, 0), spring=ap.Elastic(frequency=2, damping=damping)))
    if damping == 0:
        body.position = (0, -GRAVITY / (4 * math.pi) ** 2, 0)
    world.run(10)
    assert joint.translation == pytest.approx(-GRAVITY / (4 * math.pi) ** 2, rel=2e-3)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("damping", [0.05, 1.0])
def test_springs_on_vectors_swing_and_decay_as_they_should(damping, solver):
    """A body that is dragged along x, one that is softly welded to the world and let go turned, and two that are welded to each other."""
    world = ap.World(solver=solver, gravity=(0, 0, 0), sleeping=False)
    dragged = world.add(ap.Box(size=(0.4, 0.2, 0.3)), mass=3)
    world.join(ap.Target(None, dragged, target=(-0.5, 0, 0), frequency=2, damping=damping))
    spring = ap.Elastic(frequency=2, damping=damping)
    welded = world.add(ap.Box(size=(0.4, 0.2, 0.3)), position=(3, 0, 0), mass=2)
    world.join(ap.Fixed(None, welded, spring=spring))
    welded.orientation = (math.cos(0.1), 0, 0, math.sin(0.1))
    pair = [world.add(ap.Sphere(radius=0.1), position=(x, 0, 0), mass=m) for x, m in ((6, 1), (7, 4))]
    world.join(ap.Fixed(*pair, anchor=(6.8, 0, 0), spring=spring))
    pair[0].position, pair[1].position = (5.6, 0, 0), (7.1, 0, 0)
    h, omega = 1 / 240, 4 * math.pi
    swing = omega * math.sqrt(abs(1 - damping**2))
    found, exact = [], []
    for step in range(1, 241):
        world.step(h)
        w, _, _, z = welded.orientation
        found.append((dragged.position[0] + 0.5, 2 * math.atan2(z, w), pair[1].position[0] - pair[0].position[0] - 1))
        t = h * step
        bent = t if damping == 1 else math.sin(swing * t) / swing
        even = 1 if damping == 1 else math.cos(swing * t)
        exact.append(np.array([0.5, 0.2, 0.5]) * math.exp(-damping * omega * t) * (even + damping * omega * bent))
    assert np.abs(np.array(found) - np.array(exact)).max(axis=0) == pytest.approx(0, abs=0.02)


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_soft_weld_gives_way_and_a_target_pulls_no_harder_than_it_may(solver):
    world = ap.World(solver=solver, sleeping=False)
    shelf = world.add(ap.Box(size=(1, 0.1, 0.1)), position=(0.5, 0, 0), mass=2)
    weld = world.join(ap.Fixed(None, shelf, anchor=(0, 0, 0), spring=ap.Elastic(frequency=4, damping=1)))
    load = world.add(ap.Sphere(radius=0.1), position=(5, 0, 0), mass=2)
    pull = world.join(ap.Target(None, load, target=(5, 9, 0), frequency=5, damping=1, max_force=GRAVITY))
    world.run(1.5)
    assert load.velocity[1] == pytest.approx(-0.5 * GRAVITY * 1.5, rel=0.01)
    assert pull.reaction_force == pytest.approx([0, GRAVITY, 0], abs=0.01 * GRAVITY)
    assert -0.5 < shelf.position[1] < -0.005
    assert np.abs(shelf.velocity).max() < 0.01
    assert weld.reaction_force == pytest.approx([0, 2 * GRAVITY, 0], abs=0.02 * GRAVITY)


def test_a_force_limited_motor_gives_its_torque_and_then_its_speed():
    world = ap.World(gravity=(0, 0, 0), sleeping=False)
    body = world.add(ap.Box(size=(1, 1, 1)), mass=6)
    joint = world.join(ap.Hinge(None, body, axis=(0, 0, 1), motor=ap.Motor(speed=3, max_force=2)))
    world.run(1)
    assert body.angular_velocity[2] == pytest.approx(2, rel=1e-5)  # α = τ / I, I = 1
    assert joint.motor_force == pytest.approx(2, rel=1e-5)
    assert joint.reaction_torque == pytest.approx([0, 0, 2], abs=1e-4)
    world.run(1)
    assert joint.speed == pytest.approx(3, rel=1e-5)
    joint.motor = ap.Motor(position=1.0)
    world.run(3)
    assert joint.angle == pytest.approx(1, abs=1e-4)


def test_friction_stops_a_hinge_and_holds_less_than_its_torque():
    world = ap.World(gravity=(0, 0, 0), sleeping=False)
    body = world.add(ap.Box(size=(1, 1, 1)), mass=6, angular_velocity=(0, 0, 2))
    joint = world.join(ap.Hinge(None, body, axis=(0, 0, 1), friction=1))
    world.run(1)
    assert body.angular_velocity[2] == pytest.approx(1, rel=1e-4)
    world.run(2)
    assert abs(joint.speed) < 1e-6


@pytest.mark.parametrize("solver", ["xpbd", "avbd"])
def test_reactions_springs_and_motors_in_balance(solver):
    """A cantilever shows its weight and moment, a damped spring hangs at F / k, and a slider's motor holds what it can and gives way else."""
    world = ap.World(solver=solver, sleeping=False)
    beam = world.add(ap.Box(size=(1, 0.1, 0.1)), position=(0.5, 0, 0), mass=2)
    fixed = world.join(ap.Fixed(None, beam, anchor=(0, 0, 0)))
    weight = world.add(ap.Sphere(radius=0.1), position=(5, -1, 0), mass=3)
    spring = world.join(
        ap.Spring(None, weight, anchor_a=(5, 0, 0), anchor_b=(0, 0, 0), frequency=2, damping=0.7, rest_length=1)
    )
    lift, slack = (world.add(ap.Sphere(radius=0.1), position=(x, 0, 0), mass=1) for x in (-5, -7))
    motors = [
        world.join(ap.Slider(None, body, axis=(0, 1, 0), motor=ap.Motor(speed=0.5, max_force=force)))
        for body, force in ((lift, 20), (slack, 0.75 * GRAVITY))
    ]
    world.run(3)
    assert fixed.reaction_force == pytest.approx([0, 2 * GRAVITY, 0], abs=0.02 * GRAVITY)
    assert fixed.reaction_torque == pytest.approx([0, 0, GRAVITY], abs=0.01 * GRAVITY)
    assert spring.distance == pytest.approx(1 + GRAVITY / (4 * math.pi) ** 2, rel=1e-3)
    assert spring.reaction_force[1] == pytest.approx(3 * GRAVITY, rel=0.01)
    assert lift.velocity[1] == pytest.approx(0.5, rel=1e-3)
    assert motors[0].motor_force == pytest.approx(GRAVITY, rel=0.01)
    assert slack.velocity[1] == pytest.approx(-0.25 * GRAVITY * 3, rel=1e-3)


@pytest.mark.parametrize("solver", SOLVERS)
def test_limits_hold(solver):
    world = ap.World(solver=solver)
    body = world.add(ap.Box(size=(1, 0.1, 0.1)), position=(0.5, 0, 0), mass=1)
    hinge = world.join(ap.Hinge(None, body, anchor=(0, 0, 0), axis=(0, 0, 1), limits=(-0.5, 0.3)))
    other = world.add(ap.Capsule(radius=0.1, length=1), position=(9, -0.7, 0), angular_velocity=(4, 5, 0))
    ball = world.join(ap.Ball(None, other, anchor=(9, 0, 0), axis=(0, -1, 0), cone=0.5, twist=(-0.3, 0.3)))
    rope_end = world.add(ap.Sphere(radius=0.1), position=(-9, -1, 0))
    rope = world.join(ap.Distance(None, rope_end, anchor_a=(-9, 0, 0), limits=(0, 2)))
    world.run(4)
    assert hinge.angle == pytest.approx(-0.5, abs=2e-3)
    assert hinge.reaction_torque[2] == pytest.approx(0.5 * GRAVITY * math.cos(0.5), rel=0.01)
    assert ball.swing < 0.51
    assert abs(ball.coordinate("twist")) < 0.31
    assert rope.distance == pytest.approx(2, abs=2e-3)


def test_couplings_keep_their_ratios():
    world = ap.World(gravity=(0, 0, 0), sleeping=False)
    lying = (1, 1, 0, 0)
    a = world.add(ap.Cylinder(radius=0.2, length=0.1), orientation=lying, mask=0)
    b = world.add(ap.Cylinder(radius=0.1, length=0.1), position=(0.3, 0, 0), orientation=lying, mask=0)
    rack = world.add(ap.Box(size=(2, 0.1, 0.1)), position=(0, -0.25, 0), mask=0)
    hinges = [world.join(ap.Hinge(None, body, axis=(0, 0, 1))) for body in (a, b)]
    slider = world.join(ap.Slider(None, rack, axis=(1, 0, 0)))
    world.join(ap.Gear(a, b, axis_a=(0, 0, 1), axis_b=(0, 0, 1), ratio=2))
    world.join(ap.RackPinion(a, rack, axis=(0, 0, 1), direction=(1, 0, 0), radius=0.2))
    a.angular_velocity = (0, 0, 3)
    world.run(1)
    assert hinges[0].angle > 0.3
    assert hinges[1].angle == pytest.approx(-2 * hinges[0].angle, abs=1e-4)
    assert slider.translation == pytest.approx(0.2 * hinges[0].angle, abs=1e-4)


def test_a_pulley_is_atwoods_machine():
    world = ap.World(sleeping=False)
    a = world.add(ap.Sphere(radius=0.1), mass=1)
    b = world.add(ap.Sphere(radius=0.1), position=(1, 0, 0), mass=3)
    rope = world.join(ap.Pulley(a, b, ground_a=(0, 5, 0), ground_b=(1, 5, 0)))
    world.run(0.5)
    assert a.velocity[1] == pytest.approx(GRAVITY / 4, rel=1e-3)
    assert rope.reaction_force[1] == pytest.approx(1.5 * GRAVITY, rel=1e-3)


def test_parts_of_one_type_of_one_joint_do_not_see_each_others_impulses_half_applied():
    world = ap.World()
    body = world.add(ap.Box(size=(1, 0.5, 0.3)), velocity=(1, 0, 0), angular_velocity=(2, 1, 1))
    joint = world.join(ap.SixDof(None, body, x=(-2, 2), y=(-0.5, 0.5), rx="free", ry=(-0.2, 0.2)))
    world.run(3)
    assert joint.coordinate("y") == pytest.approx(-0.5, abs=1e-3)
    assert joint.coordinate("x") == pytest.approx(2, abs=1e-3)
    assert abs(joint.coordinate("z")) < 1e-3
    assert abs(joint.coordinate("ry")) < 0.21


# Laws -----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("solver", ["soft_step", "avbd"])
@pytest.mark.parametrize("kind", ["ball", "hinge", "fixed", "slider", "universal", "distance"])
def test_momenta_are_kept_in_zero_gravity(kind, solver):
    world = ap.World(solver=solver, gravity=(0, 0, 0), precision="double", sleeping=False)
    a, b = bodies(world)
    made = {
        "ball": ap.Ball(a, b, anchor=(0.6, 0, 0)),
        "hinge": ap.Hinge(a, b, anchor=(0.6, 0, 0), axis=(0, 0, 1)),
        "fixed": ap.Fixed(a, b, anchor=(0.6, 0, 0)),
        "slider": ap.Slider(a, b, axis=(1, 0, 0)),
        "universal": ap.Universal(a, b, anchor=(0.6, 0, 0), axis=(0, 1, 0), axis_b=(0, 0, 1)),
        "distance": ap.Distance(a, b, anchor_a=(0.5, 0.2, 0), anchor_b=(-0.5, 0.1, 0)),
    }
    world.join(made[kind])
    a.angular_velocity, b.velocity = (0.3, 0.2, 1.0), (0.2, 1.0, 0.1)
    momentum, spin = world.momentum(), world.angular_momentum()
    world.run(5)
    assert np.abs(world.momentum() - momentum).max() < 1e-12
    assert np.abs(world.angular_momentum() - spin).max() < 0.01 * np.linalg.norm(spin)


@pytest.mark.parametrize(("kind", "lost"), [("ball", 0.002), ("hinge", 0.002), ("distance", 0.01)])
def test_avbd_keeps_the_energy_of_what_tumbles_slowly(kind, lost):
    """Ten links that tumble without gravity for ten seconds."""
    number = random.Random(5).random
    world = ap.World(solver="avbd", gravity=(0, 0, 0))
    above = None
    for k in range(10):
        speeds = [[2 * number() - 1 for _ in range(3)] for _ in range(2)]
        link = world.add(ap.Capsule(radius=0.1, length=0.3), position=(0, -0.5 * k, 0), mass=1, mask=0)
        link.velocity, link.angular_velocity = speeds
        at = (0, -0.5 * k + 0.25, 0)
        if above is not None:
            made = {
                "ball": ap.Ball(above, link, anchor=at),
                "hinge": ap.Hinge(above, link, anchor=at, axis=(0, 0, 1) if k % 2 else (1, 0, 0)),
                "distance": ap.Distance(above, link, anchor_a=(0, -0.1, 0), anchor_b=(0, 0.1, 0)),
            }
            world.join(made[kind])
        above = link
    world.run(1)
    start = world.energy().kinetic
    world.run(10)
    assert world.energy().kinetic == pytest.approx(start, rel=lost)


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_driven_crank_keeps_its_rate_under_load(solver):
    """A motor that lifts and lowers a weight at the end of a bar that hangs on the crank: the angle is that of the motor's speed."""
    world = ap.World(solver=solver, sleeping=False)
    crank = world.add(ap.Box(size=(0.5, 0.1, 0.1)), position=(0.25, 0, 0), angular_velocity=(0, 0, 4), mass=1, mask=0)
    bar = world.add(ap.Box(size=(0.1, 1, 0.1)), position=(0.5, -0.5, 0), velocity=(0, 2, 0), mass=5, mask=0)
    drive = world.join(ap.Hinge(None, crank, anchor=(0, 0, 0), axis=(0, 0, 1), motor=ap.Motor(speed=4)))
    world.join(ap.Hinge(crank, bar, anchor=(0.5, 0, 0), axis=(0, 0, 1)))
    angle = worst = 0.0
    for step in range(1, 181):
        world.step(1 / 240)
        angle += math.remainder(drive.angle - angle, 2 * math.pi)
        worst = max(worst, abs(angle - 4 * step / 240))
    assert worst < 0.004


@pytest.mark.parametrize("solver", SOLVERS)
def test_absurd_errors_are_taken_back_without_an_explosion(solver):
    world = ap.World(solver=solver, gravity=(0, 0, 0))
    a, b = bodies(world)
    for joint in (ap.Ball(a, b, anchor_a=(0, 0, 0), anchor_b=(40, 30, 0)), ap.Fixed(a, b)):
        world.join(joint)
    b.orientation = (0, 1, 0.2, 0.1)
    worst = 0.0
    for _ in range(600):
        world.step(1 / 60)
        worst = max(worst, world.energy().kinetic)
    assert np.isfinite(world.bodies.position).all()
    assert worst < 1e5


# Bits -----------------------------------------------------------------------------------------------------------------


def net(threads=1):
    """A net large enough to be shared by threads, which falls on a ball."""
    world = ap.World(threads=threads)
    world.add(ap.Sphere(radius=2), position=(6, -3, 6), kind="static")
    rows = []
    for i in range(14):
        rows.append([world.add(ap.Sphere(radius=0.3), position=(i, 0, k)) for k in range(14)])
        for k in range(14):
            if i:
                world.join(ap.Ball(rows[i - 1][k], rows[i][k], anchor=(i - 0.5, 0, k)))
            if k:
                world.join(ap.Hinge(rows[i][k - 1], rows[i][k], anchor=(i, 0, k - 0.5), axis=(1, 0, 0)))
    return world


def test_the_bits_do_not_depend_on_the_number_of_threads():
    hashes = []
    for threads in (1, 2):
        world = net(threads)
        world.run(0.5)
        hashes.append(world.state_hash())
    assert hashes[0] == hashes[1]


@pytest.mark.parametrize("solver", SOLVERS)
def test_snapshots_copies_and_pickles_go_on_alike(solver):
    world = chain(solver)
    world.bodies.velocity[:] = [[0.3, 0, 0.1 * k] for k in range(6)]
    world.run(0.3)
    state, copied, pickled = world.snapshot(), copy.deepcopy(world), pickle.loads(pickle.dumps(world))
    world.run(0.3)
    expected = world.state_hash()
    world.restore(state)
    for other in (world, copied, pickled):
        other.run(0.3)
        assert other.state_hash() == expected
    assert state.__repr__().startswith("<Snapshot")


@pytest.mark.parametrize("solver", SOLVERS[:2])  # the others come through this
def test_a_step_that_fails_leaves_the_joints_as_they_were(solver):
    world = chain(solver)
    world.bodies.velocity[:] = (0.3, 0, 0.1)
    world.run(0.2)
    speck = world.add(ap.Sphere(radius=1e-3), position=(5, 0, 0), mass=1e-9)
    speck.apply_torque((1e9, 1e9, 1e9))
    before = world.state_hash()
    with pytest.raises(ap.DivergenceError):
        for _ in range(5):
            before = world.state_hash()
            world.step(10.0)
            speck.apply_torque((1e9, 1e9, 1e9))
    assert world.state_hash() == before


# Sleep, collision, breaking, removal ----------------------------------------------------------------------------------


def test_joined_bodies_sleep_and_wake_together():
    world = ap.World()
    world.add(ap.Plane())
    a = world.add(ap.Box(size=(1, 1, 1)), position=(0, 0.5, 0))
    b = world.add(ap.Box(size=(1, 1, 1)), position=(3, 0.5, 0))
    joint = world.join(ap.Distance(a, b))
    world.run(2)
    assert a.asleep
    assert b.asleep
    kept = world.state_hash(), joint.reaction_force
    world.run(1)
    assert np.array_equal(joint.reaction_force, kept[1])
    a.wake()
    assert not b.asleep
    world.run(2)
    joint.length = 4
    assert not a.asleep
    world.run(2)
    assert joint.distance == pytest.approx(4, abs=1e-2)


@pytest.mark.parametrize("solver", SOLVERS)
def test_joined_bodies_collide_only_if_asked_to(solver):
    world = ap.World(solver=solver, gravity=(0, 0, 0))
    a, b = bodies(world)
    b.position = (0.5, 0, 0)
    joint = world.join(ap.Ball(a, b, anchor=(0.25, 0, 0)))
    world.step(1 / 60)
    assert len(world.contacts) == 0
    joint.collide = True
    world.step(1 / 60)
    assert len(world.contacts) > 0
    joint.collide = False
    world.step(1 / 60)
    assert len(world.contacts) == 0


@pytest.mark.parametrize("solver", SOLVERS)
def test_joints_break_with_an_event(solver):
    world = ap.World(solver=solver)
    body = world.add(ap.Sphere(radius=0.1), position=(0, -1, 0), mass=2)
    joint = world.join(ap.Distance(None, body, breaking_force=30))
    world.run(1)
    assert not joint.broken
    body.apply_force((0, -20, 0))
    world.step(1 / 60)
    assert [(event.kind, event.joint, event.a, event.b) for event in world.events] == [
        ("joint_break", joint, None, body)
    ]
    assert joint.broken
    world.step(1 / 60)
    assert world.events == []
    height = body.position[1]
    world.run(0.5)
    assert body.position[1] < height - 1
    joint.broken = False
    world.run(0.1)
    assert not joint.enabled or joint.broken  # far too long now: it breaks again


def test_removal():
    world = chain()
    joints, first, third = list(world.joints), world.bodies[0], world.bodies[2]
    world.run(0.2)
    world.remove(joints[0])
    assert len(world.joints) == 5
    with pytest.raises(ap.RemovedJointError):
        _ = joints[0].enabled
    assert repr(joints[0]) == "<Joint: removed>"
    world.remove(third)
    assert [joint.row for joint in (joints[1], joints[4], joints[5])] == [0, 1, 2]
    with pytest.raises(ap.RemovedJointError):
        _ = joints[2].row
    assert world.joints.bodies.tolist() == [[0, 1], [2, 3], [3, 4]]
    world.run(0.5)
    assert first.velocity[1] == pytest.approx(-GRAVITY * 0.5, rel=1e-3)
    with pytest.raises(ap.RemovedJointError):
        world.remove(joints[0])


def test_disabled_joints_do_nothing():
    world = ap.World()
    body = world.add(ap.Sphere(radius=0.1))
    joint = world.join(ap.Ball(None, body))
    world.run(0.1)
    joint.enabled = False
    world.run(0.5)
    assert body.velocity[1] == pytest.approx(-GRAVITY * 0.5, rel=1e-3)
    joint.enabled = True
    world.run(3)
    assert np.abs(joint.anchors[1]).max() < 1e-3


# Handles and errors ---------------------------------------------------------------------------------------------------


def test_handles_say_what_the_joint_is():
    world = ap.World()
    a, b = bodies(world)
    hinge = world.join(ap.Hinge(a, b, anchor=(0.6, 0, 0), axis=(0, 0, 2), limits=(-1, 1)), name="elbow")
    assert repr(hinge) == "<Joint 'elbow': Hinge of body 0 to body 1>"
    assert (hinge.a, hinge.b, hinge.name, world.joints["elbow"], world.joints[0]) == (a, b, "elbow", hinge, hinge)
    assert world.joints[:] == list(world.joints) == [hinge]
    b.orientation = (math.cos(0.2), 0, 0, math.sin(0.2))
    b.angular_velocity = (0, 0, 3)
    assert hinge.angle == pytest.approx(0.4, abs=1e-6)
    assert hinge.speed == pytest.approx(3, abs=1e-6)
    hinge.motor = ap.Motor(speed=1)
    hinge.motor_speed = 2
    hinge.change(friction=3, limits=None)
    assert (hinge.motor_speed, hinge.friction, hinge.limits, hinge.motor_max_force) == (2, 3, None, math.inf)
    hinge.motor_position = 0.3
    assert hinge.motor_position == 0.3
    with pytest.raises(ap.InvalidArgumentError, match="no speed"):
        _ = hinge.motor_speed
    with pytest.raises(AttributeError, match="a Hinge has no cone"):
        _ = hinge.cone
    with pytest.raises(AttributeError, match="no coordinate 'translation'"):
        _ = hinge.translation
    before = hinge.settings
    with pytest.raises(ap.InvalidArgumentError, match="limits"):
        hinge.limits = (2, 1)
    assert hinge.settings == before


def bad_joints(a, b):
    other = ap.World().add(ap.Sphere(radius=1))
    fixed = a.world.add(ap.Plane())
    removed = a.world.add(ap.Sphere(radius=1))
    a.world.remove(removed)
    nan = math.nan
    return [
        (lambda: ap.Ball(a, a), "two different bodies"),
        (lambda: ap.Ball(None, None), "both None"),
        (lambda: ap.Ball(fixed, None), "dynamic"),
        (lambda: ap.Ball(a, other), "another one"),
        (lambda: ap.Ball(a, 3), "must be a body"),
        (lambda: ap.Ball(a, removed), "no longer"),
        (lambda: ap.Ball(a, b, anchor=(0, nan, 0)), r"anchor\[1\]"),
        (lambda: ap.Ball(a, b, anchor=(0, 1)), "anchor"),
        (lambda: ap.Ball(a, b, anchor_a=(0, 0, 0)), "both or neither"),
        (lambda: ap.Ball(a, b, anchor=(0, 0, 0), anchor_a=(0, 0, 0), anchor_b=(0, 0, 0)), "twice"),
        (lambda: ap.Ball(a, b, cone=1), "needs an axis"),
        (lambda: ap.Ball(a, b, axis=(1, 0, 0), cone=4), "cone"),
        (lambda: ap.Ball(a, b, axis=(1, 0, 0), twist=(1, -1)), "twist"),
        (lambda: ap.Hinge(a, b), "needs an axis"),
        (lambda: ap.Hinge(a, b, axis=(0, 0, 0)), "not zero"),
        (lambda: ap.Hinge(a, b, axis=(0, 0, 1), limits=(1, -1)), "in order"),
        (lambda: ap.Hinge(a, b, axis=(0, 0, 1), friction=-1), "friction"),
        (lambda: ap.Hinge(a, b, axis=(0, 0, 1), motor=3), "Motor"),
        (
            lambda: ap.Hinge(a, b, axis=(0, 0, 1), motor=ap.Motor(position=1), spring=ap.Elastic(frequency=1)),
            "one of the two",
        ),
        (lambda: ap.Hinge(a, b, axis=(0, 0, 1), breaking_force=nan), "breaking_force"),
        (lambda: ap.Hinge(a, b, axis=(0, 0, 1), collide=1), "collide"),
        (lambda: ap.Fixed(a, b, frame_a=(0, 0, 0, 0), frame_b=(1, 0, 0, 0)), "frame_a"),
        (lambda: ap.Slider(a, b, axis=(0, 0, 1), frame_a=(1, 0, 0, 0), frame_b=(1, 0, 0, 0)), "twice"),
        (lambda: ap.Motor(), "either"),
        (lambda: ap.Motor(speed=1, position=1), "either"),
        (lambda: ap.Elastic(frequency=0), "frequency"),
        (lambda: ap.Distance(a, b, anchor_a=(1.2, 0, 0)), "same place"),
        (lambda: ap.Distance(a, b, length=1, limits=(0, 1)), "not both"),
        (lambda: ap.Distance(a, b, length=0), "length"),
        (lambda: ap.Distance(a, b, limits=(0, 0)), "limits"),
        (lambda: ap.Distance(a, b, limits=3), "limits"),
        (lambda: ap.Spring(a, b, frequency=-1), "frequency"),
        (lambda: ap.Universal(a, b, axis=(1, 0, 0), axis_b=(2, 0, 0)), "parallel"),
        (lambda: ap.Universal(a, b, axis=(1, 0, 0)), "axis_b"),
        (lambda: ap.Wheel(a, b, axis=(0, 1, 0), axle=(0, -3, 0)), "parallel"),
        (lambda: ap.Wheel(a, b, axis=(0, 1, 0), axle=(1, 0, 0), motor=ap.Motor(position=0)), "speed"),
        (lambda: ap.SixDof(a, b, x="loose"), "free"),
        (lambda: ap.SixDof(a, b, springs={"x": ap.Elastic(frequency=1)}), "not locked"),
        (lambda: ap.Gear(a, b, axis_a=(1, 0, 0)), "axis_b"),
        (lambda: ap.Gear(a, b, axis_a=(1, 0, 0), axis_b=(1, 0, 0), ratio=0), "ratio"),
        (lambda: ap.RackPinion(a, b, axis=(1, 0, 0), direction=(1, 0, 0), radius=-1), "radius"),
        (lambda: ap.Pulley(a, b, ground_a=(0, 0, 0), ground_b=(0, 3, 0)), "no length"),
        (lambda: ap.Target(a, b), "world"),
        (lambda: "hinge", "must be a joint"),
    ]


@pytest.mark.parametrize("number", range(44))
def test_what_cannot_be_joined_is_refused(number):
    world = ap.World()
    a, b = bodies(world)
    cases = bad_joints(a, b)
    assert len(cases) == 44
    make, message = cases[number]
    before = world.state_hash()
    with pytest.raises(ap.AtlasPhysError, match=message):
        world.join(make())
    assert world.state_hash() == before
    assert len(world.joints) == 0


def test_names_of_joints_are_unique():
    world = ap.World()
    a, b = bodies(world)
    world.join(ap.Ball(a, b), name="x")
    with pytest.raises(ap.InvalidArgumentError, match="already taken"):
        world.join(ap.Ball(a, b), name="x")
    with pytest.raises(ap.InvalidArgumentError, match="non-empty"):
        world.join(ap.Ball(a, b), name="")
