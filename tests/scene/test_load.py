"""Scene files: what is right loads, what is wrong is said with file, line and path, and nothing else is ever raised."""

import copy
import json
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import atlasphys as ap
from atlasphys.errors import SceneError
from atlasphys.scene.load import parse_scene

WRONG = """\
version = 1
seconds = "long"

[world]
gravity = [0, -9.81]
presett = "classic"

[[bodies]]
shape = { type = "spher", radius = 1 }

[[bodies]]
name = "crate"
mas = 3
  [bodies.shape]
  type = "sphere"
  radius = -0.5

[[bodies]]
shape = { type = "plane", normal = [0, 0, 0] }
kind = "statik"

[[bodies]]
shape = { type = "box", size = [1, nan, true] }
position = [1, 2, 3, 4]
inertia = [1, 2]
color = "red"
locks = ["x", "w"]

[[bodies]]
position = "here"
[[bodies]]
shape = {radius = 1}
"""

FAULTS = """\
scene.toml:2: seconds: must be a number (got 'long')
scene.toml:5: world.gravity: must have 3 entries (got [0, -9.81])
scene.toml:6: world.presett: unknown key; did you mean 'preset'?
scene.toml:9: bodies[0].shape.type: unknown shape 'spher'; did you mean 'sphere'?
scene.toml:13: bodies[1].mas: unknown key; did you mean 'mass'?
scene.toml:16: bodies[1].shape.radius: must be greater than 0 (got -0.5)
scene.toml:19: bodies[2].shape.normal: must be a vector that is not zero (got (0.0, 0.0, 0.0))
scene.toml:20: bodies[2].kind: must be 'dynamic', 'static' or 'kinematic' (got 'statik'); did you mean 'static'?
scene.toml:23: bodies[3].shape.size[1]: must be a finite number (got nan)
scene.toml:23: bodies[3].shape.size[2]: must be a number (got True)
scene.toml:24: bodies[3].position: must have 3 entries (got [1, 2, 3, 4])
scene.toml:25: bodies[3].inertia: must be three moments, or three rows of three numbers (got [1, 2])
scene.toml:26: bodies[3].color: must be '#rrggbb', or three numbers from 0 to 1 (got 'red')
scene.toml:27: bodies[3].locks[1]: must be 'x', 'y', 'z', 'rx', 'ry' or 'rz' (got 'w'); known: x, y, z, rx, ry, rz
scene.toml:29: bodies[4].shape: is required
scene.toml:30: bodies[4].position: must be an array (got 'here')
scene.toml:32: bodies[5].shape: must have a key 'type', one of plane, sphere, box, capsule, cylinder, cone, \
convex_hull, tetrahedron, pyramid, octahedron
"""


def refusal(text, name="scene.toml", is_json=False):
    with pytest.raises(SceneError) as error:
        parse_scene(text, name=name, is_json=is_json)
    return str(error.value)


def test_all_faults_are_said_at_once_with_their_lines():
    assert refusal(WRONG).splitlines() == FAULTS.splitlines()


def test_faults_of_json_have_lines_too():
    body = '{"shape": {"type": "sphere",\n   "radius": -0.5}}'
    text = f'{{\n "version": 1,\n "bodies": [\n  {body}\n ],\n "dt": 1,\n "dt": 2\n}}'
    assert refusal(text, "a.json", is_json=True) == "a.json:8: dt: is given twice"
    assert (
        refusal(text.replace('"dt": 2', '"x": 2'), "a.json", is_json=True)
        == "a.json:5: bodies[0].shape.radius: must be greater than 0 (got -0.5)\n"
        "a.json:8: x: unknown key; known: version, name, description, seconds, dt, world, bodies, joints"
    )


def test_what_the_world_refuses_is_said_with_path_and_line_too():
    text = """\
version = 1
[world]
solver = "magic"
[[bodies]]
shape = { type = "sphere", radius = 1 }
mass = 1
density = 2
[[bodies]]
shape = { type = "sphere", radius = 1 }
position = [1e300, 0, 0]
name = "a"
[[bodies]]
shape = { type = "plane" }
kind = "dynamic"
[[bodies]]
name = "a"
shape = { type = "sphere", radius = 1 }
"""
    scene = parse_scene(text, name="scene.toml", is_json=False)
    with pytest.raises(SceneError) as error:
        scene.build()
    lines = str(error.value).splitlines()
    assert [line.split(": ")[0] for line in lines] == ["scene.toml:3", "scene.toml:4", "scene.toml:10", "scene.toml:12"]
    assert "world.solver: must be one of 'soft_step', 'sequential_impulse'" in lines[0]
    assert "bodies[0]: " in lines[1]
    assert "mass" in lines[1]
    assert "bodies[1].position: must be" in lines[2]
    assert "plane" in lines[3]


