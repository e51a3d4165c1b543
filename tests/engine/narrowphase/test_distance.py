"""GJK by itself, before faces are preferred: distance and nearest points of pairs apart."""

from __future__ import annotations

import math
import zlib

import numpy as np
import numpy.typing as npt
import pytest

from atlasphys.engine.jit import allocating_kernel as kernel
from atlasphys.engine.math import vec
from atlasphys.engine.narrowphase.epa import polytope_scratch
from atlasphys.engine.narrowphase.pair import place
from atlasphys.engine.narrowphase.pairs.convex_convex import core_contact
from atlasphys.engine.shapes.support import rounding
from atlasphys.engine.state.contacts import Contacts, empty_contacts
from tests.engine.narrowphase.poses import random_poses, state_of
from tests.engine.narrowphase.test_depth import PAIRS, as_pairs, rounded, size_of
from tests.reference.narrowphase import reach, sphere_points
from tests.reference.sweep import minima


@kernel
def surface_distances(bodies, colliders, shapes, contacts: Contacts, distance, nearest):  # type: ignore[no-untyped-def]
    """Distance of each pair, and the nearest points of both surfaces as seen from the first one's origin."""
    real = contacts.depth.dtype.type
    simplex = np.empty((4, 7), contacts.depth.dtype)
    polytope = polytope_scratch(contacts.depth.dtype)
    for p in range(len(distance)):
        pair, _ = place(bodies, colliders, shapes, contacts, p)
        radius_a, radius_b = rounding(shapes, pair[0]), rounding(shapes, pair[1])
        normal, between, on_a, on_b = core_contact(shapes, pair, real(1e6), simplex, polytope)
        distance[p] = between - radius_a - radius_b
        vec.store(nearest, 2 * p, vec.add_scaled(on_a, normal, radius_a))
        vec.store(nearest, 2 * p + 1, vec.add_scaled(on_b, normal, -radius_b))


def check(kind_a: str, kind_b: str, case: str, number: int, real: npt.DTypeLike) -> float:
    """Returns the worst error of a distance."""
    rng = np.random.default_rng([3, zlib.crc32(f"{kind_a} {kind_b} {case}".encode())])
    poses = [
        p._replace(rotation_a=rounded(p.rotation_a, real), rotation_b=rounded(p.rotation_b, real))
        for p in random_poses(kind_a, kind_b, rng, case, number)
    ]
    depths, _ = minima(as_pairs(poses))
    state = state_of(poses, real)
    contacts = empty_contacts(number, 1, real)
    contacts.a[:number], contacts.b[:number] = state.pairs.T
    distance, nearest = np.empty(number), np.empty((number, 2, 3))
    surface_distances(*state[:3], contacts, distance, nearest.reshape(-1, 3))
    error = 0.0
    directions = sphere_points(300)
    for k, pose in enumerate(poses):
        tolerance = (1e-8 if real is np.float64 else 2e-5) * size_of(pose)
        error = max(error, abs(distance[k] + depths[k, 0]) / size_of(pose))
        assert distance[k] == pytest.approx(-depths[k, 0], abs=tolerance), pose
        on_a, on_b = nearest[k]
        if distance[k] > 0:
            assert np.linalg.norm(on_b - on_a) == pytest.approx(distance[k], abs=tolerance)
        beyond_a = directions @ on_a - reach(pose.a, directions @ pose.rotation_a)
        on_b = on_b - (pose.position_b - pose.position_a)
        beyond_b = directions @ on_b - reach(pose.b, directions @ pose.rotation_b)
        # GJK ends when the distance is exact to a relative 16 (double precision: 4096) epsilon. On surfaces with a
        # radius r a point moved aside by x changes it by x² / 2r, so of the points that is the square root.
        relative = 1e-12 if real is np.float64 else 2e-6
        aside = math.sqrt(2.0 * relative * max(distance[k], 0.0) * size_of(pose))
        assert max(beyond_a.max(), beyond_b.max()) < tolerance + aside, pose
    return error


@pytest.mark.parametrize(("kind_a", "kind_b"), PAIRS)
def test_distance_and_nearest_points(kind_a: str, kind_b: str) -> None:
    check(kind_a, kind_b, "apart", 8, np.float64)


@pytest.mark.full
@pytest.mark.parametrize("real", [np.float32, np.float64])
@pytest.mark.parametrize(("kind_a", "kind_b"), PAIRS)
def test_distance_and_nearest_points_of_2000_pairs(kind_a: str, kind_b: str, real: npt.DTypeLike) -> None:
    print(kind_a, kind_b, np.dtype(real).name, f"{check(kind_a, kind_b, 'apart', 2000, real):.1e}")
