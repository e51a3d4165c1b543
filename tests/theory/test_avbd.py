"""The formulas of docs/theory/avbd.md."""

import numpy as np
import pytest
import sympy as sp

from atlasphys.engine.math.ldlt import solve_6x6
from atlasphys.engine.solvers.avbd_contacts import contact_force
from tests.theory.formulas import checks, interpreted

SOLVE, FORCE = interpreted(solve_6x6), interpreted(contact_force)


@checks("avbd-minimum", "avbd-newton")
def test_implicit_euler_is_a_minimum_and_block_descent_finds_it():
    x, y, m, h = sp.symbols("x y m h", positive=True)
    energy = sp.Function("E")(x)
    slope = sp.diff(m * (x - y) ** 2 / (2 * h**2) + energy, x)
    assert sp.simplify(slope - (m * (x - y) / h**2 + energy.diff(x))) == 0
    # Three masses joined by springs: sweeps over one mass at a time never raise G and reach its least.
    rng = np.random.default_rng(3)
    springs = rng.normal(size=(4, 3))
    hessian, mass, step, target = springs.T @ springs * 50, np.array([1.0, 2.0, 0.5]), 0.1, rng.normal(size=3)
    system = np.diag(mass / step**2) + hessian
    least = np.linalg.solve(system, mass / step**2 * target)
    at = target.copy()

    def total(p):
        return (mass * (p - target) ** 2).sum() / (2 * step**2) + p @ hessian @ p / 2

    for _ in range(200):
        for i in range(3):
            before = total(at)
            force = -mass[i] / step**2 * (at[i] - target[i]) - (hessian @ at)[i]
            at[i] += force / system[i, i]
            assert total(at) <= before + 1e-12
    assert np.allclose(at, least)


@checks("avbd-ldlt")
@pytest.mark.parametrize("seed", range(4))
def test_ldlt(seed):
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(6, 6))
    H, f = root @ root.T + np.eye(6), rng.normal(size=6)
    lower, pivots = np.eye(6), np.zeros(6)
    for j in range(6):
        pivots[j] = H[j, j] - (lower[j, :j] ** 2 * pivots[:j]).sum()
        for i in range(j + 1, 6):
            lower[i, j] = (H[i, j] - (lower[i, :j] * lower[j, :j] * pivots[:j]).sum()) / pivots[j]
    assert np.allclose(lower @ np.diag(pivots) @ lower.T, H)
    assert (pivots > 0).all()

    def six(s):
        return s[0, 0], s[1, 1], s[2, 2], s[0, 1], s[0, 2], s[1, 2]

    x, y = SOLVE(six(H[:3, :3]), tuple(H[3:, :3].ravel()), six(H[3:, 3:]), tuple(f[:3]), tuple(f[3:]))
    assert np.allclose(H @ [*x, *y], f)


@checks("avbd-multiplier", "avbd-rate")
@pytest.mark.parametrize("kappa", [0.1, 1.0, 10.0])
def test_the_multiplier_makes_a_contact_hard(kappa):
    x, multiplier, load, mu, stiffness = sp.symbols("x lambda F mu kappa", positive=True)
    least = sp.solve(sp.diff(mu * x**2 / 2 + load * x - multiplier * x + stiffness * x**2 / 2, x), x)[0]
    assert sp.simplify(least - (multiplier - load) / (mu + stiffness)) == 0
    new = multiplier - stiffness * least
    assert sp.simplify(new - load - mu / (mu + stiffness) * (multiplier - load)) == 0
    # In the engine's units: penalty in kg, impulse in N s, n · u − target for C / h.
    mass, pull, held = 1.0, 3.0, 0.0
    for _ in range(400):
        speed = (held - pull) / (mass + kappa)
        held, _, _ = FORCE(held, (0.0, 0.0, 0.0), kappa, 0.0, (0.0, 1.0, 0.0), (0.0, speed, 0.0), 0.0)
    assert held == pytest.approx(pull)
    assert (held - pull) / (mass + kappa) == pytest.approx(0, abs=1e-9)
    # Pulled upwards instead, the contact lets go.
    assert FORCE(0.0, (0.0, 0.0, 0.0), kappa, 0.0, (0.0, 1.0, 0.0), (0.0, 2.0, 0.0), 0.0)[0] == 0


@checks("avbd-block", "avbd-friction")
def test_a_contact_point_in_the_system():
    r = sp.Matrix(sp.symbols("r:3", real=True))
    hat = sp.Matrix([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])
    jacobian = sp.Matrix.hstack(sp.eye(3), -hat)
    block = sp.Matrix(sp.BlockMatrix([[sp.eye(3), -hat], [hat, r.dot(r) * sp.eye(3) - r * r.T]]))
    assert (jacobian.T * jacobian - block).expand() == sp.zeros(6, 6)
    for slip in (0.1, 5.0):
        pressed, rubs, share = FORCE(2.0, (0.3, 0.0, 0.0), 1.0, 0.5, (0.0, 1.0, 0.0), (slip, 0.0, 0.4), 0.0)
        wanted = np.array([0.3 - slip, 0, -0.4])
        assert pressed == 2.0
        assert share == pytest.approx(min(1, 0.5 * 2 / np.linalg.norm(wanted)))
        assert np.allclose(rubs, share * wanted)
