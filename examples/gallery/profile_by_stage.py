"""
Where the time of a step goes
=============================

``world.profile`` has the seconds that each stage of the last step took, by the stages' names. Which stage
matters depends on the scene.
"""

import matplotlib.pyplot as plt
import numpy as np

import atlasphys as ap

SCENES = {
    "pit: 512 spheres": ("sphere_pit", {"count": 512}, 1.5),
    "pyramid: 210 cubes": ("pyramid", {"base": 20}, 0.7),
    "mixed: 100 shapes of all kinds": ("mixed_shapes", {"count": 100}, 1.5),
}

# %%
# Each scene runs to the moment that is asked for; then sixty steps are measured, and of each stage the median
# is taken. Sleep is off, so that there is something to measure.


def profile(name, sizes, seconds):
    """The median time of each stage [µs], and the number of contact points."""
    world = ap.load_scene(name, **sizes).build(sleeping=False)
    world.run(seconds=seconds)
    measured = []
    for _ in range(60):
        world.step(1 / 60)
        measured.append(list(world.profile.values()))
    return 1e6 * np.median(measured, axis=0), len(world.contacts), list(world.profile)


results = {label: profile(*case) for label, case in SCENES.items()}
stages = next(iter(results.values()))[2]
figure, axes = plt.subplots(figsize=(9, 3.2), layout="constrained")
for row, (micro, contacts, _) in enumerate(results.values()):
    start = 0.0
    for k, stage in enumerate(stages):
        axes.barh(row, micro[k], left=start, color=f"C{k}", label=stage if row == 0 else None)
        start += micro[k]
    axes.annotate(f" {contacts} points", (start, row), va="center", fontsize=8)
axes.set(yticks=range(len(results)), yticklabels=results, xlabel="time of a step, by stage [µs]")
axes.invert_yaxis()
axes.margins(x=0.12)
axes.legend(ncols=4, fontsize=8, loc="upper center", bbox_to_anchor=(0.4, 1.22))
plt.show()

for label, (micro, _, _) in results.items():
    print(f"{label:34} {micro.sum():7.0f} µs, most of it {stages[int(np.argmax(micro))]}")
assert all(micro.sum() > 0 for micro, _, _ in results.values())

# %%
# The figures are those of the machine that built this page, and of what else it had to do. ``atlasphys
# bench`` measures with more care (:doc:`/bench`).
