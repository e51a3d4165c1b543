import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from atlasphys.engine.shapes.box import Box
from atlasphys.engine.shapes.hull import COPLANAR, ConvexHull, octahedron, pyramid, tetrahedron
from atlasphys.engine.shapes.polyhedron import edges_of
from atlasphys.errors import InvalidArgumentError
from tests.reference.shapes import rotation_matrix


def random_points(seed):
    """Awkward points: on a grid, stretched, on a ball, in clusters, in prisms, rounded to single precision."""
    rng = np.random.default_rng(seed)
    p = rng.normal(size=(int(rng.integers(4, 60)), 3))
    rotation = rotation_matrix(np.array([0.8, 0.0, 0.6, 0.0]))
    match seed % 8:
        case 0:
            return p
        case 1:
            return np.round(2.0 * p) / 2.0
        case 2:
            return p * 10.0 ** rng.uniform(-3, 3, 3)
        case 3:
            return p / np.linalg.norm(p, axis=1)[:, None]
        case 4:
            return p * 10.0 ** rng.uniform(-3, 3, (len(p), 1))
        case 5:
            return np.concatenate([p, p + 1e-8 * rng.normal(size=p.shape), p + 1e-6 * rng.normal(size=p.shape)])
        case 6:
            turns = np.linspace(0, 2 * math.pi, 10 * len(p), endpoint=False)
            ring = np.stack([np.cos(turns), 0 * turns, np.sin(turns)], axis=1)
            return np.concatenate([ring, 0.3 * ring + (0, 1, 0)]) @ rotation
        case _:
            return (np.round(rng.uniform(-2, 2, (300, 3))) @ rotation).astype(np.float32).astype(float)


def check_polyhedron(hull):
    """Faces close up, are convex, face outwards and hold all vertices inside."""
    vertices, planes = np.array(hull.vertices), np.array(hull.planes)
    extent = np.max(np.ptp(vertices, axis=0))
    edges = edges_of(hull.faces)
    assert len(vertices) - len(edges) + len(hull.faces) == 2  # Euler
    assert sum(map(len, hull.faces)) == 2 * len(edges)
    assert len({(a, b) for a, b, _, _ in edges}) == len(edges)
    assert sorted({v for face in hull.faces for v in face}) == list(range(len(vertices)))
    assert list(hull.vertices) == sorted(hull.vertices)
    assert list(hull.faces) == sorted(hull.faces)
    np.testing.assert_allclose(np.linalg.norm(planes[:, :3], axis=1), 1.0, rtol=1e-14)
    height = vertices @ planes[:, :3].T - planes[:, 3]
    assert np.max(height) <= 2 * COPLANAR * extent
    for number, face in enumerate(hull.faces):
        assert face[0] == min(face)
        assert np.max(np.abs(height[list(face), number])) <= 4 * COPLANAR * extent
    for a, b, left, right in edges:
        assert a < b
        around = [hull.faces[left], hull.faces[right][::-1]]
        for face in around:
            assert face[(face.index(a) + 1) % len(face)] == b


@pytest.mark.parametrize("seed", range(48))
def test_hulls_of_awkward_points_are_closed_convex_and_independent_of_their_order(seed):
    points = random_points(seed)
    hull = ConvexHull(points)
    check_polyhedron(hull)
    planes = np.array(hull.planes)
    extent = np.max(np.ptp(points, axis=0))
    assert np.max(points @ planes[:, :3].T - planes[:, 3]) <= 2 * COPLANAR * extent

    for twin in (ConvexHull(np.random.default_rng(seed).permutation(points)), ConvexHull(hull.vertices)):
        assert twin == hull
        assert twin.faces == hull.faces
        assert twin.planes == hull.planes
        assert twin.inertia() == hull.inertia()


def test_a_box_of_points_has_the_boxs_faces_and_edges():
    box, extra = Box((1.0, 2.0, 3.0)), [(0, 0, 0), (0.5, 0, 0), (0.5, 1, 0), (0.5, 1.0, 1.5)]
    hull = ConvexHull(np.concatenate([box.polyhedron.vertices, extra]))
    np.testing.assert_array_equal(hull.polyhedron.vertices, box.polyhedron.vertices)
    assert set(hull.faces) == {tuple(face) for face in box.polyhedron.face_vertices.reshape(6, 4).tolist()}
    assert {tuple(edge) for edge in hull.polyhedron.edges[:, :2].tolist()} == {
        tuple(edge) for edge in box.polyhedron.edges[:, :2].tolist()
    }
    assert set(hull.planes) == {tuple(plane) for plane in box.polyhedron.planes.tolist()}


