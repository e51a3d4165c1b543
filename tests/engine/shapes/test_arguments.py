import copy
import math
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from atlasphys.engine.shapes.box import Box
from atlasphys.engine.shapes.capsule import Capsule
from atlasphys.engine.shapes.cone import Cone
from atlasphys.engine.shapes.cylinder import Cylinder
from atlasphys.engine.shapes.hull import ConvexHull, octahedron, pyramid, tetrahedron
from atlasphys.engine.shapes.mass import mass_properties
from atlasphys.engine.shapes.plane import Plane
from atlasphys.engine.shapes.sphere import Sphere
from atlasphys.errors import InvalidArgumentError
from tests.engine.shapes.examples import SOLIDS

NOT_LENGTHS = [
    0,
    -1,
    0.0,
    -0.0,
    1e-300,
    1e200,
    1e-7,
    1e7,
    math.nan,
    math.inf,
    -math.inf,
    10**400,
    True,
    None,
    "1",
    [1],
    1j,
    (),
    np.array(1.0),
    np.array([1.0]),
]
ANYTHING = (
    st.floats()
    | st.integers()
    | st.none()
    | st.booleans()
    | st.text()
    | st.lists(st.floats() | st.integers() | st.text(max_size=2), max_size=4)
    | st.dictionaries(st.integers(), st.integers(), max_size=3)
    | st.just(10**400)
    | st.just(np.float32(0.5))
    | st.builds(np.array, st.lists(st.floats(), max_size=4))
)


@pytest.mark.parametrize("bad", NOT_LENGTHS, ids=repr)
def test_what_is_no_length_is_refused_by_name(bad):
    makers = {
        "radius": [
            Sphere,
            lambda v: Capsule(v, 1),
            lambda v: Cylinder(v, 1),
            lambda v: Cone(v, 1),
            tetrahedron,
            octahedron,
            lambda v: pyramid(4, v, 1),
        ],
        "length": [lambda v: Capsule(1, v), lambda v: Cylinder(1, v)],
        "height": [lambda v: Cone(1, v), lambda v: pyramid(4, 1, v)],
        r"size\[1\]": [lambda v: Box((1, v, 1))],
    }
    for name, calls in makers.items():
        for call in calls:
            with pytest.raises(
                InvalidArgumentError, match=rf"^{name} must be a length between 1e-06 and 1e\+06 m \(got "
            ):
                call(bad)


@given(ANYTHING, ANYTHING, ANYTHING)
def test_any_argument_makes_a_usable_shape_or_a_clear_error(a, b, c):
    for make in (
        lambda: Sphere(a),
        lambda: Box(a),
        lambda: Box((a, b, c)),
        lambda: Capsule(a, b),
        lambda: Cylinder(a, b),
        lambda: Cone(a, b),
        lambda: pyramid(a, b, c),
        lambda: ConvexHull(a),
        lambda: ConvexHull([a, b, c, a]),
    ):
        try:
            shape = make()
        except InvalidArgumentError as error:
            assert "must" in str(error) or "points" in str(error)
            continue
        properties = mass_properties(shape, density=1000.0)
        with np.errstate(over="raise", under="raise"):
            held = np.array([properties.mass, *properties.moments]).astype(np.float32)
            assert np.all(np.isfinite(1 / held))


@given(ANYTHING, ANYTHING)
def test_any_plane_has_a_unit_normal_or_is_refused(normal, offset):
    try:
        plane = Plane(normal, offset)
    except InvalidArgumentError as error:
        assert str(error).startswith(("normal", "offset"))
    else:
        assert math.hypot(*plane.normal) == pytest.approx(1.0, rel=1e-15)
        assert abs(plane.offset) <= 1e6


@given(st.tuples(*[st.floats(-1e300, 1e300)] * 3).filter(any))
def test_a_planes_normal_keeps_its_direction_and_is_a_fixed_point(normal):
    plane = Plane(normal, 1)
    scaled = np.array(normal) / max(map(abs, normal))
    np.testing.assert_allclose(plane.normal, scaled / np.linalg.norm(scaled), atol=1e-15)
    assert Plane(plane.normal, 1) == plane


@pytest.mark.parametrize("bad", [0, 2, 3.0, -4, True, None, "4", 10**6])
def test_a_pyramid_needs_a_whole_number_of_sides(bad):
    with pytest.raises(InvalidArgumentError, match=r"^sides must be a whole number from 3 to 1000"):
        pyramid(bad, 1.0, 1.0)


@pytest.mark.parametrize(
    "bad",
    [5, None, "abc", b"abc", {1, 2, 3}, {0: 1, 1: 1, 2: 1}, (1, 1), (1, 1, 1, 1), iter((1, 1, 1)), np.eye(3)],
    ids=lambda bad: type(bad).__name__,
)
def test_a_size_is_three_lengths(bad):
    with pytest.raises(InvalidArgumentError, match=r"^size"):
        Box(bad)


def test_numpy_numbers_and_integers_become_floats():
    assert Box(np.array([1, 2, 3])) == Box((1.0, 2.0, 3.0)) == Box([np.float32(1), 2, np.int8(3)])
    assert type(Sphere(np.float32(0.5)).radius) is float
    assert Plane() == Plane(normal=(0, 2, 0), offset=0) == Plane((-0.0, 1e-200, -0.0), -0.0)


@pytest.mark.parametrize("shape", [*SOLIDS, Plane((1, 2, 3), 0.5)], ids=repr)
def test_shapes_are_immutable_values(shape):
    for twin in (pickle.loads(pickle.dumps(shape)), copy.deepcopy(shape), copy.copy(shape)):
        assert twin == shape
        assert hash(twin) == hash(shape)
        assert repr(twin) == repr(shape)
        assert twin.volume == shape.volume
    assert not hasattr(shape, "__dict__")
    with pytest.raises((AttributeError, TypeError)):
        shape.radius = 3.0
    with pytest.raises((AttributeError, TypeError)):
        shape.kind = 3


def test_unequal_shapes_differ():
    shapes = [*SOLIDS, Plane(), Plane((1, 0, 0)), Plane(offset=1), Cylinder(0.3, 1.1), Cone(0.3, 1.1)]
    assert len(set(shapes)) == len(shapes)


def test_repr_can_be_read():
    assert repr(Box((1, 1, 1))) == "Box(size=(1.0, 1.0, 1.0))"
    assert repr(Capsule(0.5, 2)) == "Capsule(radius=0.5, length=2.0)"
    assert repr(Plane()) == "Plane(normal=(0.0, 1.0, 0.0), offset=0.0)"
    assert repr(octahedron(0.5)) == "ConvexHull(6 vertices, 8 faces, 1 × 1 × 1 m)"
