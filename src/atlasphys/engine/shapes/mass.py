"""Mass, centre of mass and principal moments of inertia of a body made of one shape."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from atlasphys.engine.shapes.arguments import entries, invalid, number
from atlasphys.engine.shapes.plane import Plane
from atlasphys.engine.shapes.shape import Matrix, Shape, Vector, diagonal
from atlasphys.errors import InvalidArgumentError

LEAST, GREATEST = 1e-37, 1e37
"""Range of masses [kg] and moments [kg m²]: they and their inverses are normal numbers in single precision."""

INERTIA_TOLERANCE = 1e-6
"""By how much, as a part of its greatest entry, a given inertia tensor may miss symmetry and the triangle
inequality. Covers numbers from files with seven digits; larger would let wrong tensors pass."""

NEGLIGIBLE = 1e-11
"""An off-diagonal entry smaller than this part of the geometric mean of its two diagonal entries counts as zero, so
that round-off does not turn the axes of a symmetric body."""


@dataclass(frozen=True, slots=True)
class MassProperties:
    """What a body's shape means for its motion."""

    mass: float
    """[kg]"""
    center: Vector
    """Centre of mass in the shape's own frame [m]."""
    moments: Vector
    """Principal moments of inertia about the centre of mass [kg m²]."""
    principal: tuple[float, float, float, float]
    """Unit quaternion (w, x, y, z) from the principal axes to the shape's own frame."""


def mass_properties(
    shape: Shape,
    *,
    mass: float | None = None,
    density: float | None = None,
    inertia: npt.ArrayLike | Sequence[float] | None = None,
) -> MassProperties:
    """Mass properties of a shape of uniform density.

    Args:
        shape: any shape but a plane.
        mass: mass [kg]; or give
        density: density [kg/m³].
        inertia: inertia about the centre of mass instead of the shape's own [kg m²]: three moments about the shape's
            axes, or a 3×3 tensor in those axes. Default: that of the shape.

    Raises:
        InvalidArgumentError: not exactly one of mass and density is given; a value is not positive, or so small or
            large that single precision does not hold it or its inverse; the inertia is not one that a body can have;
            the shape is a plane.
    """
    if isinstance(shape, Plane):
        raise InvalidArgumentError("a plane has no finite mass: its body must be static")
    if (mass is None) == (density is None):
        raise InvalidArgumentError("give exactly one of mass and density")
    if mass is not None:
        total = _in_range("mass", "kg", number("mass", mass, "a positive number of kg"), mass)
    else:
        rho = number("density", density, "a positive number of kg/m³")
        if rho <= 0.0:
            raise invalid("density", "a positive number of kg/m³", density)
        total = _in_range("density × volume", "kg", rho * shape.volume, density)
    tensor = shape.inertia(total / shape.volume) if inertia is None else _checked_inertia(inertia)
    moments, principal = principal_axes(tensor)
    for moment in moments:
        _in_range("each principal moment of inertia", "kg m²", moment, inertia if inertia is not None else moments)
    low, middle, high = sorted(moments)
    if high > low + middle + INERTIA_TOLERANCE * high:
        raise invalid("inertia", "such that no principal moment is greater than the sum of the others", inertia)
    return MassProperties(total, shape.center_of_mass, moments, principal)


def _in_range(name: str, unit: str, value: float, given: object) -> float:
    if not LEAST <= value <= GREATEST:
        raise invalid(name, f"between {LEAST:g} and {GREATEST:g} {unit}", given)
    return value


def _checked_inertia(inertia: object) -> Matrix:
    """The tensor that was given, as a symmetric matrix."""
    wanted = "three positive moments or a symmetric positive definite 3×3 tensor [kg m²]"
    rows = entries("inertia", inertia, 3, wanted)
    if not any(isinstance(row, (Sequence, np.ndarray)) for row in rows):
        x, y, z = (number(f"inertia[{i}]", entry) for i, entry in enumerate(rows))
        return diagonal(x, y, z)
    m = [
        [number(f"inertia[{i}][{j}]", entry) for j, entry in enumerate(entries(f"inertia[{i}]", row, 3, wanted))]
        for i, row in enumerate(rows)
    ]
    largest = max(abs(entry) for row in m for entry in row)
    if any(abs(m[i][j] - m[j][i]) > INERTIA_TOLERANCE * largest for i, j in ((0, 1), (0, 2), (1, 2))):
        raise invalid("inertia", "a symmetric tensor", inertia)
    xy, xz, yz = 0.5 * m[0][1] + 0.5 * m[1][0], 0.5 * m[0][2] + 0.5 * m[2][0], 0.5 * m[1][2] + 0.5 * m[2][1]
    return (m[0][0], xy, xz), (xy, m[1][1], yz), (xz, yz, m[2][2])


def principal_axes(tensor: Matrix) -> tuple[Vector, tuple[float, float, float, float]]:
    """Eigenvalues of a symmetric tensor and the quaternion whose rotation has the eigenvectors as columns.

    Cyclic Jacobi rotations (Golub and Van Loan, Matrix Computations, 4th ed., §8.5.3). Each turns by at most 45°, so a
    diagonal tensor keeps its axes, and the identity, exactly. Written out in Python floats since LAPACK's last bits
    differ between CPUs.
    """
    a = [list(row) for row in tensor]
    v = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    for _ in range(50):  # five sweeps are usual: convergence is quadratic
        turned = False
        for p, q in ((0, 1), (0, 2), (1, 2)):
            if abs(a[p][q]) <= NEGLIGIBLE * math.sqrt(abs(a[p][p])) * math.sqrt(abs(a[q][q])):
                continue
            turned = True
            theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q])
            t = math.copysign(1.0, theta) / (abs(theta) + math.sqrt(theta * theta + 1.0))
            c = 1.0 / math.sqrt(t * t + 1.0)
            s = t * c
            r = 3 - p - q
            a[p][p], a[q][q] = a[p][p] - t * a[p][q], a[q][q] + t * a[p][q]
            a[p][q] = a[q][p] = 0.0
            a[r][p], a[r][q] = c * a[r][p] - s * a[r][q], s * a[r][p] + c * a[r][q]
            a[p][r], a[q][r] = a[r][p], a[r][q]
            for row in v:
                row[p], row[q] = c * row[p] - s * row[q], s * row[p] + c * row[q]
        if not turned:
            break
    return (a[0][0], a[1][1], a[2][2]), _quaternion(v)


def _quaternion(m: list[list[float]]) -> tuple[float, float, float, float]:
    """The unit quaternion, w ≥ 0, of a rotation matrix, from its component of greatest magnitude.

    Shepperd, "Quaternion from Rotation Matrix", J. Guidance and Control 1(3), 1978.
    """
    squares = [
        1.0 + m[0][0] + m[1][1] + m[2][2],
        1.0 + m[0][0] - m[1][1] - m[2][2],
        1.0 - m[0][0] + m[1][1] - m[2][2],
        1.0 - m[0][0] - m[1][1] + m[2][2],
    ]
    x, y, z = m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]
    xy, xz, yz = m[0][1] + m[1][0], m[0][2] + m[2][0], m[1][2] + m[2][1]
    largest = squares.index(max(squares))
    rows = ((squares[0], x, y, z), (x, squares[1], xy, xz), (y, xy, squares[2], yz), (z, xz, yz, squares[3]))
    row = rows[largest]
    size = math.sqrt(sum(entry * entry for entry in row))
    scale = -size if row[0] < 0.0 else size
    return row[0] / scale + 0.0, row[1] / scale + 0.0, row[2] / scale + 0.0, row[3] / scale + 0.0
