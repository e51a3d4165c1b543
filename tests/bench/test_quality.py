"""The judge: what stands is accepted, what fell, sank, flew or went through is not."""

import numpy as np
import pytest

from atlasphys.bench.quality import judge
from atlasphys.bench.scenes import DT, make


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


def test_energy_of_what_swings():
    """A chain that turns about its hook as one body: ½ I ω² against what it lost in height."""
    scene = make("chains_50x20")
    positions, orientations = poses(scene)
    lowered = positions - (0, 1.0, 0)
    assert judge(scene, 1, lowered, orientations, (lowered, orientations)).energy == pytest.approx(-0.1)
    rate, turned = 2.0, []
    for angle in (-0.5 * rate * DT, 0.5 * rate * DT):
        cosine, sine = np.cos(angle), np.sin(angle)
        x, y, z = positions.T
        places = np.stack([cosine * x - sine * y, sine * x + cosine * y, z], axis=1)
        w, i, j, k = orientations.T  # times a turn about z
        c, s = np.cos(angle / 2), np.sin(angle / 2)
        turned.append((places, np.stack([c * w - s * k, c * i - s * j, c * j + s * i, c * k + s * w], axis=1)))
    quality = judge(scene, 1, *turned[1], turned[0])
    assert quality.stretch < 1e-9
    # A rod of 10 m: ½ (m L²/3) ω² = m g L · L ω²/(6 g); capsules are a little shorter than their pitch.
    assert quality.energy == pytest.approx(10 * rate**2 / (6 * 9.81), rel=2e-3)
    assert not quality.stands
    assert quality.fault == "it gained energy"


def test_links_that_came_apart_are_caught():
    scene = make("chains_50x20")
    positions, orientations = poses(scene)
    positions[500:] += (0, -4.0, 0)
    assert "links came apart" in judge(scene, 1, positions, orientations, (positions, orientations)).fault


def test_falling_bodies_that_drift_apart_have_met():
    scene = make("falling_10")
    positions, orientations = poses(scene)
    positions[:, 1] -= 0.5 * 9.81 * 4
    positions[4, 0] += 0.05
    quality = judge(scene, 2.0, positions, orientations)
    assert not quality.stands
    assert quality.worst_drift == pytest.approx(0.05)
