"""Mean rates over a substep: to third order; pendulums whose period errs in second order."""

import numpy as np
import pytest

import atlasphys as ap
from atlasphys.engine.joints.halfway import CARRIED_ON, halfway
from atlasphys.engine.joints.parts import PARTS
from atlasphys.engine.joints.rows import rate
from atlasphys.engine.state.joints import DISTANCE, POINT
from atlasphys.validate.cases.jointed import mean_period
from atlasphys.validate.cases.pendulum import period, swing
from tests.engine.joints.test_parts import Scene, lanes

NO_INERTIA = (lanes([0] * 6), lanes([0] * 6))


def errors(kind, seed, h, load):
    """How far h times the mean rate is from the change of the coordinate."""
    scene, part = Scene(seed), PARTS[kind]
    velocity = scene.velocities()
    inertias = NO_INERTIA if load == 0 else (lanes([1e3] * 6), lanes([1e3] * 6))
    middle = halfway(kind, scene.ends(), velocity, np.array([0.5 * h]), inertias, np.array([float(load)]))
    change = np.array(part.measure(scene.ends(h))) - np.array(part.measure(scene.ends()))
    return np.abs(change - h * np.array([rate(row, *velocity) for row in part.rows(middle)])).max()


@pytest.mark.parametrize("kind", CARRIED_ON)
@pytest.mark.parametrize("seed", range(4))
def test_mean_rates_err_in_third_order(kind, seed):
    assert errors(kind, seed, 1e-3, 0) < 4e-3 * errors(kind, seed, 1e-2, 0) + 1e-9
    assert errors(kind, seed, 1e-3, 0) < 1e-7


@pytest.mark.parametrize("kind", [POINT, DISTANCE])
def test_arms_that_swing_faster_than_substeps_resolve_are_not_carried_on(kind):
    assert errors(kind, 1, 1e-3, 1e6) > 10 * errors(kind, 1, 1e-3, 0)
    scene = Scene(1)
    middle = halfway(kind, scene.ends(), scene.velocities(), np.array([0.5]), NO_INERTIA, np.array([0.0]))
    assert np.abs(np.array(middle.arm_a) - np.array(scene.ends().arm_a)).max() == 0  # turned too far in a substep


@pytest.mark.parametrize("solver", ["soft_step", "sequential_impulse"])
@pytest.mark.parametrize("degrees", [6, 57, 120])
def test_a_pendulums_period_errs_in_second_order(solver, degrees):
    exact, found = period(degrees), []
    for dt in (1 / 120, 1 / 240):

        def make(**scene):
            return ap.World(solver=solver, precision="double", sleeping=False, **scene)

        times, angles, _ = swing(make, degrees, 4.2 * exact, dt)
        found.append(abs(mean_period(times, angles) / exact - 1))
    assert found[1] < (1e-4 if solver == "soft_step" else 1e-3)
    assert found[1] < 2**-1.8 * found[0] + 2e-6  # which allows for terms of third order
