r"""
The slope and the friction cone
===============================

A block on a slope of angle :math:`\theta` holds as long as :math:`\tan\theta \le \mu`. Beyond, it slides with

.. math:: a = g\,(\sin\theta - \mu\cos\theta) .

In place of tilting the ground, this example tilts gravity, which is the same.
"""

import math

import matplotlib.pyplot as plt
import numpy as np

import atlasphys as ap

MU, G = 0.5, 9.81


def slide(degrees):
    """Acceleration down the slope [m/s²], and friction over normal impulse, of a block that starts at rest."""
    angle = math.radians(degrees)
    world = ap.World(gravity=(G * math.sin(angle), -G * math.cos(angle), 0), sleeping=False)
    world.add(ap.Plane(normal=(0, 1, 0)), friction=MU)
    block = world.add(ap.Box(size=(1, 0.3, 1)), position=(0, 0.15, 0), friction=MU)
    world.run(seconds=0.5)  # settle on the soft contacts
    before = float(block.velocity[0])
    world.run(seconds=0.5)
    contacts = world.contacts
    friction = np.linalg.norm(contacts.friction_impulse.sum(axis=0))
    return (float(block.velocity[0]) - before) / 0.5, friction / contacts.normal_impulse.sum()


angles = np.arange(0, 51, 2.5)
measured, ratio = np.array([slide(angle) for angle in angles]).T

# %%
# On the left the acceleration. On the right friction, as a share of the normal force: it grows with the
# slope, just as much as is needed to hold the block, until it reaches :math:`\mu` and can grow no more. The
# block slides where the dashed line, :math:`\tan\theta`, leaves the cone.

theta = np.radians(np.linspace(0, 50, 300))
limit = math.degrees(math.atan(MU))
exact = np.maximum(0, G * (np.sin(theta) - MU * np.cos(theta)))
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4), layout="constrained")
left.plot(np.degrees(theta), exact, color="0.5", label="g (sin θ − μ cos θ)")
left.plot(angles, measured, "o", markersize=4, label="measured")
left.set(xlabel="slope θ [°]", ylabel="acceleration [m/s²]")
left.axvline(limit, color="C3", linewidth=0.8)
left.annotate(f"arctan μ = {limit:.1f}°", (limit, 3.2), rotation=90, ha="right", color="C3")
left.legend()
right.fill_between([0, 50], 0, MU, color="C2", alpha=0.15, label="inside the cone")
right.plot(np.degrees(theta), np.tan(theta), "--", color="0.5", label="tan θ: needed to hold")
right.plot(angles, ratio, "o", markersize=4, label="measured")
right.set(xlabel="slope θ [°]", ylabel="friction / normal force", ylim=(0, 1))
right.legend(loc="upper left")
plt.show()

expected = np.maximum(0, G * (np.sin(np.radians(angles)) - MU * np.cos(np.radians(angles))))
print(f"greatest difference: {np.max(np.abs(measured - expected)):.4f} m/s²")
assert np.allclose(measured, expected, atol=0.02)

# %%
# The cone is round
# -----------------
# Some engines clamp friction along two axes one by one. The cone becomes a pyramid, and a puck's way depends
# on how it lies to the axes. Here it does not: pucks that are pushed in all directions at 4 m/s come to rest
# on a circle of radius :math:`v^2 / 2\mu g`.

world = ap.World()
world.add(ap.Plane(normal=(0, 1, 0)), friction=MU)
headings = np.radians(np.arange(0, 360, 15))
for heading in headings:
    # Pucks of groups that do not collide with one another start at the same place.
    world.add(
        ap.Cylinder(radius=0.1, length=0.02),
        position=(0, 0.01, 0),
        velocity=(4 * math.cos(heading), 0, 4 * math.sin(heading)),
        friction=MU,
        group=2,
        mask=1,
    )
world.run(seconds=2)
ends = world.bodies.position[1:, [0, 2]]
figure, axes = plt.subplots(figsize=(4.6, 4.6), layout="constrained")
axes.add_patch(plt.Circle((0, 0), 16 / (2 * MU * G), fill=False, color="0.5"))
for end in ends:
    axes.plot([0, end[0]], [0, end[1]], color="C0", linewidth=0.8)
axes.plot(*ends.T, "o", markersize=5)
axes.set(xlabel="x [m]", ylabel="z [m]", aspect="equal", title="where pucks come to rest; grey: v² / 2μg")
plt.show()

radii = np.linalg.norm(ends, axis=1)
print(f"from {radii.min():.3f} to {radii.max():.3f} m; v² / 2μg = {16 / (2 * MU * G):.3f} m")
assert np.ptp(radii) < 0.01
