"""
Recording, replaying, plotting energy
=====================================

A recording is an HDF5 file with all poses of all bodies. It is read by step or by body, played in the browser
(``atlasphys view wall.h5``), filmed (``atlasphys render wall.h5 wall.mp4``), or opened in any other program
that knows HDF5.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from drawing import outline

import atlasphys as ap

path = Path(tempfile.mkdtemp()) / "wall.h5"

# %%
# A heavy ball hits a wall. The recorder writes after each step; a killed program leaves a file that can be
# read up to its last steps.

scene = ap.load_scene("wall", bricks=6, rows=6)
world = scene.build()
energy = []
with ap.Recorder(path, world, scene) as recorder:
    for _ in range(180):
        world.step(1 / 60)
        recorder.record()
        energy.append(world.energy())
print(f"{path.name}: {path.stat().st_size / 1e3:.0f} kB for {recorder.steps} steps of {len(world.bodies)} bodies")

# %%
# The energy of the run. What the ball brings goes into flight, spin and height, and friction and inelastic
# impacts take it away; it never grows.

time = np.arange(1, 181) / 60
kinetic, potential = np.array(energy).T
figure, axes = plt.subplots(figsize=(8, 3.5), layout="constrained")
axes.plot(time, kinetic / 1e3, label="kinetic")
axes.plot(time, potential / 1e3, label="potential")
axes.plot(time, (kinetic + potential) / 1e3, "k", linewidth=1, label="total")
axes.set(xlabel="t [s]", ylabel="energy [kJ]")
axes.legend()
plt.show()
assert np.diff(kinetic + potential).max() < 0.01 * energy[0].total

# %%
# Read back, later or elsewhere. ``poses(step)`` reads one step, ``body(name)`` the way of one body. The wall
# is seen from behind the ball.

with ap.Recording(path) as recording:
    built = recording.scene.build()
    figure, panels = plt.subplots(1, 3, figsize=(10, 3.6), sharex=True, sharey=True, layout="constrained")
    for axes, step in zip(panels, (0, 40, 120), strict=True):
        poses = recording.poses(step)
        order = np.argsort(poses.positions[:, 2])
        for row in order:
            shape = built.bodies[int(row)].shape
            if not isinstance(shape, ap.Plane):
                colour = "#e45756" if isinstance(shape, ap.Sphere) else plt.cm.Oranges(0.25 + 0.1 * (row % 5))
                axes.fill(*outline(shape, poses.positions[row], poses.orientations[row]).T, fc=colour, ec="0.3", lw=0.6)
        axes.axhline(0, color="0.4")
        axes.set(title=f"{recording.times[step]:.2f} s", aspect="equal", xlabel="x [m]")
    panels[0].set_ylabel("y [m]")
    plt.show()
    last = recording.poses(-1).positions
    fastest = max((np.ptp(recording.body(row).positions, axis=0).max(), row) for row in range(len(recording.names)))
    print(f"{recording.names[fastest[1]]} came farthest: {fastest[0]:.1f} m")

# %%
# Replay is exact: the recorded poses are the world's, to the last bit.

assert np.array_equal(last, world.bodies.position)
