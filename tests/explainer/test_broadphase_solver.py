"""The traces of the broad phase and of the solver."""

import numpy as np
import pytest

import atlasphys as ap
from atlasphys.engine.broadphase.brute import find_pairs
from atlasphys.engine.shapes.bounds import update_bounds
from tests.explainer.pairs import story_of, world_of
from tests.world.scenes import heap, stack


@pytest.mark.parametrize("method", ["brute", "sweep", "tree"])
def test_all_broad_phases_tell_the_same_survivors(method):
    world = heap(31, broadphase=method, preset="classic")
    with ap.explain(world) as story:
        world.step(1 / 60)
    trace = story.broadphase
    state = story.moment.before
    lower, upper = state.colliders.lower, state.colliders.upper
    for a, b in trace.survivors:
        if a > 0:  # row 0 is the plane
            assert np.all(lower[a] <= upper[b])
            assert np.all(lower[b] <= upper[a])
    pairs = {tuple(pair) for pair in trace.survivors.tolist()}
    np.testing.assert_array_equal(np.array(sorted(pairs)), state_pairs(31))
    for test in trace.tests:
        if test.answer.startswith("apart along"):
            axis = "xyz".index(test.answer[-1])
            assert lower[test.a, axis] > upper[test.b, axis] or lower[test.b, axis] > upper[test.a, axis]
            assert (test.a, test.b) not in pairs
    assert bool(trace.visits) == (method == "tree")
    if method == "sweep":
        assert any(test.answer == "begins later" for test in trace.tests)
    assert f"{len(pairs)} survive" in str(trace)


def state_pairs(seed):
    """The candidate pairs of the compiled engine."""
    before = heap(seed, preset="classic")._state
    update_bounds(before.bodies, before.colliders, before.table.arrays, before.count, before.tolerances.margin)
    pairs, found = find_pairs(before.bodies, before.colliders, before.table.arrays, before.count, before.pairs)
    return pairs[:found]


def test_the_pair_is_told_why_it_ends():
    world = world_of("deep")
    with ap.explain(world, pair=("first", "far")) as story:
        world.step(1 / 60)
    trace = story.broadphase
    assert not trace.survives
    assert trace.verdict[-1].answer == "apart along x"
    assert "ends here" in str(trace)
    assert "tight bounds" in trace.remark

    world = ap.World()
    for place in (0, 0.5):
        world.add(ap.Box(size=(1, 1, 1)), position=(place, 0, 0), group=1, mask=2)
    with ap.explain(world) as story:
        world.step(1 / 60)
    assert [test.answer for test in story.broadphase.verdict] == ["filtered"]


def test_a_plane_is_reached_or_not():
    world = stack(2)
    for pair, answer in (((0, 1), "reaches plane"), ((0, 2), "above plane")):
        with ap.explain(world, pair=pair) as story:
            world.step(1 / 60)
        assert story.broadphase.verdict[-1].answer == answer
        assert story.broadphase.survives == (answer == "reaches plane")


def test_large_worlds_are_told_for_the_pair_alone():
    world = ap.World(sleeping=False)
    for i in range(201):
        world.add(ap.Sphere(radius=0.4), position=(i, 0, 0))
    with ap.explain(world, pair=(0, 1)) as story:
        world.step(1 / 60)
    assert story.broadphase.survivors is None
    assert "is not told" in str(story.broadphase)


def test_the_sweeps_end_with_the_impulses_of_the_step():
    world = stack(2, preset="classic")
    world.run(seconds=0.1)
    with ap.explain(world, pair=(1, 2)) as story:
        world.step(1 / 60)
    trace = story.solver
    contacts = world.contacts
    mine = (contacts.body_a == 1) & (contacts.body_b == 2)
    np.testing.assert_array_equal(trace.sweeps[-1].normal, contacts.normal_impulse[mine])
    np.testing.assert_allclose(trace.sweeps[-2].normal, contacts.normal_impulse[mine], rtol=1e-6)
    assert [sweep.number for sweep in trace.sweeps] == [*range(len(trace.sweeps) - 1), -1]
    assert trace.sweeps[-2].normal.sum() == pytest.approx(1000 * 9.81 / 60, rel=1e-3)  # the upper box's weight
    assert all(clamp == "free" for clamp in trace.sweeps[-1].clamps)
    assert "kinetic energy" in str(trace)


def test_clamps_are_named():
    world = ap.World(preset="classic", gravity=(0, -9.81, 0))
    world.add(ap.Plane(normal=(0, 1, 0)), friction=0.1)
    world.add(ap.Box(size=(1, 1, 1)), position=(0, 0.5, 0), velocity=(3, 0, 0), friction=0.1)
    world.add(ap.Box(size=(1, 1, 1)), position=(5, 0.5, 0), velocity=(0, 3, 0))
    for pair, clamp in (((0, 1), "slides"), ((0, 2), "pulls")):
        copy = world.snapshot()
        with ap.explain(world, pair=pair) as story:
            world.step(1 / 60)
        assert clamp in story.solver.sweeps[-2].clamps
        world.restore(copy)


def test_solvers_with_substeps_tell_their_passes():
    trace = story_of("touching").solver
    assert "those of its substep" in trace.remark
    assert [sweep.number for sweep in trace.sweeps] == [*range(8), -1]
    assert [sweep.when for sweep in trace.sweeps[:3]] == ["substep 1, solve", "substep 1, relax", "substep 2, solve"]
    assert trace.sweeps[-1].when == "end of the step"
    whole = sum(sweep.normal for sweep in trace.sweeps[1:8:2])
    np.testing.assert_allclose(whole, trace.sweeps[-1].normal, rtol=1e-5, atol=1e-6)
    assert "nothing to do" in story_of("separate").solver.instead
