"""Figures as SVG, for notebooks: seen from a little above, from far away."""

from __future__ import annotations

import math
from collections.abc import Callable
from html import escape

import numpy as np
from scipy.spatial import ConvexHull

from atlasphys.explainer.events import Points
from atlasphys.explainer.slides.figure import A, Arrows, B, Colour, Dots, Label, Lines, Mark, Marks, Solid
from atlasphys.explainer.slides.slide import Slide
from atlasphys.explainer.slides.solids import Floats, Pair

WIDTH, HEIGHT, MARGIN = 330.0, 260.0, 26.0
"""Of each of the two pictures [pixels]."""

DOT = 4.0
"""Radius of a corner of the simplex [pixels]."""

FROM_ABOVE = (0.42, 0.36, 0.83)
FROM_THE_FRONT = (0.0, 0.0, 1.0)
"""Directions towards the eye."""


def figure(pair: Pair, slide: Slide) -> str:
    """The figure of a slide: the shapes, and beside them what the algorithm looks at."""
    shapes = [*bodies(pair, slide.opacity), *slide.shapes]
    eye = FROM_THE_FRONT if pair.is_flat else FROM_ABOVE
    pictures = [picture(tuple(shapes), eye, "the two shapes")]
    if slide.beside:
        pictures.append(picture(slide.beside, FROM_THE_FRONT if slide.faces_viewer else eye, slide.caption))
    return f'<div style="display:flex;flex-wrap:wrap;gap:10px">{"".join(pictures)}</div>'


def bodies(pair: Pair, opacity: float) -> Marks:
    """The two shapes."""
    return tuple(Solid(hull, colour, opacity) for hull, colour in zip(pair.bodies, (A, B), strict=True))


def picture(marks: Marks, eye: tuple[float, float, float], caption: str) -> str:
    """One picture, with its caption."""
    back = np.array(eye) / math.hypot(*eye)
    right = np.cross((0.0, 1.0, 0.0), back)
    right /= np.linalg.norm(right)
    axes = np.array([right, np.cross(back, right), back])
    everything = np.concatenate([_points(mark) for mark in marks]) @ axes.T
    low, high = everything[:, :2].min(axis=0), everything[:, :2].max(axis=0)
    scale = min((WIDTH - 2 * MARGIN) / max(high[0] - low[0], 1e-9), (HEIGHT - 2 * MARGIN) / max(high[1] - low[1], 1e-9))
    middle = (low + high) / 2

    def screen(points: Points) -> Floats:
        turned = points.reshape(-1, 3).astype(np.float64) @ axes.T
        x, y = WIDTH / 2 + scale * (turned[:, 0] - middle[0]), HEIGHT / 2 - scale * (turned[:, 1] - middle[1])
        return np.stack([x, y, turned[:, 2]], axis=1)

    layers = sorted(marks, key=lambda mark: (Solid, Lines, Arrows, Dots, Label).index(type(mark)))
    drawn = "".join(_drawn(mark, screen) for mark in layers)
    return (
        f'<figure style="margin:0"><svg viewBox="0 0 {WIDTH:g} {HEIGHT:g}" width="{WIDTH:g}" height="{HEIGHT:g}" role="img" '
        f'aria-label="{escape(caption)}" style="background:#fff;border:1px solid #d8dde3;border-radius:4px">{drawn}</svg>'
        f'<figcaption style="font-size:0.8em;color:#69727d">{escape(caption)}</figcaption></figure>'
    )


def _points(mark: Mark) -> Floats:
    match mark:
        case Solid(hull=hull):
            return hull.vertices
        case Label(at=at):
            return np.asarray(at, np.float64).reshape(1, 3)
    return np.asarray(mark.points, np.float64).reshape(-1, 3)


def _drawn(mark: Mark, screen: Callable[[Points], Floats]) -> str:
    match mark:
        case Solid():
            return _solid(mark, screen)
        case Lines():
            ends = screen(mark.points)
            return _path(ends, mark.colour, 0.7 * mark.width)
        case Arrows():
            ends = screen(mark.points)
            return _path(ends, mark.colour, 1.8) + "".join(
                _head(tail, tip, mark.colour) for tail, tip in zip(ends[::2], ends[1::2], strict=True)
            )
        case Dots():
            radius = DOT * mark.size
            return "".join(
                f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:.1f}" fill="rgb{mark.colour}"/>'
                for x, y, _ in screen(mark.points)
            )
        case Label():
            x, y, _ = screen(np.asarray(mark.at, np.float64))[0]
            aside = (
                f'x="{x - 6:.1f}" y="{y + 16:.1f}" text-anchor="end"'
                if mark.below
                else f'x="{x + 6:.1f}" y="{y - 6:.1f}"'
            )
            return (
                f'<text {aside} font-family="sans-serif" font-size="12" fill="rgb{mark.colour}" '
                f'stroke="#fff" stroke-width="3" paint-order="stroke">{escape(mark.text)}</text>'
            )


def _solid(mark: Solid, screen: Callable[[Points], Floats]) -> str:
    hull = mark.hull
    corners = screen(hull.vertices)
    if hull.is_smooth and len(hull.faces):
        around = corners[ConvexHull(corners[:, :2]).vertices]
        path = "L".join(_at(corner) for corner in around)
        return (
            f'<path d="M{path}z" fill="rgb{mark.colour}" fill-opacity="{mark.opacity:g}" stroke="rgb{mark.colour}" '
            'stroke-width="1.1"/>'
        )
    parts = []
    if len(hull.faces):
        triangles = corners[hull.faces]
        (ax, ay), (bx, by) = (triangles[:, k, :2].T - triangles[:, 0, :2].T for k in (1, 2))
        front = ax * by - ay * bx < 0  # y points downwards
        path = "".join(f"M{_at(t[0])}L{_at(t[1])}L{_at(t[2])}z" for t in triangles[front])
        parts.append(f'<path d="{path}" fill="rgb{mark.colour}" fill-opacity="{mark.opacity:g}" stroke="none"/>')
    if mark.outlined and len(hull.edges):
        parts.append(_path(corners[hull.edges].reshape(-1, 3), mark.colour, 1.1))
    return "".join(parts)


def _path(ends: Floats, colour: Colour, width: float) -> str:
    path = "".join(f"M{_at(start)}L{_at(end)}" for start, end in zip(ends[::2], ends[1::2], strict=True))
    return f'<path d="{path}" fill="none" stroke="rgb{colour}" stroke-width="{width:.1f}" stroke-linecap="round"/>'


def _head(tail: Floats, tip: Floats, colour: Colour) -> str:
    along = tip[:2] - tail[:2]
    size = float(np.linalg.norm(along))
    if size < 1e-6:
        return ""
    along = along / size * 9
    across = np.array((-along[1], along[0])) * 0.4
    corners = (tip[:2], tip[:2] - along + across, tip[:2] - along - across)
    return f'<path d="M{"L".join(_at(corner) for corner in corners)}z" fill="rgb{colour}"/>'


def _at(point: Floats) -> str:
    return f"{point[0]:.1f} {point[1]:.1f}"
