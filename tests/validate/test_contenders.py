"""Names with settings."""

import pytest

import atlasphys as ap
from atlasphys.engine.solvers import SOLVERS
from atlasphys.errors import InvalidArgumentError
from atlasphys.validate.contenders import solvers
from atlasphys.world.settings import PRESETS


def test_by_default_every_solver_is_there():
    made = [contender.make_world() for contender in solvers(None)]
    assert {world.solver for world in made} == set(SOLVERS)
    assert [contender.name for contender in solvers(None)][: len(PRESETS)] == list(PRESETS)


def test_settings():
    first, second, third = solvers(
        "soft_step:substeps=8:contact_recycling=false, classic:correction=0.3,default:narrowphase=sat"
    )
    assert first.make_world().solver_settings == ap.SoftStep(substeps=8, contact_recycling=False)
    assert first.title == "soft_step, substeps=8, contact_recycling=false"
    world = second.make_world(precision="double")
    assert world.solver_settings == ap.SequentialImpulse(correction=0.3)
    assert (world.broadphase, world.precision) == ("sweep", "double")
    assert second.title == "classic (sequential_impulse), correction=0.3"
    assert third.make_world().narrowphase == "sat"


def test_a_name_is_taken_once():
    assert [contender.name for contender in solvers("classic,classic")] == ["classic"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("fast", "some of default, classic.*got 'fast'"),
        ("", "got ''"),
        ("soft_step:substep=4", "soft_step takes substeps.*got 'substep=4'"),
        ("soft_step:substeps", "got 'substeps'"),
        ("soft_step:substeps=many", "substeps takes an integer"),
        ("soft_step:contact_damping=x", "takes a number"),
        ("classic:warm_starting=1", "true or false"),
        ("soft_step:substeps=0", "from 1 to 1000"),
        ("classic:threads=2", "threads must be 1"),
        ("default:narrowphase=best", "narrowphase must be one of"),
    ],
)
def test_what_makes_no_sense_is_said(words, message):
    with pytest.raises(InvalidArgumentError, match=message):
        solvers(words)
