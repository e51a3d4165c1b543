"""Figures of the chapter on differential equations and integrators."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

import atlasphys as ap


def oscillator(step: float = 0.1, steps: int = 300) -> Figure:
    """Energy of x'' = −x after each step, of three Euler methods, as a share of that at the start."""
    explicit = np.array([[1.0, step], [-step, 1.0]])
    methods = {
        "explicit Euler": explicit,
        "implicit Euler": explicit / (1 + step**2),
        "semi-implicit Euler": np.array([[1 - step**2, step], [-step, 1.0]]),
    }
    figure, axes = plt.subplots(figsize=(7, 3.2), layout="constrained")
    for name, matrix in methods.items():
        states = [np.array([1.0, 0.0])]
        for _ in range(steps):
            states.append(matrix @ states[-1])
        axes.plot(step * np.arange(steps + 1), np.sum(np.square(states), axis=1), label=name)
    axes.set(xlabel="ω t", ylabel="E / E₀", yscale="log")
    axes.legend()
    return figure


def logistic() -> Figure:
    """Explicit Euler on the logistic equation: its error over the step, and what it does for steps that are too long."""

    def euler(h: float, end: float) -> np.ndarray:
        values = [0.1]
        for _ in range(round(end / h)):
            values.append(values[-1] + h * values[-1] * (1 - values[-1]))
        return np.array(values)

    def exact(t: np.ndarray | float) -> np.ndarray | float:
        return 1 / (1 + 9 * np.exp(-t))

    figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.2), layout="constrained")
    t = np.linspace(0, 20, 400)
    left.plot(t, exact(t), "k", linewidth=1, label="solution")
    for h in (0.5, 1.8, 2.3):
        values = euler(h, 20)
        left.plot(h * np.arange(len(values)), values, "o-", markersize=3, linewidth=0.8, label=f"h k = {h}")
    left.set(xlabel="k t", ylabel="P / K")
    left.legend(loc="lower right")
    steps = 4.0 / 2 ** np.arange(3, 10)
    errors = np.array([abs(euler(h, 4.0)[-1] - exact(4.0)) for h in steps])
    right.loglog(steps, errors, "o-", label="error at k t = 4")
    right.loglog(steps, errors[-1] * steps / steps[-1], "--", color="0.5", label="in proportion to h")
    right.set(xlabel="h k", ylabel="error of P / K")
    right.legend()
    return figure


def fall() -> Figure:
    """Free fall in the engine: how far it is from the parabola, for three steps, in solvers of one substep."""
    figure, axes = plt.subplots(figsize=(6, 3.2), layout="constrained")
    for denominator in (30, 60, 120):
        h = 1 / denominator
        world = ap.World(solver=ap.SoftStep(substeps=1), precision="double")
        ball = world.add(ap.Sphere(radius=0.5))
        apart = []
        for n in range(1, denominator + 1):
            world.step(h)
            apart.append(ball.position[1] + 0.5 * 9.81 * (n * h) ** 2)
        time = h * np.arange(1, denominator + 1)
        (line,) = axes.plot(time[::2], 1e3 * np.array(apart)[::2], ".", label=f"h = 1/{denominator} s")
        axes.plot(time, -1e3 * 0.5 * 9.81 * time * h, color=line.get_color(), linewidth=0.8)
    axes.set(xlabel="t [s]", ylabel="engine's fall − parabola [mm]")
    axes.legend(title="lines: −½ g t h")
    return figure


def turning() -> Figure:
    """A free body about its middle axis, in the engine, and the same with explicit Euler on Euler's equation."""
    h, steps = 1 / 60, 900
    world = ap.World(gravity=(0, 0, 0), precision="double", solver=ap.SoftStep(substeps=1))
    plate = world.add(ap.Box(size=(1, 0.1, 0.4)), mass=1, angular_velocity=(0.01, 0.01, 5))
    inertia = np.array(plate.inertia)
    spin = np.array([0.01, 0.01, 5.0])
    kept: dict[str, list[float]] = {"implicit midpoint (the engine)": [], "explicit Euler": []}
    begun = world.energy().kinetic
    for _ in range(steps):
        world.step(h)
        kept["implicit midpoint (the engine)"].append(world.energy().kinetic / begun)
        spin = spin + h * np.cross(inertia * spin, spin) / inertia
        kept["explicit Euler"].append(0.5 * spin @ (inertia * spin) / begun)
    figure, axes = plt.subplots(figsize=(7, 3), layout="constrained")
    for name, energy in kept.items():
        axes.plot(h * np.arange(1, steps + 1), energy, label=name)
    axes.set(xlabel="t [s]", ylabel="E / E₀")
    axes.legend()
    return figure
