"""Figures of the chapter on collision, from stories of the engine's own runs."""

from collections.abc import Iterator, Sequence
from itertools import combinations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from scipy.spatial import ConvexHull

import atlasphys as ap


def _turn(body: ap.Body) -> np.ndarray:
    """The rotation matrix of a body."""
    w, x, y, z = np.asarray(body.orientation, float)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def _corners(body: ap.Body) -> np.ndarray:
    """Corners of a polyhedron in world axes."""
    return np.asarray(body.shape.polyhedron.vertices) @ _turn(body).T + body.position


def _pair(offset: Sequence[float], orientation: Sequence[float]) -> tuple[ap.Body, ap.Body, ap.Story]:
    """Two boxes in double precision, the story of a step of no length to speak of, and the world as it was before."""
    world = ap.World(gravity=(0, 0, 0), precision="double", preset="classic")
    a = world.add(ap.Box(size=(1, 1, 1)), name="A")
    b = world.add(ap.Box(size=(0.9, 0.6, 0.8)), position=offset, orientation=orientation, name="B")
    start = world.snapshot()
    with ap.explain(world, pair=(a, b)) as story:
        world.step(1e-6)
    world.restore(start)
    return a, b, story


FLAT = (np.cos(0.35), 0, 0, np.sin(0.35))
"""40° about z: seen along z, boxes so turned are rectangles."""
TILTED = (0.92, 0.2, 0.3, 0.1)


def _rectangle(axes: Axes, points: np.ndarray, **style: object) -> None:
    """The outline of points, seen along z."""
    flat = points[:, :2]
    axes.fill(*flat[ConvexHull(flat).vertices].T, **style)


def minkowski() -> Figure:
    """Two boxes beside their Minkowski difference, seen along z: apart and overlapping."""
    figure, panels = plt.subplots(2, 2, figsize=(7, 6), layout="constrained")
    for row, offset in zip(panels, ((1.15, 0.75, 0), (0.7, 0.4, 0)), strict=True):
        a, b, story = _pair(offset, FLAT)
        _rectangle(row[0], _corners(a), facecolor="C0", alpha=0.4, edgecolor="C0")
        _rectangle(row[0], _corners(b), facecolor="C1", alpha=0.4, edgecolor="C1")
        row[0].annotate("A", a.position[:2], ha="center")
        row[0].annotate("B", b.position[:2], ha="center")
        difference = (_corners(a)[:, None] - _corners(b)[None]).reshape(-1, 3)
        _rectangle(row[1], difference, facecolor="C2", alpha=0.25, edgecolor="C2")
        row[1].plot(0, 0, "k*", markersize=10)
        row[1].annotate("A ⊖ B", difference.mean(axis=0)[:2], ha="center", color="C2")
        if story.gjk.verdict == "separated":
            end, kind = story.gjk.on_a - story.gjk.on_b, "distance"
            size, ends = story.gjk.distance, (story.gjk.on_a, story.gjk.on_b)
        else:
            end, kind = story.epa.normal * story.epa.depth, "depth"
            size, ends = story.epa.depth, (story.epa.on_a, story.epa.on_b)
        row[0].plot(*np.array(ends)[:, :2].T, "k.-")
        row[1].plot([0, end[0]], [0, end[1]], "k.-")
        row[0].set_title(f"{story.gjk.verdict}, {kind} {size:.3f} m")
        row[1].set_title("outside: apart" if kind == "distance" else "inside: overlap")
        for axes in row:
            axes.set_aspect("equal")
    return figure


VIEW = np.array([[-0.62, 0.78, 0.0], [-0.3, -0.24, 0.92]])
"""From space to the page: seen from the front, a little from the side and from above."""


def _edges(points: np.ndarray) -> Iterator[np.ndarray]:
    """Edges of the hull of points: where triangles of two planes meet."""
    hull = ConvexHull(points)
    for i, around in enumerate(hull.neighbors):
        for opposite, j in enumerate(around):
            if i < j and not np.allclose(hull.equations[i], hull.equations[j], atol=1e-6):
                yield points[np.delete(hull.simplices[i], opposite)]


