"""The formulas of docs/theory/position.md."""

import numpy as np
import pytest
import scipy.spatial
import sympy as sp

from atlasphys.engine.solvers.projection import shift
from tests.theory.formulas import checks, interpreted
from tests.theory.test_impulses import Contact


@checks("position-baumgarte", "position-energy")
def test_baumgarte_s_bias_decays_and_bursts():
    P, slop, beta, h, k = sp.symbols("P slop beta h k", positive=True)
    speed = beta / h * (P - slop)
    assert sp.simplify((P - h * speed - slop) - (1 - beta) * (P - slop)) == 0
    assert np.log(2) / -np.log(0.8) == pytest.approx(3.1, abs=0.01)
    # From rest the impulse j = v / k gives the energy ½ j v.
    speed = beta * P / h
    assert sp.simplify((speed / k) * speed / 2 - (beta * P / h) ** 2 / (2 * k)) == 0
    burst = beta * P / h
    assert float(burst.subs({beta: 0.2, P: 1, h: sp.Rational(1, 60)})) == pytest.approx(12)


@checks("position-projection", "position-momentum")
@pytest.mark.parametrize("seed", range(3))
def test_a_projection_removes_its_share_to_first_order(seed):
    contact = Contact(seed)
    n, k = contact.n, contact.n @ contact.K @ contact.n
    for overlap in (1e-3, 1e-4):
        push = overlap / k
        moved = []
        for i, sign in ((0, -1), (1, 1)):
            turn = sign * push * contact.inverse[i] @ np.cross(contact.r[i], n)
            rotation = scipy.spatial.transform.Rotation.from_rotvec(turn).as_matrix()
            moved.append(sign * push / contact.m[i] * n + rotation @ contact.r[i] - contact.r[i])
        left = overlap - n @ (moved[1] - moved[0])
        assert abs(left) < 20 * overlap**2
        change = sum(
            contact.m[i] * np.cross(sign * push / contact.m[i] * n, contact.v[i]) for i, sign in ((0, -1), (1, 1))
        )
        assert np.allclose(change, push * np.cross(n, contact.v[1] - contact.v[0]))
    left = (1 - 0.2) ** 4
    assert left == pytest.approx(0.41, abs=0.001)


@checks("position-second-order")
def test_the_arm_s_end_to_second_order():
    r, axis = np.array([0.3, -2.0, 1.0]), np.array([0.5, 0.4, -0.7])
    errors = []
    for size in (0.1, 0.05):
        turn = size * axis
        exact = scipy.spatial.transform.Rotation.from_rotvec(turn).as_matrix() @ r - r
        errors.append(np.linalg.norm(exact - interpreted(shift)(tuple(r), (0.0, 0.0, 0.0), tuple(turn))))
    assert errors[0] / errors[1] == pytest.approx(8, rel=0.05)


def test_the_article_s_shift_pulls_what_is_less_deep_than_the_slop():
    overlap, slop = 0.002, 0.005
    assert 0.2 * (overlap - slop) < 0 == max(0.0, overlap - slop)
