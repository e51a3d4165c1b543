"""Slides say what the traces say, point at the line that did it, and draw what is there."""

import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import atlasphys as ap
from atlasphys.explainer import STAGES
from atlasphys.explainer.slides.figure import Arrows, Dots, Lines, Solid
from atlasphys.explainer.slides.mathml import display, formula, fraction, norm
from atlasphys.explainer.slides.slide import excerpt, line_that_did_it, source_lines
from atlasphys.explainer.slides.solids import Pair, hull_of
from tests.explainer.pairs import KINDS, story_of

SOME = ("separate", "touching", "turned", "deep", "deep cylinders", "touching capsule", "sunk ball")


def parsed(html):
    """HTML that is XML as well, as that of the slides is meant to be."""
    return ET.fromstring(f"<div>{html}</div>")


def said(html):
    return "".join(parsed(html).itertext())


@pytest.mark.parametrize("kind", SOME)
def test_every_stage_has_slides_that_are_well_formed(kind):
    story = story_of(kind, preset="classic")
    for stage in STAGES:
        slides = story.slides(stage)
        assert len(slides) >= 1
        for slide in slides:
            assert slide.title
            assert len(said(slide.text)) > 20
            for mark in (*slide.shapes, *slide.beside):
                points = mark.hull.vertices if isinstance(mark, Solid) else getattr(mark, "points", np.zeros(3))
                assert np.isfinite(points).all(), (stage, slide.title)
                if isinstance(mark, Lines | Arrows):
                    assert points.shape[1:] == (2, 3)
                if isinstance(mark, Dots):
                    assert points.shape[1:] == (3,)
        parsed(slides._repr_html_())
        assert slides._repr_html_().count("<svg") >= len(slides)


def test_gjk_slides_tell_the_numbers_of_the_trace():
    story = story_of("deep")
    slides, trace = story.slides("gjk"), story.gjk
    asked = [slide for slide in slides if "ask for" in slide.title]
    taken = [slide for slide in slides if "the simplex is" in slide.title]
    assert len(asked) == len(trace.steps)
    for slide, step in zip(asked, trace.steps, strict=True):
        assert numbers(step.point) in said(slide.text)
        assert any(isinstance(m, Dots) and (m.points == step.point).all() for m in slide.beside)
    for slide, step in zip(taken, trace.steps, strict=True):
        assert step.case[1:] in said(slide.text)
        assert numbers(step.closest) in said(slide.text)
        assert any(isinstance(m, Dots) and np.array_equal(m.points, step.simplex) for m in slide.beside)
    assert trace.verdict in slides[-1].title


def numbers(vector):
    """A vector as a formula shows it."""
    return "".join(ET.fromstring(formula(vector)).itertext())


@pytest.mark.parametrize("kind", ["deep", "deep hulls", "deep cylinders"])
def test_epa_slides_tell_the_numbers_of_the_trace(kind):
    story = story_of(kind)
    slides, trace = story.slides("epa"), story.epa
    asked = [slide for slide in slides if "ask the" in slide.title]
    assert len(asked) == len(trace.steps)
    for slide, step in zip(asked, trace.steps, strict=True):
        assert numbers(step.point) in said(slide.text)
        assert "l=" + numbers(step.lower) in said(slide.text) or step.outcome == "wall"
    assert numbers(trace.normal) in said(slides[-1].text)
    for slide in slides:
        if slide.title.endswith("the polytope grows"):
            before, gone, new, after = map(int, re.search(r"(\d+)−(\d+)\+(\d+)=(\d+)", said(slide.text)).groups())
            assert before - gone + new == after


