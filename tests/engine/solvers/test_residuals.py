"""Residuals of contacts against closed forms, and the trace of a solver."""

import copy
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import atlasphys as ap
from atlasphys.engine.solvers import SOLVERS
from atlasphys.engine.solvers.residuals import contact_residuals, point_residuals
from atlasphys.engine.state.manifolds import FRICTION
from atlasphys.errors import InvalidArgumentError
from atlasphys.world.watch import watched
from tests.world.scenes import heap, stack, steps

G, H, MASS = 9.81, 1 / 60, 2.0
number = st.floats(-1e3, 1e3)
positive = st.floats(0, 1e3)


def one(excess, inverse_mass, impulse, rubbed=0.0, friction=0.0):
    columns = (np.array([float(value)]) for value in (excess, inverse_mass, impulse, rubbed, friction, 0.0))
    return point_residuals(*columns)


@given(number, st.floats(1e-3, 1e3), positive)
def test_complementarity(excess, inverse_mass, impulse):
    found = one(excess, inverse_mass, impulse)
    if excess < 0:
        assert found.complementarity[0] == pytest.approx(-excess / inverse_mass)  # what would stop the approach
    else:
        assert found.complementarity[0] == pytest.approx(min(excess / inverse_mass, impulse))
    assert found.work[0] == pytest.approx(abs(impulse * excess))


@given(positive, positive, st.floats(0, 3))
def test_cone(rubbed, impulse, friction):
    found = one(0.0, 1.0, impulse, rubbed, friction).cone[0]
    assert found == (rubbed - friction * impulse if rubbed > friction * impulse else 0)


def test_two_immovable_bodies_lack_nothing():
    assert one(-5.0, 0.0, 0.0).complementarity[0] == 0


def resting(solver, shape=None, **options):
    """A body of 2 kg that rests on the ground."""
    world = ap.World(gravity=(0, -G, 0), solver=solver, sleeping=False, precision="double", **options)
    world.add(ap.Plane(normal=(0, 1, 0)))
    body = world.add(shape or ap.Sphere(radius=0.5), position=(0, 0.5, 0), mass=MASS)
    world.run(seconds=3, dt=H)
    return world, body


@pytest.mark.parametrize("solver", list(SOLVERS))
def test_what_rests_lacks_nothing(solver):
    world, _ = resting(solver, ap.Box(size=(1, 1, 1)))
    found, before = world.residuals(), world.state_hash()
    assert len(found.complementarity) == 4
    assert found.complementarity.max() < 1e-3 * MASS * G * H
    assert found.cone.max() < 1e-3 * MASS * G * H
    assert world.state_hash() == before


@pytest.mark.parametrize("solver", list(SOLVERS))
@pytest.mark.parametrize("sunk", [1e-4, 3e-3])
def test_an_approach_lacks_what_would_stop_it(solver, sunk):
    """A ball that ends a step deeper by d than it began, at the speed d/h: the impulse m d/h is missing."""
    world, ball = resting(solver)
    start = world.residuals().depth[0]
    h = world._state.last_h  # a substep, or a whole step where solvers take these apart by themselves
    ball.position = ball.position - np.array([0, sunk + 0.01, 0])
    ball.velocity = (0, -(sunk + 0.01) / h, 0)
    found = world.residuals()
    assert found.depth[0] == pytest.approx(start + sunk + 0.01)
    assert found.complementarity[0] == pytest.approx(MASS * (sunk + 0.01) / h, rel=max(start, 1e-9) / sunk)


@pytest.mark.parametrize("solver", list(SOLVERS))
@pytest.mark.parametrize("speed", [1e-3, 5.0])
def test_a_contact_that_pulls_apart_while_it_pushes(solver, speed):
    world, ball = resting(solver)
    h = world._state.last_h  # a substep, or a whole step where solvers take these apart by themselves
    ball.position = ball.position + np.array([0, speed * h, 0])
    ball.velocity = (0, speed, 0)
    pushed = world.contacts.normal_impulse[0]
    found = world.residuals()
    assert found.complementarity[0] == pytest.approx(min(MASS * speed, pushed), rel=1e-2)
    assert found.work[0] == pytest.approx(pushed * speed, rel=1e-2)


def test_the_mass_that_a_contact_feels_includes_rotation():
    """A rod struck at a distance r from its centre gives way by 1/m + r²/I."""
    world, rod = resting("sequential_impulse", ap.Box(size=(2, 1, 1)))
    rod.velocity, sunk = (0, -0.01 / H, 0), 0.01
    rod.position = rod.position - np.array([0, sunk, 0])
    inverse = 1 / MASS + (1.0 + 0.25) / (MASS / 12 * (4 + 1))  # corners: r × n has parts about x and z
    about_x, about_z = 0.25 / (MASS / 12 * 2), 1.0 / (MASS / 12 * 5)
    inverse = 1 / MASS + about_x + about_z
    assert world.residuals().complementarity == pytest.approx(np.full(4, sunk / H / inverse), rel=1e-3)


