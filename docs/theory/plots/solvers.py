"""Figures of the chapters on soft contacts, XPBD and AVBD: measured in the engine."""

import math

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

import atlasphys as ap


def _tower(height: int, solver: object, seconds: float = 2.0) -> float:
    """How much lower than its cubes' heights together the top of a tower stands [m]."""
    world = ap.load_scene("tower", height=height).build(solver=solver)
    world.run(seconds=seconds)
    return height - 0.5 - float(world.bodies.position[-1, 1])


def _sunk(ratio: float, solver: object, seconds: float = 2.0) -> float:
    """How far a load of so many times the mass of what bears it has sunk [m]."""
    world = ap.load_scene("heavy_on_light", ratio=ratio).build(solver=solver)
    world.run(seconds=seconds)
    return 1.5 - float(world.bodies["heavy"].position[1])


def sag() -> Figure:
    """A ball on a soft contact: how it settles, and how deep for contacts of several frequencies, with 16 substeps."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.2), layout="constrained")
    frequencies = np.array([10.0, 20.0, 34.0, 60.0])
    depths = []
    for frequency in frequencies:
        solver = ap.SoftStep(substeps=16, contact_frequency=float(frequency), contact_recycling=False)
        world = ap.World(solver=solver, sleeping=False, precision="double")
        world.add(ap.Plane(normal=(0, 1, 0)))
        ball = world.add(ap.Sphere(radius=0.5), position=(0, 0.5, 0))
        overlap = []
        for _ in range(240):
            world.step(1 / 60)
            overlap.append(1e3 * (0.5 - ball.position[1]))
        left.plot(np.arange(1, 241) / 60, overlap, label=f"{frequency:.0f} Hz")
        depths.append(overlap[-1])
    left.set(xlabel="t [s]", ylabel="overlap [mm]")
    left.legend()
    dense = np.linspace(8, 65, 100)
    right.loglog(dense, 1e3 * 9.81 / (2 * math.pi * dense) ** 2, color="0.5", label="g / ω²")
    right.loglog(frequencies, depths, "o", label="measured")
    right.set_xticks(frequencies, labels=[f"{frequency:.0f}" for frequency in frequencies])
    right.minorticks_off()
    right.set(xlabel="contact frequency [Hz]", ylabel="overlap at rest [mm]")
    right.legend()
    return figure


def substeps() -> Figure:
    """The error of a tower of ten for the same number of visits to each contact: as sweeps of one step, and as substeps of one sweep."""
    counts = np.array([1, 2, 4, 8, 16, 32])
    figure, axes = plt.subplots(figsize=(6, 3.4), layout="constrained")
    cold = {"warm_starting": False}
    cases = {
        "sweeps of one step (sequential_impulse), no warm start": [
            _tower(10, ap.SequentialImpulse(iterations=int(n), **cold)) for n in counts
        ],
        "substeps of one sweep (soft_step), no warm start": [
            _tower(10, ap.SoftStep(substeps=int(n), **cold)) for n in counts
        ],
        "substeps of one sweep (soft_step)": [_tower(10, ap.SoftStep(substeps=int(n))) for n in counts],
    }
    for label, sunk in cases.items():
        axes.loglog(counts, np.maximum(sunk, 1e-5), "o-", label=label)
    axes.set(xlabel="sweeps or substeps in a step of 1/60 s", ylabel="top of the tower is too low by [m]")
    axes.set_xticks(counts, labels=[str(n) for n in counts])
    axes.minorticks_off()
    axes.legend(fontsize=7)
    return figure


def xpbd_substeps() -> Figure:
    """XPBD: how far a load sinks over the number of substeps."""
    counts = np.array([2, 4, 8, 15, 30, 60])
    figure, axes = plt.subplots(figsize=(6, 3.2), layout="constrained")
    for ratio in (1, 10, 100):
        sunk = [max(_sunk(ratio, ap.XPBD(substeps=int(n))), 1e-6) for n in counts]
        axes.loglog(counts, 1e3 * np.array(sunk), "o-", label=f"{ratio} : 1")
    axes.set(xlabel="substeps in a step of 1/60 s", ylabel="load has sunk by [mm]")
    axes.set_xticks(counts, labels=[str(n) for n in counts])
    axes.minorticks_off()
    axes.legend(title="load : bearer")
    return figure


def avbd_loads() -> Figure:
    """AVBD beside the other solvers under a load, and how its number of iterations tells."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.4), layout="constrained")
    ratios = (1, 10, 100, 1000)
    for solver in ("soft_step", "sequential_impulse", "xpbd", "avbd"):
        left.loglog(ratios, [1e3 * max(_sunk(ratio, solver), 1e-6) for ratio in ratios], "o-", label=solver)
    left.set(xlabel="mass of the load / of its bearer", ylabel="sunk after 2 s [mm]")
    left.legend(fontsize=7)
    for iterations in (2, 5, 20):
        world = ap.load_scene("heavy_on_light", ratio=100.0).build(solver=ap.AVBD(iterations=iterations))
        heavy = world.bodies["heavy"]
        sunk = []
        for _ in range(60):
            world.step(1 / 60)
            sunk.append(1e3 * max(1.5 - heavy.position[1], 1e-6))
        right.semilogy(np.arange(1, 61), sunk, label=f"{iterations} iterations")
    right.set(xlabel="step", ylabel="sunk [mm]", title="100 : 1")
    right.legend(fontsize=7)
    return figure
