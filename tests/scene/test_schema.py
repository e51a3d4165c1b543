"""The schema says of worlds and bodies what their functions take."""

import inspect
from pathlib import Path

import pytest

import atlasphys as ap
from atlasphys.scene.schema import SHAPES, BodyModel, SceneModel, WorldModel


def test_a_body_has_the_arguments_of_add():
    arguments = inspect.signature(ap.World.add).parameters
    assert sorted(BodyModel.model_fields) == sorted(set(arguments) - {"self"})


def test_a_world_has_the_arguments_of_world():
    arguments = inspect.signature(ap.World).parameters
    assert sorted(WorldModel.model_fields) == sorted([*arguments, "solver_settings"])


def test_every_shape_is_public():
    for model in SHAPES.values():
        assert hasattr(ap, model.maker.split(".")[1])


def test_every_field_is_described_in_the_json_schema():
    schema = SceneModel.model_json_schema()
    for definition in (schema, *schema["$defs"].values()):
        if "properties" not in definition:  # any JSON value
            continue
        for name, field in definition["properties"].items():
            assert name == "type" or field.get("description"), name


@pytest.mark.parametrize(
    "path", sorted(Path(__file__).parents[2].glob("examples/scenes/*")), ids=lambda path: path.name
)
def test_the_example_files_build(path):
    scene = ap.load_scene(path)
    assert len(scene.build().bodies) == len(scene.bodies) > 1
