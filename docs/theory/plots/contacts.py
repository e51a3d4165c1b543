"""Figures of the chapters on impulses, friction and position error: measured in the engine."""

import math

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

import atlasphys as ap


def sweeps() -> Figure:
    """Projected Gauss–Seidel on a tower of six: the impulse between neighbours after each sweep, and the residual, from a cold start."""
    solver = ap.SequentialImpulse(iterations=60)
    world = ap.World(preset="classic", solver=solver, precision="double", sleeping=False)
    world.add(ap.Plane(normal=(0, 1, 0)))
    for k in range(6):
        world.add(ap.Box(size=(1, 1, 1)), position=(0, 0.5 + k, 0), mass=10)
    figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.4), layout="constrained")
    for k in range(6):
        with ap.explain(world, pair=(k, k + 1)) as story:
            start = world.snapshot()
            world.step(1 / 60)
            world.restore(start)
        total = [sweep.normal.sum() for sweep in story.solver.sweeps if sweep.number >= 0]
        (line,) = left.plot(total, label=f"under cube {k + 1}")
        left.axhline((6 - k) * 10 * 9.81 / 60, color=line.get_color(), linewidth=0.5, linestyle="--")
    left.set(xlabel="sweep", ylabel="impulse [N s]", title="each contact's load is found from below", ylim=(0, None))
    left.legend(fontsize=7, loc="lower right")
    world.trace_solver = True
    for label, steps in (("first step", 1), ("second step, warm started", 1)):
        world.run(seconds=steps / 60)
        trace = world.solver_trace
        chosen = trace.sweep >= 0
        right.semilogy(trace.sweep[chosen], np.maximum(trace.complementarity[chosen], 1e-18), label=label)
    right.set(xlabel="sweep", ylabel="residual |min(w/k, λ)| [N s]", title="linear convergence")
    right.legend(fontsize=7)
    return figure


def cone() -> Figure:
    """Friction and normal impulse of a block on slopes up to 50°, measured."""
    mu, g = 0.5, 9.81
    points = []
    for degrees in np.arange(0, 51, 2.5):
        angle = math.radians(degrees)
        world = ap.World(gravity=(g * math.sin(angle), -g * math.cos(angle), 0), sleeping=False)
        world.add(ap.Plane(normal=(0, 1, 0)), friction=mu)
        world.add(ap.Box(size=(1, 0.3, 1)), position=(0, 0.15, 0), friction=mu, mass=1)
        world.run(seconds=0.8)
        contacts = world.contacts
        rubbed = np.linalg.norm(contacts.friction_impulse.sum(axis=0))
        points.append((degrees, 60 * contacts.normal_impulse.sum(), 60 * rubbed))
    slope, pushed, rubbed = np.array(points).T
    figure, axes = plt.subplots(figsize=(5.5, 3.6), layout="constrained")
    axes.fill_between([0, 10.5], 0, [0, mu * 10.5], color="C2", alpha=0.15)
    axes.annotate("the cone |λₜ| ≤ μ λₙ", (7.2, 1.2), color="C2", ha="center")
    colours = axes.scatter(pushed, rubbed, c=slope, cmap="viridis", s=22, zorder=3)
    figure.colorbar(colours, label="slope [°]")
    axes.set(xlabel="normal force [N]", ylabel="friction [N]", xlim=(0, 10.5), ylim=(0, 5.5))
    return figure


def corrections() -> Figure:
    """A cube that begins 10 cm in the ground, with each position correction: its overlap and its speed."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.2), layout="constrained")
    for name in ("projection", "baumgarte"):
        world = ap.World(preset="classic", position_correction=name)
        world.add(ap.Plane(normal=(0, 1, 0)))
        cube = world.add(ap.Box(size=(1, 1, 1)), position=(0, 0.4, 0))
        overlap, speed = [], []
        for _ in range(40):
            world.step(1 / 60)
            overlap.append(100 * (0.5 - cube.position[1]))
            speed.append(cube.velocity[1])
        left.plot(range(1, 41), overlap, ".-", label=name)
        right.plot(range(1, 41), speed, ".-", label=name)
    left.axhline(0, color="0.5", linewidth=0.8)
    left.set(xlabel="step", ylabel="overlap [cm]")
    right.set(xlabel="step", ylabel="speed upward [m/s]")
    left.legend()
    return figure


def bounces() -> Figure:
    """Apexes of a bouncing ball in the engine against the closed form."""
    figure, axes = plt.subplots(figsize=(6, 3.2), layout="constrained")
    for restitution in (0.9, 0.75, 0.5):
        world = ap.World(restitution_threshold=0.0, sleeping=False)
        world.add(ap.Plane(normal=(0, 1, 0)))
        ball = world.add(ap.Sphere(radius=0.1), position=(0, 2.1, 0), restitution=restitution)
        heights = []
        while world.time < 6:
            world.step(1 / 240)
            heights.append(ball.position[1] - 0.1)
        height = np.array(heights)
        apexes = height[1:-1][(height[1:-1] > height[:-2]) & (height[1:-1] >= height[2:])]
        apexes = apexes[apexes > 1e-3]
        count = np.arange(1, len(apexes) + 1)
        (line,) = axes.semilogy(count, 2 * restitution ** (2 * count), linewidth=0.9)
        axes.semilogy(count, apexes, "o", markersize=4, color=line.get_color(), label=f"e = {restitution}")
    axes.set(xlabel="bounce i", ylabel="apex [m]", xlim=(0.5, 14))
    axes.legend(title="lines: e²ⁱ h₀")
    return figure
