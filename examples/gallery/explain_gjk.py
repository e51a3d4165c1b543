r"""
GJK, step by step
=================

Do two boxes overlap, and if not, how far apart are they? GJK answers with a walk through their *Minkowski
difference* :math:`A \ominus B`, the set of all :math:`a - b`: the boxes meet exactly where it holds the
origin. ``ap.explain`` tells what the engine's own code did on the way.
"""

import matplotlib.pyplot as plt
import numpy as np
from drawing import core, matrix
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from scipy.spatial import ConvexHull

import atlasphys as ap


def explained(offset):
    """Two boxes and the story of a step, without gravity."""
    world = ap.World(gravity=(0, 0, 0))
    a = world.add(ap.Box(size=(1, 1, 1)), name="a")
    b = world.add(ap.Box(size=(0.6, 0.8, 1)), position=offset, orientation=(0.92, 0.2, 0.3, 0.1), name="b")
    with ap.explain(world, pair=(a, b)) as story:
        world.step(1e-6)
    return a, b, story


a, b, story = explained((1.0, 0.9, 0.3))
print(story.gjk)

# %%
# Behind the words are arrays: ``story.gjk.steps[2].simplex`` holds the points that the search kept. Nobody
# ever builds the Minkowski difference; here it is, for the eye: the hull of all differences of two corners.


def corners(body):
    """(8, 3) corners of a box in world axes."""
    points, _ = core(body.shape)
    return points @ matrix(body.orientation).T + body.position


def difference(a, b):
    """The hull of a − b."""
    points = (corners(a)[:, None] - corners(b)[None]).reshape(-1, 3)
    return ConvexHull(points)


def edges(hull):
    """The edges of a hull: where triangles of two planes meet."""
    for i, around in enumerate(hull.neighbors):
        for opposite, j in enumerate(around):
            if i < j and not np.allclose(hull.equations[i], hull.equations[j], atol=1e-6):
                yield hull.points[np.delete(hull.simplices[i], opposite)]


def draw_steps(title, a, b, steps, view):
    """A panel for each step: the difference, the simplex, the direction of the search and the point that it found."""
    hull = difference(a, b)
    columns = min(len(steps), 3)
    rows = -(-len(steps) // columns)
    figure = plt.figure(figsize=(3.3 * columns, 3.2 * rows), layout="constrained")
    for k, step in enumerate(steps):
        axes = figure.add_subplot(rows, columns, k + 1, projection="3d", computed_zorder=False)
        axes.add_collection3d(Poly3DCollection(hull.points[hull.simplices], facecolor="C0", alpha=0.06))
        for edge in edges(hull):
            axes.plot(*edge.T, color="C0", linewidth=0.6, alpha=0.5)
        axes.plot(0, 0, 0, "k*", markersize=9, zorder=9)
        for i in range(len(step.simplex)):
            for j in range(i):
                axes.plot(*step.simplex[[i, j]].T, color="C1", linewidth=2, zorder=5)
        if len(step.simplex) >= 3:
            axes.add_collection3d(Poly3DCollection([step.simplex[:3]], facecolor="C1", alpha=0.3, zorder=4))
        axes.plot(*step.simplex.T, "o", color="C1", markersize=5, zorder=6)
        axes.plot(*step.point, "o", color="C3", markersize=8, fillstyle="none", zorder=7)
        if step.closest is not None:
            axes.plot(*np.array([np.zeros(3), step.closest]).T, ":", color="k", zorder=8)
        low, high = hull.min_bound, hull.max_bound
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
        axes.set_box_aspect(high - low, zoom=1.2)
        axes.view_init(*view)
        axes.set_axis_off()
        names = {1: "point", 2: "line", 3: "triangle", 4: "tetrahedron"}
        axes.set_title(f"{k + 1}: {names[len(step.simplex)]}, {step.distance:.3f} m", fontsize=10)
    figure.suptitle(title)
    plt.show()


# %%
# Star: the origin. Orange: the simplex after the step. Red circle: the support point that the step found.
# Dotted: from the origin to the simplex's closest point, whose length is in the title. It shrinks from step
# to step, until no point of the difference is nearer.

draw_steps("apart: the closest point of A − B to the origin", a, b, story.gjk.steps, (20, 60))
print(f"verdict: {story.gjk.verdict}, {story.gjk.distance:.4f} m from {story.gjk.on_a} to {story.gjk.on_b}")
assert story.gjk.verdict == "separated"
assert np.isclose(np.linalg.norm(story.gjk.on_b - story.gjk.on_a), story.gjk.distance, rtol=1e-5)

# %%
# Move the second box nearer, and the walk ends otherwise: with a tetrahedron around the origin. The boxes
# overlap; how deep is a question for EPA (:doc:`explain_epa`).

a, b, story = explained((0.5, 0.5, 0.2))
draw_steps("overlapping: a tetrahedron around the origin", a, b, story.gjk.steps, (20, 60))
print(f"verdict: {story.gjk.verdict}: {story.gjk.reason}")
assert story.gjk.verdict == "overlapping"

# %%
# The bounds close in
# -------------------
# Each support point also bounds the distance from below: all of :math:`A \ominus B` lies beyond the plane
# through it. When the bounds meet, the search is over.

a, b, story = explained((1.0, 0.9, 0.3))
upper = [step.distance for step in story.gjk.steps]
lower = [-step.direction @ step.point / np.linalg.norm(step.direction) for step in story.gjk.steps]
figure, axes = plt.subplots(figsize=(6, 3.5), layout="constrained")
count = np.arange(1, len(upper) + 1)
axes.plot(count, upper, "o-", label="closest point of the simplex")
axes.plot(count, np.maximum.accumulate(lower), "s-", label="plane through the support point")
axes.axhline(story.gjk.distance, color="0.5", linewidth=0.8)
axes.set(xlabel="step", ylabel="distance from the origin [m]", xticks=count)
axes.legend()
plt.show()
assert max(lower) <= story.gjk.distance * (1 + 1e-5) <= upper[0]
