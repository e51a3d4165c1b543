"""
Drawing a world from the side
=============================

``world.view()`` shows a world in the browser, and ``atlasphys render`` makes films of it. For a figure it
often takes no more than outlines. This file draws them with Matplotlib; the other examples import it.

Every body has a pose and a shape. A shape is a convex core and a radius about it: a sphere is a point, a
capsule a segment, the others have no radius. Seen along z, its outline is where it is farthest in each
direction of the page, its *support*, which is also what the engine's collision routines ask of shapes.
"""

import matplotlib.pyplot as plt
import numpy as np

import atlasphys as ap

COLOURS = ("#4c78a8", "#f58518", "#54a24b", "#b279a2", "#e45756", "#72b7b2", "#eeca3b", "#9d755d")
"""Colours of bodies that have none of their own."""


def matrix(orientation):
    """The rotation matrix of a unit quaternion (w, x, y, z)."""
    w, x, y, z = orientation
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def core(shape):
    """(n, 3) points whose hull is the core of a shape, in its own frame, and the radius about it."""
    angles = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    ring = np.stack([np.cos(angles), np.zeros_like(angles), np.sin(angles)], axis=1)
    up = np.array([[0.0, 0.5, 0.0]])
    match shape:
        case ap.Sphere(radius=r):
            return np.zeros((1, 3)), r
        case ap.Capsule(radius=r, length=length):
            return np.concatenate([length * up, -length * up]), r
        case ap.Cylinder(radius=r, length=length):
            return np.concatenate([r * ring + length * up, r * ring - length * up]), 0.0
        case ap.Cone(radius=r, height=height):
            return np.concatenate([r * ring - height * up, height * up]), 0.0
    return np.asarray(shape.polyhedron.vertices), 0.0


def outline(shape, position, orientation):
    """(360, 2) the outline of a shape, seen along z."""
    points, radius = core(shape)
    flat = (points @ matrix(orientation).T + position)[:, :2]
    angles = np.radians(np.arange(360))
    around = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return flat[np.argmax(around @ flat.T, axis=1)] + radius * around


def draw(axes, world, alpha=1.0, labels=False):
    """Draw all bodies, seen along z, and planes as the lines where they cross the page."""
    for row, body in enumerate(world.bodies):
        colour = body.color or COLOURS[row % len(COLOURS)]
        if isinstance(body.shape, ap.Plane):
            normal, offset = np.array(body.shape.normal), body.shape.offset
            axes.axline(normal[:2] * offset, slope=None if normal[1] == 0 else -normal[0] / normal[1], color="0.4")
            continue
        points = outline(body.shape, body.position, body.orientation)
        axes.fill(*points.T, facecolor=colour, edgecolor="0.2", linewidth=0.8, alpha=alpha)
        if labels:
            axes.annotate(body.name or f"body {row}", points.mean(axis=0), ha="center", va="center", fontsize=8)
    axes.set_aspect("equal")


# %%
# A fall of every shape that there is, drawn at three moments:

if __name__ == "__main__":
    world = ap.World()
    world.add(ap.Plane(normal=(0, 1, 0)))
    shapes = [
        ap.Sphere(radius=0.4),
        ap.Box(size=(0.8, 0.5, 0.6)),
        ap.Capsule(radius=0.25, length=0.6),
        ap.Cylinder(radius=0.3, length=0.7),
        ap.Cone(radius=0.4, height=0.8),
        ap.octahedron(radius=0.5),
        ap.tetrahedron(radius=0.5),
        ap.pyramid(sides=5, radius=0.45, height=0.7),
    ]
    for k, shape in enumerate(shapes):
        world.add(shape, position=(1.2 * k, 2.0, 0), orientation=(0.9, 0, 0, -0.43), restitution=0.2)

    figure, panels = plt.subplots(3, 1, figsize=(8, 6), sharex=True, sharey=True, layout="constrained")
    for axes in panels:
        draw(axes, world)
        axes.set(title=f"{world.time:.2f} s", ylim=(-0.2, 2.7), ylabel="y [m]")
        world.run(seconds=0.6)
    panels[-1].set_xlabel("x [m]")
    plt.show()
