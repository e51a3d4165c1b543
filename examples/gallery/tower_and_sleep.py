"""
A tower, and what sleeping does
===============================

Ten crates fall on one another from small heights. As soon as they have been at rest for half a second they
fall *asleep*: their island is left out of the computation until something touches it.
"""

import matplotlib.pyplot as plt
import numpy as np
from drawing import draw
from scipy.ndimage import median_filter

import atlasphys as ap


def tower(sleeping):
    """A world with ten cubes that drop a few millimetres on one another."""
    world = ap.World(sleeping=sleeping)
    world.add(ap.Plane(normal=(0, 1, 0)))
    for k in range(10):
        world.add(ap.Box(size=(1, 1, 1)), position=(0, 0.5 + 1.01 * k, 0), mass=10, name=f"cube {k}")
    return world


# %%
# Two equal worlds; in one of them sleep is switched off. After three seconds a ball comes flying. What wakes,
# wakes by itself.

worlds = {"sleeping=True": tower(True), "sleeping=False": tower(False)}
energy = {name: [] for name in worlds}
cost = {name: [] for name in worlds}
awake = []
pictures = []
for step in range(360):
    for name, world in worlds.items():
        if step == 180:
            world.add(ap.Sphere(radius=0.4), position=(-6, 5, 0), velocity=(12, 3, 0), mass=40, name="ball")
        world.step(1 / 60)
        energy[name].append(world.energy().kinetic)
        cost[name].append(1e6 * sum(world.profile.values()))
    first = worlds["sleeping=True"]
    awake.append(np.sum(~first.bodies.asleep & (first.bodies.kind == "dynamic")))

time = np.arange(1, 361) / 60
figure, panels = plt.subplots(3, 1, figsize=(8, 6.5), sharex=True, layout="constrained")
for name in worlds:
    panels[0].semilogy(time, np.maximum(energy[name], 1e-9), label=name)
    panels[2].plot(time, median_filter(cost[name], 15), label=name)
panels[0].set(ylabel="kinetic energy [J]", title="a tower settles; a ball comes at 3 s")
panels[0].legend()
panels[1].step(time, awake, color="C0")
panels[1].set(ylabel="bodies awake", yticks=(0, 5, 10))
panels[2].set(ylabel="time of a step [µs],\nmedian of 15", xlabel="t [s]", ylim=(0, None))
plt.show()

# %%
# Asleep, a body has no velocity at all, where in the other world some energy of the soft contacts' last
# trembling is left. Every change is an event:

world = tower(True)
for _ in range(180):
    world.step(1 / 60)
    slept = [event.a.name for event in world.events if event.kind == "sleep"]
    if slept:
        print(f"{world.time:.2f} s: asleep are {', '.join(slept)}")
assert world.bodies.asleep[1:].all()

# %%
# What the ball does to this tower, 1.2 s after it was thrown:

figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
world.add(ap.Sphere(radius=0.4), position=(-6, 5, 0), velocity=(12, 3, 0), mass=40, name="ball")
world.run(seconds=1.2)
draw(axes, world)
axes.set(xlabel="x [m]", ylabel="y [m]")
plt.show()
assert not world.bodies.asleep[1:].any()