def test_two_bodies_of_one_name_are_refused():
    ball = {"shape": {"type": "sphere", "radius": 1}, "name": "a"}
    with pytest.raises(SceneError, match=r"bodies\[1\].*'a' is already taken"):
        ap.Scene([ball, ball]).build()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("version = ", "scene.toml:1:11: not valid TOML: Invalid value"),
        ("version = 1\nx = [1,\n", "scene.toml:3:1: not valid TOML: "),
        ("version = 1\nversion = 1", "scene.toml:2:12: not valid TOML: Cannot overwrite a value"),
        ("", "scene.toml: is empty; a scene begins with version = 1"),
        ("# nothing\n", "scene.toml: is empty"),
        ("bodies = []", "scene.toml:1: version: is required"),
        ("\nversion = 2", "scene.toml:2: version: is 2, and this version of AtlasPhys reads scenes of version 1"),
        ("version = -1", "version: is -1"),
        ("version = '1'", "scene.toml:1: version: must be a whole number (got '1')"),
        ("version = true", "scene.toml:1: version: must be a whole number (got True)"),
        ("version = 1.5", "scene.toml:1: version: must be a whole number (got 1.5)"),
        ("version = " + "9" * 5000, "too many digits"),
        ("version = 1\nx = " + "[" * 5000 + "]" * 5000, "nested too deeply"),
        ("version = 1\nseconds = 1e999", "scene.toml:2: seconds: must be a finite number (got inf)"),
        ("version = 1\nseconds = 0", "scene.toml:2: seconds: must be greater than 0 (got 0)"),
        ("version = 1\nworld = 3", "scene.toml:2: world: must be a table (got 3)"),
        ("version = 1\nbodies = {a = 3}", "scene.toml:2: bodies: must be an array (got {'a': 3})"),
        ("version = 1\nbodies = [3]", "scene.toml:2: bodies[0]: must be a table (got 3)"),
        ("version = 1\n[world.solver_settings]\niterations = [1]", "world.solver_settings"),
        ("version = 1\n[[bodies]]\nshape = {type = 'sphere', radius = 1e30}", "shape.radius: must be a length between"),
        (
            "version = 1\n[[bodies]]\nshape = {type = 'sphere', radius = " + "9" * 400 + "}",
            "shape.radius: must be a number",
        ),
        (
            "version = 1\n[[bodies]]\nshape = {type = 'convex_hull', points = [[0, 0, 0]]}",
            "shape.points: must be at least 4",
        ),
        (
            "version = 1\n[[bodies]]\nshape = {type = 'pyramid', sides = 2, radius = 1, height = 1}",
            "shape.sides: must be greater",
        ),
        (
            "version = 1\n[[bodies]]\nshape = {type = 'pyramid', sides = 4.0, radius = 1, height = 1}",
            "shape.sides: must be a whole",
        ),
        ("version = 1\n[[bodies]]\nshape = 'box'", "bodies[0].shape: must be a table (got 'box')"),
        ("version = 1\nname = ''", "name: must have at least 1 character (got '')"),
    ],
)
def test_what_is_wrong_with_a_text_is_said(text, message):
    assert message in refusal(text)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "a.json:1:1: not valid JSON: Expecting value"),
        ("[]", "a.json:1: must be an object with the keys of a scene (got [])"),
        ("{}", "a.json: is empty"),
        ('{"version": 1, "seconds": NaN}', "a.json:1: seconds: must be a finite number (got nan)"),
        ('{"version": 1, "name": "\\ud800"}', "name: must"),
        ("[" * 100_000, "nested too deeply"),
    ],
)
def test_what_is_wrong_with_a_json_text_is_said(text, message):
    assert message in refusal(text, "a.json", is_json=True)


def test_files_that_cannot_be_read_are_refused(tmp_path):
    (tmp_path / "latin.toml").write_bytes(b"name = '\xff'")
    for name, message in (
        ("latin.toml", "is not UTF-8 text"),
        ("missing.toml", "cannot be read: No such file"),
        (".", "cannot be read: Is a directory"),
        ("a\0b", "cannot be read"),
        ("x" * 300 + ".toml", "cannot be read"),
    ):
        with pytest.raises(SceneError, match=message):
            ap.load_scene(tmp_path / name)


