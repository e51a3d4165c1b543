r"""
Bounces, and how high they are
==============================

A ball that falls from a height :math:`H` and bounces with coefficient of restitution :math:`e` rises to
:math:`e^2 H`, then to :math:`e^4 H`, and after :math:`n` bounces to :math:`e^{2n} H`. Does the engine's?
"""

import matplotlib.pyplot as plt
import numpy as np

import atlasphys as ap

HEIGHT = 2.0

# %%
# Bodies bounce only if they come faster than ``restitution_threshold``, 1 m/s unless told otherwise: without
# it nothing that can bounce would ever come to rest. Here it is set to zero. The ball's coefficient is that
# of the contact, for ``restitution_combine`` is ``"max"`` and the ground's is zero.

figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4), layout="constrained")
for restitution in (0.9, 0.75, 0.5):
    world = ap.World(restitution_threshold=0.0, sleeping=False)
    world.add(ap.Plane(normal=(0, 1, 0)))
    ball = world.add(ap.Sphere(radius=0.1), position=(0, HEIGHT + 0.1, 0), restitution=restitution)
    times, heights = [0.0], [HEIGHT]
    while world.time < 5:
        world.step(1 / 240)
        times.append(world.time)
        heights.append(ball.position[1] - 0.1)
    heights = np.array(heights)
    (line,) = left.plot(times, heights, label=f"e = {restitution}")

    # Apexes: higher than the states before and after.
    apexes = heights[1:-1][(heights[1:-1] > heights[:-2]) & (heights[1:-1] >= heights[2:])]
    apexes = apexes[apexes > 0.01]
    bounce = np.arange(1, len(apexes) + 1)
    expected = HEIGHT * restitution ** (2 * bounce)
    right.semilogy(bounce, expected, color=line.get_color(), linewidth=1)
    right.semilogy(bounce, apexes, "o", color=line.get_color(), markersize=4)
    print(f"e = {restitution}: {len(apexes)} bounces, worst {100 * np.max(np.abs(apexes / expected - 1)):.2f} % off")
    assert np.allclose(apexes, expected, rtol=0.03)

left.set(xlabel="t [s]", ylabel="height [m]")
left.legend()
right.set(xlabel="bounce n", ylabel="apex [m]", title="dots: the engine; lines: e²ⁿ H", xlim=(0, 15))
plt.show()

# %%
# Heights are right to a few thousandths although an impact nearly always falls *inside* a step. The solver
# works out how fast the ball is at the moment of the impact, and with which speed the step has to end so that
# the energy fits (:doc:`/theory/impulses`, "When within the step?").
