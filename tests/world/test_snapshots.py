"""Snapshots, copies and pickles go on exactly like the world they were taken of; handles never come to mean another body."""

import copy
import os
import pickle
import subprocess
import sys

import numpy as np
import pytest

import atlasphys as ap
from tests.world.scenes import heap, stack, steps


def by_snapshot(world):
    other = ap.World()
    other.restore(world.snapshot())
    return other


def by_pickled_snapshot(world):
    other = ap.World()
    other.restore(pickle.loads(pickle.dumps(world.snapshot())))
    return other


def by_pickle(world):
    return pickle.loads(pickle.dumps(world))


@pytest.mark.parametrize("duplicate", [copy.copy, copy.deepcopy, by_snapshot, by_pickle, by_pickled_snapshot])
@pytest.mark.parametrize("before", [0, 25])
def test_a_duplicate_goes_on_to_the_bit(duplicate, before):
    world = heap(1)
    steps(world, before)
    world.bodies[5].apply_force((10, 20, 30), at=(1, 2, 3))
    twin = duplicate(world)
    assert twin.state_hash() == world.state_hash()
    straight = steps(world, 25)
    assert steps(twin, 25) == straight
    assert twin.time == world.time
    np.testing.assert_array_equal(twin.contacts, world.contacts)


def test_restore_returns_to_the_bit_again_and_again():
    world = heap(2)
    steps(world, 20)
    snapshot = world.snapshot()
    contacts, energy = world.contacts.copy(), world.energy()
    ends = set()
    for _ in range(3):
        ends.add(steps(world, 20))
        world.restore(snapshot)
        np.testing.assert_array_equal(world.contacts, contacts)
        assert world.energy() == energy
    assert len(ends) == 1


@pytest.mark.parametrize("duplicate", [copy.copy, copy.deepcopy])
def test_a_duplicate_is_independent(duplicate):
    world = stack(2)
    steps(world, 3)
    snapshot, twin, before = world.snapshot(), duplicate(world), world.state_hash()
    world.add(ap.Sphere(radius=1), position=(0, 9, 0))
    world.bodies[1].position = (3, 3, 3)
    world.gravity = (0, 0, 0)
    world.solver = ap.SequentialImpulse(iterations=1)
    steps(world, 3)
    world.remove(world.bodies[0])
    assert twin.state_hash() == before
    assert twin.gravity.tolist() == [0, -9.81, 0]
    world.restore(snapshot)
    assert world.state_hash() == before
    assert world.gravity.tolist() == [0, -9.81, 0]
    assert world.solver == "soft_step"
    assert steps(world, 5) == steps(twin, 5)


def test_adds_and_removes_between_snapshot_and_restore_leave_no_trace():
    world = heap(3, count=12)
    steps(world, 10)
    snapshot = world.snapshot()
    straight = steps(world, 20)
    world.restore(snapshot)
    for row in (2, 5, 7):
        world.remove(world.bodies[row])
    for i in range(40):  # more than the present capacity
        world.add(ap.Sphere(radius=0.1 + 0.01 * i), position=(i, 5, 0))
    steps(world, 5)
    world.restore(snapshot)
    assert steps(world, 20) == straight


def test_history_of_adds_and_removes_does_not_matter_but_the_bodies_do():
    """The hash is of the state, not of how it came about."""

    def build(detour):
        world = ap.World()
        if detour:
            passing = world.add(ap.Box(size=(1, 1, 1)), position=(50, 0, 0))
        world.add(ap.Plane(normal=(0, 1, 0)))
        world.add(ap.Sphere(radius=0.5), position=(0, 0.5, 0))
        if detour:
            world.remove(passing)
        world.add(ap.Box(size=(1, 1, 1)), position=(0, 1.5, 0))
        return world

    plain, detour = build(False), build(True)
    assert plain.state_hash() == detour.state_hash()
    assert steps(plain, 10) == steps(detour, 10)


