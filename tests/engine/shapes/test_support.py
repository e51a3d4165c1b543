import numpy as np
import pytest

from atlasphys.engine.shapes.plane import Plane
from atlasphys.engine.shapes.table import ShapeTable
from tests.engine.shapes.examples import PRECISIONS, SOLIDS, directions
from tests.engine.shapes.probes import probe_support
from tests.reference.shapes import core_points, core_radius


@pytest.mark.parametrize("scale", [1.0, 1e-30, 1e25])
@pytest.mark.parametrize("real", PRECISIONS)
def test_no_point_of_the_core_is_farther(real, scale):
    shapes = ShapeTable(real, SOLIDS)
    for row, shape in enumerate(SOLIDS):
        candidates = core_points(shape)
        size = np.max(np.abs(candidates), initial=core_radius(shape))
        for d in directions(row):
            x, y, z = (d * scale).astype(real)
            point, radius = probe_support(shapes.arrays, row, x, y, z)
            assert {type(real(0)), float} >= {type(entry) for entry in point}
            assert radius == real(core_radius(shape))
            along = candidates @ d
            # As far as the farthest sample, and no farther than sampling the rim every quarter of a degree can miss.
            assert np.max(along) - 4 * np.finfo(real).eps * size <= d @ point <= np.max(along) + 1e-5 * size, shape
            assert np.min(np.linalg.norm(candidates - point, axis=1)) <= 5e-3 * size


@pytest.mark.parametrize("real", PRECISIONS)
def test_a_zero_direction_gives_some_point_of_the_core(real):
    shapes = ShapeTable(real, [*SOLIDS, Plane()])
    for row, shape in enumerate(SOLIDS):
        candidates = core_points(shape)
        point, _ = probe_support(shapes.arrays, row, real(0), real(0), real(0))
        assert np.min(np.linalg.norm(candidates - point, axis=1)) <= 1e-6 * np.max(np.abs(candidates), initial=1.0)
    assert probe_support(shapes.arrays, len(SOLIDS), real(0), real(1), real(0)) == ((0.0, 0.0, 0.0), 0.0)
