"""Small symmetric systems of equations. Over lanes, or over plain numbers."""

from __future__ import annotations

from typing import Any

from atlasphys.engine.joints.ends import reciprocal
from atlasphys.engine.simd import select


def solve_symmetric(matrix: list[list[Any]], wanted: list[Any]) -> list[Any]:
    """K⁻¹ x for a symmetric K of two or three rows, its upper triangle given, by Cramer's rule; rows that nothing moves give 0."""
    if len(wanted) == 2:
        (a, b), (c,) = matrix
        determinant = a * c - b * b
        regular = determinant > 1e-7 * (a * c)
        inverse = 1 / determinant
        x, y = wanted
        return [
            select(regular, (c * x - b * y) * inverse, reciprocal(a) * x),
            select(regular, (a * y - b * x) * inverse, reciprocal(c) * y),
        ]
    (xx, xy, xz), (yy, yz), (zz,) = matrix
    a, b, c = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    d, e, f = xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy
    determinant = xx * a + xy * b + xz * c
    regular = determinant > 1e-7 * (xx * yy * zz)
    inverse = 1 / determinant
    x, y, z = wanted
    return [
        select(regular, (a * x + b * y + c * z) * inverse, reciprocal(xx) * x),
        select(regular, (b * x + d * y + e * z) * inverse, reciprocal(yy) * y),
        select(regular, (c * x + e * y + f * z) * inverse, reciprocal(zz) * z),
    ]
