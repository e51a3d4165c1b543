"""Two boxes: the separating axis test over fifteen axes, then clipping, or the crossing of two edges.

The axes are those of S. Gottschalk, M. C. Lin, D. Manocha, "OBBTree", SIGGRAPH 1996. The second box's faces must part
the boxes better than the first's, and pairs of edges better than faces, by a bias, so that the features in contact do
not change with every bit of round-off.

Along a face's normal the contact is the other box's incident face, a parallelogram as seen along the normal, cut to
the face's rectangle. The corners of that polygon are known at once, without cutting by one side after the other: each
of the parallelogram's four edges gives the ends of its part within the rectangle (Y. Liang, B. Barsky, "A New Concept and
Method for Line Clipping", ACM TOG 3(1), 1984), and the rectangle's corners within the parallelogram are the rest. Of
these twelve at most four are kept.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from atlasphys.engine.narrowphase.clip import FACE_PREFERENCE
from atlasphys.engine.narrowphase.lanes.common import (
    FIRST,
    ROOM,
    SECOND,
    clamp,
    from_axis,
    sign,
    vector,
    within,
    write_contact,
)
from atlasphys.engine.narrowphase.lanes.reduce import Point, keep_four
from atlasphys.engine.narrowphase.sat import PARALLEL_SQUARED
from atlasphys.engine.simd import (
    absolute,
    any_lane,
    full,
    gather,
    load,
    maximum,
    minimum,
    select,
    simd_kernel,
    sqrt,
    store,
    vec,
    when,
)

RELATIVE_PREFERENCE = 0.01
"""Bias in favour of faces as a part of the depth, besides the absolute one (``FACE_PREFERENCE``). Smaller: the axis of
deep contacts flickers. Larger: by so much more than the least depth is reported."""

STEADY = 0.01
"""How much more (as a cosine) another face must be turned towards the reference face to become the incident one."""

FIRST_EDGE_FEATURE = 1 << 12
"""Features below come from clipping: the candidate's number (4 bits), the reference face's (4), the incident face's
(3). From here on they are two edges' numbers."""

SLANT_OF_CORNER = 1.7321
"""√3 and a little: a box's corner may be so many times as far as the distance along the axis of any of its faces or edges (``Shapes.bluntness``)."""

NEVER = -1e30
"""Distance along an axis that counts as none."""


class Frame(NamedTuple):
    """Two boxes in the frame of the first."""

    r: Any
    """Nine lanes, row by row: entry (i, j) is the product of the first's axis i and the second's axis j."""
    d: Any
    """From the centre of the first to that of the second."""
    half_a: Any
    half_b: Any


class Choice(NamedTuple):
    """The axis of least depth."""

    on_b: Any
    """Whether the best face is one of the second box."""
    is_0: Any
    is_1: Any
    """Whether the best face is on its box's axis 0, or axis 1."""
    face: Any
    """Distance along the best face's normal."""
    by_edges: Any
    """Whether a pair of edges is better still."""
    edge: Any
    """3 i + j of the axes of the best pair of edges."""
    edges: Any
    """Distance along its normal."""
    faces: Any
    """Distance along the best face's normal of either box."""


def _best_face(distances: Any) -> Any:
    """The greatest of three, and whether it is the one on axis 0 or 1."""
    second = distances[1] > distances[0]
    best = select(second, distances[1], distances[0])
    third = distances[2] > best
    return select(third, distances[2], best), ~second & ~third, second & ~third


