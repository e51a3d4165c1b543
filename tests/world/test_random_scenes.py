"""Random scenes of twenty bodies, deep overlaps included, stay finite for 200 steps."""

import numpy as np
import pytest

import atlasphys as ap
from tests.world.scenes import heap

QUICK, FULL = 20, 2000

SOLVERS = (
    ap.SequentialImpulse(),
    ap.SequentialImpulse(position_correction="baumgarte"),
    ap.SequentialImpulse(warm_starting=False),
    ap.SequentialImpulse(iterations=3, position_iterations=1, correction=0.5),
    ap.XPBD(),
)


def check(seed):
    spread = (0.1, 0.5, 1.5, 4.0)[seed % 4]  # from twenty bodies in one place to hardly any contact
    # Few combinations of precision and method, since each is compiled by itself.
    world = heap(
        seed, spread=spread, solver=SOLVERS[seed // 4 % len(SOLVERS)], broadphase=("sweep", "brute")[seed // 16 % 2]
    )
    fastest = 0.0
    for step in range(200):
        world.step(1 / 60)
        for name in ("position", "orientation", "velocity", "angular_velocity"):
            assert np.isfinite(getattr(world.bodies, name)).all(), (seed, step, name)
        fastest = max(fastest, float(np.abs(world.bodies.velocity).max()))
    lengths = np.linalg.norm(world.bodies.orientation.astype(float), axis=1)
    np.testing.assert_allclose(lengths, 1, atol=1e-6)
    assert np.isfinite(world.contacts.normal_impulse).all()
    assert (world.contacts.normal_impulse >= 0).all()
    return fastest


@pytest.mark.parametrize("seed", range(QUICK))
def test_random_scenes_stay_finite(seed):
    assert check(seed) < 1000


@pytest.mark.full
def test_many_random_scenes_stay_finite():
    for seed in range(QUICK, FULL):
        assert check(seed) < 1000, seed
