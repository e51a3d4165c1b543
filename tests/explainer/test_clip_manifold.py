"""The traces of clipping and of the manifold."""

import numpy as np
import pytest

import atlasphys as ap
from tests.explainer.pairs import KINDS, story_of
from tests.world.scenes import stack

TOUCHING = [kind for kind in KINDS if not kind.startswith("separate")]


@pytest.mark.parametrize("narrowphase", ["auto", "gjk_epa"])
@pytest.mark.parametrize("kind", TOUCHING)
def test_the_contact_points_are_those_of_the_step(kind, narrowphase):
    """Of the step's own manifold: for boxes over lanes, up to round-off."""
    story = story_of(kind, narrowphase=narrowphase, preset="classic")
    trace, contact = story.clip, story.moment.contact
    assert len(trace.points) == story._narrowphase.own[0].count[0] > 0
    kept = list(story.manifold.kept)
    np.testing.assert_array_equal(trace.point_depths[kept], contact.depth)
    assert len(kept) <= 4


def test_over_lanes_the_points_are_the_same():
    for kind in ("touching", "deep"):
        story = story_of(kind, precision="double")
        assert "eight pairs at a time" in story.clip.remark
        kept = list(story.manifold.kept)
        np.testing.assert_allclose(
            np.sort(story.clip.point_depths[kept]), np.sort(story.moment.contact.depth), atol=1e-9
        )


@pytest.mark.parametrize("kind", ["touching", "turned"])
def test_each_cut_fits_the_one_before(kind):
    trace = story_of(kind, precision="double").clip
    assert trace.reference in ("a", "b")
    for cut, following in zip(trace.cuts, trace.cuts[1:], strict=False):
        np.testing.assert_array_equal(cut.after, following.before)
    slack = 0.025 * 0.02 + 1e-9  # the bias in favour of faces widens their outline
    for cut in trace.cuts:
        assert np.all((cut.after - cut.corner) @ cut.outward <= slack)
        dropped = (cut.before - cut.corner) @ cut.outward > slack
        assert dropped.any() or len(cut.after) == len(cut.before)
    np.testing.assert_array_equal(trace.cuts[-1].after, trace.clipped)
    np.testing.assert_array_equal(trace.depths[trace.kept], trace.point_depths[: trace.kept.sum()])
    assert "side plane" in str(trace)


def test_edges_meet_at_a_point():
    trace = story_of("deep").clip
    assert trace.reference == ""
    assert len(trace.points) == 1
    assert "No face parts the two" in str(trace)


def test_what_is_not_clipped_is_said():
    assert "without clipping" in story_of("sunk ball").clip.instead
    assert "apart by more than the margin" in story_of("separate").clip.instead
    assert "no contact points" in story_of("separate").manifold.instead


def test_reduction_keeps_the_deepest_of_many_points():
    world = ap.World(preset="classic")
    world.add(ap.Box(size=(1, 1, 1)), kind="static")
    turned = (np.cos(np.pi / 8), 0, np.sin(np.pi / 8), 0)
    world.add(ap.Box(size=(1, 1, 1)), position=(0, 0.99, 0), orientation=turned)
    with ap.explain(world) as story:
        world.step(1 / 60)
    trace = story.manifold
    assert len(trace.depths) == 8  # an octagon
    assert [entry.why for entry in trace.reduction] == ["deepest", "farthest", "triangle", "other side"]
    assert sorted(entry.index for entry in trace.reduction) == list(trace.kept)
    assert trace.depths[trace.reduction[0].index] == trace.depths.max()
    assert "twice" in str(trace)


def test_impulses_are_carried_over_as_the_step_does():
    world = stack(2, preset="classic")
    world.run(seconds=0.1)
    with ap.explain(world, pair=("box 0", "box 1")) as story:
        world.step(1 / 60)
    trace = story.manifold
    assert trace.old_points == 4
    assert sorted(trace.origin) == [0, 1, 2, 3]
    assert trace.impulses.min() > 0
    np.testing.assert_allclose(story.solver.sweeps[0].normal, trace.impulses, rtol=1e-6)
    assert {match.by for match in trace.matches} == {"feature"}
