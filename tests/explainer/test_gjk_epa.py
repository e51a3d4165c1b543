"""The traces of GJK and EPA end with what the compiled engine answers, and every event fits the one before."""

import numpy as np
import pytest

from atlasphys.engine.narrowphase.dispatch import collide
from atlasphys.engine.state.contacts import empty_contacts
from tests.explainer.pairs import KINDS, story_of

PRECISIONS = ["single", "double"]


def compiled_answer(story, method="gjk_epa"):
    """The contacts that the compiled narrow phase finds for the story's pair."""
    moment = story.moment
    state = moment.before
    pairs = np.array([[moment.a, moment.b]], np.int32)
    contacts = empty_contacts(1, 64, state.real)
    return collide(state.bodies, state.colliders, moment.shapes, pairs, method, state.tolerances.margin, contacts)


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("kind", KINDS)
def test_the_trace_ends_with_the_answer_of_the_engine(kind, precision):
    story = story_of(kind, preset="classic", precision=precision)
    contacts, count = compiled_answer(story), 0
    mine, _ = story._narrowphase.generic
    count = int(contacts.count[0])
    assert mine.count[0] == count
    assert mine.gap[0] == contacts.gap[0]
    assert (count == 0) == kind.startswith("separate")
    for column in ("anchor_a", "anchor_b", "depth", "feature"):
        np.testing.assert_array_equal(getattr(mine, column)[:count], getattr(contacts, column)[:count])
    if count:
        np.testing.assert_array_equal(mine.normal[0], contacts.normal[0])
        contact = story.moment.contact
        np.testing.assert_array_equal(contact.normal, contacts.normal[0])
        assert contact.depth.max() == contacts.depth[:count].max()


@pytest.mark.parametrize("kind", KINDS)
def test_each_step_of_gjk_fits_the_one_before(kind):
    trace = story_of(kind).gjk
    assert len(trace.steps[0].before) == 0
    for step, following in zip(trace.steps, trace.steps[1:], strict=False):
        np.testing.assert_array_equal(step.simplex, following.before)
        assert following.distance <= step.distance
        np.testing.assert_allclose(following.direction, -step.closest, atol=1e-9)
    for step in trace.steps:
        np.testing.assert_allclose(step.support_a - step.support_b, step.point, atol=1e-6)
        if step.closest is not None:
            tried = np.vstack([step.before, step.point])
            np.testing.assert_allclose(step.weights @ tried, step.closest, atol=2e-6)
            assert len(step.simplex) == (step.weights > 0).sum()
            assert step.case
            assert any(word in step.case for word in ("point", "line", "triangle", "tetrahedron"))
    if trace.verdict == "separated":
        np.testing.assert_allclose(trace.on_b - trace.on_a, trace.distance * trace.normal, atol=2e-6)


@pytest.mark.parametrize("kind", ["deep", "deep hulls", "deep cylinders"])
def test_each_step_of_epa_fits_the_one_before(kind):
    trace = story_of(kind, precision="double").epa
    assert not trace.instead
    assert trace.steps[-1].grown is None
    for step, following in zip(trace.steps, trace.steps[1:], strict=False):
        assert step.lower <= following.lower + 1e-12
        assert step.best >= following.best >= following.lower - 1e-9
        if step.grown is not None:
            np.testing.assert_array_equal(step.grown.vertices, following.polytope.vertices)
            assert len(step.grown.faces) == len(step.polytope.faces) - len(step.removed) + len(step.horizon)
    for step in trace.steps:
        polytope = step.polytope
        assert len(polytope.faces) == 2 * len(polytope.vertices) - 4  # a closed surface of triangles
        corners = polytope.vertices[polytope.faces]
        np.testing.assert_allclose(
            np.einsum("fk,fck->fc", polytope.normals, corners), polytope.distances[:, None] * [1, 1, 1], atol=1e-9
        )
        assert step.upper == pytest.approx(step.point @ step.normal)
    np.testing.assert_allclose(trace.on_a - trace.on_b, trace.depth * trace.normal, atol=1e-9)


def test_epa_says_why_it_had_nothing_to_do():
    trace = story_of("separate").epa
    assert "GJK found the shapes" in trace.instead
    assert not trace.steps


def test_the_story_names_the_cases_and_the_lines():
    said = str(story_of("deep").gjk)
    assert "tetrahedron" in said
    assert "engine/narrowphase/gjk.py:" in said
    assert "overlapping" in said
