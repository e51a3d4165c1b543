"""Linear systems with a symmetric positive definite 6×6 matrix, such as a rigid body's: three rows for translation, three for rotation."""

from atlasphys.engine.jit import routine


@routine
def solve_6x6(a, b, d, u, w):
    """The solution (x, y) of A x + Bᵀ y = u, B x + D y = w, as two vectors.

    A and D are symmetric (six scalars: xx, yy, zz, xy, xz, yz), B is 3×3 (nine, row by row). The whole matrix is factored as L Δ Lᵀ with a unit
    lower triangle L and a diagonal Δ: no square roots, and no pivots, which a positive definite matrix does not need. (Golub and Van Loan,
    Matrix Computations, 4.1.2.) The rows are written out: loops over small arrays would cost several times as much.
    """
    one = type(u[0])(1)
    # e_ij = l_ij δ_j is the entry (i, j) before it is divided by its column's pivot.
    p0 = one / a[0]
    l10, l20, l30, l40, l50 = a[3] * p0, a[4] * p0, b[0] * p0, b[3] * p0, b[6] * p0
    p1 = one / (a[1] - l10 * a[3])
    e21, e31, e41, e51 = a[5] - l20 * a[3], b[1] - l30 * a[3], b[4] - l40 * a[3], b[7] - l50 * a[3]
    l21, l31, l41, l51 = e21 * p1, e31 * p1, e41 * p1, e51 * p1
    p2 = one / (a[2] - l20 * a[4] - l21 * e21)
    e32 = b[2] - l30 * a[4] - l31 * e21
    e42 = b[5] - l40 * a[4] - l41 * e21
    e52 = b[8] - l50 * a[4] - l51 * e21
    l32, l42, l52 = e32 * p2, e42 * p2, e52 * p2
    p3 = one / (d[0] - l30 * b[0] - l31 * e31 - l32 * e32)
    e43 = d[3] - l40 * b[0] - l41 * e31 - l42 * e32
    e53 = d[4] - l50 * b[0] - l51 * e31 - l52 * e32
    l43, l53 = e43 * p3, e53 * p3
    p4 = one / (d[1] - l40 * b[3] - l41 * e41 - l42 * e42 - l43 * e43)
    e54 = d[5] - l50 * b[3] - l51 * e41 - l52 * e42 - l53 * e43
    l54 = e54 * p4
    p5 = one / (d[2] - l50 * b[6] - l51 * e51 - l52 * e52 - l53 * e53 - l54 * e54)

    z0 = u[0]
    z1 = u[1] - l10 * z0
    z2 = u[2] - l20 * z0 - l21 * z1
    z3 = w[0] - l30 * z0 - l31 * z1 - l32 * z2
    z4 = w[1] - l40 * z0 - l41 * z1 - l42 * z2 - l43 * z3
    z5 = w[2] - l50 * z0 - l51 * z1 - l52 * z2 - l53 * z3 - l54 * z4
    y2 = z5 * p5
    y1 = z4 * p4 - l54 * y2
    y0 = z3 * p3 - l43 * y1 - l53 * y2
    x2 = z2 * p2 - l32 * y0 - l42 * y1 - l52 * y2
    x1 = z1 * p1 - l21 * x2 - l31 * y0 - l41 * y1 - l51 * y2
    x0 = z0 * p0 - l10 * x1 - l20 * x2 - l30 * y0 - l40 * y1 - l50 * y2
    return (x0, x1, x2), (y0, y1, y2)
