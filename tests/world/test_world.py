import itertools

import numpy as np
import pytest

import atlasphys as ap
from atlasphys.engine.step import STAGES
from tests.world.scenes import stack, steps


def test_the_example_of_the_design_works_as_written():
    world = ap.World(gravity=(0, -9.81, 0), narrowphase="gjk_epa", broadphase="sweep", threads=1, precision="single")
    ground = world.add(ap.Plane(normal=(0, 1, 0)))
    ball = world.add(ap.Sphere(radius=0.5), position=(0, 3, 0), density=1000, restitution=0.8, friction=0.5)
    crate = world.add(ap.Box(size=(1, 1, 1)), position=(3, 0.5, 0), mass=10, orientation=(1, 0, 0, 0), name="crate")
    assert (ground.kind, ball.kind, crate.kind) == ("static", "dynamic", "dynamic")
    world.step(1 / 60)
    world.run(seconds=0.5, dt=1 / 60)
    assert world.steps == 31
    assert world.time == pytest.approx(31 / 60)
    ball.velocity = (1, 0, 0)
    assert ball.velocity.tolist() == [1, 0, 0]
    ball.apply_force((0, 5, 0), at=None)
    ball.apply_impulse((0, 1, 0))
    ball.apply_torque((0, 1, 0))
    world.bodies.position[:, 0] += 1
    world.step(1 / 60)
    assert crate.position[0] == pytest.approx(4, abs=1e-3)
    assert {"body_a", "body_b", "point", "normal", "depth", "normal_impulse", "friction_impulse"} <= set(
        world.contacts.dtype.names
    )
    assert world.energy().total == world.energy().kinetic + world.energy().potential
    assert world.momentum().shape == world.angular_momentum().shape == (3,)
    assert list(world.profile) == list(STAGES)
    assert sum(world.profile.values()) > 0
    state = world.snapshot()
    before = world.state_hash()
    world.step(1 / 60)
    assert world.state_hash() != before
    world.restore(state)
    assert world.state_hash() == before
    world.remove(crate)
    with pytest.raises(ap.RemovedBodyError):
        _ = crate.position


def test_presets():
    for world in (ap.World(), ap.World(preset="default")):
        assert (world.solver, world.narrowphase, world.broadphase) == ("soft_step", "auto", "tree")
        assert (world.substeps, world.threads, world.sleeping, world.precision) == (4, 1, True, "single")
    world = ap.World(preset="classic")
    assert (world.solver, world.narrowphase, world.broadphase) == ("sequential_impulse", "gjk_epa", "sweep")
    assert world.solver_settings.position_correction == "projection"
    assert (world.substeps, world.threads, world.sleeping, world.precision) == (1, 1, False, "single")
    assert ap.World(preset="classic", broadphase="brute").broadphase == "brute"


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ({"solver": "magic"}, "'sequential_impulse'"),
        ({"broadphase": "octree"}, "'sweep'"),
        ({"narrowphase": "mpr"}, "'gjk_epa'"),
        ({"preset": "magic"}, "'classic'"),
        ({"precision": "half"}, "'double'"),
        ({"friction_combine": "sum"}, "'average'"),
        ({"restitution_combine": 3}, "'max'"),
        ({"preset": "classic", "position_correction": "none"}, "projection"),
        ({"position_correction": "projection"}, "sequential_impulse"),
        ({"preset": "classic", "threads": 2}, "must be 1"),
        ({"threads": 0}, "from 1"),
        ({"threads": True}, "from 1"),
        ({"preset": "classic", "sleeping": True}, "False"),
        ({"sleeping": 1}, "True or False"),
        ({"preset": "classic", "substeps": 4}, "1"),
        ({"substeps": 0}, "from 1"),
        ({"solver": ap.SoftStep(), "substeps": 4}, "given twice"),
        ({"solver": ap.SequentialImpulse(), "position_correction": "baumgarte"}, "given twice"),
    ],
)
def test_what_does_not_exist_is_refused_by_naming_what_does(arguments, named):
    with pytest.raises(ap.InvalidArgumentError, match=named):
        ap.World(**arguments)


