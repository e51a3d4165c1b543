"""Where the contacts of each pair go, and which routine works them out."""

from atlasphys.engine.jit import kernel, routine
from atlasphys.engine.shapes.table import EDGE_COUNT, FEATURE_POINTS, KIND, PLANE, RIM_POINTS, VERTEX_COUNT

CONVEX_CONVEX, PLANE_CONVEX, POLYHEDRA = range(3)
"""Numbers of the routines that the fused step has no lanes for; others follow in ``dispatch.ROUTINES``."""


@routine
def most_points(layout, row_a, row_b):
    """The most points that two shapes can have.

    Clipping a feature of m corners by one of k leaves at most m + k, and one more is kept for the deepest point. On a
    plane a polyhedron may rest on all its vertices, a capsule on two points, a disc on its rim and its lowest point.
    """
    if layout[row_a, KIND] == PLANE or layout[row_b, KIND] == PLANE:
        return max(layout[row_a, VERTEX_COUNT], layout[row_b, VERTEX_COUNT], RIM_POINTS + 1)
    return layout[row_a, FEATURE_POINTS] + layout[row_b, FEATURE_POINTS] + 1


@kernel
def lay_out(pairs, shape, layout, routines, most_edge_pairs, contacts, of_pair, rows, starts):
    """Give each pair its range of slots, and list the pairs of each routine.

    Args:
        pairs: (P, 2) rows of colliders.
        shape: the colliders' rows in the table of shapes, of which ``layout`` is a part.
        routines: (kinds, kinds) the number of the routine for two kinds of shapes.
        most_edge_pairs: CONVEX_CONVEX stands in for POLYHEDRA where the product of the two shapes' numbers of edges is greater.
        contacts: room for P pairs; ``a``, ``b`` and ``first`` are set, and no pair has points.
        of_pair: scratch (P,).
        rows: (P,) on return the pairs, sorted by routine.
        starts: (routines + 1,) on return where in ``rows`` the pairs of each routine begin.

    Returns:
        The number of slots.
    """
    starts[:] = 0
    total = 0
    for p in range(len(pairs)):
        a, b = pairs[p, 0], pairs[p, 1]
        row_a, row_b = shape[a], shape[b]
        number = routines[layout[row_a, KIND], layout[row_b, KIND]]
        if number == POLYHEDRA and layout[row_a, EDGE_COUNT] * layout[row_b, EDGE_COUNT] > most_edge_pairs:
            number = CONVEX_CONVEX
        of_pair[p] = number
        starts[number] += 1
        contacts.a[p], contacts.b[p], contacts.first[p] = a, b, total
        contacts.count[p] = 0
        contacts.gap[p] = 0
        total += most_points(layout, row_a, row_b)
    contacts.first[len(pairs)] = total
    begin = 0
    for number in range(len(starts)):
        begin += starts[number]
        starts[number] = begin
    for p in range(len(pairs) - 1, -1, -1):
        starts[of_pair[p]] -= 1
        rows[starts[of_pair[p]]] = p
    return total
