import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from atlasphys.engine.shapes.box import Box
from atlasphys.engine.shapes.capsule import Capsule
from atlasphys.engine.shapes.cone import Cone
from atlasphys.engine.shapes.cylinder import Cylinder
from atlasphys.engine.shapes.hull import ConvexHull
from atlasphys.engine.shapes.mass import mass_properties, principal_axes
from atlasphys.engine.shapes.plane import Plane
from atlasphys.engine.shapes.sphere import Sphere
from atlasphys.errors import InvalidArgumentError
from tests.engine.shapes.examples import SOLIDS, random_hull
from tests.reference.shapes import disc_integrals, grid_integrals, rotation_matrix, tetrahedra_integrals

LENGTHS = st.floats(-3, 3).map(lambda power: 10.0**power)


def assert_integrals(shape, expected, tolerance):
    volume, center, inertia = expected
    size = np.sqrt(np.trace(inertia) / volume)
    assert shape.volume == pytest.approx(volume, rel=tolerance)
    np.testing.assert_allclose(shape.center_of_mass, center, rtol=0, atol=tolerance * (size + np.max(np.abs(center))))
    np.testing.assert_allclose(shape.inertia(), inertia, rtol=0, atol=tolerance * np.max(inertia))


@pytest.mark.parametrize("shape", SOLIDS[:-1], ids=repr)
def test_integrals_agree_with_the_midpoint_rule(shape):
    assert_integrals(shape, grid_integrals(shape), 0.04)
    # An error of the rule, not of the formula, shrinks as cells do.
    assert shape.volume == pytest.approx(grid_integrals(shape, 120)[0], rel=0.015)


@given(LENGTHS, LENGTHS)
def test_solids_of_revolution_agree_with_quadrature_to_round_off(r, h):
    half = 0.5 * h
    assert_integrals(Cylinder(r, h), disc_integrals(lambda y: r + 0.0 * y, [-half, half]), 1e-12)
    assert_integrals(Cone(r, h), disc_integrals(lambda y: r * (0.5 - y / h), [-half, half]), 1e-12)
    assert_integrals(Sphere(r), disc_integrals(lambda y: np.sqrt(r * r - y * y), [-r, 0.0, r]), 1e-12)

    def capsule(y):
        beyond = np.maximum(np.abs(y) - half, 0.0)
        return np.sqrt(np.maximum((r - beyond) * (r + beyond), 0.0))

    assert_integrals(Capsule(r, h), disc_integrals(capsule, [-half - r, -half, half, half + r]), 1e-9)


@pytest.mark.parametrize("seed", range(10))
def test_hulls_agree_with_tetrahedra_to_round_off(seed):
    hull = random_hull(seed, 5 + 10 * seed)
    assert_integrals(hull, tetrahedra_integrals(hull.vertices), 1e-12)


@given(LENGTHS, LENGTHS, LENGTHS)
def test_a_hull_of_a_boxs_corners_has_the_boxs_integrals(x, y, z):
    box = Box((x, y, z))
    try:
        hull = ConvexHull(box.polyhedron.vertices)
    except InvalidArgumentError:
        assert min(x, y, z) < 1e-6 * max(x, y, z)
        return
    assert_integrals(hull, (box.volume, np.zeros(3), np.array(box.inertia())), 1e-12)


def test_far_from_the_origin_a_hull_keeps_its_inertia():
    near, shift = random_hull(3), np.array([1e5, -1e5, 1e5])
    far = ConvexHull(near.vertices + shift)
    assert far.volume == pytest.approx(near.volume, rel=1e-9)
    np.testing.assert_allclose(far.inertia(), near.inertia(), rtol=0, atol=1e-9 * np.max(near.inertia()))
    np.testing.assert_allclose(np.subtract(far.center_of_mass, near.center_of_mass), shift, rtol=1e-12)


@pytest.mark.parametrize("shape", SOLIDS, ids=repr)
def test_mass_and_density_mean_the_same(shape):
    by_density = mass_properties(shape, density=700.0)
    by_mass = mass_properties(shape, mass=700.0 * shape.volume)
    assert by_density == by_mass
    assert by_density.mass == 700.0 * shape.volume
    assert by_density.center == shape.center_of_mass
    rotation = rotation_matrix(by_density.principal)
    tensor = 700.0 * np.array(shape.inertia())
    np.testing.assert_allclose(rotation @ np.diag(by_density.moments) @ rotation.T, tensor, atol=1e-10 * tensor.max())


def tensors():
    """Random symmetric tensors that a body could have, of all orders of magnitude, some with equal moments."""
    moment = st.floats(0.5, 1.0) | st.just(0.75)
    entry = st.floats(-1, 1)
    return st.tuples(st.tuples(moment, moment, moment), st.tuples(entry, entry, entry, entry), LENGTHS)