def test_the_hash_tells_all_that_matters_apart():
    def build(change=None, **arguments):
        world = ap.World()
        arguments = {"mass": 1, "inertia": (1, 1, 1)} | arguments
        shape = arguments.pop("shape", ap.Sphere(radius=1))
        body = world.add(shape, **arguments)
        if change:
            change(body)
        return world.state_hash()

    hashes = [
        build(),
        build(shape=ap.Sphere(radius=2)),
        build(shape=ap.Box(size=(1, 1, 1))),
        build(shape=ap.Cylinder(radius=1, length=1)),
        build(shape=ap.ConvexHull([(1, 0, 0), (-1, 1, 0), (-1, -1, 1), (-1, -1, -1)])),
        build(shape=ap.ConvexHull([(1.5, 0, 0), (-1, 1, 0), (-1, -1, 1), (-1, -1, -1)])),
        build(kind="static"),
        build(kind="kinematic"),
        build(position=(1, 0, 0)),
        build(orientation=(0, 1, 0, 0)),
        build(velocity=(1, 0, 0)),
        build(angular_velocity=(1, 0, 0)),
        build(mass=2),
        build(inertia=(1, 1, 1.5)),
        build(friction=0.25),
        build(restitution=0.25),
        build(rolling_friction=0.25),
        build(torsional_friction=0.25),
        build(linear_damping=0.25),
        build(angular_damping=0.25),
        build(gravity_scale=0.25),
        build(locks=("x",)),
        build(group=2),
        build(mask=2),
        build(lambda body: body.apply_force((1, 0, 0))),
        build(lambda body: body.apply_torque((1, 0, 0))),
    ]
    assert len(set(hashes)) == len(hashes)
    assert build() == build(name="named", color=(1, 0, 0))


def test_a_pickle_goes_on_in_another_process(tmp_path):
    world = stack(3)
    steps(world, 10)
    (tmp_path / "world.pickle").write_bytes(pickle.dumps(world))
    code = (
        "import pickle, sys\n"
        "world = pickle.load(open(sys.argv[1], 'rb'))\n"
        "for _ in range(20): world.step(1 / 60)\n"
        "print(world.state_hash(), world.bodies['box 1'].name)"
    )
    answer = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "world.pickle")],
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert answer.stdout.split("\n")[0] == f"{steps(world, 20)} box 1"


def test_a_snapshot_of_another_precision_is_refused():
    single, double = stack(1), stack(1, precision="double")
    before = single.state_hash()
    for wrong in (double.snapshot(), None, double, 3):
        with pytest.raises(ap.InvalidArgumentError):
            single.restore(wrong)
    assert single.state_hash() == before


def test_unchecked_bulk_writes_stay_noticeable_in_duplicates():
    world = stack(1)
    world.bodies.position[1] = np.nan
    for twin in (copy.deepcopy(world), by_pickle(world), by_snapshot(world)):
        with pytest.raises(ap.InvalidArgumentError, match="position"):
            twin.step(1 / 60)


def test_names_and_colours_are_restored():
    world = ap.World()
    body = world.add(ap.Sphere(radius=1), name="first", color="#00ff00")
    snapshot = world.snapshot()
    world.remove(body)
    world.add(ap.Sphere(radius=1), name="second")
    world.restore(snapshot)
    assert (body.name, body.color) == ("first", (0, 1, 0))
    world.add(ap.Sphere(radius=1), name="second")
    with pytest.raises(ap.InvalidArgumentError, match="first"):
        world.add(ap.Sphere(radius=1), name="first")


# Handles ---------------------------------------------------------------------------------------------------------------


def test_a_removed_body_is_gone():
    world = stack(2)
    body, other = world.bodies[1], world.bodies[2]
    world.remove(body)
    for use in (
        lambda: body.position,
        lambda: body.name,
        lambda: body.mass,
        lambda: body.row,
        lambda: body.apply_force((1, 0, 0)),
        lambda: setattr(body, "velocity", (1, 0, 0)),
        lambda: setattr(body, "friction", 1),
        lambda: setattr(body, "locks", None),
        lambda: world.remove(body),
    ):
        before = world.state_hash()
        with pytest.raises(ap.RemovedBodyError):
            use()
        assert world.state_hash() == before
    assert other.name == "box 1"
    assert other.row == 1
    replacement = world.add(ap.Box(size=(1, 1, 1)), name="box 0")
    assert replacement != body
    with pytest.raises(ap.RemovedBodyError):
        _ = body.position