@pytest.mark.parametrize("solver", list(SOLVERS))
def test_friction_beyond_the_cone(solver):
    """A sliding block rubs with μ λ; had μ been smaller by 0.2, that would be 0.2 λ too much."""
    world, block = resting(solver, ap.Box(size=(1, 1, 1)))
    block.velocity = (3, 0, 0)
    world.step(H)
    assert world.residuals().cone.max() < 1e-9
    state = world._state
    state.manifolds.contact[: state.manifold_count, FRICTION] -= 0.2
    pushed = world.contacts.normal_impulse
    assert contact_residuals(state).cone == pytest.approx(0.2 * pushed, rel=1e-6)


def test_bounces_are_no_violation():
    world = ap.World(gravity=(0, 0, 0), precision="double")
    world.add(ap.Plane(normal=(0, 1, 0)))
    ball = world.add(ap.Sphere(radius=0.5), position=(0, 0.51, 0), velocity=(0, -4, 0), restitution=0.5)
    while ball.velocity[1] < 0:
        world.step(H)
    assert world.contacts.normal_impulse[0] > 0
    assert world.residuals().complementarity[0] == 0


def test_an_empty_world_has_no_residuals():
    world = ap.World()
    world.step(H)
    assert len(world.residuals().complementarity) == 0


@pytest.mark.parametrize("solver", list(SOLVERS))
def test_a_trace_changes_no_bit(solver):
    hashes = []
    for tracing in (False, True):
        world = stack(5)
        world.solver = solver
        world.trace_solver = tracing
        world.run(seconds=0.5, dt=H)
        world.step(H)
        hashes.append(world.state_hash())
    assert hashes[0] == hashes[1]


@pytest.mark.parametrize("solver", list(SOLVERS))
def test_a_trace_has_the_end_of_every_step(solver):
    world = stack(3)
    world.solver = solver
    assert len(world.solver_trace) == 0
    world.trace_solver = True
    world.run(seconds=5 * H, dt=H)
    trace = world.solver_trace
    ends = trace[trace.sweep == -1]
    assert ends.step.tolist() == [1, 2, 3, 4, 5]
    now, energy = world.residuals(), world.energy()
    assert ends.complementarity[-1] == now.complementarity.max()
    assert ends.work[-1] == pytest.approx(now.work.sum())
    assert ends.translation[-1] + ends.rotation[-1] == pytest.approx(energy.kinetic)
    assert ends.potential[-1] == energy.potential
    assert ends.depth[-1] == max(now.depth.max(), 0)
    world.step(H)
    assert set(world.solver_trace.step) == {6}
    with pytest.raises(ValueError, match="read-only"):
        world.solver_trace.step[0] = 1
    world.trace_solver = False
    assert len(world.solver_trace) == 0


def test_sweeps_of_sequential_impulses_converge():
    world = ap.World(solver=ap.SequentialImpulse(iterations=60, warm_starting=False), precision="double")
    world.add(ap.Plane(normal=(0, 1, 0)))
    for level in range(3):
        world.add(ap.Box(size=(1, 1, 1)), position=(0, 0.5 + level, 0), mass=1)
    world.trace_solver = True
    world.step(H)
    trace = world.solver_trace
    assert trace.sweep.tolist() == [*range(61), -1]
    assert (trace.colour == -1).all()
    # Nothing pushes at first: every cube has fallen for a step.
    assert trace.translation[0] == pytest.approx(3 * 0.5 * (G * H) ** 2)
    assert trace.complementarity[0] > 0.1 * G * H
    assert trace.complementarity[-2] < 1e-3 * trace.complementarity[1]
    assert trace.translation[-2] < 1e-6 * trace.translation[0]
    assert trace.complementarity[-1] == pytest.approx(trace.complementarity[-2], abs=1e-9)


def test_bounces_add_sweeps_to_a_trace():
    world = ap.World(solver="sequential_impulse", gravity=(0, 0, 0), restitution_threshold=0)
    world.trace_solver = True
    for i in range(4):  # three in a row at rest, touching, struck by the fourth
        world.add(ap.Sphere(radius=0.5), position=(i, 0, 0), velocity=(-3 if i == 3 else 0, 0, 0), restitution=1)
    world.step(H)
    assert world.solver_trace.sweep.max() > 10


PASSES = {"soft_step": ("solve", "relax"), "xpbd": ("positions", "velocities")}