def tensor_of(moments, q, scale):
    q = np.array(q)
    q = q / np.linalg.norm(q) if np.linalg.norm(q) > 1e-3 else np.array([1.0, 0.0, 0.0, 0.0])
    rotation = rotation_matrix(q)
    tensor = rotation @ np.diag(moments) @ rotation.T * scale
    return 0.5 * (tensor + tensor.T)


@given(tensors())
def test_principal_axes_rebuild_the_tensor(drawn):
    tensor = tensor_of(*drawn)
    moments, q = principal_axes(tuple(map(tuple, tensor.tolist())))
    rotation = rotation_matrix(q)
    assert math.hypot(*q) == pytest.approx(1.0, rel=1e-15)
    assert q[0] >= 0.0
    np.testing.assert_allclose(rotation @ np.diag(moments) @ rotation.T, tensor, rtol=0, atol=1e-10 * tensor.max())
    np.testing.assert_allclose(sorted(moments), np.linalg.eigvalsh(tensor), rtol=1e-10)


@given(st.tuples(*[st.floats(1e-30, 1e30)] * 3))
def test_a_diagonal_tensor_keeps_its_axes_exactly(moments):
    x, y, z = moments
    result = principal_axes(((x, 0.0, 0.0), (0.0, y, 0.0), (0.0, 0.0, z)))
    assert result == (moments, (1.0, 0.0, 0.0, 0.0))


def test_a_rotated_box_has_the_boxs_moments():
    box, rotation = (
        Box((1.0, 2.0, 3.0)),
        rotation_matrix(np.array([0.5, 0.5, -0.1, 0.7]) / np.linalg.norm([0.5, 0.5, -0.1, 0.7])),
    )
    turned = mass_properties(ConvexHull(box.polyhedron.vertices @ rotation.T), mass=2.0)
    np.testing.assert_allclose(sorted(turned.moments), sorted(mass_properties(box, mass=2.0).moments), rtol=1e-12)


def test_a_given_inertia_replaces_the_shapes_own():
    ball = Sphere(1.0)
    assert mass_properties(ball, mass=2.0, inertia=(1, 2, 2.5)).moments == (1.0, 2.0, 2.5)
    tensor = np.array([[2.0, 0.1, 0.0], [0.1, 2.0, 0.0], [0.0, 0.0, 1.5]])
    given_tensor = mass_properties(ball, density=2.0, inertia=tensor)
    assert sorted(given_tensor.moments) == pytest.approx([1.5, 1.9, 2.1])
    assert given_tensor.mass == 2.0 * ball.volume
    mass_properties(ball, mass=1.0, inertia=(1.0, 2.0, 3.0))  # a flat body: the limit of the triangle inequality


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        ({}, "exactly one of mass and density"),
        ({"mass": 1, "density": 1}, "exactly one of mass and density"),
        ({"mass": 0}, "mass must be"),
        ({"mass": -1.0}, "mass must be"),
        ({"mass": True}, "mass must be"),
        ({"mass": math.nan}, "mass must be"),
        ({"mass": 1e-300}, "mass must be"),
        ({"mass": 1e200}, "mass must be"),
        ({"mass": 10**400}, "mass must be"),
        ({"density": 0.0}, "density must be"),
        ({"density": -3}, "density must be"),
        ({"density": 1e300}, "density × volume must be"),
        ({"density": "heavy"}, "density must be"),
        ({"mass": 1e-36}, "each principal moment"),
        ({"mass": 1, "inertia": 3.0}, "inertia must be"),
        ({"mass": 1, "inertia": (1, 1)}, "inertia must be"),
        ({"mass": 1, "inertia": "abc"}, "inertia must be"),
        ({"mass": 1, "inertia": (1, 1, math.inf)}, r"inertia\[2\] must be"),
        ({"mass": 1, "inertia": (1, 1, 0)}, "each principal moment"),
        ({"mass": 1, "inertia": (1, 1, -1)}, "each principal moment"),
        ({"mass": 1, "inertia": (1, 1, 2.1)}, "no principal moment is greater"),
        ({"mass": 1, "inertia": [[1, 0, 0], [0, 1, 0], [0, 0]]}, r"inertia\[2\] must be"),
        ({"mass": 1, "inertia": [[1, 0.5, 0], [0, 1, 0], [0, 0, 1]]}, "symmetric"),
        ({"mass": 1, "inertia": [[1, 2, 0], [2, 1, 0], [0, 0, 1]]}, "each principal moment"),
        ({"mass": 1, "inertia": [[1e308, -1e308, 0], [-1e308, -1e308, 0], [0, 0, 1]]}, "each principal moment"),
    ],
)
def test_wrong_masses_are_refused_with_the_reason(arguments, reason):
    with pytest.raises(InvalidArgumentError, match=reason):
        mass_properties(Sphere(0.1), **arguments)


def test_a_plane_has_no_mass():
    for call in (
        lambda: mass_properties(Plane(), mass=1.0),
        lambda: Plane().center_of_mass,
        lambda: Plane().inertia(),
    ):
        with pytest.raises(InvalidArgumentError, match="plane"):
            call()
    assert Plane().volume == math.inf