def gjk() -> Figure:
    """The simplex after each step of GJK: for boxes that are apart, above, and that overlap, below."""
    figure, panels = plt.subplots(2, 6, figsize=(8, 3.2), layout="constrained")
    for row, offset in zip(panels, ((0.6, 1.0, 0.2), (-0.3, 0.45, 0.3)), strict=True):
        a, b, story = _pair(offset, TILTED)
        difference = (_corners(a)[:, None] - _corners(b)[None]).reshape(-1, 3)
        origin = np.zeros(3)
        for axes in row:
            axes.set_aspect("equal")
            axes.set_axis_off()
        for k, (axes, step) in enumerate(zip(row, story.gjk.steps, strict=False)):
            for edge in _edges(difference):
                axes.plot(*(VIEW @ edge.T), color="C2", linewidth=0.5, alpha=0.5)
            axes.plot(0, 0, "k*", markersize=8, zorder=5)
            way = VIEW @ (origin + 0.7 * step.direction / np.linalg.norm(step.direction))
            axes.annotate("", way, VIEW @ origin, arrowprops={"arrowstyle": "->", "color": "C3"}, zorder=6)
            simplex = VIEW @ step.simplex.T
            for i in range(len(step.simplex)):
                for j in range(i):
                    axes.plot(*simplex[:, [i, j]], color="C1", linewidth=1.5)
            for face in combinations(range(len(step.simplex)), 3):
                axes.fill(*simplex[:, face], color="C1", alpha=0.15)
            axes.plot(*simplex, "o", color="C1", markersize=4)
            axes.plot(*(VIEW @ step.point), "o", color="C3", fillstyle="none", markersize=8)
            if step.closest is not None:
                origin = step.closest
                axes.plot(*(VIEW @ origin), "k.", markersize=6)
            names = ("", "point", "line", "triangle", "tetrahedron")
            axes.set_title(f"{k + 1}. {names[len(step.simplex)]}, {step.distance:.2f} m", fontsize=8)
    return figure


