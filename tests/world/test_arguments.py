"""Wrong, huge, tiny, mistyped and misshapen input: an InvalidArgumentError and an unchanged world, or it is taken and the world goes on."""

import fractions
import math
import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import atlasphys as ap
from tests.world.scenes import stack

NUMBERS = st.one_of(
    st.floats(),
    st.sampled_from(
        [0, -0.0, 1, -1, 0.5, 1e-300, 5e-324, 1e-45, 1e38, 1e39, -1e39, 1e308, 2**63, -(2**63), 2**1100, 10**400]
    ),
    st.integers(),
)
JUNK = st.sampled_from(
    [
        None,
        True,
        False,
        "",
        "x",
        "1",
        b"1",
        1j,
        math.nan,
        math.inf,
        {},
        {1, 2, 3},
        [],
        (),
        [None] * 3,
        ["1", "2", "3"],
        [[1, 2, 3]],
        [[1], [2], [3]],
        np.zeros((3, 1)),
        np.zeros((3, 3)),
        np.array(2.0),
        np.array(2),
        np.array([1, 2]),
        np.array(["x", "y", "z"]),
        np.array([1j, 0, 0]),
        np.array([True, False, True]),
        np.float32(1),
        np.int8(1),
        np.bool_(True),
        np.datetime64(0, "s"),
        fractions.Fraction(1, 3),
        fractions.Fraction(10**400),
        int,
        object(),
        lambda: None,
        range(3),
        "projection",
        "baumgarte",
        "dynamic",
        "static",
        "brute",
        "#12345",
        "#gggggg",
        "#ffffff",
        ["x", "w"],
        ["x", "x"],
        [np.array(["x", "y"])],
        "xyz",
        float,
        ap.Box(size=(1, 1, 1)),
    ]
)
VALUES = st.one_of(
    JUNK,
    NUMBERS,
    st.lists(NUMBERS, min_size=2, max_size=5),
    st.lists(st.floats(-10, 10), min_size=3, max_size=4),
    st.lists(st.lists(NUMBERS, min_size=3, max_size=3), min_size=3, max_size=3),
    st.tuples(NUMBERS, NUMBERS, NUMBERS).map(np.array),
)

BODY_SETTERS = (
    "position",
    "orientation",
    "velocity",
    "angular_velocity",
    "friction",
    "restitution",
    "rolling_friction",
    "torsional_friction",
    "gravity_scale",
    "linear_damping",
    "angular_damping",
    "locks",
    "group",
    "mask",
)
BODY_METHODS = ("apply_force", "apply_torque", "apply_impulse", "apply_angular_impulse")
WORLD_SETTERS = (
    "gravity",
    "solver",
    "narrowphase",
    "broadphase",
    "restitution_threshold",
    "friction_combine",
    "restitution_combine",
)
BULK_SETTERS = ("position", "orientation", "velocity", "angular_velocity")
ADD_ARGUMENTS = (*BODY_SETTERS, "mass", "density", "inertia", "kind", "color", "name")
WORLD_ARGUMENTS = (
    *WORLD_SETTERS,
    "preset",
    "position_correction",
    "substeps",
    "threads",
    "precision",
    "sleeping",
    "length_unit",
)

QUICK = settings(max_examples=150)


@pytest.fixture(scope="module", params=["single", "double"])
def calm(request):
    """A world at rest, and its snapshot to come back to."""
    world = stack(1, precision=request.param)
    world.add(ap.Cone(radius=0.5, height=1), position=(4, 4, 0), kind="kinematic", name="cone")
    world.add(ap.Sphere(radius=0.5), position=(8, 4, 0), name="ball")
    world.step(1 / 60)
    return world, world.snapshot()


def attempt(calm, action):
    """Do it; if refused, all must be as before; if not, the state must be finite and the step after it finite or refused."""
    world, snapshot = calm
    world.restore(snapshot)
    before = world.state_hash(), settings_of(world)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            action(world)
        except ap.InvalidArgumentError as error:
            assert len(str(error)) > 10
            assert (world.state_hash(), settings_of(world)) == before
            return
        for name in BULK_SETTERS:
            assert np.isfinite(getattr(world.bodies, name)).all()
        before = world.state_hash()
        try:
            world.step(1 / 60)
        except (ap.InvalidArgumentError, ap.DivergenceError):
            assert world.state_hash() == before
        for name in BULK_SETTERS:
            assert np.isfinite(getattr(world.bodies, name)).all()


def settings_of(world):
    names = (*WORLD_SETTERS, "solver_settings", "precision", "length_unit")
    return [str(getattr(world, name)) for name in names] + [world.bodies.names]


@QUICK
@given(row=st.integers(0, 3), name=st.sampled_from(BODY_SETTERS), value=VALUES)
def test_body_setters(calm, row, name, value):
    attempt(calm, lambda world: setattr(world.bodies[row], name, value))


