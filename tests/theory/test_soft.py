"""The formulas of docs/theory/soft.md."""

import math

import pytest
import sympy as sp

from atlasphys.engine.solvers.soft_step import softness
from tests.theory.formulas import checks

s, v, w, z, h, k, g, old = sp.symbols("s v omega zeta h k g lambda", positive=True)
RATE = w / (2 * z + h * w)
SOFT = 1 / (h * w * (2 * z + h * w))


@checks("soft-ode", "soft-implicit", "soft-constraint")
def test_the_implicit_spring_is_a_soft_constraint():
    new = sp.Symbol("new")
    solved = sp.solve(sp.Eq(new, v - h * (2 * z * w * new + w**2 * (s + h * new))), new)[0]
    assert sp.simplify(solved - (v - h * w**2 * s) / (1 + h * w * (2 * z + h * w))) == 0
    impulse = (solved - v) / k
    assert sp.simplify(solved + RATE * s + SOFT * k * impulse) == 0
    # Consistent with the differential equation: (v' − v) / h → −2ζω v − ω² s.
    assert sp.simplify(sp.limit((solved - v) / h, h, 0) + 2 * z * w * v + w**2 * s) == 0


@checks("soft-sweep")
def test_the_sweep_and_the_engine_s_numbers():
    mass_scale = 1 / (1 + SOFT)
    sweep = old - (v + RATE * s + SOFT * k * old) / ((1 + SOFT) * k)
    assert sp.simplify(sweep - ((1 - (1 - mass_scale)) * old - mass_scale / k * (v + RATE * s))) == 0
    # Its fixed point is the soft constraint: with v + k (λ' − λ) in place of v' it holds after one sweep.
    assert sp.simplify((v + k * (sweep - old)) + RATE * s + SOFT * k * sweep) == 0
    assert sp.limit(mass_scale, w, sp.oo) == 1
    assert sp.limit(RATE, w, sp.oo) == 1 / h
    for frequency, damping, step in ((30, 10, 1 / 240), (60, 1, 1 / 600)):
        at = {w: 2 * math.pi * frequency, z: damping, h: step}
        assert softness(frequency, damping, step) == pytest.approx([float(e.subs(at)) for e in (RATE, mass_scale)])


@checks("soft-sag", "soft-substeps")
def test_sag_and_substeps():
    # At rest: v' = 0 after gravity has made it −g h.
    solved = ((-g * h) - h * w**2 * s) / (1 + h * w * (2 * z + h * w))
    assert sp.solve(sp.Eq(solved.subs(s, -k), 0), k)[0] == g / w**2
    a, n = sp.symbols("a N", positive=True)
    assert sp.simplify(n * a * (h / n) ** 2 - a * h**2 / n) == 0
    # The overlap that such a step leaves under a load, by simulation: one mass, one spring, many steps.
    overlap, speed = 0.0, 0.0
    omega, step = 2 * math.pi * 30, 1 / 240
    rate, mass_scale = softness(30, 10, step)
    impulse = 0.0
    for _ in range(5000):
        speed -= 9.81 * step
        speed += impulse  # warm start, unit mass
        new = mass_scale * impulse - mass_scale * (speed + rate * overlap)
        speed += new - impulse
        impulse = new
        overlap += step * speed
    assert overlap == pytest.approx(-9.81 / omega**2, rel=1e-6)