def _choose_axis(frame: Frame, d_b: Any, bias: Any, rows: Any) -> Choice:
    """The separating axis test. Distances are negative where the boxes overlap."""
    r, d, half_a, half_b = frame
    positive = tuple(absolute(entry) for entry in r)
    face_a, *first = _best_face(
        [absolute(d[i]) - half_a[i] - vec.dot(half_b, positive[3 * i : 3 * i + 3]) for i in range(3)]
    )
    face_b, *second = _best_face(
        [absolute(d_b[j]) - half_b[j] - vec.dot(half_a, vec.column(positive, j)) for j in range(3)]
    )
    on_b = face_b > face_a + (bias + RELATIVE_PREFERENCE * absolute(face_a))
    face = select(on_b, face_b, face_a)

    # Of pairs of edges the squares of the distances are compared, with their signs: one root and division in all.
    squared, best = full(face, 1), full(face, NEVER)
    value, edge = full(face, -float("inf")), full(rows, 0)
    for i in range(3):
        i1, i2 = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            j1, j2 = (j + 1) % 3, (j + 2) % 3
            reach_a = half_a[i1] * positive[3 * i2 + j] + half_a[i2] * positive[3 * i1 + j]
            reach_b = half_b[j1] * positive[3 * i + j2] + half_b[j2] * positive[3 * i + j1]
            along = absolute(d[i2] * r[3 * i1 + j] - d[i1] * r[3 * i2 + j]) - (reach_a + reach_b)
            sine = r[3 * i1 + j] * r[3 * i1 + j] + r[3 * i2 + j] * r[3 * i2 + j]
            signed = along * absolute(along)
            better = (signed * squared > value * sine) & (sine > PARALLEL_SQUARED)
            value, squared = select(better, signed, value), select(better, sine, squared)
            best, edge = select(better, along, best), select(better, full(rows, 3 * i + j), edge)
    edges = best / sqrt(squared)
    # Better than either box's best face: the second's may be better than the one that is preferred.
    best_face = maximum(face_a, face_b)
    by_edges = edges > best_face + (bias + RELATIVE_PREFERENCE * absolute(best_face))
    is_0, is_1 = ((on_b & b) | (~on_b & a) for a, b in zip(first, second, strict=True))
    return Choice(on_b, is_0, is_1, face, by_edges, edge, edges, (face_a, face_b))


def _room(frame: Frame, choice: Choice, limit: Any) -> Any:
    """By how much two boxes may at least come nearer before the separating axis test finds less than ``limit``: the first two of the bounds that
    ``pairs/polyhedra.py`` explains."""
    apart, extent_a, extent_b = vec.length(frame.d), vec.length(frame.half_a), vec.length(frame.half_b)
    best = maximum(choice.face, choice.edges) - SLANT_OF_CORNER * limit
    for face, own, other in ((choice.faces[0], extent_a, extent_b), (choice.faces[1], extent_b, extent_a)):
        room = face - limit
        best = maximum(best, room / maximum((apart + other + room) / own, 1))
    return best


@simd_kernel
def box_box(pairs, geometry, place, margin, contact, tags) -> bool:
    """Contacts of eight pairs of boxes."""
    rows = load(pairs, 0)
    rotation_a, rotation_b = gather(geometry, rows, 16)[0:9], gather(geometry, load(pairs, 1), 16)[0:9]
    d = vector(place)
    columns = [vec.mat_transpose_mul_vec(rotation_a, vec.column(rotation_b, j)) for j in range(3)]
    r = tuple(columns[j][i] for i in range(3) for j in range(3))
    frame = Frame(r, vec.mat_transpose_mul_vec(rotation_a, d), vector(place, FIRST), vector(place, SECOND))
    d_b = vec.mat_transpose_mul_vec(rotation_b, d)
    bias = FACE_PREFERENCE * margin
    choice = _choose_axis(frame, d_b, bias, rows)
    near = maximum(choice.face, choice.edges) < margin
    by_face = near & ~choice.by_edges
    by_edges = near & choice.by_edges

    def clip() -> None:
        _write_faces(frame, d_b, choice, by_face, bias, margin, (rotation_a, rotation_b, d), (pairs, contact, tags))

    def leave_empty() -> None:
        for field in range(24):
            store(contact, field, 0)
        for field in range(5):
            store(tags, field, 0)

    def cross() -> None:
        _write_edges(frame, choice, by_edges, rotation_a, (contact, tags))

    when(any_lane(by_face), clip)
    when(~any_lane(by_face), leave_empty)
    when(any_lane(by_edges), cross)
    store(contact, ROOM, _room(frame, choice, margin + bias))
    return any_lane(load(tags, 4) > 0)