def test_an_empty_world_steps():
    world = ap.World()
    steps(world, 2)
    assert len(world.bodies) == len(world.contacts) == len(world.events) == 0
    assert world.energy() == (0, 0)
    assert world.momentum().tolist() == world.angular_momentum().tolist() == [0, 0, 0]
    world.add(ap.Plane(normal=(0, 1, 0)))
    steps(world, 2)


def test_settings_change_between_steps():
    world = stack(1)
    world.gravity = (1, 0, 0)
    world.broadphase = "brute"
    world.solver = ap.SequentialImpulse(iterations=5, position_correction="baumgarte")
    world.friction_combine, world.restitution_combine, world.restitution_threshold = "min", "average", 0.25
    assert world.gravity.tolist() == [1, 0, 0]
    assert world.solver_settings.iterations == 5
    assert (world.friction_combine, world.restitution_combine, world.restitution_threshold) == ("min", "average", 0.25)
    with pytest.raises(ValueError, match="read-only"):
        world.gravity[0] = 2
    steps(world, 3)
    assert world.bodies["box 0"].velocity[0] > 0


def test_handles_return_read_only_copies():
    world = stack(1)
    box = world.bodies["box 0"]
    for name in (
        "position",
        "orientation",
        "velocity",
        "angular_velocity",
        "inertia",
        "principal_axes",
        "center_of_mass",
    ):
        with pytest.raises(ValueError, match="read-only"):
            getattr(box, name)[0] = 1
        kept = getattr(box, name)
        before = kept.copy()
        box.position = (1, 2, 3)
        box.orientation = (1, 1, 0, 0)
        box.velocity = box.angular_velocity = (4, 5, 6)
        np.testing.assert_array_equal(kept, before)


def test_properties_of_each_kind():
    world = ap.World()
    moved = world.add(ap.Box(size=(1, 2, 3)), mass=6, color="#ff0000")
    platform = world.add(ap.Box(size=(1, 2, 3)), kind="kinematic", velocity=(1, 0, 0))
    assert moved.mass == 6
    assert moved.inertia == pytest.approx([6.5, 5, 2.5])
    assert moved.color == (1, 0, 0)
    assert platform.mass == np.inf
    assert (platform.inertia == np.inf).all()
    assert world.bodies.mass.tolist() == [6, 0]
    assert world.bodies.kind.tolist() == ["dynamic", "kinematic"]
    assert moved.shape == platform.shape == ap.Box(size=(1, 2, 3))
    for name in ("mass", "inertia"):
        assert not getattr(world.bodies, name).flags.writeable
    for value in ("friction", "restitution", "rolling_friction", "torsional_friction", "gravity_scale"):
        setattr(moved, value, 0.25)
        assert getattr(moved, value) == 0.25
    for value in ("linear_damping", "angular_damping"):
        setattr(moved, value, 2)
        assert getattr(moved, value) == 2
    moved.locks = ("x", "rz")
    assert moved.locks == ("x", "rz")
    assert (moved.group, moved.mask) == (1, 2**32 - 1)
    moved.group, moved.mask = 4, ~1
    assert (moved.group, moved.mask) == (4, 2**32 - 2)
    assert moved.principal_axes.tolist() == [1, 0, 0, 0]


def test_groups_may_change_between_steps():
    world = stack(1)
    world.step(1 / 60)
    assert len(world.contacts) == 4
    world.bodies[1].mask = 2
    world.step(1 / 60)
    assert len(world.contacts) == 0


def test_principal_axes_and_moments_make_the_inertia_tensor():
    world = ap.World(precision="double")
    tensor = [[3.0, 0.5, 0.2], [0.5, 4.0, -0.3], [0.2, -0.3, 5.0]]
    body = world.add(ap.Sphere(radius=1), mass=1, inertia=tensor)
    w, *v = body.principal_axes
    skew = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    axes = np.eye(3) + 2 * w * skew + 2 * skew @ skew
    np.testing.assert_allclose(axes @ np.diag(body.inertia) @ axes.T, tensor, atol=1e-12)


