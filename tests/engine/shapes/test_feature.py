import math

import numpy as np
import pytest

from atlasphys.engine.shapes.box import Box
from atlasphys.engine.shapes.capsule import Capsule
from atlasphys.engine.shapes.cone import Cone
from atlasphys.engine.shapes.cylinder import Cylinder
from atlasphys.engine.shapes.feature import ALIGNED
from atlasphys.engine.shapes.plane import Plane
from atlasphys.engine.shapes.sphere import Sphere
from atlasphys.engine.shapes.table import FEATURE_POINTS, ShapeTable
from tests.engine.shapes.examples import PRECISIONS, SOLIDS, directions
from tests.engine.shapes.probes import probe_feature, probe_support
from tests.reference.shapes import core_points


def feature(arrays, row, d, real):
    points, ids = np.full((40, 3), np.nan, real), np.full(40, -1, np.int32)
    count = probe_feature(arrays, row, *np.asarray(d, real), points, ids)
    assert np.all(np.isnan(points[count:]))
    assert np.all(ids[count:] == -1)
    return points[:count].astype(float), ids[:count].tolist()


@pytest.mark.parametrize("real", PRECISIONS)
def test_a_feature_is_a_nearly_farthest_part_of_the_core(real):
    shapes = ShapeTable(real, SOLIDS)
    for row, shape in enumerate(SOLIDS):
        size = np.max(np.abs(core_points(shape)), initial=1e-3)
        polyhedron = shape.polyhedron
        if polyhedron is not None:
            ends = np.cumsum(polyhedron.face_sizes)[:-1]
            faces = [face.tolist() for face in np.split(polyhedron.face_vertices, ends)]
        for d in directions(row):
            points, ids = feature(shapes.arrays, row, d, real)
            count = len(points)
            assert 1 <= count <= shapes.arrays.layout[row, FEATURE_POINTS]
            assert len(set(ids)) == count
            assert min(ids) >= 0
            farthest = np.dot(d, probe_support(shapes.arrays, row, *d.astype(real))[0])
            assert np.max(points @ d) <= farthest + 1e-6 * size
            if polyhedron is not None:
                along = polyhedron.planes[:, :3] @ d
                assert along[faces.index(ids)] >= np.max(along) - 1e-6
                np.testing.assert_allclose(points, polyhedron.vertices[ids].astype(real))
            elif count == 1:
                assert points[0] @ d == pytest.approx(farthest, abs=1e-6 * size)
            elif count == 2:
                # The ends differ along d by no more than their distance times the sine of the tilt allowed.
                assert np.min(points @ d) >= farthest - (ALIGNED + 1e-5) * np.linalg.norm(points[1] - points[0])
            else:
                normal = polygon_normal(points)
                assert abs(normal[1]) == pytest.approx(1.0)
                assert normal @ d >= math.sqrt(1 - ALIGNED**2) - 1e-3


def polygon_normal(points):
    """Unit normal of a polygon, outward if it is counter-clockwise from outside."""
    fan = points[1:] - points[0]
    normal = np.sum(np.cross(fan[:-1], fan[1:]), axis=0)
    return normal / np.linalg.norm(normal)


def row_feature(shape, d, real=np.float64):
    return feature(ShapeTable(real, [shape]).arrays, 0, d, real)


@pytest.mark.parametrize("real", PRECISIONS)
def test_rims_are_octagons_in_the_flat_ends(real):
    top, top_ids = row_feature(Cylinder(2.0, 3.0), (0.01, 1.0, -0.05), real)
    bottom, bottom_ids = row_feature(Cylinder(2.0, 3.0), (0.01, -1.0, -0.05), real)
    base, base_ids = row_feature(Cone(2.0, 3.0), (0.01, -1.0, -0.05), real)
    assert sorted(top_ids) == sorted(base_ids) == list(range(8))
    assert sorted(bottom_ids) == list(range(8, 16))
    for points, y in ((top, 1.5), (bottom, -1.5), (base, -1.5)):
        np.testing.assert_allclose(points[:, 1], y)
        np.testing.assert_allclose(np.hypot(points[:, 0], points[:, 2]), 2.0, rtol=1e-6)
        steps = np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1)
        np.testing.assert_allclose(steps, 4.0 * math.sin(math.pi / 8), rtol=1e-6)
    assert polygon_normal(top)[1] == pytest.approx(1.0)
    assert polygon_normal(bottom)[1] == polygon_normal(base)[1] == pytest.approx(-1.0)
    # An id belongs to one place, whatever the direction.
    again, again_ids = row_feature(Cylinder(2.0, 3.0), (-0.02, 1.0, 0.0), real)
    np.testing.assert_array_equal(again, top)
    assert again_ids == top_ids


@pytest.mark.parametrize(
    ("shape", "d", "points", "ids"),
    [
        (Sphere(1.0), (0, 1, 0), [(0, 0, 0)], [0]),
        (Capsule(1.0, 2.0), (0, 1, 0), [(0, 1, 0)], [0]),
        (Capsule(1.0, 2.0), (1, -0.2, 0), [(0, -1, 0)], [1]),
        (Capsule(1.0, 2.0), (1, -0.09, 0), [(0, 1, 0), (0, -1, 0)], [0, 1]),
        (Cylinder(1.0, 2.0), (3, 0.2, 0), [(1, 1, 0), (1, -1, 0)], [16, 17]),
        (Cylinder(1.0, 2.0), (0, -0.09, -1), [(0, 1, -1), (0, -1, -1)], [16, 17]),
        (Cylinder(1.0, 2.0), (0.6, 1, 0.8), [(0.6, 1, 0.8)], [16]),
        (Cylinder(1.0, 2.0), (-0.6, -1, 0.8), [(-0.6, -1, 0.8)], [17]),
        (Cone(1.0, 2.0), (0, 1, 0), [(0, 1, 0)], [8]),
        (Cone(1.0, 2.0), (2, 1, 0), [(0, 1, 0), (1, -1, 0)], [8, 9]),
        (Cone(1.0, 2.0), (0, 1.1, -2), [(0, 1, 0), (0, -1, -1)], [8, 9]),
        (Cone(1.0, 2.0), (0, 0, -2), [(0, -1, -1)], [9]),
        (Cone(1.0, 2.0), (2, -3, 0), [(1, -1, 0)], [9]),
        (Cone(1.0, 2.0), (1, 2, 0), [(0, 1, 0)], [8]),
        (Box((2.0, 4.0, 6.0)), (0.5, 0.4, -0.4), [(1, -2, -3), (1, 2, -3), (1, 2, 3), (1, -2, 3)], [4, 6, 7, 5]),
        (Plane(), (0, 1, 0), np.empty((0, 3)), []),
    ],
)
def test_known_features(shape, d, points, ids):
    for real in PRECISIONS:
        found, found_ids = row_feature(shape, d, real)
        np.testing.assert_allclose(found, points, atol=1e-6)
        assert found_ids == ids


@pytest.mark.parametrize("shape", SOLIDS, ids=repr)
def test_a_zero_direction_gives_some_feature(shape):
    points, _ = row_feature(shape, (0.0, 0.0, 0.0))
    assert len(points) >= 1
    assert np.all(np.isfinite(points))