def epa() -> Figure:
    """The polytope of EPA on two tilted boxes, and how the bounds of the depth close in."""
    _, _, story = _pair((0.45, 0.35, 0.2), TILTED)
    steps = [step for step in story.epa.steps if step.outcome != "wall"]
    figure = plt.figure(figsize=(8, 2.9), layout="constrained")
    every = np.concatenate([steps[-1].polytope.vertices, [step.point for step in steps]])
    low, high = every.min(axis=0), every.max(axis=0)
    for panel, k in enumerate(sorted({0, len(steps) // 2, len(steps) - 1})):
        step = steps[k]
        axes = figure.add_subplot(1, 4, panel + 1, projection="3d", computed_zorder=False)
        faces = step.polytope.vertices[step.polytope.faces]
        asked = np.arange(len(faces)) == step.face
        axes.add_collection3d(
            Poly3DCollection(faces[~asked], facecolor="C0", alpha=0.12, edgecolor="C0", linewidth=0.5)
        )
        axes.add_collection3d(Poly3DCollection(faces[asked], facecolor="C3", alpha=0.6, zorder=3))
        axes.plot(0, 0, 0, "k*", zorder=9)
        axes.plot(*step.point, "o", color="C3", markersize=5, zorder=7)
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
        axes.set_box_aspect(high - low, zoom=1.3)
        axes.view_init(elev=22, azim=35)
        axes.set_axis_off()
        axes.set_title(f"step {k + 1}: {len(faces)} faces", fontsize=8)
    bounds = figure.add_subplot(1, 4, 4)
    count = np.arange(1, len(story.epa.steps) + 1)
    bounds.step(count, [step.best for step in story.epa.steps], where="mid", color="C3", label="least h(n)")
    bounds.step(count, [step.lower for step in story.epa.steps], where="mid", color="C0", label="nearest face δ")
    bounds.set(xlabel="step", title="depth [m]", ylim=(0, None))
    bounds.legend(fontsize=7)
    return figure


def sat() -> Figure:
    """What two boxes cover of each axis that the separating axis test tries."""
    world = ap.World(gravity=(0, 0, 0), precision="double", narrowphase="sat")
    a = world.add(ap.Box(size=(1, 1, 1)), name="A")
    b = world.add(ap.Box(size=(0.9, 0.6, 0.8)), position=(0.55, 0.45, 0.3), orientation=TILTED, name="B")
    with ap.explain(world, pair=(a, b)) as story:
        world.step(1e-6)
    figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
    names = []
    # The axes that faces and edges gave, and the shapes' whole shadows on them: corners are all it takes.
    for k, axis in enumerate(story.sat.axes):
        for body, colour, shift in ((a, "C0", -0.15), (b, "C1", 0.15)):
            shadow = _corners(body) @ axis.axis
            axes.plot([shadow.min(), shadow.max()], [k + shift] * 2, color=colour, linewidth=4, solid_capstyle="butt")
        overlap = axis.a_to - axis.b_from
        best = axis.axis @ story.sat.normal > 1 - 1e-9
        axes.barh(k, overlap, left=axis.b_from, height=0.8, color="C3" if best else "0.6", alpha=0.3)
        axes.annotate(f"{overlap:.3f} m", (1.35, k), va="center", fontsize=7, color="C3" if best else "0.2")
        part = {"face of a": f"face {axis.a + 1} of A", "face of b": f"face {axis.b + 1} of B"}
        names.append(part.get(axis.of, f"edge {axis.a + 1} of A × {axis.b + 1} of B"))
    axes.set(yticks=range(len(names)), yticklabels=names, xlabel="along the axis [m]", xlim=(-0.9, 1.6))
    axes.set_ylim(-0.5, len(names) - 0.5)
    axes.invert_yaxis()
    axes.tick_params(axis="y", labelsize=7)
    return figure


def clipping() -> Figure:
    """The incident face of a box on another, cut by one side plane after the other, seen along the normal."""
    world = ap.World(gravity=(0, 0, 0), precision="double", preset="classic")
    below = world.add(ap.Box(size=(1, 1, 1)), name="A")
    turned = (np.cos(0.3), -0.01, np.sin(0.3), -0.004)
    above = world.add(ap.Box(size=(1, 0.6, 1)), position=(0.35, 0.8, 0.25), orientation=turned, name="B")
    with ap.explain(world, pair=(below, above)) as story:
        world.step(1e-6)
    clip = story.clip
    reference, incident = (
        (clip.feature_a, clip.feature_b) if clip.reference == "a" else (clip.feature_b, clip.feature_a)
    )

    def closed(points: np.ndarray) -> np.ndarray:
        """Seen from above: x and z, back to the first point."""
        return np.concatenate([points, points[:1]])[:, [0, 2]].T

    figure, panels = plt.subplots(
        1, len(clip.cuts) + 1, figsize=(9, 2.3), layout="constrained", sharex=True, sharey=True
    )
    for axes in panels:
        axes.fill(*closed(reference), facecolor="C0", alpha=0.2, edgecolor="C0")
        axes.plot(*closed(incident), ":", color="0.6", linewidth=1)
        axes.set(aspect="equal", xticks=(), yticks=())
    for k, (axes, cut) in enumerate(zip(panels, clip.cuts, strict=False)):
        axes.fill(*closed(cut.after), facecolor="C1", alpha=0.4, edgecolor="C1")
        tangent = np.cross(cut.outward, clip.reference_normal)
        line = np.array([cut.corner - 2 * tangent, cut.corner + 2 * tangent])
        axes.plot(*line[:, [0, 2]].T, color="C3", linewidth=1)
        axes.set_title(f"cut {k + 1}: {len(cut.before)} → {len(cut.after)} corners", fontsize=8)
    panels[-1].fill(*closed(clip.clipped), facecolor="C1", alpha=0.25)
    for point, depth, kept in zip(clip.clipped, clip.depths, clip.kept, strict=True):
        panels[-1].plot(*point[[0, 2]], "o" if kept else "x", color="C3" if kept else "0.3", markersize=5)
        panels[-1].annotate(f"{1e3 * depth:.0f}", point[[0, 2]], fontsize=7, xytext=(4, 3), textcoords="offset points")
    panels[-1].set_title("depths [mm]", fontsize=8)
    panels[0].set(xlim=(-0.75, 1.15), ylim=(-0.75, 1.15))
    return figure
