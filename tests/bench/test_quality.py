"""The judge: what stands is accepted, what fell, sank, flew or went through is not."""

import numpy as np
import pytest

from atlasphys.bench.quality import judge
from atlasphys.bench.scenes import make


def poses(scene):
    return np.array([b.position for b in scene.bodies]), np.array([b.orientation for b in scene.bodies])


def test_a_tower_as_built_stands():
    scene = make("tower_20")
    quality = judge(scene, 10, *poses(scene))
    assert quality.stands
    assert (quality.fault, quality.worst_drift, quality.lost) == ("", 0.0, 0)
    assert quality.deepest < 1e-9


def test_drift_and_penetration_are_measured():
    scene = make("tower_20")
    positions, orientations = poses(scene)
    positions[:, 1] -= 0.003  # the lowest is now 3 mm in the ground
    quality = judge(scene, 10, positions, orientations)
    assert quality.stands
    assert quality.worst_drift == pytest.approx(0.003)
    assert quality.deepest == pytest.approx(0.003, abs=1e-6)


def test_a_fallen_tower_is_caught():
    scene = make("tower_20")
    positions, orientations = poses(scene)
    positions[:, 0], positions[:, 1] = positions[:, 1], 0.5  # it lies along x
    quality = judge(scene, 10, positions, orientations)
    assert not quality.stands
    assert "19 of 20 bodies fell" in quality.fault


def test_one_cube_beside_its_tower_is_caught():
    scene = make("towers_100x10")
    positions, orientations = poses(scene)
    positions[9] += (1.0, -9.0, 0.0)
    assert "1 of 1000 bodies fell" in judge(scene, 10, positions, orientations).fault


def test_a_cube_thrown_up_is_caught():
    scene = make("tower_50")
    positions, orientations = poses(scene)
    positions[-1, 1] += 5.0
    assert "1 of 50 bodies fell" in judge(scene, 10, positions, orientations).fault


@pytest.mark.parametrize("place", [(0, -3, 0), (100, 1, 0), (0, 1, -100)])
def test_a_body_out_of_the_pit_is_caught(place):
    scene = make("pile_137")
    positions, orientations = poses(scene)
    assert judge(scene, 0, positions, orientations).stands
    positions[7] = place
    quality = judge(scene, 10, positions, orientations)
    assert not quality.stands
    assert quality.lost == 1
    assert "1 of 137 bodies are out" in quality.fault


def test_bodies_inside_each_other_are_caught():
    scene = make("pile_137")
    positions, orientations = poses(scene)
    positions[8] = positions[7] + (0.1, 0.1, 0.1)
    quality = judge(scene, 10, positions, orientations)
    assert not quality.stands
    assert "overlap" in quality.fault
    assert quality.deepest > 0.2


def test_numbers_that_are_not_finite_are_caught():
    scene = make("pile_137")
    positions, orientations = poses(scene)
    orientations[3, 2] = np.nan
    assert judge(scene, 10, positions, orientations).fault == "numbers are not finite"


@pytest.mark.parametrize(("way", "stands"), [(1.0, True), (0.97, True), (0.5, False), (0.0, False)])
def test_falling_bodies_must_fall(way, stands):
    scene = make("falling_10")
    positions, orientations = poses(scene)
    positions[:, 1] -= way * 0.5 * 9.81 * 4
    assert judge(scene, 2.0, positions, orientations).stands is stands


def test_falling_bodies_that_drift_apart_have_met():
    scene = make("falling_10")
    positions, orientations = poses(scene)
    positions[:, 1] -= 0.5 * 9.81 * 4
    positions[4, 0] += 0.05
    quality = judge(scene, 2.0, positions, orientations)
    assert not quality.stands
    assert quality.worst_drift == pytest.approx(0.05)
