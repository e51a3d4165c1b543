"""
Single, double, and the same bits every time
============================================

``precision="double"`` computes everything with 16 digits instead of 7 (positions have 16 in both). Whichever
is chosen, equal worlds stay equal to the bit, in every run and for every number of threads.
"""

import matplotlib.pyplot as plt
import numpy as np

import atlasphys as ap


def pyramid(**settings):
    """A pyramid after half a second."""
    world = ap.load_scene("pyramid", base=8).build(**settings)
    world.run(seconds=0.5)
    return world


# %%
# ``state_hash()`` is a digest of the whole state. One number in another last digit changes it.

for settings in ({}, {"threads": 2}, {"broadphase": "brute"}, {"precision": "double"}):
    print(f"{settings!s:28} {pyramid(**settings).state_hash()}")
assert pyramid().state_hash() == pyramid().state_hash() == pyramid(threads=2).state_hash()

# %%
# What does single precision cost? Here is a free body that spins: nothing acts on it, so each change of its
# energy is the computer's. And a block that slides to a stop, next to the same run in double precision.

figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
slides = {}
for precision in ("single", "double"):
    free = ap.World(gravity=(0, 0, 0), precision=precision)
    free.add(ap.Box(size=(1, 0.5, 0.25)), angular_velocity=(1, 3, 2))
    begun, drift = free.energy().kinetic, []
    for _ in range(1200):
        free.step(1 / 60)
        drift.append(abs(free.energy().kinetic / begun - 1))
    left.semilogy(np.arange(1, 1201) / 60, np.maximum(drift, 1e-17), label=precision, linewidth=0.9)

    table = ap.World(precision=precision, sleeping=False)
    table.add(ap.Plane(normal=(0, 1, 0)))
    puck = table.add(ap.Box(size=(1, 0.2, 1)), position=(0, 0.1, 0), velocity=(3, 0, 1))
    way = []
    for _ in range(120):
        table.step(1 / 60)
        way.append(puck.position.copy())
    slides[precision] = np.array(way)
left.set(xlabel="t [s]", ylabel="change of energy, as a share", title="a free spinning body")
left.legend()
apart = np.linalg.norm(slides["single"] - slides["double"], axis=1)
right.plot(np.arange(1, 121) / 60, 1e6 * apart)
right.set(xlabel="t [s]", ylabel="single from double [µm]", title="a block slides 1 m and stops")
plt.show()
print(f"the blocks stop {1e6 * apart[-1]:.1f} µm apart, after {np.linalg.norm(slides['double'][-1, [0, 2]]):.3f} m")
assert drift[-1] < 1e-11
assert apart[-1] < 1e-3

# %%
# Single precision is right for almost everything: it is faster, and its error far below that of the time
# step. Double precision is for long free flights, for comparisons with closed forms, and for doubts. The
# tests hold hashes of many scenes for both (``tests/golden``).
