"""The formulas of docs/theory/rotation.md."""

import math

import numpy as np
import sympy as sp
from sympy.algebras.quaternion import Quaternion

from atlasphys.engine.math import quat
from tests.theory.formulas import checks, interpreted

REAL = {"real": True}
p = sp.symbols("p:4", **REAL)
q = sp.symbols("q:4", **REAL)
v = sp.symbols("v:3", **REAL)
mul, conjugate = interpreted(quat.mul), interpreted(quat.conjugate)


def same(left, right):
    return all(sp.expand(x - y) == 0 for x, y in zip(left, right, strict=True))


def vector(a):
    return sp.Matrix(a[1:])


@checks("rotation-complex", "rotation-euler")
def test_complex_numbers():
    a, b, c, d, t = sp.symbols("a b c d t", **REAL)
    x, y = a + b * sp.I, c + d * sp.I
    assert sp.expand(x * y - ((a * c - b * d) + (a * d + b * c) * sp.I)) == 0
    assert sp.simplify(x / y - ((a * c + b * d) + (b * c - a * d) * sp.I) / (c**2 + d**2)) == 0
    series = sp.series(sp.exp(sp.I * t), t, 0, 10).removeO()
    parts = sp.series(sp.cos(t), t, 0, 10).removeO() + sp.I * sp.series(sp.sin(t), t, 0, 10).removeO()
    assert sp.expand(series - parts) == 0
    turned = sp.expand((a + sp.I * b) * (sp.cos(t) + sp.I * sp.sin(t)))
    assert sp.re(turned) == a * sp.cos(t) - b * sp.sin(t)
    assert sp.im(turned) == a * sp.sin(t) + b * sp.cos(t)


@checks("rotation-multiple")
def test_multiple_angles():
    c, s = sp.symbols("c s", **REAL)
    for n in range(1, 8):
        expanded = sp.expand((c + sp.I * s) ** n)
        cosine = sum(sp.binomial(n, 2 * k) * (-1) ** k * c ** (n - 2 * k) * s ** (2 * k) for k in range(n // 2 + 1))
        sine = sum(
            sp.binomial(n, 2 * k + 1) * (-1) ** k * c ** (n - 2 * k - 1) * s ** (2 * k + 1)
            for k in range((n - 1) // 2 + 1)
        )
        assert sp.expand(sp.re(expanded) - cosine) == 0
        assert sp.expand(sp.im(expanded) - sine) == 0


@checks("rotation-product", "rotation-conjugate")
def test_quaternions():
    known = Quaternion(*p) * Quaternion(*q)
    assert same(mul(p, q), (known.a, known.b, known.c, known.d))
    assert same(mul(p, q)[1:], p[0] * vector(q) + q[0] * vector(p) + vector(p).cross(vector(q)))
    assert sp.expand(mul(p, q)[0] - (p[0] * q[0] - vector(p).dot(vector(q)))) == 0
    assert not same(mul(p, q), mul(q, p))
    assert same(mul(q, conjugate(q)), (sum(e * e for e in q), 0, 0, 0))
    assert same(conjugate(mul(p, q)), mul(conjugate(q), conjugate(p)))
    assert sp.expand(sum(e**2 for e in mul(p, q)) - sum(e**2 for e in p) * sum(e**2 for e in q)) == 0


@checks("rotation-sandwich", "rotation-rodrigues", "rotation-axis-angle", "rotation-matrix")
def test_a_unit_quaternion_turns_a_vector():
    turned = mul(mul(q, (0, *v)), conjugate(q))
    V, Q = sp.Matrix(v), vector(q)
    expected = (q[0] ** 2 - Q.dot(Q)) * V + 2 * q[0] * Q.cross(V) + 2 * Q.dot(V) * Q
    assert same(turned, (0, *expected))
    assert mul(q, (0, *v))[0] == -Q.dot(V)

    theta, a, b = sp.symbols("theta a b", **REAL)
    u = sp.Matrix([sp.sin(a) * sp.cos(b), sp.sin(a) * sp.sin(b), sp.cos(a)])
    half = (sp.cos(theta / 2), *(sp.sin(theta / 2) * u))
    rodrigues = u.dot(V) * u + sp.cos(theta) * (V - u.dot(V) * u) + sp.sin(theta) * u.cross(V)
    turned = sp.Matrix(mul(mul(half, (0, *v)), conjugate(half))[1:])
    w, x, y, z = half
    matrix = sp.Matrix(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    at = {theta: 0.7, a: 1.1, b: -0.4, v[0]: 0.3, v[1]: -2.0, v[2]: 0.9}
    assert max(abs(e) for e in (turned - rodrigues).subs(at).evalf()) < 1e-14
    assert max(abs(e) for e in (matrix * V - rodrigues).subs(at).evalf()) < 1e-14
    numbers = tuple(float(e.subs(at)) for e in half)
    assert np.allclose(interpreted(quat.matrix)(numbers), [float(e) for e in matrix.subs(at)], atol=1e-15)


@checks("rotation-rate")
def test_the_rate_of_a_turning_body():
    t, rate, a, b = sp.symbols("t omega a b", **REAL)
    u = sp.Matrix([sp.sin(a) * sp.cos(b), sp.sin(a) * sp.sin(b), sp.cos(a)])
    turning = mul((sp.cos(rate * t / 2), *(sp.sin(rate * t / 2) * u)), q)
    claimed = [e / 2 for e in mul((0, *(rate * u)), turning)]
    assert all(sp.simplify(sp.diff(x, t) - y) == 0 for x, y in zip(turning, claimed, strict=True))
    z = sp.Matrix([[sp.cos(rate * t), -sp.sin(rate * t), 0], [sp.sin(rate * t), sp.cos(rate * t), 0], [0, 0, 1]])
    assert z.diff(t) == sp.Matrix([[0, -rate, 0], [rate, 0, 0], [0, 0, 0]]) * z


@checks("rotation-cayley", "rotation-lengthened")
def test_cayley_s_map_is_a_rotation_by_twice_the_arctangent():
    theta = sp.Matrix(sp.symbols("x y z", **REAL))
    hat = sp.Matrix([[0, -theta[2], theta[1]], [theta[2], 0, -theta[0]], [-theta[1], theta[0], 0]])
    cay = (sp.eye(3) + hat / 2) * (sp.eye(3) - hat / 2).inv()
    assert (cay.T * cay).applyfunc(sp.cancel) == sp.eye(3)
    at = dict(zip(theta, (0.4, -0.9, 0.3), strict=True))
    engine = interpreted(quat.matrix)(interpreted(quat.cayley)(tuple(at.values())))
    assert np.allclose(engine, [float(e) for e in cay.subs(at)], atol=1e-15)
    angle = math.acos((float(cay.subs(at).trace()) - 1) / 2)
    assert abs(angle - 2 * math.atan(math.sqrt(sum(x * x for x in at.values())) / 2)) < 1e-14
    f = sp.Symbol("phi", positive=True)
    assert sp.series(2 * sp.tan(f / 2) / f, f, 0, 6).removeO() == 1 + f**2 / 12 + f**4 / 120


def test_euler_angles_do_not_add():
    """Half a second about x, then half a second about y: no sum of angles says where that ends."""

    def turn(axis, angle):
        c, s = math.cos(angle / 2), math.sin(angle / 2)
        return (c, s * axis[0], s * axis[1], s * axis[2])

    x, y = (1, 0, 0), (0, 1, 0)
    right = mul(turn(y, 1.0), turn(x, 1.0))
    other = mul(turn(x, 1.0), turn(y, 1.0))
    assert max(abs(a - b) for a, b in zip(right, other, strict=True)) > 0.4
