"""The formulas of docs/theory/integrators.md."""

import numpy as np
import pytest
import sympy as sp

import atlasphys as ap
from atlasphys.engine.solvers.integrate import midpoint_spin
from tests.theory.formulas import checks, interpreted

h, w, k, K, g, c = sp.symbols("h omega k K g c", positive=True)
x, v, t, P = sp.symbols("x v t P", real=True)
SEMI = sp.Matrix([[1 - h**2 * w**2, h], [-h * w**2, 1]])
EXPLICIT = sp.Matrix([[1, h], [-h * w**2, 1]])
IMPLICIT = EXPLICIT / (1 + h**2 * w**2)


@checks("integrators-logistic", "integrators-logistic-solution")
def test_the_logistic_equation():
    P0 = sp.Symbol("P0", positive=True)
    solution = K / (1 + (K - P0) / P0 * sp.exp(-k * t))
    assert sp.simplify(sp.diff(solution, t) - k * solution * (1 - solution / K)) == 0
    assert sp.simplify(solution.subs(t, 0) - P0) == 0
    assert sp.simplify(sp.apart(K / (P * (K - P)), P) - (1 / P + 1 / (K - P))) == 0
    above = [float(solution.subs({K: 1, k: 1, P0: 3, t: s})) for s in (0, 0.5, 1, 5)]
    assert above == sorted(above, reverse=True)
    assert above[-1] > 1


def euler(step, seconds=4.0):
    p = 0.1
    for _ in range(round(seconds / step)):
        p += step * p * (1 - p)
    return p


@checks("integrators-order", "integrators-stability")
def test_explicit_euler_is_of_first_order_and_breaks_at_hk_of_2():
    f = sp.Function("P")
    series = f(t + h).series(h, 0, 3).removeO().doit()
    assert sp.simplify(series - f(t) - h * f(t).diff(t) - h**2 / 2 * f(t).diff(t, 2)) == 0
    exact = 1 / (1 + 9 * np.exp(-4.0))
    errors = [abs(euler(step) - exact) for step in (0.02, 0.01, 0.005)]
    assert errors[0] / errors[1] == pytest.approx(2, rel=0.02)
    assert errors[1] / errors[2] == pytest.approx(2, rel=0.01)
    step = P + h * k * P * (1 - P / K)
    assert sp.simplify(sp.diff(step, P).subs(P, K) - (1 - h * k)) == 0
    assert abs(euler(1.9, 190) - 1) < 1e-3 < abs(euler(2.1, 210) - 1)


@checks("integrators-maps", "integrators-determinants", "integrators-shadow")
def test_energy_of_three_eulers():
    state = sp.Matrix([x, v])
    field = sp.Matrix([[0, 1], [-(w**2), 0]])
    assert sp.eye(2) + h * field == EXPLICIT
    assert sp.simplify(IMPLICIT - (sp.eye(2) - h * field).inv()) == sp.zeros(2, 2)
    new_v = v - h * w**2 * x
    assert (SEMI * state - sp.Matrix([x + h * new_v, new_v])).expand() == sp.zeros(2, 1)
    assert sp.simplify(EXPLICIT.det() - (1 + h**2 * w**2)) == 0
    assert sp.simplify(IMPLICIT.det() - 1 / (1 + h**2 * w**2)) == 0
    assert sp.simplify(SEMI.det() - 1) == 0

    def energy(s):
        return s[1] ** 2 / 2 + w**2 * s[0] ** 2 / 2

    def shadow(s):
        return energy(s) - h * w**2 * s[0] * s[1] / 2

    assert sp.simplify(energy(EXPLICIT * state) - (1 + h**2 * w**2) * energy(state)) == 0
    assert sp.simplify(energy(IMPLICIT * state) - energy(state) / (1 + h**2 * w**2)) == 0
    assert sp.expand(shadow(SEMI * state) - shadow(state)) == 0
    # Positive definite up to hω = 2, where the eigenvalues leave the unit circle.
    hessian = sp.hessian(shadow(state), (x, v))
    assert sp.simplify(hessian.det() - w**2 * (1 - h**2 * w**2 / 4)) == 0
    for step, radius in ((1.9, 1.0), (2.1, 1.3)):
        found = max(abs(np.linalg.eigvals(np.array(SEMI.subs({h: step, w: 1}), float))))
        assert (found == pytest.approx(1)) if radius == 1 else found > radius


