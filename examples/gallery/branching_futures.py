"""
Branching futures: snapshots and chaos
======================================

A snapshot holds everything that the future depends on. Restored, a world goes on to the same bits. Restored
and changed by a billionth, it goes on to another future: how soon?
"""

import matplotlib.pyplot as plt
import numpy as np

import atlasphys as ap

# %%
# A die is thrown on a table. (To move it sideways would change nothing: the table is the same everywhere. So
# it is lifted.) At half a second, before it lands, the world is saved.

world = ap.World(precision="double")
world.add(ap.Plane(normal=(0, 1, 0)))
die = world.add(
    ap.Box(size=(1, 1, 1)),
    position=(0, 4, 0),
    orientation=(0.85, 0.2, 0.4, 0.27),
    velocity=(4, 2, 0),
    angular_velocity=(3, 2, -7),
    restitution=0.85,
)
world.run(seconds=0.5, dt=1 / 120)
fork = world.snapshot()


def future(nudge=0.0, seconds=7.0):
    """The die's way from the fork on, first lifted by so much [m]; then the world's hash."""
    world.restore(fork)
    x, y, z = die.position
    die.position = x, y + nudge, z
    way = []
    for _ in range(round(seconds * 120)):
        world.step(1 / 120)
        way.append(die.position.copy())
    return np.array(way), world.state_hash()


# %%
# Restored and left alone, the future is the same, to the bit:

reference, digest = future()
again, same = future()
assert digest == same
assert np.array_equal(reference, again)
print("two futures without a nudge:", digest, same)

# %%
# Nudged, it departs. Each impact multiplies a difference, and at an edge that just does or does not catch the
# ways part for good.

figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
left.plot(*reference[:, [0, 2]].T, "k", linewidth=2, zorder=3, label="no nudge")
time = 0.5 + np.arange(1, len(reference) + 1) / 120
for exponent in (-12, -9, -6, -3):
    way, _ = future(10.0**exponent)
    apart = np.linalg.norm(way - reference, axis=1)
    label = f"{10.0**exponent:.0e} m"
    left.plot(*way[:, [0, 2]].T, label=label)
    right.semilogy(time, np.maximum(apart, 1e-16), label=label)
left.set(xlabel="x [m]", ylabel="z [m]", title="seen from above", aspect="equal")
left.legend(fontsize=8)
right.set(xlabel="t [s]", ylabel="distance from the way without nudge [m]")
plt.show()

# %%
# What is chance, then? A thousand throws would do; sixty, from heights a centimetre or less from the first
# one, show how the top face hangs on a millimetre.

tops = []
for nudge in np.linspace(-0.01, 0.01, 60):
    future(nudge, seconds=8.0)
    w, x, y, z = die.orientation
    up = np.array(
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)]
    )  # the world's y in the die's axes
    face = int(np.argmax(np.abs(up)))
    tops.append("xyz"[face] + ("+" if up[face] > 0 else "−"))
figure, axes = plt.subplots(figsize=(8, 2.6), layout="constrained")
names = sorted(set(tops))
for k, name in enumerate(names):
    chosen = np.array([top == name for top in tops])
    axes.plot(1e3 * np.linspace(-0.01, 0.01, 60)[chosen], np.full(chosen.sum(), k), "s", markersize=5)
axes.set(
    xlabel="nudge [mm]",
    yticks=range(len(names)),
    yticklabels=names,
    ylabel="face on top",
    ylim=(-0.6, len(names) - 0.4),
)
plt.show()
assert len(names) > 1
