import math
import os
import subprocess
import sys

import numpy as np
import pytest

from atlasphys.engine.shapes.bounds import update_bounds
from atlasphys.engine.shapes.plane import Plane
from atlasphys.engine.shapes.table import ShapeTable
from atlasphys.engine.state.bodies import empty_bodies
from atlasphys.engine.state.colliders import empty_colliders
from tests.engine.shapes.examples import PRECISIONS, SOLIDS
from tests.reference.shapes import core_points, core_radius, rotation_matrix


def bounds(shapes, rotations, positions, real, margin):
    """Bounds of each shape in each pose."""
    poses = len(rotations)
    arrays = ShapeTable(real, shapes).arrays
    bodies, colliders = empty_bodies(poses, real), empty_colliders(poses * len(shapes), real)
    bodies.geometry[:, :9] = np.reshape(rotations, (poses, 9))
    bodies.position[:] = positions
    colliders.body[:] = np.repeat(np.arange(poses), len(shapes))
    colliders.shape[:] = np.tile(np.arange(len(shapes)), poses)
    update_bounds(bodies, colliders, arrays, poses * len(shapes), margin)
    return colliders.lower.reshape(poses, -1, 3), colliders.upper.reshape(poses, -1, 3)


@pytest.mark.parametrize("real", PRECISIONS)
def test_bounds_are_those_of_the_rotated_shape_and_its_margin(real):
    rng = np.random.default_rng(4)
    quaternions = rng.normal(size=(12, 4))
    half = math.sqrt(0.5)
    special = [
        (1, 0, 0, 0),
        (half, half, 0, 0),
        (half, 0, half, 0),
        (0, 0, 0, 1),
        (half, 0, 0, half),
        (0.5, 0.5, 0.5, 0.5),
    ]
    rotations = [rotation_matrix(q / np.linalg.norm(q)) for q in np.concatenate([quaternions, special])]
    positions = rng.normal(size=(len(rotations), 3)) * 1e6
    lower, upper = bounds(SOLIDS, rotations, positions, real, 0.25)
    for pose, rotation in enumerate(rotations):
        for row, shape in enumerate(SOLIDS):
            points = core_points(shape) @ rotation.T
            size = np.max(np.abs(points), initial=core_radius(shape))
            tolerance = 1e-9 + size * (1e-5 + 10 * np.finfo(real).eps)
            expected_lower = points.min(axis=0) - core_radius(shape) - 0.25
            expected_upper = points.max(axis=0) + core_radius(shape) + 0.25
            np.testing.assert_allclose(lower[pose, row] - positions[pose], expected_lower, rtol=0, atol=tolerance)
            np.testing.assert_allclose(upper[pose, row] - positions[pose], expected_upper, rtol=0, atol=tolerance)


def test_a_plane_has_no_bounds():
    lower, upper = bounds([Plane((1, 2, 3))], [np.eye(3)], [(1.0, 2.0, 3.0)], np.float32, 0.1)
    assert np.all(lower == -np.inf)
    assert np.all(upper == np.inf)


def test_only_the_rows_asked_for_are_written():
    arrays = ShapeTable(np.float32, SOLIDS[:1]).arrays
    bodies, colliders = empty_bodies(1, np.float32), empty_colliders(3, np.float32)
    update_bounds(bodies, colliders, arrays, 2, 0.5)
    assert np.all(colliders.upper[:2] > 0.0)
    assert np.all(colliders.upper[2] == 0.0)


def test_plain_python_means_the_same():
    here = os.path.dirname(__file__)
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-q",
        "-p",
        "no:cacheprovider",
        "-k",
        "known or plane or zero or asked_for",
        here,
    ]
    result = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout
