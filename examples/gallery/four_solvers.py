"""
Four solvers under a heavy load
===============================

A crate of a tonne or of ten stands on one of ten kilograms. That is where iterative solvers are told apart:
in each visit to a contact the light crate gives way, and hands the load on only little by little. All four
solvers of the engine get the same scene, from the scene library, and the same time step.
"""

import time

import matplotlib.pyplot as plt
import numpy as np

import atlasphys as ap

SOLVERS = ("soft_step", "sequential_impulse", "xpbd", "avbd")
RATIOS = (1, 10, 100, 1000)


def sinking(solver, ratio, seconds=3.0):
    """How far the light crate is pressed into the ground and the heavy one into it [m], over time, and the time of a step [s]."""
    world = ap.load_scene("heavy_on_light", ratio=ratio).build(solver=solver)
    heavy = world.bodies["heavy"]
    world.step(1 / 60)
    depth, begun = [], time.perf_counter()
    for _ in range(round(seconds * 60)):
        world.step(1 / 60)
        depth.append(1.5 - heavy.position[1])
    return np.array(depth), (time.perf_counter() - begun) / (seconds * 60)


results = {solver: {ratio: sinking(solver, ratio) for ratio in RATIOS} for solver in SOLVERS}

# %%
# On the left, over time, for a load of 100 : 1. On the right, after three seconds, for all ratios.

figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4), layout="constrained")
for solver in SOLVERS:
    depth = 1e3 * results[solver][100][0]
    left.plot(np.arange(len(depth)) / 60, depth, label=solver)
    final = [max(1e3 * results[solver][ratio][0][-1], 1e-3) for ratio in RATIOS]
    right.loglog(RATIOS, final, "o-", label=solver)
left.set(xlabel="t [s]", ylabel="load has sunk by [mm]", title="100 : 1", yscale="symlog")
right.set(xlabel="mass of the load / mass of the crate", ylabel="sunk after 3 s [mm]")
right.legend()
plt.show()

# %%
# The default, ``soft_step``, has springs for contacts, which are as stiff as suits bodies of like mass: it is
# meant for many bodies, and right there. ``avbd`` finds the load itself as a multiplier
# (:doc:`/theory/avbd`), and does not sink however heavy it is. The price:

for solver in SOLVERS:
    print(f"{solver:20} {1e6 * results[solver][1000][1]:7.0f} µs a step")
assert results["avbd"][1000][0][-1] < 0.01 < results["soft_step"][1000][0][-1]

# %%
# ``atlasphys compare heavy_on_light --solver soft_step,avbd`` makes such a table for any scene.