@checks("integrators-fall", "integrators-fall-shadow")
@pytest.mark.parametrize("solver", ["sequential_impulse", "avbd"])
def test_free_fall_of_the_engine(solver):
    n = sp.Symbol("n", positive=True, integer=True)
    y0, v0 = sp.symbols("y0 v0", real=True)
    claimed = y0 + v0 * n * h - g * n * h * (n * h + h) / 2
    speed = v0 - g * n * h
    assert sp.expand(claimed.subs(n, n + 1) - claimed - h * speed.subs(n, n + 1)) == 0
    assert claimed.subs(n, 0) == y0
    kept = speed**2 / 2 + g * claimed - g * h * speed / 2
    assert sp.expand(kept.subs(n, n + 1) - kept) == 0
    world = ap.World(gravity=(0, -9.81, 0), precision="double", solver=solver)
    ball = world.add(ap.Sphere(radius=0.5), position=(0, 2, 0), velocity=(0, 3, 0))
    for _ in range(30):
        world.step(1 / 60)
    at = {y0: 2, v0: 3, g: 9.81, h: 1 / 60, n: 30}
    assert ball.position[1] == pytest.approx(float(claimed.subs(at)), abs=1e-12)
    assert ball.velocity[1] == pytest.approx(float(speed.subs(at)), abs=1e-12)


@checks("integrators-damping")
def test_implicit_damping():
    assert sp.expand(sp.series(1 / (1 + h * c) - sp.exp(-h * c), h, 0, 3).removeO() - h**2 * c**2 / 2) == 0
    world = ap.World(gravity=(0, 0, 0), precision="double", solver="sequential_impulse")
    ball = world.add(ap.Sphere(radius=0.5), velocity=(1, 0, 0), linear_damping=300.0)
    world.step(1 / 60)
    assert ball.velocity[0] == pytest.approx(1 / (1 + 300 / 60), rel=1e-14)


@checks("integrators-euler", "integrators-dzhanibekov")
def test_euler_s_equation():
    J = sp.diag(*sp.symbols("I_1 I_2 I_3", positive=True))
    omega = sp.Matrix(sp.symbols("w1 w2 w3", real=True))
    L = J * omega
    assert (L.cross(J.inv() * L) + omega.cross(J * omega)).expand() == sp.zeros(3, 1)
    spin, e2, e3 = sp.symbols("Omega e2 e3", real=True)
    rate = -J.inv() * sp.Matrix([spin, e2, e3]).cross(J * sp.Matrix([spin, e2, e3]))
    # ε̇₂ = a ε₃ and ε̇₃ = b ε₂ to first order, so ε̈₂ = a b ε₂.
    a, b = rate[1].diff(e3).subs(e2, 0), rate[2].diff(e2).subs(e3, 0)
    I1, I2, I3 = J.diagonal()
    assert sp.simplify(a * b - (I3 - I1) * (I1 - I2) / (I2 * I3) * spin**2) == 0


@checks("integrators-midpoint", "integrators-invariants", "integrators-world")
def test_the_midpoint_rule_keeps_both_invariants():
    m = sp.Matrix(sp.symbols("m:3", real=True))
    J = sp.diag(*sp.symbols("I_1 I_2 I_3", positive=True))
    spin = J.inv() * m
    change = h * m.cross(spin)
    assert sp.expand(2 * m.dot(change)) == 0
    assert sp.expand(2 * spin.dot(change)) == 0

    def cay(theta):
        hat = np.array([[0, -theta[2], theta[1]], [theta[2], 0, -theta[0]], [-theta[1], theta[0], 0]])
        return (np.eye(3) + hat / 2) @ np.linalg.inv(np.eye(3) - hat / 2)

    inertia, start, step = np.array([1.0, 2.5, 3.0]), np.array([0.4, 5.0, -0.7]), 0.05
    middle = np.array(interpreted(midpoint_spin)(tuple(inertia * start), tuple(inertia), tuple(1 / inertia), step))
    before, after = inertia * start, cay(-step * middle) @ (inertia * start)
    assert np.allclose((before + after) / 2, inertia * middle, atol=1e-14)
    assert np.allclose(after, before + step * np.cross(inertia * middle, middle), atol=1e-14)
    assert after @ after == pytest.approx(before @ before, rel=1e-14)
    assert after @ (after / inertia) == pytest.approx(before @ (before / inertia), rel=1e-14)
    assert np.allclose(cay(step * middle) @ after, before, atol=1e-14)
