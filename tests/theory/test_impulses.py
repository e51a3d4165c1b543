"""The formulas of docs/theory/impulses.md."""

import numpy as np
import pytest
import scipy.optimize
import sympy as sp

from atlasphys.engine.solvers.common import relative_velocity
from atlasphys.engine.solvers.sequential_impulse import bounce_speed
from tests.theory.formulas import checks, interpreted


def hat(r):
    return np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])


class Contact:
    """Two bodies of random masses, inertias and velocities that touch at random arms."""

    def __init__(self, seed):
        rng = np.random.default_rng(seed)
        self.m = rng.uniform(0.5, 3, 2)
        spread = rng.normal(size=(2, 3, 3))
        self.inertia = np.array([s @ s.T + np.eye(3) for s in spread])
        self.inverse = np.linalg.inv(self.inertia)
        self.r, self.v, self.w = rng.normal(size=(3, 2, 3))
        n = rng.normal(size=3)
        self.n = n / np.linalg.norm(n)
        self.x = -self.r  # the contact is the origin
        self.K = (1 / self.m).sum() * np.eye(3) - sum(
            hat(r) @ i @ hat(r) for r, i in zip(self.r, self.inverse, strict=True)
        )

    def velocity(self):
        return self.v[1] + np.cross(self.w[1], self.r[1]) - self.v[0] - np.cross(self.w[0], self.r[0])

    def push(self, J):
        for i, sign in ((0, -1), (1, 1)):
            self.v[i] += sign * J / self.m[i]
            self.w[i] += sign * self.inverse[i] @ np.cross(self.r[i], J)

    def kept(self):
        p = self.m @ self.v
        spin = sum(tensor @ w for tensor, w in zip(self.inertia, self.w, strict=True))
        return p, spin + sum(m * np.cross(x, v) for m, x, v in zip(self.m, self.x, self.v, strict=True))

    def energy(self):
        return 0.5 * (self.m * (self.v**2).sum(axis=1)).sum() + 0.5 * sum(
            w @ tensor @ w for tensor, w in zip(self.inertia, self.w, strict=True)
        )


@checks("impulses-velocity", "impulses-change", "impulses-matrix", "impulses-k")
@pytest.mark.parametrize("seed", range(5))
def test_an_impulse_changes_the_velocity_by_its_matrix(seed):
    contact, J = Contact(seed), np.array([0.3, -1.0, 0.7])
    before, kept = contact.velocity(), contact.kept()
    arguments = [tuple(row) for i in (0, 1) for row in (contact.v[i], contact.w[i], contact.r[i])]
    assert np.allclose(interpreted(relative_velocity)(*arguments), before)
    contact.push(J)
    assert np.allclose(contact.velocity() - before, contact.K @ J)
    assert np.allclose(np.concatenate(contact.kept()), np.concatenate(kept))
    n = contact.n
    arms = [np.cross(r, n) for r in contact.r]
    k = (1 / contact.m).sum() + sum(a @ i @ a for a, i in zip(arms, contact.inverse, strict=True))
    assert n @ contact.K @ n == pytest.approx(k)
    # The article's form, with a double cross product, is the same number.
    other = sum(n @ np.cross(i @ a, r) for i, a, r in zip(contact.inverse, arms, contact.r, strict=True))
    assert (1 / contact.m).sum() + other == pytest.approx(k)


@checks("impulses-j", "impulses-energy")
@pytest.mark.parametrize("e", [0.0, 0.4, 1.0])
def test_restitution_and_the_energy_it_takes(e):
    contact = Contact(7)
    n, energy = contact.n, contact.energy()
    speed, k = n @ contact.velocity(), n @ contact.K @ n
    contact.push(-(1 + e) * speed / k * n)
    assert n @ contact.velocity() == pytest.approx(-e * speed)
    assert contact.energy() - energy == pytest.approx(-(1 - e**2) * speed**2 / (2 * k), abs=1e-12)


@checks("impulses-bounces", "impulses-moment")
def test_bounces():
    h0, g, e = sp.symbols("h0 g e", positive=True)
    i = sp.Symbol("i", integer=True, nonnegative=True)
    apex = (e**i * sp.sqrt(2 * g * h0)) ** 2 / (2 * g)
    assert sp.simplify(apex - e ** (2 * i) * h0) == 0
    fall = np.sqrt(2 * 3 / 9.81)
    total = fall + sum(2 * fall * 0.6**i for i in range(1, 200))
    assert total == pytest.approx(fall * (1 + 0.6) / (1 - 0.6))
    # The step that contains the impact keeps what semi-implicit Euler keeps.
    s, h, gap, gravity = 3.0, 0.02, 0.01, 9.81
    squared = s**2 + gravity * h * s + 2 * gravity * gap
    u = interpreted(bounce_speed)(0.6, s, gravity, gap, h)
    assert u**2 / 2 + gravity * h * u / 2 + gravity * gap == pytest.approx(0.6**2 * squared / 2)

    def kept(height, velocity):  # upwards, per unit mass
        return velocity**2 / 2 + gravity * height - gravity * h * velocity / 2

    assert kept(gap, -s) == pytest.approx(squared / 2)
    # Leaving the surface downwards or upwards at speed e S is the same squared speed, up to the shift.
    assert kept(gap + h * u, u) == pytest.approx(0.6**2 * squared / 2)


@checks("impulses-complementarity", "impulses-quadratic", "impulses-gauss-seidel")
@pytest.mark.parametrize("seed", range(4))
def test_projected_gauss_seidel_finds_the_least_of_the_quadratic(seed):
    rng = np.random.default_rng(seed)
    jacobian = rng.normal(size=(5, 8))
    A, v, t = jacobian @ jacobian.T, rng.normal(size=5), 0.1 * rng.normal(size=5)
    impulse = np.zeros(5)

    def f(x):
        return x @ A @ x / 2 + (v - t) @ x

    for _ in range(3000):
        for i in range(5):
            before = f(impulse)
            impulse[i] = max(0.0, impulse[i] - ((v + A @ impulse)[i] - t[i]) / A[i, i])
            assert f(impulse) <= before + 1e-12
    after = v + A @ impulse
    assert (impulse >= 0).all()
    assert (after >= t - 1e-9).all()
    assert np.allclose(impulse * (after - t), 0, atol=1e-9)
    # ½ |Lᵀ x + L⁻¹ (v − t)|² differs from f by a constant.
    lower = np.linalg.cholesky(A)
    best, _ = scipy.optimize.nnls(lower.T, -np.linalg.solve(lower, v - t))
    assert np.allclose(impulse, best, atol=1e-7)