def test_a_body_of_another_world_cannot_be_removed():
    world, other = stack(1), stack(1)
    for wrong in (other.bodies[1], copy.deepcopy(world).bodies[1], 1, None, "box 0"):
        with pytest.raises(ap.InvalidArgumentError, match="of this world"):
            world.remove(wrong)
    assert len(world.bodies) == len(other.bodies) == 2


def test_a_handle_made_after_a_snapshot_never_means_another_body():
    world = stack(1)
    snapshot = world.snapshot()
    late = world.add(ap.Sphere(radius=1), name="late")
    world.restore(snapshot)
    again = world.add(ap.Sphere(radius=1), name="again")
    with pytest.raises(ap.RemovedBodyError):
        _ = late.position
    assert again.name == "again"
    assert late != again
    world.restore(snapshot)
    third = world.add(ap.Sphere(radius=1), name="third")
    for gone in (late, again):
        with pytest.raises(ap.RemovedBodyError):
            _ = gone.position
    assert third.name == "third"


def test_handles_from_before_a_snapshot_stay_good():
    world = stack(3)
    top = world.bodies["box 2"]
    snapshot = world.snapshot()
    world.remove(world.bodies["box 0"])
    assert top.row == 2
    world.remove(top)
    world.restore(snapshot)
    assert (top.row, top.name) == (3, "box 2")
    top.velocity = (0, 1, 0)
    assert world.bodies.velocity[3].tolist() == [0, 1, 0]


def test_handles_of_copies_stay_apart():
    world = stack(1)
    twin = copy.deepcopy(world)
    mine, yours = world.add(ap.Sphere(radius=1), name="mine"), twin.add(ap.Sphere(radius=1), name="yours")
    assert mine != yours
    assert mine.world is world
    assert yours.world is twin
    world.restore(twin.snapshot())
    with pytest.raises(ap.RemovedBodyError):
        _ = mine.name
    assert world.bodies[2].name == "yours"
    twin.restore(world.snapshot())
    assert yours.name == "yours"


@pytest.mark.parametrize("duplicate", [copy.deepcopy, by_pickle])
def test_a_handle_copied_with_its_world_means_the_copy(duplicate):
    world = stack(1)
    both = duplicate((world, world.bodies[1]))
    assert both[1].world is both[0]
    assert both[1] == both[0].bodies[1]
    both[1].position = (7, 7, 7)
    assert world.bodies[1].position.tolist() == [0, 0.5, 0]


def test_handles_compare_and_hash_by_body():
    world = stack(2)
    assert world.bodies[1] == world.bodies["box 0"]
    assert len({world.bodies[1], world.bodies["box 0"], world.bodies[2]}) == 2
    assert world.bodies[1] != 1


# Removal keeps what others carry ---------------------------------------------------------------------------------------


def test_removal_keeps_the_impulses_of_the_other_contacts():
    world = stack(5)
    side = world.add(ap.Box(size=(1, 1, 1)), position=(5, 0.5, 0))
    steps(world, 60)
    before = world.contacts.copy()
    names = np.array(world.bodies.names, object)
    pairs = {(names[c["body_a"]], names[c["body_b"]], *c["point"], c["normal_impulse"]) for c in before}
    world.remove(world.bodies["box 4"])
    names = np.array(world.bodies.names, object)
    after = {(names[c["body_a"]], names[c["body_b"]], *c["point"], c["normal_impulse"]) for c in world.contacts}
    assert after == {pair for pair in pairs if "box 4" not in pair[:2]}
    assert (world.contacts.normal_impulse > 0).all()
    world.step(1 / 60)
    # Warm started, the pile below barely notices; the lone box beside it not at all.
    assert np.abs(world.bodies.velocity).max() < 0.05
    assert np.abs(side.velocity).max() < 1e-5
    assert side.row == 5


def test_removal_from_the_middle_of_a_stack():
    world = stack(5)
    steps(world, 60)
    world.remove(world.bodies["box 2"])
    assert all(event.kind in ("contact_begin", "contact_end") for event in world.events)
    world.step(1 / 60)
    speed = np.abs(world.bodies.velocity[:, 1])
    assert speed[1:3].max() < 0.1  # the two below are relieved of load
    assert speed[3:] == pytest.approx(9.81 / 60, abs=0.02)  # those above begin to fall
    steps(world, 120)
    assert world.bodies.position[:, 1] == pytest.approx([0, 0.5, 1.5, 2.5, 3.5], abs=0.025)
