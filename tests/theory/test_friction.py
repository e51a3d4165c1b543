"""The formulas of docs/theory/friction.md."""

import numpy as np
import pytest
import sympy as sp

from atlasphys.engine.math import vec
from atlasphys.engine.solvers.common import invert_2x2, solve_disk
from atlasphys.engine.solvers.sequential_impulse import tangent_matrix
from tests.theory.formulas import checks, interpreted
from tests.theory.test_impulses import Contact

INVERT, SOLVE = interpreted(invert_2x2), interpreted(solve_disk)


@checks("friction-coulomb", "friction-dissipation")
def test_the_least_work_over_a_disk_is_at_the_rim():
    v, limit = np.array([3.0, 4.0]), 2.0
    angle = np.linspace(0, 2 * np.pi, 7201)
    work = limit * (np.cos(angle) * v[0] + np.sin(angle) * v[1])
    assert work.min() == pytest.approx(-limit * np.linalg.norm(v), rel=1e-6)
    at = angle[work.argmin()]
    assert np.allclose(limit * np.array([np.cos(at), np.sin(at)]), -limit * v / np.linalg.norm(v), atol=1e-3)


@checks("friction-matrix", "friction-stick", "friction-gradient", "friction-coulomb")
@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("limit", [0.05, 0.3, 100.0])
def test_the_engine_s_disk_converges_to_coulomb_s_law(seed, limit):
    contact = Contact(seed)
    t = np.array(interpreted(vec.tangents)(tuple(contact.n)))
    K = t @ contact.K @ t.T
    summed = (1 / contact.m).sum() * np.eye(2)
    for r, i in zip(contact.r, contact.inverse, strict=True):
        symmetric = (i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2])
        k11, k12, k22 = interpreted(tangent_matrix)(tuple(r), symmetric, tuple(t[0]), tuple(t[1]))
        summed += [[k11, k12], [k12, k22]]
    assert np.allclose(summed, K)
    inverse = INVERT(K[0, 0], K[0, 1], K[1, 1])
    assert np.allclose([[inverse[0], inverse[1]], [inverse[1], inverse[2]]], np.linalg.inv(K))
    greatest = (K[0, 0] + K[1, 1]) / 2 + np.sqrt((K[0, 0] - K[1, 1]) ** 2 / 4 + K[0, 1] ** 2)
    assert greatest == pytest.approx(np.linalg.eigvalsh(K)[-1])
    assert inverse[3] == pytest.approx(1 / greatest)
    start = t @ contact.velocity()
    impulse = np.zeros(2)

    def f(x):
        return x @ K @ x / 2 + x @ start

    for _ in range(2000):
        before = f(impulse)
        impulse = np.array(SOLVE(tuple(impulse), tuple(start + K @ impulse), inverse, limit))
        assert f(impulse) <= before + 1e-12
    v = start + K @ impulse
    assert np.linalg.norm(impulse) <= limit * (1 + 1e-12)
    if np.linalg.norm(np.linalg.solve(K, start)) <= limit:
        assert np.allclose(v, 0, atol=1e-9)
    else:
        assert np.allclose(impulse, -limit * v / np.linalg.norm(v), atol=1e-6 * limit)


def test_scaling_back_to_the_rim_points_elsewhere():
    K, start, limit = np.diag([1.0, 4.0]), np.array([1.0, 1.0]), 0.1
    scaled = -np.linalg.solve(K, start)
    scaled *= limit / np.linalg.norm(scaled)
    v = start + K @ scaled
    assert abs(scaled[0] * v[1] - scaled[1] * v[0]) > 0.3 * limit * np.linalg.norm(v)


@checks("friction-slope", "friction-ball", "friction-rolling-ball", "friction-rolling")
def test_blocks_and_balls():
    m, g, R, mu, v0, t, lever, angle = sp.symbols("m g R mu v0 t l theta", positive=True)
    force = m * g * sp.sin(angle) - mu * m * g * sp.cos(angle)
    assert sp.simplify(force / m - g * (sp.sin(angle) - mu * sp.cos(angle))) == 0
    assert sp.simplify(force.subs(mu, sp.tan(angle))) == 0
    path = v0 * t - mu * g * t**2 / 2
    assert sp.simplify(path.subs(t, v0 / (mu * g)) - v0**2 / (2 * mu * g)) == 0
    inertia = m * R**2 * 2 / 5
    meet = sp.solve(sp.Eq(v0 - mu * g * t, R * mu * m * g * R / inertia * t), t)[0]
    assert sp.simplify(meet - 2 * v0 / (7 * mu * g)) == 0
    assert sp.simplify(v0 - mu * g * meet - v0 * 5 / 7) == 0
    # Rolling resistance: f is the ground's friction that keeps v = ω R while the torque l m g brakes the spin.
    f, a = sp.symbols("f a", real=True)
    found = sp.solve([sp.Eq(m * a, f), sp.Eq(inertia * a / R, -f * R - lever * m * g)], [a, f])[a]
    assert sp.simplify(found + lever * m * g * R / (inertia + m * R**2)) == 0
    assert sp.simplify(found + lever / R * g * 5 / 7) == 0
    # The cone for rolling is the same disk, with the lever arm in place of μ.
    impulse = SOLVE((0.0, 0.0), (3.0, 4.0), INVERT(1.0, 0.0, 1.0), 0.1 * 2.0)
    assert np.allclose(impulse, -0.2 * np.array([0.6, 0.8]))
