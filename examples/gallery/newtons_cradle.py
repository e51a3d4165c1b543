r"""
Newton's cradle
===============

As many balls leave as arrive. Why? Momentum and energy alone do not say so for more than two balls. The
answer is that the impacts happen one after the other: each is between two equal elastic balls, which swap
their velocities.
"""

import matplotlib.pyplot as plt
import numpy as np

import atlasphys as ap

# %%
# The scene of the library has small gaps between the balls, so that impacts happen one by one. Each line
# below is a ball's place over time.

figure, panels = plt.subplots(1, 3, figsize=(10, 4), sharey=True, layout="constrained")
for axes, moving in zip(panels, (1, 2, 3), strict=True):
    world = ap.load_scene("newtons_cradle", balls=5, moving=moving, speed=2.0).build()
    before = world.energy().kinetic, world.momentum()[0]
    places = []
    for _ in range(150):
        world.step(1 / 60)
        places.append(world.bodies.position[:, 0].copy())
    speeds = world.bodies.velocity[:, 0]
    assert np.allclose(speeds, [0] * (5 - moving) + [2] * moving, atol=1e-3)
    assert np.isclose(world.energy().kinetic, before[0], rtol=1e-4)
    assert np.isclose(world.momentum()[0], before[1], rtol=1e-4)
    print(f"{moving} in, {np.sum(speeds > 1)} out: {speeds.round(4) + 0.0} m/s")
    axes.plot(np.arange(1, 151) / 60, places)
    axes.set(xlabel="t [s]", title=f"{moving} in, {moving} out")
panels[0].set_ylabel("x [m]")
plt.show()

# %%
# Restitution below one
# ---------------------
# With :math:`e < 1` an impact of two equal balls leaves :math:`(1 - e)/2` of the speed with the first and
# hands on :math:`(1 + e)/2`. Through four impacts the last ball gets :math:`((1 + e)/2)^4` of it, and all of
# them creep after.

figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
coefficients = np.linspace(0.4, 1, 7)
last = []
for restitution in coefficients:
    world = ap.World(gravity=(0, 0, 0), restitution_threshold=0.0)
    for k in range(5):
        speed = 2.0 if k == 0 else 0.0
        place = (1.5 * k, 0, 0)
        world.add(ap.Sphere(radius=0.5), position=place, velocity=(speed, 0, 0), restitution=restitution, friction=0)
    fastest = 0.0
    for _ in range(240):
        world.step(1 / 60)
        fastest = max(fastest, world.bodies.velocity[4, 0])
    last.append(fastest / 2)
dense = np.linspace(0.4, 1, 100)
axes.plot(dense, ((1 + dense) / 2) ** 4, color="0.5", label="((1 + e)/2)⁴")
axes.plot(coefficients, last, "o", label="measured")
axes.set(xlabel="coefficient of restitution e", ylabel="speed of the last ball / of the first")
axes.legend()
plt.show()
assert np.allclose(last, ((1 + coefficients) / 2) ** 4, rtol=1e-3)
