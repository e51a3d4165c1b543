"""The library: every scene builds, runs, and says how it may be changed."""

import hashlib
import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import atlasphys as ap
from atlasphys.errors import SceneError
from atlasphys.scene import library


def test_there_are_at_least_fifteen():
    assert len(library.names()) >= 15
    assert len(set(library.names())) == len(library.names())


@pytest.mark.parametrize("name", library.names())
def test_it_runs(name):
    scene = ap.load_scene(name)
    world = scene.build()
    for _ in range(5):
        world.step(scene.dt)
    assert np.isfinite(world.bodies.position).all()
    assert (world.bodies.kind == "dynamic").any()
    assert all(body.name for body in scene.bodies)


@pytest.mark.parametrize("name", library.names())
def test_nothing_overlaps_at_the_start(name):
    """Bodies begin apart or just touching: an overlap at the start would be solved by a kick."""
    world = ap.load_scene(name).build()
    world.gravity = (0, 0, 0)
    world.bodies.velocity[:] = 0
    world.bodies.angular_velocity[:] = 0
    world.step(1e-6)
    contacts = world.contacts
    deepest = contacts.depth.max() if len(contacts) else 0.0
    assert deepest < 1e-5


@pytest.mark.parametrize("name", library.names())
def test_it_says_what_it_shows_in_a_line(name):
    entry = library.entry(name)
    assert 10 < len(entry.description) <= 75
    assert entry.description.endswith(".")
    assert ap.load_scene(name).description == entry.description


SIZES = {
    "demo": ({"pairs": 7}, 15),
    "tower": ({"height": 20}, 21),
    "pyramid": ({"base": 4, "gap": 0}, 11),
    "wall": ({"bricks": 3, "rows": 2, "ball_speed": 0}, 8),
    "dominoes": ({"count": 5}, 6),
    "bouncing_balls": ({"count": 3}, 4),
    "newtons_cradle": ({"balls": 3, "moving": 2}, 3),
    "mixed_shapes": ({"count": 7}, 12),
    "polyhedra": ({"copies": 1}, 8),
    "sphere_pit": ({"count": 10, "seed": 5}, 15),
    "card_house": ({"levels": 1}, 3),
    "polygons": ({"distance": 0.5}, 2),
    "chain": ({"links": 3}, 3),
    "bridge": ({"planks": 4, "boxes": 1}, 5),
    "rope_heavy": ({"ratio": 10, "links": 2}, 3),
    "wrecking_ball": ({"angle": 30, "rows": 1}, 21),
    "cradle_strings": ({"balls": 3, "moving": 2, "angle": 10}, 3),
    "suspension": ({"bumps": 0, "speed": 5, "steering": 10}, 6),
    "ragdoll_pile": ({"count": 2}, 27),
    "joint_grid": ({"side": 7}, 49),
}


@pytest.mark.parametrize("name", SIZES)
def test_sizes_are_parameters(name):
    parameters, bodies = SIZES[name]
    assert len(ap.load_scene(name, **parameters).bodies) == bodies
    as_text = {key: str(value) for key, value in parameters.items()}
    assert ap.load_scene(name, **as_text) == ap.load_scene(name, **parameters)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"heigth": 3}, r"tower: heigth: unknown parameter; did you mean 'height'\?"),
        ({"x": 3}, "tower: x: unknown parameter; known: height"),
        ({"height": "tall"}, r"tower: height: must be a valid integer, .* \(got 'tall'\)"),
        ({"height": 0}, r"tower: height: must be greater than or equal to 1 \(got 0\)"),
        ({"height": "1e9"}, "tower: height: must be"),
        ({"height": 10**9}, "must be less than or equal to 1000"),
        ({"height": float("nan")}, "tower: height: must be"),
        ({"height": None}, "tower: height: must be"),
        ({"height": 2.5}, "tower: height: must be"),
    ],
)
def test_a_parameter_that_is_unknown_or_out_of_range_is_refused(parameters, message):
    with pytest.raises(SceneError, match=message):
        ap.load_scene("tower", **parameters)


def test_all_wrong_parameters_are_named_at_once():
    with pytest.raises(SceneError) as error:
        ap.load_scene("pyramid", base=0, gap="inf", x=1)
    assert [line.split(": ")[1] for line in str(error.value).splitlines()] == ["base", "gap", "x"]


@given(
    name=st.sampled_from(["tower", "pyramid", "wall", "incline", "heavy_on_light"]),
    value=st.one_of(
        st.text(max_size=6), st.integers(), st.floats(), st.booleans(), st.none(), st.lists(st.integers(), max_size=2)
    ),
    data=st.data(),
)
def test_any_value_of_a_parameter_makes_a_scene_or_a_scene_error(name, value, data):
    parameter = data.draw(st.sampled_from([*library.entry(name).parameters.model_fields, "odd", "bodies", "version"]))
    if isinstance(value, int) and value > 30:
        value += 10**6  # no large scenes
    try:
        scene = ap.load_scene(name, **{parameter: value})
    except SceneError as error:
        assert str(error).startswith(f"{name}: {parameter}: ")
    else:
        assert scene.bodies


def test_the_boxes_of_a_tower_just_touch():
    heights = [body.position[1] for body in ap.load_scene("tower", height=4).bodies[1:]]
    assert heights == [0.5, 1.5, 2.5, 3.5]


def test_scenes_are_the_same_to_the_bit_everywhere():
    """A digest of all scenes, taken once: another computer must find the same."""
    text = json.dumps([ap.load_scene(name).data() for name in library.names()])
    assert hashlib.sha256(text.encode()).hexdigest()[:16] == "1fcc120a1cb215f9"
