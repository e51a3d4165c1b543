"""``ap.explain``: steps are what they are without it, and wrong use is said."""

import copy
import json
import os
import pickle
import subprocess
import sys

import pytest

import atlasphys as ap
from atlasphys.cli import main
from atlasphys.explainer import STAGES
from tests.explainer.pairs import world_of
from tests.world.scenes import heap, stack


@pytest.mark.parametrize("preset", ["default", "classic", "xpbd", "avbd"])
def test_an_explained_step_is_that_step_to_the_bit(preset):
    quiet, told = heap(31, preset=preset), heap(31, preset=preset)
    for _ in range(3):
        quiet.step(1 / 60)
        with ap.explain(told) as story:
            told.step(1 / 60)
        str(story)
    assert quiet.state_hash() == told.state_hash()
    assert story.step == told.steps == 3


def test_of_several_steps_the_last_is_told():
    quiet, told = stack(2), stack(2)
    quiet.run(seconds=0.2)
    with ap.explain(told, pair=(1, 2)) as story:
        told.run(seconds=0.2)
    assert story.step == told.steps == 12
    assert quiet.state_hash() == told.state_hash()


def test_the_trace_of_the_solver_is_left_to_those_who_asked_for_it():
    world = stack(1, preset="classic")
    with ap.explain(world):
        world.step(1 / 60)
    assert not world.trace_solver
    assert len(world.solver_trace) == 0
    world.trace_solver = True
    with ap.explain(world):
        world.run(seconds=0.05)
    assert set(world.solver_trace.step) == {2, 3, 4}


def test_the_pair_may_be_handles_names_or_rows():
    world = world_of("deep")
    for pair in (("first", "second"), (1, 0), (world.bodies[0], "second")):
        with ap.explain(world, pair=pair) as story:
            world.step(1 / 60)
        assert story.pair == ("first", "second")
    assert repr(story) == "<Story: step 3, first and second>"


def test_without_a_pair_the_deepest_contact_is_told_planes_last():
    world = stack(2)
    with ap.explain(world) as story:
        world.step(1 / 60)
    assert story.pair == ("box 0", "box 1")


def test_a_pair_that_never_meets_is_told_as_such():
    world = world_of("deep")
    with ap.explain(world, pair=("first", "far")) as story:
        world.step(1 / 60)
    assert "no contact" in story.heading()
    assert story.gjk.verdict == "separated"


def test_a_plane_has_no_gjk():
    world = stack(1)
    with ap.explain(world, pair=(0, 1)) as story:
        world.step(1 / 60)
    assert "plane" in story.gjk.instead
    assert "plane" in str(story.epa)


def test_the_data_are_plain_and_complete():
    world = world_of("deep")
    with ap.explain(world) as story:
        world.step(1 / 60)
    told = json.loads(json.dumps(story.data(), allow_nan=False))
    assert set(STAGES) <= set(told)
    assert told["gjk"]["steps"][0]["point"] == story.gjk.steps[0].point.tolist()
    assert told["pair"] == ["first", "second"]


@pytest.mark.parametrize(
    ("pair", "said"),
    [
        (("first", "nobody"), "no body is named 'nobody'; there are 'first', 'second', 'far'"),
        (("first", "first"), "two different bodies"),
        (("first", 7), "row from 0 to 2"),
        ("first", "must be two bodies"),
        ((True, 1), "row from 0 to 2"),
    ],
)
def test_wrong_pairs_are_said(pair, said):
    with pytest.raises(ap.InvalidArgumentError, match=said), ap.explain(world_of("deep"), pair=pair):
        pass


def test_other_errors_are_said():
    world = world_of("deep")
    with (
        pytest.raises(ap.InvalidArgumentError, match="another world"),
        ap.explain(world, pair=(world_of("deep").bodies[0], 1)),
    ):
        pass
    with pytest.raises(ap.InvalidArgumentError, match="takes a world"), ap.explain("world"):
        pass
    with pytest.raises(ap.InvalidArgumentError, match="needs a pair"), ap.explain(ap.World()):
        pass
    with ap.explain(world) as story:
        pass
    assert "no step" in repr(story)
    with pytest.raises(ap.InvalidArgumentError, match="no step was taken"):
        str(story)
    with ap.explain(world) as story:
        world.step(1 / 60)
    with pytest.raises(ap.InvalidArgumentError, match="stage must be one of"):
        story.stage("integrate")


def test_copies_made_inside_the_block_are_not_watched():
    world = world_of("deep")
    with ap.explain(world) as story:
        for other in (copy.deepcopy(world), pickle.loads(pickle.dumps(world))):
            other.step(1 / 60)
        assert "no step" in repr(story)
    world.step(1 / 60)
    assert "no step" in repr(story)


def command(*words):
    return subprocess.run(
        [sys.executable, "-W", "error", "-m", "atlasphys", "explain", *words],
        env=os.environ | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path), "PYTHONIOENCODING": "utf-8"},
        capture_output=True,
        text=True,
        timeout=300,
    )  # fmt: skip


def test_the_command_tells_the_first_contact():
    answer = command("gjk", "two_boxes", "--set", "drop=0.01")
    assert answer.returncode == 0, answer.stderr
    assert "lower and upper have 4 contact points" in answer.stdout
    assert "Verdict: the shapes are" in answer.stdout


def test_the_command_answers_as_json():
    answer = command("epa", "two_boxes", "--set", "drop=0.01", "--step", "1", "--pair", "lower,2", "--json")
    assert answer.returncode == 0, answer.stderr
    told = json.loads(answer.stdout)
    assert told["step"] == 1
    assert told["pair"] == ["lower", "upper"]
    assert "GJK found the shapes" in told["epa"]["instead"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("gjk", "two_boxes", "--step", "301"), "--step must be from 1 to 300"),
        (("gjk", "two_boxes", "--step", "0"), "--step must be from 1 to 300"),
        (("dance", "two_boxes"), "the stage must be one of"),
        (("gjk", "two_boxes", "--pair", "lower"), "--pair takes two bodies"),
        (("gjk", "two_boxes", "--pair", "lower,nobody"), "no body is named 'nobody'"),
    ],
)
def test_wrong_commands_are_said(words, said, capsys):
    assert main(["explain", *words]) == 2
    assert said in capsys.readouterr().err


def test_the_command_says_if_a_pair_never_meets(capsys):
    assert main(["explain", "gjk", "newtons_cradle", "--pair", "0,2", "--dt", "0.5"]) == 0
    assert "They do not touch in any of the" in capsys.readouterr().out
