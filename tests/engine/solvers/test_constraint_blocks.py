"""Every body over lanes of ``soft_step``: compiled code and NumPy reading agree to the last bit."""

import numpy as np
import pytest

from tests.engine.simd.values import bits
from tests.engine.solvers.constraint_blocks import all_bodies, contacts_of, random_scene


def arrays(scene):
    yield from scene.bodies
    yield from scene.manifolds
    yield from (scene.blocks, scene.rolls, scene.moved, scene.answers)


def compare(driver, points, real, seed, locks, number):
    compiled, read = (random_scene(points, real, seed, locks) for _ in range(2))
    at_first = random_scene(points, real, seed, locks)
    driver(compiled, real(number))
    driver.py_func(read, real(number))
    changed = 0
    for a, b, before in zip(arrays(compiled), arrays(read), arrays(at_first), strict=True):
        np.testing.assert_array_equal(bits(a), bits(b))
        changed += not np.array_equal(a, before)
    return changed, compiled


CONTACTS = {points: contacts_of(points) for points in (4, 1)}


@pytest.mark.parametrize(("real", "locks"), [(np.float32, False), (np.float64, False), (np.float64, True)])
def test_compiled_and_numpy_reading_agree(real, locks):
    for seed in range(3):
        for points in (4, 1):
            changed, scene = compare(CONTACTS[points], points, real, seed, locks, 0.5)
            assert changed >= 6  # motion, contact, points, total, blocks, rolls, answers
            assert np.isfinite(scene.bodies.motion).all()
            assert scene.answers.any()
            assert (scene.manifolds.total[:, 0] > 0).any()
        changed, _ = compare(all_bodies, 4, real, seed, locks, 1 / 240)
        assert changed >= 5
