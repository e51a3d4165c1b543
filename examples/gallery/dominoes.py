"""
A wave of dominoes
==================

Each domino is 1 m high, 0.2 m thick, and stands half a metre behind the one before. After some of them the
wave runs at a steady speed. Which, and what does it depend on?
"""

import matplotlib.pyplot as plt
import numpy as np
from drawing import draw

import atlasphys as ap


def fall_times(spacing, count=20, pictures=()):
    """When each domino has turned by 5° [s]. Draws the world at some times into ``pictures``: (time, axes)."""
    world = ap.load_scene("dominoes", count=count, spacing=spacing).build()
    waiting = list(pictures)
    times = np.full(count, np.nan)
    while np.isnan(times).any() and world.time < 10:
        world.step(1 / 120)
        # The cosine of the angle between a domino's own y axis and the world's, from its quaternion (w, x, y, z).
        _, x, _, z = world.bodies.orientation[1:].T
        over = 1 - 2 * (x * x + z * z) < np.cos(np.radians(5))
        times[over & np.isnan(times)] = world.time
        if waiting and world.time >= waiting[0][0]:
            draw(waiting.pop(0)[1], world)
    return times


figure, panels = plt.subplots(3, 1, figsize=(8, 5), sharex=True, sharey=True, layout="constrained")
times = fall_times(0.5, pictures=[(0.1, panels[0]), (1.7, panels[1]), (3.3, panels[2])])
for axes, when in zip(panels, (0.1, 1.7, 3.3), strict=True):
    axes.set(title=f"{when} s", ylim=(-0.1, 1.3))
plt.show()

# %%
# On the left, when each domino begins to fall: a straight line is a steady wave. On the right, the speed of
# the wave over the distance of the dominoes, in units of :math:`\sqrt{g h}`, which is all that the height can
# have to do with it.

figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4), layout="constrained")
left.plot(times, np.arange(len(times)), "o", markersize=4)
late = slice(8, None)
slope, start = np.polyfit(times[late], np.arange(len(times))[late], 1)
left.plot(times, slope * times + start, color="0.5", linewidth=0.8)
left.set(xlabel="begins to fall at [s]", ylabel="domino", ylim=(-1, 20))

spacings = np.array([0.45, 0.5, 0.55, 0.6, 0.7, 0.8])
speeds = []
for spacing in spacings:
    begins = fall_times(spacing)
    speeds.append(spacing * np.polyfit(begins[late], np.arange(len(begins))[late], 1)[0])
right.plot(spacings, np.array(speeds) / np.sqrt(9.81), "o-")
right.set(xlabel="distance of the dominoes [m]", ylabel="speed of the wave / √(g h)", ylim=(0, 1.1))
plt.show()
print("speed of the wave:", np.round(speeds, 2), "m/s")
assert np.isfinite(speeds).all()
assert 1 < min(speeds) < max(speeds) < 10