def test_the_other_stages_tell_theirs():
    story = story_of("turned", preset="classic")
    for axis, slide in zip(story.sat.axes, story.slides("sat")[1:], strict=False):
        assert numbers(axis.axis) in said(slide.text)
        assert ("best so far" in said(slide.text)) == axis.taken
    cuts = [slide for slide in story.slides("clip") if slide.title.startswith("Cut")]
    assert len(cuts) == len(story.clip.cuts)
    assert f"{len(story.clip.points)} contact points" in said(story.slides("clip")[-1].text)
    kept = [slide for slide in story.slides("manifold") if slide.title.startswith("Keep")]
    assert [slide.title for slide in kept] == [f"Keep point {k.index + 1}: {k.why}" for k in story.manifold.reduction]
    assert kept
    sweeps = story.slides("solver")[1:]
    assert len(sweeps) == len(story.solver.sweeps)
    for slide, sweep in zip(sweeps, story.solver.sweeps, strict=True):
        impulses, residual = slide.charts
        assert [curve[-1] for curve in impulses.curves.values()] == sweep.normal.tolist()
        assert residual.curves["residual"][-1] == pytest.approx(np.log10(max(sweep.complementarity, 1e-9)))
    assert "goes on to the narrow phase" in said(story.slides("broadphase")[-1].text)


LINES = {
    ("gjk", "ask for"): "difference_support(",
    ("gjk", "the simplex is"): "_set_weights(",
    ("epa", "ask the"): "difference_support(",
    ("epa", "grows"): "_take(",
    ("sat", "Axis"): "distance",
    ("clip", "Cut"): "_cut(",
    ("clip", "How deep"): "depth = ",
    ("solver", "Sweep"): "sweep(",
    ("solver", "Before"): "warm_start(",
}


@pytest.mark.parametrize(("stage", "title"), LINES)
def test_slides_point_at_the_line_that_did_it(stage, title):
    story = story_of("turned", preset="classic")
    slides = [slide for slide in story.slides(stage) if title in slide.title]
    assert slides
    for slide in slides:
        file, line = line_that_did_it(slide.source, slide.needle)
        text = source_lines(file)[line - 1]
        assert LINES[stage, title] in text
        assert "note(" not in text
        marked = [row for row in parsed(excerpt(slide.source, slide.needle))[1] if "background" in row.get("style")]
        assert len(marked) == 1
        assert text.strip() in "".join(marked[0].itertext())
        assert f"line {line}" in said(excerpt(slide.source, slide.needle))


def test_a_stage_that_does_not_apply_says_what_happened_instead():
    story = story_of("separate")
    (slide,) = story.slides("epa")
    assert "GJK found the shapes" in said(slide.text)
    world = ap.World()
    world.add(ap.Plane())
    world.add(ap.Sphere(radius=0.5), position=(0, 0.4, 0))
    with ap.explain(world) as story:
        world.step(1 / 60)
    (slide,) = story.slides("gjk")
    assert "plane" in said(slide.text)
    assert slide.beside == ()
    for stage in STAGES:
        parsed(story.slides(stage)._repr_html_())
    with pytest.raises(ap.InvalidArgumentError, match="stage must be one of"):
        story.slides("integrate")


@pytest.mark.parametrize("kind", KINDS)
def test_the_hull_that_is_drawn_is_that_of_the_difference(kind):
    story = story_of(kind, precision="double")
    pair = Pair(story.moment)
    hull = pair.difference
    for step in story.gjk.steps:  # a support point is as far as the hull reaches; curved shapes are drawn with corners
        along = hull.vertices @ step.direction
        reach = float(step.point @ step.direction)
        assert along.max() == pytest.approx(reach, abs=0.02 * np.linalg.norm(step.direction) * pair.size)
        if not hull.is_smooth:
            assert along.max() == pytest.approx(reach, abs=1e-9)
    inward = [planes(hull) @ np.append(np.zeros(3), 1.0)]
    holds = bool((np.concatenate(inward) <= 1e-9).all())
    if len(hull.faces) and story.gjk.verdict != "touching":
        assert holds == (story.gjk.verdict == "overlapping")