def _write_faces(
    frame: Frame, d_b: Any, choice: Choice, lanes: Any, bias: Any, margin: Any, world: Any, arrays: Any
) -> None:
    """Contact along a face's normal, by clipping, in the lanes of a mask; nothing in the others."""
    rotation_a, rotation_b, d = world
    pairs, contact, tags = arrays
    rows = load(pairs, 0)
    on_b, is_0, is_1 = choice.on_b, choice.is_0, choice.is_1

    def turned(triple: Any) -> Any:
        return from_axis(is_0, is_1, triple)

    # The box with the reference face, from whose axis all axes are counted: s[0] is the row of the face's normal.
    transposed = tuple(frame.r[3 * j + i] for i in range(3) for j in range(3))
    s = vec.select_vec(on_b, transposed, frame.r)
    s = list(zip(*(turned(vec.column(s, j)) for j in range(3)), strict=True))
    half = turned(vec.select_vec(on_b, frame.half_b, frame.half_a))
    other = vec.select_vec(on_b, frame.half_a, frame.half_b)
    center = turned(vec.select_vec(on_b, vec.neg(d_b), frame.d))
    up = sign(center[0])
    s[0] = vec.scale(s[0], up)

    # The incident face, from whose axis the other box's axes are counted.
    steep = [absolute(x) for x in s[0]]
    at_0 = (steep[0] + STEADY >= steep[1]) & (steep[0] + STEADY >= steep[2])
    at_1 = steep[1] + STEADY >= steep[2]
    s = [from_axis(at_0, at_1, row) for row in s]
    other = from_axis(at_0, at_1, other)
    down = -sign(s[0][0])
    middle = [absolute(center[0]) + down * other[0] * s[0][0]] + [center[k] + down * other[0] * s[k][0] for k in (1, 2)]
    edges = [[other[j] * s[k][j] for k in range(3)] for j in (1, 2)]
    number = full(rows, 0)
    for mask, value in ((up < 0, 1), (on_b, 8), (down < 0, 16)):
        number = number + select(mask, full(rows, value), 0)
    number = 16 * (number + select(is_0, full(rows, 0), select(is_1, full(rows, 2), 4)))
    number = number + select(at_0, full(rows, 0), select(at_1, full(rows, 512), 1024))

    kept = keep_four(_candidates(half, middle, edges, bias), margin, bias, rows)

    axes = [
        turned(vec.select_vec(on_b, rotation_b[3 * k : 3 * k + 3], rotation_a[3 * k : 3 * k + 3])) for k in range(3)
    ]
    n, u, v = ([column[k] for column in axes] for k in range(3))
    n = vec.scale(n, up)
    zero = full(up, 0)
    origin = vec.select_vec(on_b, d, (zero, zero, zero))
    points = []
    for used, x, y, depth, candidate in kept:
        point = vec.add_scaled(vec.add_scaled(vec.scale(n, half[0] - 0.5 * depth), u, x), v, y)
        points.append((used & lanes, vec.add(point, origin), depth, number + candidate))
    write_contact(pairs, contact, tags, vec.select_vec(on_b, vec.neg(n), n), points, 0)


