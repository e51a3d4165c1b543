r"""
EPA: how deep, and which way out
================================

When the origin lies inside :math:`A \ominus B`, the way out is the shortest one from the origin to its
boundary. EPA grows a polytope inside the set, always where its surface is nearest to the origin.
"""

import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

import atlasphys as ap

world = ap.World(gravity=(0, 0, 0), narrowphase="gjk_epa")
cone = world.add(ap.Cone(radius=0.6, height=1.2), name="cone")
solid = world.add(
    ap.octahedron(radius=0.6), position=(0.35, 0.3, 0.1), orientation=(0.9, 0.1, 0.4, 0.1), name="octahedron"
)
with ap.explain(world, pair=(cone, solid)) as story:
    world.step(1e-6)
print(str(story.epa)[:900], "…")

# %%
# Star: the origin, inside. Red: the face nearest to it, which is asked for the support point along its
# normal, the red dot. If the point lies beyond, the faces that see it give way to a fan over their rim, the
# *horizon*.

steps = [step for step in story.epa.steps if step.outcome != "wall"]
shown = sorted(set(np.linspace(0, len(steps) - 1, 6).round().astype(int).tolist()))
figure = plt.figure(figsize=(9.5, 6.4), layout="constrained")
everything = story.epa.steps[-1].polytope.vertices
for panel, k in enumerate(shown):
    step = steps[k]
    axes = figure.add_subplot(2, 3, panel + 1, projection="3d", computed_zorder=False)
    polytope = step.polytope
    faces = polytope.vertices[polytope.faces]
    asked = np.arange(len(faces)) == step.face
    axes.add_collection3d(Poly3DCollection(faces[~asked], facecolor="C0", alpha=0.12, edgecolor="C0", linewidth=0.5))
    axes.add_collection3d(Poly3DCollection(faces[asked], facecolor="C3", alpha=0.6, zorder=3))
    axes.plot(0, 0, 0, "k*", markersize=9, zorder=9)
    axes.plot(*np.array([np.zeros(3), step.lower * step.normal]).T, "k:", zorder=8)
    axes.plot(*step.point, "o", color="C3", markersize=6, zorder=7)
    low, high = everything.min(axis=0), everything.max(axis=0)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(high - low, zoom=1.4)
    axes.view_init(elev=25, azim=30)
    axes.set_axis_off()
    axes.set_title(f"{k + 1}: {len(faces)} faces, {1e3 * step.lower:.0f} to {1e3 * step.upper:.0f} mm", fontsize=10)
plt.show()

# %%
# The face's distance bounds the depth from below, its support point from above. Whatever ends the search, the
# direction with the least upper bound is a way out that is known to be free.

count = np.arange(1, len(story.epa.steps) + 1)
figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
axes.plot(
    count, [1e3 * step.upper for step in story.epa.steps], ".", color="C3", label="support point along its normal"
)
axes.step(count, [1e3 * step.best for step in story.epa.steps], where="mid", color="C3", label="best so far")
axes.step(count, [1e3 * step.lower for step in story.epa.steps], where="mid", label="nearest face")
axes.axhline(1e3 * story.epa.depth, color="0.5", linewidth=0.8)
axes.set(xlabel="step", ylabel="depth lies between [mm]")
axes.legend()
plt.show()
print(f"{1e3 * story.epa.depth:.2f} mm along {story.epa.normal.round(4)}: {story.epa.reason}")

# %%
# The proof of a way out is to go it. Moved by the depth along the normal the two just touch; by a little less
# they still overlap.

for share, verdict in ((1.01, "separated"), (0.99, "overlapping")):
    solid.position = np.array([0.35, 0.3, 0.1]) + share * story.epa.depth * story.epa.normal.astype(float)
    with ap.explain(world, pair=(cone, solid)) as moved:
        solid.velocity = 0, 0, 0
        cone.velocity = 0, 0, 0
        world.step(1e-6)
    print(f"moved by {share:.2f} of the depth: {moved.gjk.verdict}")
    assert moved.gjk.verdict == verdict
