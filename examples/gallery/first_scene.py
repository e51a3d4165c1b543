"""
A first scene
=============

A crate falls on the ground, tips over an edge and comes to rest. It takes a world, two bodies and a loop.
"""

import matplotlib.pyplot as plt
from drawing import draw

import atlasphys as ap

world = ap.World()  # gravity (0, -9.81, 0) m/s², lengths in metres, y up
world.add(ap.Plane(normal=(0, 1, 0)), name="ground")
crate = world.add(
    ap.Box(size=(1, 1, 1)),
    position=(0, 2.5, 0),
    orientation=(0.94, 0, 0, 0.34),  # a quaternion (w, x, y, z): 40° about z
    mass=10,
    name="crate",
)

# %%
# ``world.step(dt)`` takes one step. A handle such as ``crate`` always tells the present state. Here every
# twelfth state is drawn, five in a second, paler the older it is.

figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4), layout="constrained")
times, heights = [], []
for step in range(120):
    if step % 12 == 0:
        draw(left, world, alpha=0.15 + 0.07 * step / 12)
    world.step(1 / 60)
    times.append(world.time)
    heights.append(crate.position[1])
left.set(xlim=(-2, 2), ylim=(-0.3, 3.6), xlabel="x [m]", ylabel="y [m]", title="five pictures a second")

right.plot(times, heights)
right.axhline(0.5, color="0.5", linewidth=0.8, linestyle="--")
right.set(xlabel="t [s]", ylabel="height of the centre [m]", title="it ends half a metre above the ground")
plt.show()

# %%
# At rest the ground pushes with the crate's weight. Impulses of a step, over the step's time, are forces:

force = world.contacts.normal_impulse.sum() * 60
print(f"{len(world.contacts)} contact points push with {force:.2f} N; the crate weighs {10 * 9.81:.2f} N")
assert abs(force - 98.1) < 0.1
assert abs(crate.position[1] - 0.5) < 0.01
