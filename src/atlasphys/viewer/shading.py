"""What is done to the pixels of a picture: shadows by a map of depths seen from the sun, and smooth edges.

Without a graphics card both take a fraction of what they take as shaders of VTK. Arrays have a row for each line of pixels, from the bottom up.

Sources: L. Williams, Casting Curved Shadows on Curved Surfaces, SIGGRAPH 1978; W. Reeves et al., Rendering Antialiased Shadows with Depth
Maps, SIGGRAPH 1987; T. Lottes, FXAA, NVIDIA 2009.
"""

from __future__ import annotations

import math
from typing import Any

from atlasphys.engine.jit import inlined, kernel

BIAS = 1.0
"""How far a point must be below what the sun sees, to be in shadow, beside what its slope adds [texels]."""

STEEPEST = 6.0
"""Most that a slope adds to it, as a tangent."""

LEAST_CONTRAST = 14.0
"""Difference of brightness, of 255, from which on an edge is smoothed."""

LONGEST_WALK = 10
"""How far the ends of an edge are looked for [pixels]."""


@inlined
def _place(column: int, row: int, depth: Any, m: Any) -> tuple[float, float, float]:
    """Where a pixel's surface is: along the sun's map in texels, and towards the sun in texels."""
    z = depth[row, column]
    w = m[3, 0] * column + m[3, 1] * row + m[3, 2] * z + m[3, 3]
    u = m[0, 0] * column + m[0, 1] * row + m[0, 2] * z + m[0, 3]
    v = m[1, 0] * column + m[1, 1] * row + m[1, 2] * z + m[1, 3]
    d = m[2, 0] * column + m[2, 1] * row + m[2, 2] * z + m[2, 3]
    return u / w, v / w, d / w


@inlined
def _light(u: float, v: float, d: float, bias: float, sun: Any, top: float, range_: float) -> float:
    """Share of the four texels about a point that see it, weighted by nearness."""
    rows, columns = sun.shape
    i, j = int(math.floor(v)), int(math.floor(u))  # noqa: RUF046 (floats, to Numba)
    if i < 0 or j < 0 or i + 1 >= rows or j + 1 >= columns:
        return 1.0
    a, b = v - i, u - j
    limit = min((top - d - bias) / range_, 1.0)  # in the map's own numbers, in which 1 is nothing at all
    light = 0.0
    if sun[i, j] >= limit:
        light += (1.0 - a) * (1.0 - b)
    if sun[i, j + 1] >= limit:
        light += (1.0 - a) * b
    if sun[i + 1, j] >= limit:
        light += a * (1.0 - b)
    if sun[i + 1, j + 1] >= limit:
        light += a * b
    return light


@inlined
def _slopes(column: int, row: int, depth: Any, m: Any) -> float:
    """Cosine between a surface's normal, towards the eye, and the direction to the sun."""
    rows, columns = depth.shape
    left, right, down, up = max(column - 1, 0), min(column + 1, columns - 1), max(row - 1, 0), min(row + 1, rows - 1)
    here = depth[row, column]
    # Of the two neighbours the one that is as deep: the other may be on another surface.
    if (abs(depth[row, left] - here) < abs(depth[row, right] - here) and left < column) or right == column:
        right = column
    else:
        left = column
    if (abs(depth[down, column] - here) < abs(depth[up, column] - here) and down < row) or up == row:
        up = row
    else:
        down = row
    u0, v0, d0 = _place(left, row, depth, m)
    u1, v1, d1 = _place(right, row, depth, m)
    u2, v2, d2 = _place(column, down, depth, m)
    u3, v3, d3 = _place(column, up, depth, m)
    au, av, ad, bu, bv, bd = u1 - u0, v1 - v0, d1 - d0, u3 - u2, v3 - v2, d3 - d2
    nu, nv, nd = av * bd - ad * bv, ad * bu - au * bd, au * bv - av * bu
    return nd / math.sqrt(nu * nu + nv * nv + nd * nd + 1e-300)


