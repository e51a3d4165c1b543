r"""
A heap, and its angle of repose
===============================

Grains that are poured on a table pile up to a cone. Its slope, the *angle of repose*, is a measure of how
well they hold on to one another: of friction, and of how hard it is for them to roll.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import EllipseCollection

import atlasphys as ap

RADIUS = 0.1


def heap(friction, rolling, count=350):
    """Pour grains on a rough disc from low above the heap, and wait."""
    world = ap.World(length_unit=0.2)
    world.add(ap.Plane(normal=(0, 1, 0)), friction=0.9, rolling_friction=0.05)
    rng = np.random.default_rng(1)
    for layer in range(0, count, 7):
        top = world.bodies.position[1:, 1].max() if layer else 0.0
        for k in range(7):
            angle = 2 * np.pi * k / 6 + rng.uniform(0, 1)
            r = 0.0 if k == 6 else 2.2 * RADIUS
            place = (r * np.cos(angle), top + 3 * RADIUS, r * np.sin(angle))
            world.add(
                ap.Sphere(radius=RADIUS * rng.uniform(0.9, 1.1)),
                position=place,
                velocity=(0, -1, 0),
                friction=friction,
                rolling_friction=rolling,
            )
        world.run(seconds=0.2)
    world.run(seconds=1.5)
    return world


def slope(world):
    """The heap's angle [°]: of the line through the highest grain of each ring about its axis."""
    x, y, z = world.bodies.position[1:].T
    r = np.hypot(x, z)
    rings = np.arange(0, 4, 2 * RADIUS)
    inside = [(r >= a) & (r < a + 2 * RADIUS) for a in rings]
    surface = [(a + RADIUS, y[ring].max()) for a, ring in zip(rings, inside, strict=True) if ring.any()]
    surface = np.array([point for point in surface if point[1] > 1.5 * RADIUS])
    tilt, height = np.polyfit(*surface.T, 1)
    return np.degrees(np.arctan(-tilt)), surface, height, tilt


# %%
# Balls that roll freely make a flat heap, and those at its foot roll away, out of the picture. Friction makes
# it steeper, but not much: a ball that cannot slide still rolls. *Rolling friction* holds it: a lever arm of
# some millimetres by which a flattened contact resists (:doc:`/theory/friction`, "Rolling and torsion").

cases = {"friction 0.1": (0.1, 0.0), "friction 0.6": (0.6, 0.0), "and 2 cm rolling friction": (0.6, 0.02)}
figure, panels = plt.subplots(3, 1, figsize=(8, 7), sharex=True, sharey=True, layout="constrained")
found = {}
for axes, (name, (friction, rolling)) in zip(panels, cases.items(), strict=True):
    world = heap(friction, rolling)
    found[name], surface, height, tilt = slope(world)
    x, y, z = world.bodies.position[1:].T
    near = np.argsort(z)  # the nearest to the viewer last
    size = np.full(len(x), 2 * RADIUS)
    grains = EllipseCollection(size, size, 0 * size, units="xy", offsets=np.stack([x, y], 1)[near])
    grains.set(array=z[near], cmap="YlOrBr", edgecolor="0.3", linewidth=0.4, offset_transform=axes.transData)
    axes.add_collection(grains)
    ends = np.array([0, surface[-1, 0]])
    axes.plot(ends, height + tilt * ends, color="C0")
    axes.plot(-ends, height + tilt * ends, color="C0")
    axes.set(title=f"{name}: {found[name]:.0f}°", ylabel="y [m]", xlim=(-2.5, 2.5), ylim=(0, 1.5), aspect="equal")
panels[-1].set_xlabel("x [m]")
plt.show()

for name, angle in found.items():
    print(f"{name}: {angle:.1f}°")
angles = list(found.values())
assert angles[0] < angles[1] < angles[2]
