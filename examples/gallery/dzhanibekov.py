r"""
The handle that turns over
==========================

A body that spins about its axis of the middle moment of inertia turns over, again and again, though nothing
acts on it. Vladimir Dzhanibekov saw a wing nut do so in orbit in 1985; Louis Poinsot knew why in 1834. An
engine that treats :math:`\omega` as constant (as the articles' did: :doc:`/theory/errata`) cannot show it.
"""

import matplotlib.pyplot as plt
import numpy as np
from drawing import matrix

import atlasphys as ap

# %%
# A T-handle is a rod with a bar across. Bodies have one shape; all that matters in free flight is the
# inertia, so a plate with three different moments will do.

world = ap.World(gravity=(0, 0, 0), precision="double")
handle = world.add(ap.Box(size=(1.0, 0.1, 0.4)), mass=1, angular_velocity=(0.001, 0.001, 5), name="handle")
print("moments of inertia", handle.inertia.round(5), "kg m²: z, about which it spins, is the middle one")
tilt, spin, energy, momentum = [], [], [], []
for _ in range(20 * 120):
    world.step(1 / 120)
    turn = matrix(handle.orientation)
    tilt.append(turn[2, 2])
    spin.append(turn.T @ handle.angular_velocity)
    energy.append(world.energy().kinetic)
    momentum.append(world.angular_momentum())
time = np.arange(1, len(tilt) + 1) / 120
spin, energy, momentum = np.array(spin), np.array(energy), np.array(momentum)

# %%
# :math:`\omega` in the body's axes changes all the time; energy and angular momentum, which nothing can
# change, stay.

drift = np.abs(energy / energy[0] - 1)
turned = np.linalg.norm(momentum - momentum[0], axis=1) / np.linalg.norm(momentum[0])
figure, panels = plt.subplots(3, 1, figsize=(8, 6.5), sharex=True, layout="constrained")
panels[0].plot(time, tilt)
panels[0].set(ylabel="body's z · world's z", title="it turns over")
for k, axis in enumerate("xyz"):
    panels[1].plot(time, spin[:, k], label=f"ω{axis}")
panels[1].set(ylabel="ω in body axes [rad/s]")
panels[1].legend(loc="right")
panels[2].semilogy(time, np.maximum(drift, 1e-17), label="energy")
panels[2].semilogy(time, np.maximum(turned, 1e-17), label="angular momentum")
panels[2].set(ylabel="change, as a share", xlabel="t [s]")
panels[2].legend()
plt.show()
assert min(tilt) < -0.99
assert drift.max() < 1e-9
assert turned.max() < 1e-9

# %%
# Stable about the other two
# --------------------------
# Energy and angular momentum confine :math:`\omega` to the curve where two ellipsoids meet. About the least
# and the greatest moment these curves are small circles; about the middle one they lead round to the other
# side.

starts = []
for axis in range(3):
    for nudge in (0.06, 0.2, 0.4):
        for sign in (1, -1):
            start = np.full(3, nudge)
            start[axis] = sign
            starts.append((axis, 0.1 * start / np.linalg.norm(start)))
inertia = np.array(handle.inertia)
free = ap.World(gravity=(0, 0, 0), precision="double")
for k, (_, start) in enumerate(starts):
    free.add(ap.Box(size=(1.0, 0.1, 0.4)), mass=1, position=(0, 0, 2 * k), angular_velocity=start / inertia)
curves = np.empty((1200, len(starts), 3))
for frame in curves:
    free.step(1 / 120)
    turned_back = [matrix(body.orientation).T @ body.angular_velocity for body in free.bodies]
    frame[:] = np.array(turned_back) * inertia / 0.1

figure = plt.figure(figsize=(5.6, 5.2), layout="constrained")
axes = figure.add_subplot(projection="3d", computed_zorder=False)
u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 60), np.linspace(0, np.pi, 30))
axes.plot_surface(np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v), color="0.92", alpha=0.5, linewidth=0)
eye = np.array([np.cos(np.radians(-50)), np.sin(np.radians(-50)), np.tan(np.radians(25))])
for k, (axis, _) in enumerate(starts):
    seen = np.where((curves[:, k] @ eye > 0)[:, None], curves[:, k], np.nan)
    axes.plot(*curves[:, k].T, color=f"C{axis}", linewidth=0.5, alpha=0.3)
    axes.plot(*seen.T, color=f"C{axis}", linewidth=1.3)
for axis, name in enumerate(("about the least moment", "the greatest", "the middle one")):
    axes.plot([], [], color=f"C{axis}", label=name)
axes.legend(loc="lower left")
axes.set_axis_off()
axes.set_title("angular momentum as seen from the body")
axes.set_box_aspect((1, 1, 1), zoom=1.3)
axes.view_init(elev=25, azim=-50)
plt.show()
