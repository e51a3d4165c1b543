"""The formulas of docs/theory/vectors.md, on symbols, and the engine's routines against them."""

import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from atlasphys.engine.math import mat, vec
from tests.theory.formulas import checks, interpreted

REAL = {"real": True}
u, v, w = (sp.Matrix(sp.symbols(f"{name}_x {name}_y {name}_z", **REAL)) for name in "uvw")
c = sp.Symbol("c", **REAL)


def zero(expression):
    return sp.Matrix([expression]).expand().is_zero_matrix


def hat(a):
    return sp.Matrix([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def rotation():
    """A general rotation: products of turns about the axes, with rational entries so that identities are exact."""
    x, y, z = (sp.Rational(k, 7) for k in (2, -3, 5))
    q = (1, x, y, z)
    n = sum(e * e for e in q)
    w_, x_, y_, z_ = q
    return (
        sp.Matrix(
            [
                [w_**2 + x_**2 - y_**2 - z_**2, 2 * (x_ * y_ - w_ * z_), 2 * (x_ * z_ + w_ * y_)],
                [2 * (x_ * y_ + w_ * z_), w_**2 - x_**2 + y_**2 - z_**2, 2 * (y_ * z_ - w_ * x_)],
                [2 * (x_ * z_ - w_ * y_), 2 * (y_ * z_ + w_ * x_), w_**2 - x_**2 - y_**2 + z_**2],
            ]
        )
        / n
    )


@checks("vectors-laws", "vectors-length", "vectors-split")
def test_vectors_form_a_space_with_a_length():
    assert u + v == v + u
    assert zero((u + v) + w - (u + (v + w)))
    assert zero(c * (u + v) - c * u - c * v)
    # The article's (u + v) + w = u + (v + u) holds only if w = u.
    assert not zero((u + v) + w - (u + (v + u)))
    unit = interpreted(vec.unit)((3.0, 4.0, 12.0))
    assert unit == tuple(e * (1 / 13) for e in (3, 4, 12))
    n = sp.Matrix([sp.Rational(3, 13), sp.Rational(4, 13), sp.Rational(12, 13)])
    assert zero(n.dot(v - n.dot(v) * n))


@checks("vectors-dot")
def test_the_dot_product_is_the_law_of_cosines():
    assert zero((u - v).dot(u - v) - (u.dot(u) + v.dot(v) - 2 * u.dot(v)))
    theta, a, b = sp.symbols("theta a b", positive=True)
    p, q = sp.Matrix([a, 0, 0]), b * sp.Matrix([sp.cos(theta), sp.sin(theta), 0])
    assert zero(p.dot(q) - a * b * sp.cos(theta))
    assert interpreted(vec.dot)(tuple(u), tuple(v)) == u.dot(v)


@checks("vectors-cross", "vectors-lagrange")
def test_the_cross_product_is_square_to_its_factors_and_measures_area():
    assert sp.Matrix(interpreted(vec.cross)(tuple(u), tuple(v))) == u.cross(v)
    assert sp.Matrix([u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]) == u.cross(v)
    assert zero(u.dot(u.cross(v)))
    assert zero(u.cross(v) + v.cross(u))
    assert zero(u.cross(v).dot(u.cross(v)) - (u.dot(u) * v.dot(v) - u.dot(v) ** 2))


@checks("vectors-triple", "vectors-double", "vectors-jacobi")
def test_identities_of_three_vectors():
    assert zero(u.dot(v.cross(w)) - v.dot(w.cross(u)))
    assert zero(u.dot(v.cross(w)) - w.dot(u.cross(v)))
    assert zero(u.cross(v.cross(w)) - (u.dot(w) * v - u.dot(v) * w))
    assert zero(u.cross(v.cross(w)) + v.cross(w.cross(u)) + w.cross(u.cross(v)))
    assert not zero(u.cross(v.cross(w)) - u.cross(v).cross(w))


@checks("vectors-product", "vectors-hat")
def test_matrices():
    A, B, C = (sp.Matrix(3, 3, sp.symbols(f"{name}:9")) for name in "abc")
    assert zero((A * B) * C - A * (B * C))
    assert zero((A * B).T - B.T * A.T)
    assert not zero(A * B - B * A)
    assert zero(A * v - sp.Matrix(interpreted(mat.mul_vec)(tuple(A), tuple(v))))
    assert zero(hat(u) * v - u.cross(v))
    assert hat(u).T + hat(u) == sp.zeros(3, 3)
    assert zero(-hat(u) * hat(u) - (u.dot(u) * sp.eye(3) - u * u.T))


@checks("vectors-rotation", "vectors-tensor")
def test_rotations_keep_products_and_carry_tensors():
    R = rotation()
    assert zero(R.T * R - sp.eye(3))
    assert R.det() == 1
    assert zero((R * u).dot(R * v) - u.dot(v))
    assert zero((R * u).cross(R * v) - R * u.cross(v))
    d = sp.symbols("d:3", positive=True)
    D = sp.diag(*d)
    xx, yy, zz, xy, xz, yz = interpreted(mat.rotated_diagonal)(tuple(R), d)
    assert zero(sp.Matrix([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) - R * D * R.T)
    assert zero(R * D * R.T * (R * D.inv() * R.T) - sp.eye(3))


@checks("vectors-tangents")
def test_tangents_on_symbols():
    theta, phi = sp.symbols("theta phi", **REAL)
    n = sp.Matrix([sp.sin(theta) * sp.cos(phi), sp.sin(theta) * sp.sin(phi), sp.cos(theta)])
    for s in (1, -1):
        a = -1 / (s + n[2])
        t1 = sp.Matrix([1 + s * a * n[0] ** 2, s * a * n[0] * n[1], -s * n[0]])
        t2 = sp.Matrix([a * n[0] * n[1], s + a * n[1] ** 2, -n[1]])
        for value in (t1.dot(n), t2.dot(n), t1.dot(t2), t1.dot(t1) - 1, t2.dot(t2) - 1, t1.cross(t2).dot(n) - 1):
            assert sp.simplify(value) == 0


@checks("vectors-tangents")
@settings(max_examples=40)
@given(st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda n: sum(e * e for e in n) > 1e-6))
def test_the_engine_s_tangents(direction):
    n = sp.Matrix(interpreted(vec.unit)(direction)).evalf()
    t1, t2 = (sp.Matrix(t) for t in interpreted(vec.tangents)(tuple(float(e) for e in n)))
    for value in (t1.dot(n), t2.dot(n), t1.dot(t2), t1.dot(t1) - 1, t2.dot(t2) - 1, t1.cross(t2).dot(n) - 1):
        assert abs(value) < 1e-14