@QUICK
@given(row=st.integers(0, 3), name=st.sampled_from(BODY_METHODS), value=VALUES, at=st.none() | VALUES)
def test_forces_and_impulses(calm, row, name, value, at):
    arguments = {} if name in ("apply_torque", "apply_angular_impulse") else {"at": at}
    attempt(calm, lambda world: getattr(world.bodies[row], name)(value, **arguments))


@QUICK
@given(name=st.sampled_from(WORLD_SETTERS), value=VALUES)
def test_world_setters(calm, name, value):
    attempt(calm, lambda world: setattr(world, name, value))


@QUICK
@given(name=st.sampled_from(BULK_SETTERS), value=VALUES)
def test_bulk_setters(calm, name, value):
    attempt(calm, lambda world: setattr(world.bodies, name, value))


@QUICK
@given(chosen=st.dictionaries(st.sampled_from(ADD_ARGUMENTS), VALUES, min_size=1, max_size=3))
def test_add(calm, chosen):
    attempt(calm, lambda world: world.add(ap.Box(size=(1, 1, 1)), **({"position": (0, 20, 0)} | chosen)))


@given(shape=VALUES)
def test_add_wants_a_shape(calm, shape):
    if not isinstance(shape, ap.Box):
        with pytest.raises(ap.InvalidArgumentError, match="shape"):
            calm[0].add(shape)


@QUICK
@given(chosen=st.dictionaries(st.sampled_from(WORLD_ARGUMENTS), VALUES, min_size=1, max_size=2))
def test_world_arguments(chosen):
    try:
        world = ap.World(**chosen)
    except ap.InvalidArgumentError as error:
        assert len(str(error)) > 10
    else:
        assert np.isfinite(world.gravity).all()


@QUICK
@given(dt=VALUES)
def test_step(calm, dt):
    attempt(calm, lambda world: world.step(dt))


@given(seconds=JUNK | st.sampled_from([-1, -1e-300, 1e10, 1e308, 10**400]), dt=st.just(1 / 60) | JUNK)
def test_run(calm, seconds, dt):
    attempt(calm, lambda world: world.run(seconds, dt))


@given(value=VALUES)
def test_methods_that_take_something_else(calm, value):
    attempt(calm, lambda world: world.restore(value))
    attempt(calm, lambda world: world.remove(value))
    attempt(calm, lambda world: world.angular_momentum(value))


SETTINGS = ("iterations", "position_correction", "position_iterations", "correction", "warm_starting")


@QUICK
@given(name=st.sampled_from(SETTINGS), value=VALUES)
def test_solver_settings(name, value):
    try:
        chosen = ap.SequentialImpulse(**{name: value})
    except ap.InvalidArgumentError as error:
        assert name in str(error)
    else:
        assert ap.World(solver=chosen).solver_settings == chosen


def test_messages_say_what_was_wrong_and_what_would_be_right():
    world = stack(1)
    box = world.bodies[1]
    for action, parts in (
        (lambda: setattr(box, "velocity", (1, 2)), ("velocity", "three", "(1, 2)")),
        (lambda: setattr(box, "friction", -0.5), ("friction", "0", "-0.5")),
        (lambda: setattr(box, "restitution", 1.5), ("restitution", "1", "1.5")),
        (lambda: setattr(box, "orientation", (0, 0, 0, 0)), ("orientation", "not all zero")),
        (lambda: setattr(box, "locks", ["w"]), ("locks", "rx", "w")),
        (lambda: setattr(world.bodies[0], "velocity", (1, 0, 0)), ("velocity", "static", "kinematic")),
        (lambda: world.bodies[0].apply_force((1, 0, 0)), ("static", "dynamic")),
        (lambda: world.step(0), ("dt", "1e-07", "0")),
        (lambda: world.step("1/60"), ("dt", "1/60")),
        (lambda: world.add(ap.Sphere(radius=1), mass=1, density=1), ("mass", "density")),
        (lambda: world.add(ap.Sphere(radius=1), mass=0), ("mass", "0")),
        (lambda: world.add(ap.Sphere(radius=1), kind="fixed"), ("kind", "'kinematic'", "'fixed'")),
        (lambda: world.add(ap.Plane(normal=(0, 1, 0)), kind="dynamic"), ("plane", "static")),
        (lambda: world.add(ap.Plane(), mass=-1), ("mass", "plane")),
        (lambda: world.add(ap.Plane(), density=5), ("density", "plane")),
        (lambda: world.add(ap.Plane(), inertia="x"), ("inertia", "plane")),
        (lambda: world.add(ap.Sphere(radius=1), kind="static", velocity=(1, 0, 0)), ("static", "kinematic")),
        (lambda: world.add(ap.Sphere(radius=1), name="box 0"), ("box 0", "taken")),
        (lambda: world.add(ap.Sphere(radius=1), name="\ud800"), ("name", "Unicode")),
        (lambda: world.add(ap.Sphere(radius=1), color="red"), ("color", "#rrggbb", "red")),
        (lambda: world.add(ap.Sphere(radius=1), group=2**32), ("group", "32")),
    ):
        with pytest.raises(ap.InvalidArgumentError) as caught:
            action()
        for part in parts:
            assert part in str(caught.value)
