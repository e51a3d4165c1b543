"""The formulas of docs/theory/xpbd.md."""

import sympy as sp

from tests.theory.formulas import checks

x, v, m, h, alpha, f, c0 = sp.symbols("x v m h alpha f c0", positive=True)
SOFT = alpha / h**2


@checks("xpbd-system", "xpbd-update")
def test_one_visit_solves_a_linear_constraint():
    """C(x) = g · x + c₀ in three dimensions, with a mass matrix."""
    gradient = sp.Matrix([[2, -1, 3]])
    mass = sp.diag(1, 2, 5)
    start = sp.Matrix(sp.symbols("x0:3"))
    k = (gradient * mass.inv() * gradient.T)[0]

    def constraint(at):
        return (gradient * at)[0] + c0

    first = -(constraint(start) + SOFT * 0) / (k + SOFT)
    end = start + mass.inv() * gradient.T * first
    assert (mass * (end - start) - gradient.T * first).applyfunc(sp.simplify) == sp.zeros(3, 1)
    assert sp.simplify(constraint(end) + SOFT * first) == 0
    # The force −C/α at the end of the step, times h², is that multiplier; a second visit changes nothing.
    assert sp.simplify(first + h**2 * constraint(end) / alpha) == 0
    assert sp.simplify(constraint(end) + SOFT * first) == 0
    # Without the memory of λ a second visit would push again.
    assert sp.simplify(constraint(end)) != 0
    assert sp.simplify(constraint(end).subs(alpha, 0)) == 0


@checks("xpbd-velocity", "xpbd-oscillator")
def test_velocity_and_the_oscillator():
    predicted = x + h * v + h**2 * f / m
    multiplier = sp.Symbol("lambda")
    end = predicted + multiplier / m
    assert sp.simplify((end - x) / h - (v + h * f / m + multiplier / m / h)) == 0
    omega = sp.sqrt(1 / (alpha * m))
    free = x + h * v
    solved = free + (-free / (1 / m + SOFT)) / m
    assert sp.simplify(solved - (x + h * v) / (1 + h**2 * omega**2)) == 0
    new_v = sp.simplify((solved - x) / h)

    def energy(position, speed):
        return speed**2 + omega**2 * position**2

    assert sp.simplify(energy(solved, new_v) - energy(x, v) / (1 + h**2 * omega**2)) == 0


@checks("xpbd-friction")
def test_static_friction_as_a_position_constraint():
    """A block dragged by d against its anchor: the correction that brings it back, and when it gives."""
    d, k, mu, load = sp.Rational(1, 100), sp.Rational(1, 2), sp.Rational(1, 2), sp.Rational(3, 100)
    back = -d / k
    assert d + k * back == 0
    assert abs(back) > mu * load  # this one slides
    assert abs(back / 4) <= mu * load  # a quarter of the distance is held