def test_ids_stay_with_their_bodies():
    world = stack(3)
    ids = world.bodies.id.tolist()
    assert len(set(ids)) == 4
    assert not world.bodies.id.flags.writeable
    world.remove(world.bodies[1])
    world.add(ap.Sphere(radius=1))
    assert world.bodies.id.tolist()[:3] == [ids[0], *ids[2:]]
    assert world.bodies.id[3] not in ids


def test_bodies_is_a_sequence_in_the_order_of_addition():
    world = stack(4)
    bodies = world.bodies
    assert bodies.names == ["ground", "box 0", "box 1", "box 2", "box 3"]
    assert [body.name for body in bodies] == bodies.names
    assert bodies[-1].name == "box 3"
    assert [body.name for body in bodies[1:3]] == ["box 0", "box 1"]
    assert bodies[2] in bodies
    world.remove(bodies["box 1"])
    assert world.bodies.names == ["ground", "box 0", "box 2", "box 3"]
    assert world.bodies.position[:, 1].tolist() == [0, 0.5, 2.5, 3.5]
    with pytest.raises(KeyError, match="box 1"):
        bodies["box 1"]
    with pytest.raises(IndexError):
        bodies[4]


def test_bulk_views_are_live_and_what_is_written_counts():
    world = stack(2, gravity=(0, 0, 0))
    position, velocity = world.bodies.position, world.bodies.velocity
    world.bodies.velocity[2] = (0, 6, 0)
    assert world.bodies["box 1"].velocity.tolist() == [0, 6, 0]
    world.step(1 / 60)
    assert position[2, 1] == pytest.approx(1.6)
    assert velocity[2, 1] == pytest.approx(6)
    world.bodies.orientation[1] = (0, 0, 0, 3)
    world.bodies.position = world.bodies.position + (1, 0, 0)
    world.bodies.angular_velocity[1] = (0, 0.5, 0)
    world.step(1 / 60)
    assert np.linalg.norm(world.bodies["box 0"].orientation) == pytest.approx(1)
    assert abs(world.bodies["box 0"].orientation[3]) > 0.99
    assert world.bodies["box 0"].position[0] == pytest.approx(1)


@pytest.mark.parametrize("precision", ["single", "double"])
@pytest.mark.parametrize(
    ("column", "value"),
    [
        ("position", np.nan),
        ("position", np.inf),
        ("position", 1e30),
        ("velocity", np.nan),
        ("velocity", 1e30),
        ("angular_velocity", -np.inf),
        ("orientation", 0.0),
        ("orientation", np.nan),
    ],
)
def test_bulk_writes_are_checked_at_the_next_step(precision, column, value):
    world = stack(2, precision=precision)
    world.step(1 / 60)
    getattr(world.bodies, column)[1] = value
    before = world.state_hash()
    for _ in range(2):
        with pytest.raises(ap.InvalidArgumentError, match=rf"bodies\.{column}\[1\]"):
            world.step(1 / 60)
        assert world.state_hash() == before
    # An assignment to another property of the body does not make it pass.
    world.bodies[1].friction = 0.5
    world.bodies[1].locks = None
    if column != "velocity":
        world.bodies[1].velocity = (0, 0, 0)
    with pytest.raises(ap.InvalidArgumentError, match=rf"bodies\.{column}\[1\]"):
        world.step(1 / 60)


def test_a_huge_quaternion_is_normalised_not_lost():
    world = ap.World(precision="double")
    body = world.add(ap.Sphere(radius=1))
    world.bodies.orientation[0] = (0, 1e200, 0, 1e200)
    world.step(1 / 60)
    assert body.orientation == pytest.approx([0, 0.5**0.5, 0, 0.5**0.5])


