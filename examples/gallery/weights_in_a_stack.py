"""
Where the weight goes: contacts and forces
==========================================

Every contact point tells with which impulse it pushed in the last step. Over the step's time that is a force,
and so a stack becomes a set of scales.
"""

import matplotlib.pyplot as plt
import numpy as np
from drawing import draw

import atlasphys as ap

DT, G = 1 / 60, 9.81

# %%
# A beam of 60 kg lies on two crates, and a load of 100 kg stands on it, not in the middle.

world = ap.World()
ground = world.add(ap.Plane(normal=(0, 1, 0)), name="ground")
left = world.add(ap.Box(size=(0.6, 1, 1)), position=(-2, 0.5, 0), mass=20, name="left")
right = world.add(ap.Box(size=(0.6, 1, 1)), position=(2, 0.5, 0), mass=20, name="right")
beam = world.add(ap.Box(size=(5, 0.3, 1)), position=(0, 1.15, 0), mass=60, name="beam")
load = world.add(ap.Box(size=(0.8, 0.8, 0.8)), position=(1, 1.7, 0), mass=100, name="load")
world.run(seconds=3)

# %%
# ``world.contacts`` has a record for each point. Normals point from a to b, so b is pushed along the normal
# and a against it.

contacts = world.contacts
print("a       b       x      force")
for contact in contacts:
    names = [world.bodies[int(row)].name for row in (contact.body_a, contact.body_b)]
    print(f"{names[0]:7} {names[1]:7} {contact.point[0]:5.2f}  {contact.normal_impulse / DT:6.1f} N")


def force(a, b):
    """With how much a pushes b up [N]."""
    between = contacts[(contacts.body_a == a.row) & (contacts.body_b == b.row)]
    return (between.normal_impulse * between.normal[:, 1]).sum() / DT


# %%
# Statics gives the answer beforehand: moments about the left crate say what the right one bears. The crates
# are wide, so where along its width a crate is pressed is not known, and with it not the exact share: a
# support reaches from 1.7 to 2.3 m. What *must* be right is the sum, and the moments about any point.

bears = {"left": abs(force(left, beam)), "right": abs(force(right, beam)), "load": abs(force(beam, load))}
figure, axes = plt.subplots(figsize=(8, 4.2), layout="constrained")
draw(axes, world, alpha=0.45, labels=True)
for contact in contacts:
    scale = contact.normal_impulse / DT / 800
    for side in (1, -1):
        tip = contact.point[:2] + side * scale * contact.normal[:2]
        axes.annotate("", tip, contact.point[:2], arrowprops={"arrowstyle": "->", "color": "C3", "linewidth": 1.2})
axes.set(
    xlim=(-3, 3), ylim=(-0.6, 2.4), xlabel="x [m]", ylabel="y [m]", title="each contact pushes both bodies; 1 m: 800 N"
)
plt.show()

on_beam = contacts[(contacts.body_a == beam.row) | (contacts.body_b == beam.row)]
up = np.where(on_beam.body_b == beam.row, 1, -1) * on_beam.normal[:, 1] * on_beam.normal_impulse / DT
moment = (up * on_beam.point[:, 0]).sum()
print({name: f"{newtons:.1f} N" for name, newtons in bears.items()})
print(f"on the beam: sum {up.sum():.1f} N, its weight {60 * G:.1f} N; moment about the middle {moment:.1f} N m")
assert np.isclose(bears["load"], 100 * G, rtol=1e-3)
assert np.isclose(bears["left"] + bears["right"], 160 * G, rtol=1e-3)
assert np.isclose(force(ground, left) + force(ground, right), 200 * G, rtol=1e-3)
assert abs(moment) < 1

# %%
# A tower carries more the lower it is
# ------------------------------------

tower = ap.load_scene("tower", height=10).build()
tower.run(seconds=3)
contacts = tower.contacts
forces = [contacts.normal_impulse[contacts.body_b == row].sum() / DT for row in range(1, 11)]
weights = tower.bodies.mass[1:] * G
figure, axes = plt.subplots(figsize=(6, 3.5), layout="constrained")
axes.barh(np.arange(10), forces, label="measured")
axes.plot(np.cumsum(weights[::-1])[::-1], np.arange(10), "k|", markersize=14, label="weight from here up")
axes.set(xlabel="force under the cube [N]", ylabel="cube", yticks=range(10))
axes.legend()
plt.show()
error = np.max(np.abs(forces / np.cumsum(weights[::-1])[::-1] - 1))
print(f"worst: {100 * error:.2f} % off")
assert error < 0.01