def _candidates(half: Any, middle: Any, edges: Any, slack: Any) -> list[Point]:
    """The corners of the parallelogram ``middle + α edges[0] + β edges[1]``, α and β from −1 to 1, cut to the rectangle
    of half sizes ``half`` widened by ``slack``. Coordinate 0 is the height above the centre of the reference box."""
    x_limit, y_limit = half[1] + slack, half[2] + slack
    depth = half[0] - middle[0]
    points = []
    for j in range(2):
        along, across = edges[j], edges[1 - j]
        for side in (-1, 1):
            x, y, z = middle[1] + side * across[1], middle[2] + side * across[2], depth - side * across[0]
            low_x, high_x = within(x, along[1], x_limit)
            low_y, high_y = within(y, along[2], y_limit)
            low, high = maximum(maximum(low_x, low_y), -1), minimum(minimum(high_x, high_y), 1)
            # Round the parallelogram each edge gives its first end, and its last only if that is cut off.
            ends = (low, low <= high), (high, (low < high) & (high < 1))
            if (side > 0) == (j == 0):
                ends = (high, low <= high), (low, (low < high) & (low > -1))
            points += [Point(valid, x + t * along[1], y + t * along[2], z - t * along[0]) for t, valid in ends]
    (e_z, e_x, e_y), (f_z, f_x, f_y) = edges
    area = e_x * f_y - e_y * f_x
    e_fall, f_fall = e_z / area, f_z / area
    area = absolute(area)
    for side_x, side_y in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
        x, y = side_x * x_limit, side_y * y_limit
        right, ahead = x - middle[1], y - middle[2]
        alpha, beta = right * f_y - ahead * f_x, e_x * ahead - e_y * right
        valid = (absolute(alpha) < area) & (absolute(beta) < area)
        points.append(Point(valid, x, y, depth - alpha * e_fall - beta * f_fall))
    return points


def _write_edges(frame: Frame, choice: Choice, lanes: Any, rotation_a: Any, arrays: Any) -> None:
    """Contact where two edges cross, in the lanes of a mask; what is there already in the others."""
    contact, tags = arrays
    edge = choice.edge
    i_0, i_1 = edge < 3, edge < 6
    j = edge - select(i_0, full(edge, 0), select(i_1, full(edge, 3), 6))
    j_0, j_1 = j == 0, j == 1

    def turned(triple: Any) -> Any:
        return from_axis(i_0, i_1, triple)

    # Axes counted from those of the edges: b[k] is an axis of the second box, b[0] along its edge.
    rows = [from_axis(j_0, j_1, frame.r[3 * k : 3 * k + 3]) for k in range(3)]
    b = [turned([row[k] for row in rows]) for k in range(3)]
    d, half_a, half_b = turned(frame.d), turned(frame.half_a), from_axis(j_0, j_1, frame.half_b)
    _, b_y, b_z = b[0]
    squared = b_y * b_y + b_z * b_z
    n_y, n_z = -b_z / sqrt(squared), b_y / sqrt(squared)
    out = sign(n_y * d[1] + n_z * d[2])
    n_y, n_z = out * n_y, out * n_z

    # Each box's edge lies farthest along the normal; the nearest points of their two lines lie on them.
    a_sides = [sign(n_y), sign(n_z)]
    b_sides = [-sign(n_y * axis[1] + n_z * axis[2]) for axis in b[1:]]
    p_y, p_z = a_sides[0] * half_a[1], a_sides[1] * half_a[2]
    q = vec.add_scaled(vec.add_scaled(d, b[1], b_sides[0] * half_b[1]), b[2], b_sides[1] * half_b[2])
    beta = -((q[1] - p_y) * b_y + (q[2] - p_z) * b_z) / squared
    alpha = clamp(q[0] + beta * b[0][0], half_a[0])
    q = vec.add_scaled(q, b[0], clamp(beta, half_b[0]))
    middle = 0.5 * (alpha + q[0]), 0.5 * (p_y + q[1]), 0.5 * (p_z + q[2])

    axes = [turned(rotation_a[3 * k : 3 * k + 3]) for k in range(3)]
    normal = [axis[1] * n_y + axis[2] * n_z for axis in axes]
    values = [*normal, full(squared, 0), *(vec.dot(axis, middle) for axis in axes), -choice.edges]
    for field in range(20):
        value = values[field] if field < len(values) else full(squared, 0)
        store(contact, field, select(lanes, value, load(contact, field)))
    feature = 16 * edge + FIRST_EDGE_FEATURE
    for side, value in zip((*a_sides, *b_sides), (1, 2, 4, 8), strict=True):
        feature = feature + select(side < 0, full(edge, value), 0)
    for field, value in enumerate((feature, 0, 0, 0, full(edge, 1))):
        store(tags, field, select(lanes, value, load(tags, field)))