def test_a_static_body_cannot_be_given_a_velocity_in_bulk():
    world = stack(1)
    world.bodies.velocity[0] = (1, 0, 0)
    with pytest.raises(ap.InvalidArgumentError, match="static"):
        world.step(1 / 60)
    world.bodies["ground"].position = (0, 0, 0)
    with pytest.raises(ap.InvalidArgumentError, match="static"):
        world.step(1 / 60)
    world.bodies.velocity[0] = 0
    world.step(1 / 60)


def test_far_bodies_may_still_be_written_to():
    """The range of a column is asked of what was written, not of what motion brought about."""
    world = ap.World(gravity=(0, 0, 0))
    body = world.add(ap.Sphere(radius=1), position=(1e9, 0, 0), velocity=(1e3, 0, 0))
    world.step(1)
    assert body.position[0] > 1e9
    world.bodies.velocity[0] = 0
    world.step(1)
    assert body.velocity[0] == 0


@pytest.mark.parametrize(
    "value",
    [
        np.nan,
        [1, 2],
        "abc",
        None,
        {},
        [["a", "b", "c"]] * 3,
        1j,
        np.ones((3, 3), complex),
        np.full((3, 3), np.inf),
        np.full((3, 3), 1e300),
        np.zeros((4, 3)),
        object(),
    ],
)
@pytest.mark.parametrize("column", ["position", "velocity", "angular_velocity", "orientation"])
def test_bulk_assignment_refuses_what_it_cannot_hold(column, value):
    world = stack(2)
    before = world.state_hash()
    with pytest.raises(ap.InvalidArgumentError, match=column):
        setattr(world.bodies, column, value)
    assert world.state_hash() == before


def test_contacts_of_a_resting_box():
    world = stack(1)
    steps(world, 20)
    contacts = world.contacts
    assert len(contacts) == 4
    assert set(zip(contacts.body_a.tolist(), contacts.body_b.tolist(), strict=True)) <= {(0, 1), (1, 0)}
    into_box = contacts.normal * np.where(contacts.body_b == 1, 1, -1)[:, None]
    np.testing.assert_allclose(into_box, [[0, 1, 0]] * 4, atol=1e-6)
    np.testing.assert_allclose(contacts.normal_impulse.sum() * 60, 9810, rtol=1e-4)
    np.testing.assert_allclose(contacts.point[:, 1], 0, atol=0.01)
    np.testing.assert_allclose(np.abs(contacts.point[:, [0, 2]]), 0.5, atol=1e-3)
    assert (contacts.depth < 0.01).all()
    with pytest.raises(ValueError, match="read-only"):
        contacts.depth[0] = 1
    with pytest.raises(ValueError, match="read-only"):
        contacts["depth"][0] = 1


@pytest.mark.parametrize("plane_first", [True, False])
@pytest.mark.parametrize("precision", ["single", "double"])
def test_contact_points_have_moved_with_the_body(plane_first, precision):
    world = ap.World(precision=precision)
    shapes = {"plane": ap.Plane(normal=(0, 1, 0)), "cone": ap.Cone(radius=0.5, height=1)}
    at = {"plane": (1e5, 0, 0), "cone": (7, 0.5, 3)}
    for name in ("plane", "cone") if plane_first else ("cone", "plane"):
        kind = "static" if name == "plane" else "dynamic"
        world.add(shapes[name], position=at[name], name=name, kind=kind, friction=0)
    cone = world.bodies["cone"]
    cone.velocity, cone.angular_velocity = (3, 0, 0), (0, 2, 0)
    for _ in range(5):
        world.step(1 / 60)
        offset = world.contacts.point - cone.position
        assert len(offset) >= 3
        np.testing.assert_allclose(np.hypot(offset[:, 0], offset[:, 2]), 0.5, atol=2e-3)
        np.testing.assert_allclose(offset[:, 1], -0.5, atol=0.01)
    assert cone.position[0] > 7.2


