"""The trace of the separating axis test."""

import numpy as np
import pytest

from tests.explainer.pairs import story_of
from tests.explainer.test_gjk_epa import compiled_answer

POLYHEDRA = ["separate", "touching", "deep", "separate hulls", "deep hulls"]


@pytest.mark.parametrize("precision", ["single", "double"])
@pytest.mark.parametrize("kind", POLYHEDRA)
def test_the_trace_ends_with_the_answer_of_the_engine(kind, precision):
    story = story_of(kind, narrowphase="sat", precision=precision)
    contacts, mine = compiled_answer(story, "sat"), story._narrowphase.own[0]
    count = int(contacts.count[0])
    assert mine.count[0] == count
    assert mine.gap[0] == contacts.gap[0]
    np.testing.assert_array_equal(mine.depth[:count], contacts.depth[:count])
    np.testing.assert_array_equal(mine.anchor_a[:count], contacts.anchor_a[:count])
    if count:
        np.testing.assert_array_equal(mine.normal[0], contacts.normal[0])


@pytest.mark.parametrize("kind", POLYHEDRA)
def test_each_axis_is_measured_and_the_best_is_the_result(kind):
    trace = story_of(kind, precision="double").sat
    bests = [axis for axis in trace.axes if axis.taken]
    assert bests
    for axis in trace.axes:
        assert np.linalg.norm(axis.axis) == pytest.approx(1)
        apart = axis.b_from - axis.a_to
        if not axis.taken:  # the test may stop before it has measured an axis that is worse
            assert apart <= axis.distance + 1e-9
        else:
            assert apart == pytest.approx(axis.distance, abs=1e-9)
            assert axis.distance > axis.best
    final = [axis for axis in bests if axis.distance == trace.distance]
    assert any(abs(axis.axis @ trace.normal) == pytest.approx(1) for axis in final)
    np.testing.assert_allclose((trace.on_b - trace.on_a) @ trace.normal, trace.distance, atol=1e-9)
    assert "Best:" in str(trace)


def test_boxes_have_fifteen_axes():
    trace = story_of("deep").sat
    assert len(trace.axes) + trace.parallel == 15
    aligned = story_of("touching").sat
    assert aligned.parallel == 3
    assert [axis.of for axis in aligned.axes[:6]] == ["face of a"] * 3 + ["face of b"] * 3


def test_edges_are_left_out_where_faces_suffice():
    trace = story_of("separate").sat
    assert {axis.of for axis in trace.axes} == {"face of a", "face of b"}
    assert "No edges were tried" in str(trace)


def test_round_shapes_have_no_such_test():
    assert "is for two polyhedra" in story_of("sunk ball").sat.instead


def test_the_story_says_which_routine_the_world_takes():
    assert "convex_convex (narrowphase='gjk_epa')" in story_of("deep", narrowphase="gjk_epa").sat.remark
    assert "eight pairs at a time" in story_of("deep").sat.remark
