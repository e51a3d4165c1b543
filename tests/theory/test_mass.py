"""The formulas of docs/theory/mass.md, and the engine's mass properties against integrals."""

import itertools

import numpy as np
import pytest
import scipy.integrate
import sympy as sp

import atlasphys as ap
from atlasphys.engine.shapes.mass import mass_properties
from tests.theory.formulas import checks

r, L, h, a = sp.symbols("r l h a", positive=True)
x, y, t = sp.symbols("x y t", real=True)


def revolution(pieces):
    """Volume, ȳ, I along and I across at density 1 of a solid of revolution, from (radius², y from, y to)."""

    def total(of):
        return sum(sp.integrate(sp.expand(of(square)), (y, low, high)) for square, low, high in pieces)

    mass = sp.pi * total(lambda s: s)
    center = sp.pi * total(lambda s: y * s) / mass
    along = sp.pi / 2 * total(lambda s: s**2)
    across = sp.pi * total(lambda s: s**2 / 4 + y**2 * s) - mass * center**2
    return tuple(sp.simplify(e) for e in (mass, center, along, across))


SOLIDS = {
    "cylinder": ([(r**2, -L / 2, L / 2)], lambda: ap.Cylinder(radius=0.7, length=1.3)),
    "cone": ([(r**2 * (sp.Rational(1, 2) - y / L) ** 2, -L / 2, L / 2)], lambda: ap.Cone(radius=0.7, height=1.3)),
    "capsule": (
        [
            (r**2 - (y + L / 2) ** 2, -L / 2 - r, -L / 2),
            (r**2, -L / 2, L / 2),
            (r**2 - (y - L / 2) ** 2, L / 2, L / 2 + r),
        ],
        lambda: ap.Capsule(radius=0.7, length=1.3),
    ),
    "sphere": ([(r**2 - y**2, -r, r)], lambda: ap.Sphere(radius=0.7)),
}


@checks("mass-disc", "mass-revolution", "mass-cylinder", "mass-cone", "mass-capsule")
@pytest.mark.parametrize("name", SOLIDS)
def test_discs_give_the_engine_s_mass_properties(name):
    pieces, make = SOLIDS[name]
    mass, center, along, across = revolution(pieces)
    claimed = {
        "cylinder": (sp.pi * r**2 * L, 0, mass * r**2 / 2, mass * (3 * r**2 + L**2) / 12),
        "cone": (sp.pi * r**2 * L / 3, -L / 4, mass * r**2 * 3 / 10, mass * (4 * r**2 + L**2) * 3 / 80),
        "capsule": (
            sp.pi * r**2 * (L + 4 * r / 3),
            0,
            sp.pi * r**2 * L * r**2 / 2 + sp.pi * r**3 * 4 / 3 * r**2 * 2 / 5,
            sp.pi * r**2 * L * (r**2 / 4 + L**2 / 12)
            + sp.pi * r**3 * 4 / 3 * (2 * r**2 / 5 + L**2 / 4 + 3 * L * r / 8),
        ),
        "sphere": (sp.pi * r**3 * 4 / 3, 0, mass * r**2 * 2 / 5, mass * r**2 * 2 / 5),
    }[name]
    for derived, said in zip((mass, center, along, across), claimed, strict=True):
        assert sp.simplify(derived - said) == 0
    shape = make()
    numbers = [float(sp.sympify(e).subs({r: 0.7, L: 1.3})) for e in (mass, center, along, across)]
    inertia = shape.inertia(1.0)
    found = [shape.volume, shape.center_of_mass[1], inertia[1][1], inertia[0][0]]
    assert np.allclose(found, numbers, rtol=1e-14, atol=1e-16)
    assert inertia[2][2] == inertia[0][0]
    whole = mass_properties(shape, density=1.0)
    assert np.allclose(
        [whole.mass, *sorted(whole.moments)], sorted(numbers[:1]) + sorted([numbers[2], numbers[3], numbers[3]])
    )


@checks("mass-disc", "mass-revolution")
def test_any_solid_of_revolution_as_a_hull_of_many_points():
    """An ellipsoid of revolution: its integrals against a hull of points on it, to the order of the facets."""
    mass, center, along, across = (
        float(e.subs({r: 0.7, L: 1.3})) for e in revolution([(r**2 * (1 - y**2 / L**2), -L, L)])
    )
    angles = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    points = [(0.0, sign * 1.3, 0.0) for sign in (-1, 1)]
    for polar in np.linspace(0, np.pi, 25)[1:-1]:
        ring = 0.7 * np.sin(polar)
        points += [(ring * np.cos(e), 1.3 * np.cos(polar), ring * np.sin(e)) for e in angles]
    hull = ap.ConvexHull(points)
    inertia = hull.inertia(1.0)
    assert hull.volume < mass
    assert np.allclose([hull.volume, inertia[1][1], inertia[0][0]], [mass, along, across], rtol=0.02)
    assert abs(hull.center_of_mass[1] - center) < 1e-12


@checks("mass-washer")
def test_washers_are_slices_at_right_angles_to_the_axis():
    """A ring of square section, side a, inner radius r, about x = 0 and about x = −1."""
    volume = sp.pi * sp.integrate((r + a) ** 2 - r**2, (y, 0, a))
    assert sp.simplify(volume - 2 * sp.pi * (r + a / 2) * a**2) == 0  # Pappus
    shifted = sp.pi * sp.integrate((r + a + 1) ** 2 - (r + 1) ** 2, (y, 0, a))
    assert sp.simplify(shifted - 2 * sp.pi * (r + a / 2 + 1) * a**2) == 0
    # Slices along the axis, as the article has them, give something else where the region is not symmetric.
    right = sp.pi * sp.integrate(y**2 - (y**2 / 2) ** 2, (y, 0, 2))  # between x = y and x = y²/2, about the y axis
    wrong = sp.pi * sp.integrate((sp.sqrt(2 * x)) ** 2 - x**2, (x, 0, 2))  # the same region, about the x axis
    assert sp.simplify(right - wrong) != 0