@pytest.mark.parametrize("solver", list(PASSES))
def test_a_trace_of_everything_changes_no_bit(solver):
    """Locked, rolling and bouncing bodies of all shapes; notes are taken by code that is compiled for it."""
    hashes = []
    for tracing in (False, True, False):
        world = heap(13, spread=4.0, solver=solver, sleeping=False)
        world.trace_solver = tracing
        steps(world, 10)
        world.trace_solver = not tracing
        steps(world, 3)
        hashes.append(world.state_hash())
    assert len(set(hashes)) == 1


@pytest.mark.parametrize("solver", list(PASSES))
def test_passes_of_substeps_add_up_to_the_step(solver):
    """A tower and a sliding block: impulses of the second passes are those of the substeps; friction keeps to the cone."""
    world = stack(3)
    world.solver = solver
    world.add(ap.Box(size=(1, 1, 1)), position=(5, 0.5, 0), velocity=(3, 0, 0), friction=0.5)
    steps(world, 20)
    seen = []
    with watched(world, seen.append):
        world.step(H)
    notes, trace = seen[0].sweeps, seen[0].solved[0]
    substeps = world.solver_settings.substeps
    assert [note.kind for note in notes] == [*PASSES[solver]] * substeps
    assert [note.substep for note in notes] == [s for s in range(substeps) for _ in range(2)]
    assert [note.sweep for note in notes] == list(range(2 * substeps))
    contacts = world.contacts
    whole = sum(note.impulse[:, 0] for note in notes[1::2])
    assert whole == pytest.approx(contacts.normal_impulse, rel=1e-5, abs=1e-6)
    sliding = np.flatnonzero(contacts.body_b == len(world.bodies) - 1)
    rubbed = sum(np.hypot(*note.impulse[sliding, 1:].T) for note in notes[1::2])
    assert rubbed == pytest.approx(0.5 * contacts.normal_impulse[sliding], rel=1e-4)
    last = seen[0].after.bodies.motion[: seen[0].after.count, :6]
    np.testing.assert_array_equal(notes[-1].motion, last)
    assert (trace["translation"] + trace["rotation"])[-2] == pytest.approx(world.energy().kinetic)
    scale = contacts.normal_impulse.max()
    assert trace["cone"].max() < 1e-5 * scale
    assert trace["complementarity"].max() < 0.1 * scale
    assert trace["depth"].max() == pytest.approx(contacts.depth.max(), abs=1e-4)


def test_bodies_that_nothing_stops_yet_are_a_residual():
    """A ball that falls on a plane from a gap that it will close within the step: before the pass it approaches, after it it does not."""
    world = ap.World(gravity=(0, 0, 0), solver="soft_step")
    world.add(ap.Plane(normal=(0, 1, 0)))
    world.add(ap.Sphere(radius=0.5), position=(0, 0.501, 0), velocity=(0, -1, 0), mass=2)
    world.trace_solver = True
    world.step(H)
    trace = world.solver_trace
    assert trace.translation[0] < 1.0  # ½ · 2 kg · (1 m/s)²: the first pass has braked it
    assert trace.complementarity[:-1].max() < 1e-5
    assert trace.kind.tolist() == ["solve", "relax"] * 4 + ["end"]


def test_sweeps_of_avbd_converge():
    world = ap.World(solver=ap.AVBD(iterations=60, tolerance=1e-9), precision="double")
    world.add(ap.Plane(normal=(0, 1, 0)))
    for level in range(3):
        world.add(ap.Box(size=(1, 1, 1)), position=(0, 0.5 + level, 0), mass=1)
    world.trace_solver = True
    world.step(H)
    trace = world.solver_trace
    assert trace.sweep.tolist() == [*range(len(trace) - 1), -1]
    assert trace.kind.tolist() == ["sweep"] * (len(trace) - 1) + ["end"]
    assert trace.complementarity[-2] < 1e-3 * trace.complementarity[0]
    assert trace.translation[-2] < 1e-6 * trace.translation[0]
    assert trace.cone.max() < 1e-9


def test_copies_and_pickles_of_a_traced_world_go_on_alike():
    world = stack(3)
    world.trace_solver = True
    world.step(H)
    other, third = copy.deepcopy(world), pickle.loads(pickle.dumps(world))
    for each in (world, other, third):
        each.step(H)
        assert each.trace_solver
        assert set(each.solver_trace.step) == {2}
    assert world.state_hash() == other.state_hash() == third.state_hash()


def test_trace_solver_takes_a_truth_value():
    with pytest.raises(InvalidArgumentError, match="trace_solver must be True or False"):
        ap.World().trace_solver = 1