def test_scales_from_a_millimetre_to_a_kilometre_stay_apart():
    hull = ConvexHull(Box((1e-3, 1.0, 1e3)).polyhedron.vertices)
    assert (len(hull.vertices), len(hull.faces)) == (8, 6)
    assert hull.volume == pytest.approx(1.0)
    needle = ConvexHull([(0, 0, 0), (1e-3, 0, 0), (0, 1e-3, 0), (0, 0, 1e3)])
    assert needle.volume == pytest.approx(1e-3 / 6)


def test_a_finely_cut_ball_stays_a_ball():
    turns = np.arange(600) * math.pi * (3 - math.sqrt(5))
    y = 1 - 2 * (np.arange(600) + 0.5) / 600
    points = np.stack([np.sqrt(1 - y * y) * np.cos(turns), y, np.sqrt(1 - y * y) * np.sin(turns)], axis=1)
    hull = ConvexHull(points)
    check_polyhedron(hull)
    assert len(hull.vertices) == 600
    assert hull.volume == pytest.approx(4 / 3 * math.pi, rel=0.02)


@pytest.mark.parametrize(
    ("points", "reason"),
    [
        (np.zeros((3, 3)), "at least 4"),
        (np.zeros((0, 3)), "at least 4"),
        (np.zeros((5, 2)), "shape"),
        (np.zeros(12), "shape"),
        (np.zeros((2, 2, 3)), "shape"),
        (np.zeros((8, 3)), "coincide"),
        ([(k, 2 * k, -k) for k in range(6)], "one line"),
        ([(0, 0, 0), (1, 1, 1e-9), (2, 2, 0), (3, 3, 0)], "one line"),
        ([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0), (0.5, 0.2, 0)], "one plane"),
        ([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 1e-8)], "one plane"),
        ([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, math.nan)], r"points\[3\] must be finite"),
        ([(0, 0, 0), (1, 0, 0), (0, math.inf, 0), (0, 0, 1)], r"points\[2\] must be finite"),
        ([(0, 0, 0), (1, 0, 0), (0, 1e7, 0), (0, 0, 1)], r"points\[2\] must be finite"),
        (1e-9 * np.eye(4, 3), "coincide"),
        ([(0, 0, 0), (1, 0, 0), (0, 1), (0, 0, 1)], "must be an"),
        ([(0, 0, 0), (1, 0, 0), (0, "a", 0), (0, 0, 1)], "must be an"),
        (np.eye(4, 3) * 1j, "must be an"),
        (np.eye(4, 3) > 0, "must be an"),
        ("four points", "must be an"),
        (None, "must be an"),
        ({(0, 0, 0), (1, 0, 0)}, "must be an"),
        ([(0, 0, 0), (1, 0, 0), (0, 10**400, 0), (0, 0, 1)], "must be an"),
    ],
)
def test_points_without_a_hull_are_refused_with_the_reason(points, reason):
    with pytest.raises(InvalidArgumentError, match=f"^points.*{reason}|^{reason}"):
        ConvexHull(points)


COORDINATE = st.sampled_from([0.0, 1.0, -1.0, 0.5, 1e-7, 1.0 + 1e-7, 1e-8, 1e-3]) | st.floats(-2, 2)


@settings(max_examples=200)
@given(st.lists(st.tuples(COORDINATE, COORDINATE, COORDINATE), min_size=4, max_size=12))
def test_nearly_degenerate_points_make_a_sound_hull_or_a_clear_error(points):
    try:
        hull = ConvexHull(points)
    except InvalidArgumentError as error:
        assert str(error).startswith("points")
    else:
        check_polyhedron(hull)
        assert hull.volume > 0.0


def test_the_regular_solids():
    corner = np.array(tetrahedron(2.0).vertices)
    np.testing.assert_allclose(np.linalg.norm(corner, axis=1), 2.0)
    gaps = np.linalg.norm(corner[:, None] - corner, axis=2)[np.triu_indices(4, 1)]
    np.testing.assert_allclose(gaps, 2.0 * math.sqrt(8.0 / 3.0))
    np.testing.assert_allclose(tetrahedron(2.0).center_of_mass, 0.0, atol=1e-15)

    assert len(octahedron(1.0).faces) == 8
    assert octahedron(0.5).volume == pytest.approx(4 / 3 * 0.5**3)

    for sides in (3, 4, 5, 6, 50):
        solid = pyramid(sides, 0.5, 2.0)
        assert len(solid.vertices) == sides + 1
        assert sorted(map(len, solid.faces)) == sorted([3] * sides + [sides])
        assert solid.volume == pytest.approx(sides / 2 * 0.25 * math.sin(2 * math.pi / sides) * 2.0 / 3)
        np.testing.assert_allclose(solid.center_of_mass, (0.0, -0.5, 0.0), atol=1e-11)
        assert (0.0, 1.0, 0.0) in solid.vertices
        assert {y for _, y, _ in solid.vertices} == {1.0, -1.0}