@checks("mass-parallel", "mass-triangle")
def test_parallel_axes_and_the_triangle_inequality():
    rng = np.random.default_rng(1)
    points, masses, d = rng.normal(size=(20, 3)), rng.uniform(0.5, 2, 20), np.array([0.3, -1.0, 2.0])

    def tensor(about):
        return sum(m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in zip(masses, points - about, strict=True))

    center = masses @ points / masses.sum()
    moved = tensor(center) + masses.sum() * (d @ d * np.eye(3) - np.outer(d, d))
    assert np.allclose(tensor(center + d), moved)
    J = np.diag(tensor(center))
    assert np.isclose(J[0] + J[1] - J[2], 2 * masses @ (points - center)[:, 2] ** 2)
    with pytest.raises(ap.InvalidArgumentError, match="principal moment"):
        mass_properties(ap.Sphere(radius=1), mass=1.0, inertia=(1.0, 1.0, 2.1))


@checks("mass-tetrahedron")
def test_second_moments_of_a_tetrahedron():
    u, v, w = sp.symbols("u v w", positive=True)
    A, B, C = sp.Matrix([2, 0, 1]), sp.Matrix([1, 3, 0]), sp.Matrix([0, 1, 4])
    p = u * A + v * B + w * C
    jacobian = A.dot(B.cross(C))
    moment = (p * p.T).applyfunc(
        lambda e: sp.integrate(sp.expand(e), (w, 0, 1 - u - v), (v, 0, 1 - u), (u, 0, 1)) * jacobian
    )
    s = A + B + C
    assert moment == jacobian / 6 / 20 * (A * A.T + B * B.T + C * C.T + s * s.T)
    hull = ap.ConvexHull([[float(e) for e in corner] for corner in (0 * A, A, B, C)])
    second = np.array(moment, float) - float(jacobian) / 6 * np.outer(hull.center_of_mass, hull.center_of_mass)
    assert np.allclose(hull.inertia(1.0), np.trace(second) * np.eye(3) - second)


@checks("mass-parametric", "mass-polar", "mass-patch")
def test_length_surface_and_area():
    half_circle = (-a * sp.cos(t), a * sp.sin(t))
    speed = sp.simplify(sp.sqrt(half_circle[0].diff(t) ** 2 + half_circle[1].diff(t) ** 2))
    assert speed == a
    assert sp.integrate(speed, (t, 0, sp.pi)) == sp.pi * a
    assert sp.integrate(2 * sp.pi * half_circle[1] * speed, (t, 0, sp.pi)) == 4 * sp.pi * a**2
    assert sp.simplify(sp.integrate(half_circle[1] * half_circle[0].diff(t), (t, 0, sp.pi)) - sp.pi * a**2 / 2) == 0
    # A curve whose two derivatives differ: writing x' for y', as the article does in one step, gives another length.
    chords = [(s, s**2) for s in np.linspace(0, 1, 2001)]
    length = sum(np.hypot(q[0] - p[0], q[1] - p[1]) for p, q in itertools.pairwise(chords))
    assert abs(length - scipy.integrate.quad(lambda s: np.hypot(1, 2 * s), 0, 1)[0]) < 1e-6
    assert abs(length - scipy.integrate.quad(lambda s: np.hypot(1, 1), 0, 1)[0]) > 0.06
    cardioid = a * (1 + sp.cos(t))
    assert sp.integrate(cardioid**2, (t, 0, 2 * sp.pi)) / 2 == sp.pi * a**2 * 3 / 2
    round_trip = scipy.integrate.quad(lambda s: np.hypot(1 + np.cos(s), -np.sin(s)), 0, 2 * np.pi)[0]
    assert abs(round_trip - 8) < 1e-10
    mu, F = sp.symbols("mu F", positive=True)
    torque = sp.integrate(mu * F / (sp.pi * a**2) * r * r, (r, 0, a), (t, 0, 2 * sp.pi))
    assert sp.simplify(torque - mu * F * a * 2 / 3) == 0


@checks("mass-parts", "mass-circle", "mass-table")
def test_techniques_and_the_table():
    z = sp.Symbol("z", positive=True)
    f, g = sp.Function("f")(z), sp.Function("g")(z)
    assert sp.simplify(sp.diff(f * g, z) - f * g.diff(z) - g * f.diff(z)) == 0
    assert sp.simplify(sp.diff(z * sp.log(z) - z, z) - sp.log(z)) == 0
    circle = z / 2 * sp.sqrt(a**2 - z**2) + a**2 / 2 * sp.asin(z / a)
    at = {a: 2, z: sp.Rational(7, 10)}
    assert abs((sp.diff(circle, z) - sp.sqrt(a**2 - z**2)).subs(at).evalf()) < 1e-14
    assert sp.simplify(sp.diff(x / 2 - sp.sin(2 * x) / 4, x) - sp.sin(x) ** 2) == 0
    for value in (-3.0, 1.7):
        slope = sp.diff(sp.asec(x), x).subs(x, value)
        assert abs(slope - 1 / (abs(value) * np.sqrt(value**2 - 1))) < 1e-14
        other = sp.diff(sp.asec(sp.sqrt(x**2) / 1.5) / 1.5, x).subs(x, value * 1.5)
        assert abs(other - 1 / (value * 1.5 * np.sqrt((value * 1.5) ** 2 - 1.5**2))) < 1e-14