@kernel
def cast_shadows(picture: Any, depth: Any, place: Any, sun: Any, top: float, range_: float, darkness: float) -> None:
    """Darken what the sun does not see.

    Args:
        picture: (h, w, 3) 0 to 255, changed.
        depth: (h, w) depth buffer, 1 where there is nothing.
        place: (4, 4) from (column, row, depth, 1) to homogeneous texels: along the sun's map, and height towards the sun.
        sun: (k, l) depth buffer as seen from the sun.
        top: height at which it is 0 [texels].
        range_: how far below it is 1 [texels].
        darkness: share of brightness that a surface loses that faces the sun.
    """
    rows, columns = depth.shape
    for row in range(rows):
        for column in range(columns):
            if depth[row, column] >= 1.0:
                continue
            u, v, d = _place(column, row, depth, place)
            if _light(u, v, d, BIAS, sun, top, range_) >= 1.0:
                continue
            cosine = _slopes(column, row, depth, place)
            if cosine <= 0.0:
                continue  # averted: it has no sunlight to lose
            slope = min(math.sqrt(max(1.0 - cosine * cosine, 0.0)) / cosine, STEEPEST)
            light = _light(u, v, d, BIAS + slope, sun, top, range_)
            factor = 1.0 - darkness * cosine * (1.0 - light)
            for channel in range(3):
                picture[row, column, channel] = int(factor * picture[row, column, channel] + 0.5)


@kernel
def measure_brightness(picture: Any, brightness: Any) -> None:
    """Write the (h, w) brightness of a picture's (h, w, 3) pixels."""
    rows, columns = brightness.shape
    for row in range(rows):
        for column in range(columns):
            red, green, blue = picture[row, column, 0], picture[row, column, 1], picture[row, column, 2]
            brightness[row, column] = 0.299 * red + 0.587 * green + 0.114 * blue


@inlined
def _walk(
    row: int, column: int, i: int, j: int, across_i: int, across_j: int, edge: float, least: float, light: Any
) -> Any:
    """How far an edge goes on in direction (i, j), and by how much brightness differs from the edge's where it ends."""
    rows, columns = light.shape
    difference = 0.0
    length = 0
    while length < LONGEST_WALK:
        row, column, length = row + i, column + j, length + 1
        if row < 1 or column < 1 or row >= rows - 1 or column >= columns - 1:
            break
        difference = 0.5 * (light[row, column] + light[row + across_i, column + across_j]) - edge
        if abs(difference) >= least:
            break
    return length, difference


@kernel
def smooth_edges(picture: Any, light: Any, smoothed: Any) -> None:
    """Write (h, w, 3) pixels, those of stairs at edges mixed with what is beyond by how near the stair's end is. ``light``: (h, w) brightness."""
    rows, columns = light.shape
    for row in range(rows):
        for column in range(columns):
            for channel in range(3):
                smoothed[row, column, channel] = picture[row, column, channel]
    for row in range(1, rows - 1):
        for column in range(1, columns - 1):
            here = light[row, column]
            north, south = light[row + 1, column], light[row - 1, column]
            east, west = light[row, column + 1], light[row, column - 1]
            least = min(here, min(min(north, south), min(east, west)))
            most = max(here, max(max(north, south), max(east, west)))
            if most - least < max(LEAST_CONTRAST, 0.125 * most):
                continue
            northeast, northwest = light[row + 1, column + 1], light[row + 1, column - 1]
            southeast, southwest = light[row - 1, column + 1], light[row - 1, column - 1]
            level = (
                abs(northwest + southwest - 2 * west)
                + 2 * abs(north + south - 2 * here)
                + abs(northeast + southeast - 2 * east)
            )
            upright = (
                abs(northwest + northeast - 2 * north)
                + 2 * abs(west + east - 2 * here)
                + abs(southwest + southeast - 2 * south)
            )
            across_i, across_j = 0, 0
            if level >= upright:
                across_i = 1 if abs(north - here) >= abs(south - here) else -1
            else:
                across_j = 1 if abs(east - here) >= abs(west - here) else -1
            beyond = light[row + across_i, column + across_j]
            edge, steepness = 0.5 * (here + beyond), 0.25 * abs(beyond - here)
            i, j = abs(across_j), abs(across_i)
            before, first = _walk(row, column, -i, -j, across_i, across_j, edge, steepness, light)
            after, last = _walk(row, column, i, j, across_i, across_j, edge, steepness, light)
            nearest, end = (before, first) if before < after else (after, last)
            if (end < 0.0) == (here < edge):
                continue  # the stair's other half
            share = 0.5 - nearest / (before + after)
            for channel in range(3):
                near, far = picture[row, column, channel], picture[row + across_i, column + across_j, channel]
                smoothed[row, column, channel] = int(near + share * (float(far) - float(near)) + 0.5)