def test_contact_events_come_once_each_in_order():
    world = ap.World()
    ground = world.add(ap.Plane(normal=(0, 1, 0)))
    ball = world.add(ap.Sphere(radius=0.5), position=(0, 1, 0), restitution=1, name="ball")
    seen = []
    for _ in range(240):
        world.step(1 / 60)
        seen += [(event.kind, frozenset((event.a, event.b))) for event in world.events]
    assert len(seen) >= 4
    assert {pair for _, pair in seen} == {frozenset((ground, ball))}
    assert [kind for kind, _ in seen] == ["contact_begin", "contact_end"] * (len(seen) // 2) + (
        ["contact_begin"] if len(seen) % 2 else []
    )


def test_events_end_when_bodies_are_moved_apart():
    world = stack(1)
    world.step(1 / 60)
    assert [event.kind for event in world.events] == ["contact_begin"]
    world.step(1 / 60)
    assert world.events == []
    world.bodies["box 0"].position = (0, 5, 0)
    world.step(1 / 60)
    assert [event.kind for event in world.events] == ["contact_end"]
    assert len(world.contacts) == 0


def test_energy_and_momentum_agree_with_sums_over_bodies():
    rng = np.random.default_rng(3)
    world = ap.World(gravity=(1, -9.81, 2), precision="double")
    for i in range(6):
        world.add(
            ap.Cone(radius=0.5, height=1) if i % 2 else ap.Box(size=(1, 2, 3)),
            position=rng.normal(size=3),
            orientation=rng.normal(size=4),
            velocity=rng.normal(size=3),
            angular_velocity=rng.normal(size=3),
            gravity_scale=i / 2,
        )
    world.add(ap.Sphere(radius=1), kind="kinematic", velocity=(9, 9, 9))
    kinetic, potential, momentum, angular = 0.0, 0.0, np.zeros(3), np.zeros(3)
    about = np.array((1.0, 2.0, 3.0))
    for body in itertools.islice(world.bodies, 6):
        w, x, y, z = body.orientation
        rotation = np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )
        tensor = rotation @ np.diag(body.inertia) @ rotation.T  # both shapes' own axes are principal
        spin = tensor @ body.angular_velocity
        kinetic += 0.5 * body.mass * body.velocity @ body.velocity + 0.5 * body.angular_velocity @ spin
        potential -= body.mass * body.gravity_scale * body.center_of_mass @ world.gravity
        momentum += body.mass * body.velocity
        angular += np.cross(body.center_of_mass - about, body.mass * body.velocity) + spin
    assert world.energy() == pytest.approx((kinetic, potential), rel=1e-12)
    assert world.momentum() == pytest.approx(momentum, rel=1e-12)
    assert world.angular_momentum(about) == pytest.approx(angular, rel=1e-12)


def test_repr_shows_state_with_units():
    world = stack(1)
    assert "2 bodies" in repr(world)
    assert "m/s" in repr(world.bodies["box 0"])
    assert "ground" in repr(world.bodies["ground"])
    assert repr(world.snapshot()) == "<Snapshot: 2 bodies at 0 s>"
    assert repr(world.bodies) == "<Bodies: 2>"
    removed = world.bodies["box 0"]
    world.remove(removed)
    assert repr(removed) == "<Body: removed>"


def test_run_takes_the_nearest_number_of_steps():
    world = ap.World()
    world.run(0)
    assert world.steps == 0
    world.run(0.1, dt=0.03)
    assert world.steps == 3
    world.run(seconds=1)
    assert world.steps == 63