def test_a_name_that_is_neither_scene_nor_file_is_refused_with_the_nearest():
    with pytest.raises(SceneError, match="neither a scene of the library nor a file; did you mean 'tower'"):
        ap.load_scene("towr")
    with pytest.raises(SceneError, match="known: demo, two_boxes"):
        ap.load_scene("zzzzzz")


def test_a_byte_order_mark_is_no_matter(tmp_path):
    (tmp_path / "a.toml").write_bytes(b"\xef\xbb\xbfversion = 1\r\nname = 'x'\r\n")
    assert ap.load_scene(tmp_path / "a.toml").name == "x"


def test_a_file_has_no_parameters(tmp_path):
    (tmp_path / "a.toml").write_text("version = 1")
    with pytest.raises(SceneError, match=r"has no parameters \(got height\)"):
        ap.load_scene(tmp_path / "a.toml", height=3)


GOOD = {
    "version": 1,
    "name": "all",
    "seconds": 2.5,
    "dt": 0.01,
    "world": {
        "gravity": [0, -1, 0],
        "precision": "double",
        "solver": "sequential_impulse",
        "solver_settings": {"iterations": 5, "position_correction": "baumgarte"},
        "restitution_threshold": 0.5,
        "friction_combine": "min",
    },
    "bodies": [
        {"shape": {"type": "plane", "normal": [0, 1, 0], "offset": -1.0}, "name": "ground"},
        {
            "shape": {"type": "box", "size": [1, 2, 3]},
            "name": "crate",
            "position": [0, 5, 0],
            "orientation": [1, 0, 0, 1],
            "velocity": [1, 0, 0],
            "angular_velocity": [0, 0, 1],
            "mass": 3,
            "inertia": [[2, 0.1, 0], [0.1, 3, 0], [0, 0, 4]],
            "friction": 0.25,
            "restitution": 0.5,
            "rolling_friction": 0.125,
            "torsional_friction": 0.5,
            "linear_damping": 0.25,
            "angular_damping": 0.5,
            "gravity_scale": 2,
            "locks": ["x", "rz"],
            "group": 2,
            "mask": 5,
            "color": "#ff0000",
        },
        {"shape": {"type": "capsule", "radius": 0.5, "length": 1}, "kind": "kinematic", "position": [0, 9, 0]},
        {"shape": {"type": "cylinder", "radius": 0.5, "length": 1}, "density": 500, "position": [0, 12, 0]},
        {"shape": {"type": "cone", "radius": 0.5, "height": 1}, "position": [0, 15, 0], "inertia": [1, 2, 2.5]},
        {
            "shape": {"type": "convex_hull", "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]},
            "position": [0, 18, 0],
        },
    ],
}


def test_every_setting_reaches_the_world():
    scene = parse_scene(json.dumps(GOOD), name="all", is_json=True)
    world = scene.build()
    assert (scene.name, scene.seconds, scene.dt) == ("all", 2.5, 0.01)
    assert (world.precision, world.friction_combine, world.restitution_threshold) == ("double", "min", 0.5)
    assert world.solver_settings == ap.SequentialImpulse(iterations=5, position_correction="baumgarte")
    crate = world.bodies["crate"]
    assert crate.shape == ap.Box(size=(1, 2, 3))
    assert crate.mass == 3
    assert crate.orientation.tolist() == pytest.approx([math.sqrt(0.5), 0, 0, math.sqrt(0.5)])
    for name in (
        "friction",
        "restitution",
        "rolling_friction",
        "torsional_friction",
        "linear_damping",
        "angular_damping",
    ):
        assert getattr(crate, name) == GOOD["bodies"][1][name]
    assert (crate.gravity_scale, crate.locks, crate.color) == (2, ("x", "rz"), (1, 0, 0))
    assert [body.kind for body in world.bodies] == ["static", "dynamic", "kinematic", "dynamic", "dynamic", "dynamic"]


def test_a_world_makes_a_scene_that_makes_the_world_again():
    world = parse_scene(json.dumps(GOOD), name="all", is_json=True).build()
    again = ap.Scene.from_world(world).build()
    for old, new in zip(world.bodies, again.bodies, strict=True):
        assert (old.name, old.kind, old.shape, old.mass, old.locks, old.color) == (
            new.name,
            new.kind,
            new.shape,
            new.mass,
            new.locks,
            new.color,
        )
        assert old.position.tolist() == new.position.tolist()
        assert old.velocity.tolist() == new.velocity.tolist()
        assert old.orientation.tolist() == pytest.approx(new.orientation.tolist(), abs=1e-15)
        if old.kind == "dynamic":
            assert sorted(old.inertia) == pytest.approx(sorted(new.inertia), rel=1e-6)
    assert again.solver_settings == world.solver_settings
    assert again.bodies[1].group == 2
    assert again.bodies[1].mask == 5


def test_any_name_of_a_body_is_one_in_a_scene():
    world = ap.World()
    world.add(ap.Sphere(radius=0.5), name="long" * 100)
    assert ap.Scene.from_world(world).build().bodies.names == world.bodies.names


@pytest.mark.parametrize("ending", [".toml", ".json", ".JSON"])
def test_a_saved_scene_loads_equal(tmp_path, ending):
    scene = parse_scene(
        json.dumps(GOOD | {"description": "quotes \" \\ ' and\nlines ☃ \x7f"}), name="all", is_json=True
    )
    scene.save(tmp_path / f"a{ending}")
    assert ap.load_scene(tmp_path / f"a{ending}") == scene


def test_a_key_of_any_text_is_saved_and_loaded(tmp_path):
    scene = ap.Scene(world={"solver": "sequential_impulse", "solver_settings": {"a b": 1, "": 2, 'quo"te': 3}})
    scene.save(tmp_path / "a.toml")
    assert ap.load_scene(tmp_path / "a.toml") == scene


def test_saving_where_one_cannot_is_refused(tmp_path):
    with pytest.raises(SceneError, match="cannot be written"):
        ap.Scene().save(tmp_path / "missing" / "a.toml")
    with pytest.raises(SceneError, match="cannot be written"):
        ap.Scene().save("a\0.toml")


ANYTHING = st.recursive(
    st.one_of(
        st.none(),
        st.booleans(),
        st.integers(),
        st.sampled_from([10**400, -(10**30), 2**63, 0, 1]),
        st.floats(),
        st.sampled_from([1e-320, 1e-30, 1e30, 1e308, -0.0, math.nan, math.inf]),
        st.text(max_size=5),
        st.sampled_from(["box", "plane", "dynamic", "static", "classic", "sweep", "double", "x"]),
    ),
    lambda inner: st.one_of(
        st.lists(inner, max_size=4),
        st.dictionaries(st.sampled_from(["type", "radius", "size", "odd", ""]), inner, max_size=3),
    ),
    max_leaves=6,
)


def places(data, path=()):
    yield path
    entries = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, value in entries:
        yield from places(value, (*path, key))


PLACES = [path for path in places(GOOD) if path]


@settings(deadline=None, derandomize=True, max_examples=250)
@given(changes=st.lists(st.tuples(st.sampled_from(PLACES), ANYTHING, st.booleans()), min_size=1, max_size=4))
def test_wrong_values_anywhere_are_a_scene_error_and_nothing_else(changes):
    data = copy.deepcopy(GOOD)
    for path, value, remove in changes:
        holder = data
        try:
            for key in path[:-1]:
                holder = holder[key]
            if remove:
                del holder[path[-1]]
            else:
                holder[path[-1]] = value
        except (LookupError, TypeError):
            continue
    try:
        text = json.dumps(data, indent=1)
    except ValueError:
        return  # an integer that Python does not print
    try:
        world = parse_scene(text, name="scene.json", is_json=True).build()
    except SceneError as error:
        for line in str(error).splitlines():
            assert line.startswith("scene.json:")
            assert len(line) < 400
    else:
        assert all(math.isfinite(x) for x in world.bodies.position.ravel())


@settings(deadline=None, derandomize=True, max_examples=100)
@given(data=ANYTHING)
def test_any_value_for_a_scene_is_a_scene_error(data):
    with pytest.raises(SceneError):
        ap.Scene(bodies=[{"shape": data}])


@settings(deadline=None, derandomize=True, max_examples=150)
@given(text=st.one_of(st.text(max_size=60), st.binary(max_size=60)), ending=st.sampled_from([".toml", ".json"]))
def test_any_file_is_a_scene_or_a_scene_error(tmp_path_factory, text, ending):
    path = tmp_path_factory.getbasetemp() / f"any{ending}"
    path.write_bytes(text if isinstance(text, bytes) else text.encode("utf-8", "surrogatepass"))
    with pytest.raises(SceneError):
        ap.load_scene(path)


@settings(deadline=None, derandomize=True, max_examples=150)
@given(
    place=st.integers(0, len(WRONG)), text=st.text(alphabet="[]{}=\"',.#\n\\ a1", max_size=4), drop=st.integers(0, 6)
)
def test_any_edit_of_a_file_is_a_scene_or_a_scene_error(place, text, drop):
    edited = WRONG[:place] + text + WRONG[place + drop :]
    assert refusal(edited).startswith("scene.toml:")
