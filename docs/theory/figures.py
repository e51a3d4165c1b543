"""Figures of the theory book: ``python docs/theory/figures.py`` writes them beside it. Needs matplotlib."""

from pathlib import Path

import numpy as np

FOLDER = Path(__file__).parent / "figures"


def oscillator(step: float = 0.1, steps: int = 300) -> dict[str, np.ndarray]:
    """Energy of x'' = −x after each step, of three Euler methods, as a share of that at the start."""
    explicit = np.array([[1.0, step], [-step, 1.0]])
    methods = {
        "explicit Euler": explicit,
        "implicit Euler": explicit / (1 + step**2),
        "semi-implicit Euler": np.array([[1 - step**2, step], [-step, 1.0]]),
    }
    energies = {}
    for name, matrix in methods.items():
        states = [np.array([1.0, 0.0])]
        for _ in range(steps):
            states.append(matrix @ states[-1])
        energies[name] = np.sum(np.square(states), axis=1)
    return energies


def main() -> None:
    """Draw all figures."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    FOLDER.mkdir(exist_ok=True)
    figure, axes = plt.subplots(figsize=(7, 3.2), layout="constrained")
    for name, energy in oscillator().items():
        axes.plot(0.1 * np.arange(len(energy)), energy, label=name)
    axes.set(xlabel="ω t", ylabel="E / E₀", yscale="log")
    axes.legend()
    figure.savefig(FOLDER / "oscillator.png", dpi=130)


if __name__ == "__main__":
    main()