@pytest.mark.parametrize("preset", ["default", "classic"])
def test_divergence_names_the_bodies_and_changes_nothing(preset):
    world = stack(2, preset=preset)
    world.add(ap.Sphere(radius=0.5), position=(5, 1, 0), angular_velocity=(10, 0, 0), name="fine")
    steps(world, 3)
    bad = world.add(ap.Box(size=(1, 2, 3)), position=(9, 9, 9), mass=1e-9, name="bad")
    other = world.add(ap.Sphere(radius=1), position=(20, 9, 9), mass=1e-12)
    for body in (bad, other):
        body.apply_force((1e9, 1e9, 1e9))
    world.bodies["box 0"].apply_force((1, 0, 0))
    bad.apply_torque((1e9, 0, 0))
    bad.gravity_scale = other.gravity_scale = 1e6
    world.gravity = (0, -1e9, 0)
    bad.linear_damping = other.linear_damping = 0
    before, time, took = world.state_hash(), world.time, world.steps
    for _ in range(2):
        with pytest.raises(ap.DivergenceError) as caught:
            for _ in range(50):
                before, time, took = world.state_hash(), world.time, world.steps
                world.step(10.0)
        # Whatever the gravity of 1e9 m/s² drives over the edge first
        assert {"bad", "body 5", "box 0", "box 1"}.intersection(caught.value.bodies)
        assert caught.value.bodies[0] in str(caught.value)
        assert (world.state_hash(), world.time, world.steps) == (before, time, took)
    with pytest.raises(ap.DivergenceError):
        world.run(100, dt=10.0)
    assert (world.state_hash(), world.time) == (before, time)
    world.remove(bad)
    world.remove(other)
    world.gravity = (0, -9.81, 0)
    world.step(1 / 60)


def test_capacity_grows_and_keeps_everything():
    world = ap.World()
    ground = world.add(ap.Plane(normal=(0, 1, 0)), name="ground")
    first = world.add(ap.Box(size=(1, 1, 1)), position=(0, 0.5, 0), velocity=(0, 0, 0), locks=("x",), friction=0.25)
    steps(world, 5)
    held = world.contacts.normal_impulse.copy()
    first.apply_force((0, 1, 0))
    handles = [world.add(ap.Sphere(radius=0.1 + i * 1e-4), position=(3 * i + 3, 1, 0), mass=i + 1) for i in range(1000)]
    assert len(world.bodies) == 1002
    assert (first.locks, first.friction, first.position[0], ground.name) == (("x",), 0.25, 0, "ground")
    np.testing.assert_array_equal(world.contacts.normal_impulse, held)
    assert [handle.mass for handle in handles] == [i + 1 for i in range(1000)]
    assert [handle.shape.radius for handle in handles[::100]] == [0.1 + i * 1e-4 for i in range(0, 1000, 100)]
    twin = ap.World()
    twin.add(ap.Plane(normal=(0, 1, 0)))
    for handle in handles[:3]:
        twin.add(handle.shape, position=handle.position, mass=handle.mass)
    steps(world, 60)
    steps(twin, 60)
    np.testing.assert_array_equal([h.position for h in handles[:3]], twin.bodies.position[1:])
    for handle in handles[::2]:
        world.remove(handle)
    assert [handle.mass for handle in handles[1::2]] == [i + 1 for i in range(1, 1000, 2)]
    steps(world, 2)


def test_scaling_by_a_power_of_two_scales_the_trajectory_exactly():
    def build(unit):
        world = ap.World(gravity=(0, -10 * unit, 0), length_unit=unit)
        world.add(ap.Plane(normal=(0, 1, 0)))
        for i in range(3):
            world.add(
                ap.Box(size=(unit, unit, 2 * unit)),
                position=(0.1 * i * unit, (0.6 + 1.1 * i) * unit, 0),
                velocity=(0, -unit, 0),
                angular_velocity=(0.5, 0, 0.25),
                density=100,
                restitution=0.5,
                rolling_friction=0.01 * unit,
            )
        return world

    small, large = build(1.0), build(4.0)
    for _ in range(90):
        small.step(1 / 64)
        large.step(1 / 64)
    np.testing.assert_array_equal(large.bodies.position, 4 * small.bodies.position)
    np.testing.assert_array_equal(large.bodies.orientation, small.bodies.orientation)
    np.testing.assert_array_equal(large.bodies.velocity, 4 * small.bodies.velocity)
    np.testing.assert_array_equal(large.contacts.normal_impulse, 256 * small.contacts.normal_impulse)
