import pickle
import time

import numpy as np
import pytest

from atlasphys.engine.shapes import table
from atlasphys.engine.shapes.box import Box
from atlasphys.engine.shapes.capsule import Capsule
from atlasphys.engine.shapes.cone import Cone
from atlasphys.engine.shapes.cylinder import Cylinder
from atlasphys.engine.shapes.hull import ConvexHull, octahedron, pyramid
from atlasphys.engine.shapes.plane import Plane
from atlasphys.engine.shapes.sphere import Sphere
from atlasphys.engine.shapes.table import ShapeTable
from tests.engine.shapes.examples import PRECISIONS, SOLIDS, random_hull


def test_equal_shapes_share_a_row():
    shapes = ShapeTable(np.float32)
    assert [shapes.row_of(s) for s in (Box((1, 1, 1)), Sphere(1), Box((1.0, 1.0, 1.0)), Sphere(2), Sphere(1))] == [
        0,
        1,
        0,
        2,
        1,
    ]
    assert shapes.row_of(octahedron(1.0)) == 3
    assert shapes.row_of(ConvexHull([*octahedron(1.0).vertices, (0, 0, 0)])) == 3
    assert len(shapes) == len(shapes.shapes) == 4
    assert shapes.shapes[1] == Sphere(1.0)


def test_arrays_are_rebuilt_only_when_shapes_were_added():
    shapes = ShapeTable(np.float32, [Sphere(1.0)])
    first = shapes.arrays
    shapes.row_of(Sphere(1.0))
    assert shapes.arrays is first
    shapes.row_of(Sphere(2.0))
    assert len(first.layout) == 1
    assert len(shapes.arrays.layout) == 2


@pytest.mark.parametrize("real", PRECISIONS)
def test_sizes_kinds_and_feature_points(real):
    arrays = ShapeTable(
        real,
        [Sphere(1), Capsule(1, 4), Box((2, 4, 6)), Cylinder(1, 4), Cone(1, 4), pyramid(5, 1, 4), Plane((0, 0, 2), 3)],
    ).arrays
    assert arrays.layout[:, table.KIND].tolist() == [
        table.SPHERE,
        table.CAPSULE,
        table.BOX,
        table.CYLINDER,
        table.CONE,
        table.HULL,
        table.PLANE,
    ]
    assert arrays.layout[:, table.FEATURE_POINTS].tolist() == [1, 2, 4, 8, 8, 5, 0]
    assert arrays.size.tolist() == [
        [1, 0, 0, 0],
        [1, 2, 0, 0],
        [1, 2, 3, 0],
        [1, 2, 0, 0],
        [1, 2, 0, 0],
        [0, 0, 0, 0],
        [0, 0, 1, 3],
    ]
    assert {array.dtype.type for array in (arrays.size, arrays.vertices, arrays.faces)} == {real}
    assert {array.dtype.type for array in (arrays.layout, arrays.face_range, arrays.face_vertices, arrays.edges)} == {
        np.int32
    }


@pytest.mark.parametrize("real", PRECISIONS)
def test_polyhedra_are_listed_with_their_own_rows(real):
    shapes = [Sphere(1), Box((1, 2, 3)), random_hull(5), Plane(), pyramid(6, 1, 1), Box((3, 2, 1))]
    arrays = ShapeTable(real, shapes).arrays
    layout = arrays.layout
    for row, shape in enumerate(shapes):
        first_vertex, first_face, first_edge = layout[row, [table.FIRST_VERTEX, table.FIRST_FACE, table.FIRST_EDGE]]
        counts = layout[row, [table.VERTEX_COUNT, table.FACE_COUNT, table.EDGE_COUNT]]
        polyhedron = shape.polyhedron
        if polyhedron is None:
            assert counts.tolist() == [0, 0, 0]
            continue
        assert counts.tolist() == [len(polyhedron.vertices), len(polyhedron.planes), len(polyhedron.edges)]
        vertices = arrays.vertices[first_vertex : first_vertex + counts[0]]
        np.testing.assert_array_equal(vertices, polyhedron.vertices.astype(real))
        np.testing.assert_array_equal(arrays.faces[first_face : first_face + counts[1]], polyhedron.planes.astype(real))
        for face in range(first_face, first_face + counts[1]):
            start, count = arrays.face_range[face]
            corners = arrays.vertices[arrays.face_vertices[start : start + count]].astype(float)
            normal, offset = arrays.faces[face, :3].astype(float), float(arrays.faces[face, 3])
            np.testing.assert_allclose(corners @ normal, offset, atol=1e-6)
            area = sum(np.cross(corners[k] - corners[0], corners[k + 1] - corners[0]) for k in range(1, count - 1))
            assert area @ normal == pytest.approx(np.linalg.norm(area), rel=1e-6)  # counter-clockwise from outside
            assert np.max(vertices @ normal) <= offset + 1e-6
        for a, b, left, right in arrays.edges[first_edge : first_edge + counts[2]]:
            for face, start, end in ((left, a, b), (right, b, a)):
                first, count = arrays.face_range[face]
                corners = arrays.face_vertices[first : first + count].tolist()
                assert corners[(corners.index(start) + 1) % count] == end


def test_an_empty_table_and_a_pickled_one():
    empty = ShapeTable(np.float64).arrays
    assert [len(array) for array in empty] == [0] * len(empty)
    shapes = ShapeTable(np.float32, SOLIDS)
    twin = pickle.loads(pickle.dumps(shapes))
    assert twin.shapes == shapes.shapes
    assert all(np.array_equal(a, b) for a, b in zip(twin.arrays, shapes.arrays, strict=True))


def test_a_copy_is_independent():
    shapes = ShapeTable(np.float32, SOLIDS)
    twin = shapes.copy()
    assert twin.shapes == shapes.shapes
    assert twin.row_of(Sphere(9.0)) == len(shapes) == len(shapes.arrays.layout) == len(twin.arrays.layout) - 1


def test_thousands_of_distinct_boxes_take_no_time():
    boxes = [Box((1.0 + 1e-4 * k, 1.0, 1.0)) for k in range(5000)]
    started = time.process_time()
    shapes = ShapeTable(np.float32)
    for box in boxes:
        shapes.row_of(box)
    assert len(shapes.arrays.vertices) == 40000
    assert time.process_time() - started < 1.0