def planes(hull):
    """(f, 4) outward normal n and offset −d of each triangle, so that n · x − d ≤ 0 inside."""
    if len(hull.faces) == 0:
        return np.zeros((0, 4))
    a, b, c = (hull.vertices[hull.faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    return np.column_stack([normals, -np.einsum("fk,fk->f", normals, a)])


@given(st.integers(1, 12), st.integers(0, 3), st.integers(0, 10**6))
@settings(max_examples=60, deadline=None)
def test_hulls_hold_their_points_and_are_closed(count, flat, seed):
    points = np.random.default_rng(seed).normal(size=(count, 3))
    points[:, 3 - flat :] = 0.5
    hull = hull_of(points)
    sides = planes(hull)
    if len(hull.faces) >= 3 and np.ptp(hull.vertices, axis=0).min() > 0:
        assert (points @ sides[:, :3].T + sides[:, 3] <= 1e-9).all()
        walked = {tuple(face[[i, (i + 1) % 3]].tolist()) for face in hull.faces for i in range(3)}
        assert all((b, a) in walked for a, b in walked)
        assert len(hull.vertices) - 3 * len(hull.faces) // 2 + len(hull.faces) == 2  # Euler
    for row in hull.vertices:
        assert (np.abs(points - row).max(axis=1) < 1e-12).any()
    assert hull.edges.max(initial=0) < len(hull.vertices)


def polygons(distance, turn=0.0):
    world = ap.load_scene("polygons", distance=distance).build()
    world.bodies[1].orientation = (np.cos(turn / 2), 0, 0, np.sin(turn / 2))
    with ap.explain(world, pair=(0, 1)) as story:
        world.step(1 / 60)
    return story


@given(st.floats(0, 3), st.floats(-3, 3))
@settings(max_examples=25, deadline=None)
def test_gjk_of_polygons_stays_in_their_plane_and_is_right(distance, turn):
    story = polygons(distance, turn)
    trace = story.gjk
    pair = Pair(story.moment)
    assert pair.is_flat
    for step in trace.steps:
        assert step.point[2] == 0
        assert len(step.simplex) <= 3
    flat = hull_of(pair.difference.vertices * (1.0, 1.0, 0.0))
    corners = flat.vertices[:, :2]
    before = np.roll(corners, 1, axis=0)
    crossed = np.cross(np.column_stack([before, 0 * before[:, 0]]), np.column_stack([corners, 0 * before[:, 0]]))[:, 2]
    away = np.abs(crossed / np.linalg.norm(corners - before, axis=1)).min()
    if away > 1e-4:
        inside = bool((crossed > 0).all() or (crossed < 0).all())
        assert (trace.verdict == "separated") == (not inside)


def test_pairs_in_space_are_not_called_flat():
    assert not Pair(story_of("separate").moment).is_flat
    assert not Pair(story_of("deep cylinders").moment).is_flat


def test_the_world_before_the_step_takes_the_same_step():
    world = ap.load_scene("two_boxes").build()
    world.run(seconds=0.5)
    with ap.explain(world) as story:
        world.step(1 / 60)
    again = story.world_before()
    assert again.steps == world.steps - 1
    again.step(1 / 60)
    assert again.state_hash() == world.state_hash()
    with ap.explain(world) as story:
        pass
    with pytest.raises(ap.InvalidArgumentError, match="no step was taken"):
        story.world_before()


def test_a_notebook_shows_the_story_with_figures():
    world = ap.World(gravity=(0, 0, 0))
    world.add(ap.Box(size=(1, 1, 1)))
    world.add(ap.Box(size=(1, 1, 1)), position=(0.5, 0.6, 0.7))
    with ap.explain(world) as story:
        assert story._repr_html_() is None
        world.step(1 / 60)
    html = story._repr_html_()
    parsed(html)
    assert html.count("<details>") == len(STAGES)
    assert html.count("<svg") > 20
    assert "<script" not in html
    assert "http" not in html
    assert repr(story.slides("gjk")).startswith("<Slides: gjk, ")
    assert story.slides("gjk")[0].title == "The question"


def test_formulas_are_mathml():
    assert formula("w = s_A(d)", 0.5) == (
        '<math><mi>w</mi><mo>=</mo><msub><mi>s</mi><mi>A</mi></msub><mo stretchy="false">(</mo><mi>d</mi>'
        '<mo stretchy="false">)</mo><mn>0.5</mn></math>'
    )
    assert said(formula("v_1 <", (1, -2.5, 0))) == "v1<(1,−2.5,0)"
    assert said(formula(1.5e-7)) == "1.50·10−7"
    assert said(display(norm("c"), "=", fraction("a · b", 2))) == "|c|=a·b2"
