"""The benchmark's scenes: the right bodies, the same in every run, and apart where they must not touch."""

import itertools

import numpy as np
import pytest
from numpy.testing import assert_allclose

from atlasphys.bench.quality import penetration
from atlasphys.bench.scenes import SCENES, Box, Capsule, Hull, Sphere, make, volume
from atlasphys.bench.swing import stretch
from atlasphys.errors import InvalidArgumentError

COUNTS = {
    "one_body": 1,
    "ten_bodies": 10,
    "pyramid_20": 210,
    "pyramid_40": 820,
    "towers_100x10": 1000,
    "boxes_1000_walls": 1000,
    "boxes_5000_walls": 5000,
    "spheres_2000_pit": 2000,
    "spheres_10000_pit": 10_000,
    "falling_10000": 10_000,
    "mixed_1000": 1000,
    "tower_20": 20,
    "tower_50": 50,
    "tower_100": 100,
    "heavy_on_light_100": 2,
    "chains_50x20": 1000,
    "joint_grid": 10_000,
    "pile_137": 137,
    "falling_1001": 1001,
}


def test_every_scene_is_counted_here():
    assert set(SCENES) <= set(COUNTS)


@pytest.mark.parametrize("name", COUNTS)
def test_count_and_determinism(name):
    scene = make(name)
    assert scene.name == name
    assert len(scene.bodies) == COUNTS[name]
    assert scene == make(name)
    assert scene.settle < scene.seconds


def poses(scene):
    return np.array([b.position for b in scene.bodies]), np.array([b.orientation for b in scene.bodies])


@pytest.mark.parametrize("name", ["boxes_1000_walls", "spheres_2000_pit", "mixed_1000", "pile_137"])
def test_piles_start_apart_and_inside(name):
    scene = make(name)
    positions, orientations = poses(scene)
    assert (np.abs(positions[:, [0, 2]]) < scene.inside).all()
    assert penetration(scene, positions, orientations, np.ones(len(positions), bool)) == 0.0


@pytest.mark.parametrize("name", ["pyramid_20", "towers_100x10", "tower_20", "heavy_on_light_100", "ten_bodies"])
def test_stacks_start_exactly_touching(name):
    positions, _ = poses(make(name))
    assert set(positions[:, 1] % 1) == {0.5}
    assert len({tuple(place) for place in positions.tolist()}) == len(positions)


def test_falling_bodies_are_farther_apart_than_they_are_large():
    positions, _ = poses(make("falling_1001"))
    shifts = positions[None, :100] - positions[:, None]
    distances = np.sqrt((shifts**2).sum(axis=2))
    assert distances[distances > 0].min() > np.sqrt(3) + 0.5
    assert not make("falling_1001").ground


@pytest.mark.parametrize(("name", "links"), [("chains_50x20", 1000), ("joint_grid", 2 * 9900 + 7)])
def test_links_fit_at_the_start(name, links):
    scene = make(name)
    assert len(scene.links) == links
    assert stretch(scene, *poses(scene)).max() < 1e-9


def test_the_heavy_one_is_heavy():
    light, heavy = make("heavy_on_light_100").bodies
    assert heavy.density == 100 * light.density
    assert heavy.position[1] > light.position[1]


def test_mixed_holds_four_kinds_alike():
    kinds = [type(body.shape) for body in make("mixed_1000").bodies]
    assert [kinds.count(kind) for kind in (Box, Sphere, Capsule, Hull)] == [250] * 4


def test_hulls_have_16_corners_about_their_centre_of_mass():
    import atlasphys as ap

    for body in make("mixed_1000").bodies[3:32:4]:
        hull = ap.ConvexHull(points=body.shape.points)
        assert len(hull.polyhedron.vertices) == 16
        assert_allclose(hull.center_of_mass, 0, atol=1e-8)
        assert_allclose(hull.volume, body.shape.volume, rtol=1e-7)


def test_volumes_are_ours():
    from atlasphys.bench.peers.atlasphys import shape_of

    for shape in (Box((0.1, 0.2, 0.4)), Sphere(0.3), Capsule(0.2, 0.7)):
        assert_allclose(volume(shape), shape_of(shape).volume, rtol=1e-12)


def test_walls_leave_no_gap():
    scene = make("pile_137")
    low = [np.array(wall.position) - wall.shape.half for wall in scene.walls]
    high = [np.array(wall.position) + wall.shape.half for wall in scene.walls]
    for a, b in itertools.product(range(2), range(2, 4)):  # each across x meets each across z
        assert (np.minimum(high[a], high[b]) >= np.maximum(low[a], low[b])).all()


@pytest.mark.parametrize("name", ["tower", "pile_0", "pile_-3", "pile_2000000", "tower_21", "", "pile_1e3"])
def test_unknown_scenes_are_refused(name):
    with pytest.raises(InvalidArgumentError, match="no benchmark scene"):
        make(name)
