"""How good joints are: ``python benchmarks/joints.py`` writes ``joints.csv`` beside this file and ``docs/figures/ragdolls.png``.

* The benchmark's scenes with links in each engine: greatest stretch at every tenth of a second, and energy gained after 2, 5 and 10 s.
* Ten capsules in a chain, thrown with velocities at random where there is no gravity: what is left of momentum, angular momentum and energy after
  ten seconds.
* A heavy ball that hangs on a chain of twenty links: greatest stretch, and force of the upper joint against the weight.
* A pile of 100 ragdolls for ten seconds: energy and greatest stretch.
"""

from __future__ import annotations

import csv
import math
import random
from pathlib import Path
from typing import Any

import numpy as np

import atlasphys as ap
from atlasphys.bench.peers import engine
from atlasphys.bench.scenes import make
from atlasphys.bench.swing import energy_error, stretch

STIFF = ap.SoftStep(substeps=16, joint_frequency=300, joint_damping=2)
SOLVERS: dict[str, Any] = {
    "soft_step": "soft_step",
    "soft_step, 16 substeps, 300 Hz": STIFF,
    "sequential_impulse": "sequential_impulse",
    "xpbd": "xpbd",
    "avbd": "avbd",
}
HERE = Path(__file__).parent


def swinging(name: str, against: str) -> dict[str, float]:
    """Stretch and energy of a benchmark's scene over ten seconds."""
    scene = make(name)
    run = engine(against)(scene, 1, None)
    found, widest = {}, []
    for tenth in range(1, 101):
        run.run(5)
        before = run.poses()
        run.run(1)
        after = run.poses()
        widest.append(1e3 * float(stretch(scene, *after).max()))
        if tenth in (20, 50, 100):
            found[f"energy gained after {tenth // 10} s [% of weight × length]"] = 100 * energy_error(
                scene, before, after
            )
    return {"greatest stretch [mm]": max(widest), "its median over time [mm]": float(np.median(widest))} | found


def gaps(world: ap.World) -> list[float]:
    """Distance of the anchors of each joint [m]."""
    return [math.dist(*joint.anchors) for joint in world.joints]


def floating(solver: Any, kind: str) -> dict[str, float]:
    """What a thrown chain keeps."""
    number = random.Random(5).random
    world = ap.World(solver=solver, gravity=(0, 0, 0), sleeping=False)
    above = None
    for k in range(10):
        speeds = [[2 * number() - 1 for _ in range(3)] for _ in range(2)]
        shape = ap.Capsule(radius=0.1, length=0.3)
        link = world.add(
            shape, position=(0, -0.5 * k, 0), mass=1, velocity=speeds[0], angular_velocity=speeds[1], mask=0
        )
        if above is not None:
            if kind == "ball":
                world.join(ap.Ball(above, link, anchor=(0, -0.5 * k + 0.25, 0)))
            elif kind == "hinge":
                world.join(
                    ap.Hinge(above, link, anchor=(0, -0.5 * k + 0.25, 0), axis=(0, 0, 1) if k % 2 else (1, 0, 0))
                )
            else:
                world.join(ap.Distance(above, link, anchor_a=(0, -0.1, 0), anchor_b=(0, 0.1, 0)))
        above = link
    world.run(1)  # velocities at random do not fit the joints: what they take away at once is not counted
    start = world.momentum(), world.angular_momentum(), world.energy().kinetic
    world.run(10)
    size = float(np.sqrt((start[1] ** 2).sum()))
    scale = float((world.bodies.mass * np.sqrt((world.bodies.velocity**2).sum(axis=1))).sum())
    return {
        "momentum, change / Σ m v": float(np.abs(world.momentum() - start[0]).max()) / scale,
        "angular momentum, relative change": float(np.sqrt(((world.angular_momentum() - start[1]) ** 2).sum())) / size,
        "kinetic energy, relative change": world.energy().kinetic / start[2] - 1,
    }


def hanging(solver: Any, ratio: float) -> dict[str, float]:
    """A heavy ball at rest on a light chain."""
    world = ap.World(solver=solver, sleeping=False)
    above = None
    for k in range(20):
        link = world.add(ap.Capsule(radius=0.1, length=0.3), position=(0, -0.25 - 0.5 * k, 0), mass=1)
        world.join(ap.Ball(above, link, anchor=(0, -0.5 * k, 0)))
        above = link
    ball = world.add(ap.Sphere(radius=0.5), position=(0, -10.5, 0), mass=ratio)
    world.join(ap.Ball(above, ball, anchor=(0, -10, 0)))
    world.run(10)
    widest, forces = 0.0, []
    for _ in range(60):
        world.step(1 / 60)
        widest = max(widest, *gaps(world))
        forces.append(float(world.joints[0].reaction_force[1]))
    weight = 9.81 * (20 + ratio)
    return {
        "stretch [mm]": 1e3 * widest,
        "least force / weight": min(forces) / weight,
        "greatest": max(forces) / weight,
    }


def ragdolls(count: int) -> list[tuple[float, float, float, float]]:
    """Time, energy [kJ], greatest stretch [mm] and greatest speed [m/s] of a pile, every tenth of a second."""
    world = ap.load_scene("ragdoll_pile", count=count).build()
    rows = []
    for _ in range(100):
        world.run(0.1)
        fastest = float(np.sqrt((world.bodies.velocity**2).sum(axis=1)).max())
        rows.append((world.time, 1e-3 * world.energy().total, 1e3 * max(gaps(world)), fastest))
    return rows


def draw(rows: list[tuple[float, float, float, float]], path: Path) -> None:
    """Energy, stretch and speed over time."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as pyplot

    figure, panels = pyplot.subplots(1, 3, figsize=(10, 3))
    times, *columns = zip(*rows, strict=True)
    for axes, column, label in zip(
        panels, columns, ("energy [kJ]", "greatest stretch [mm]", "greatest speed [m/s]"), strict=True
    ):
        axes.plot(times, column)
        axes.set_xlabel("time [s]")
        axes.set_ylabel(label)
        axes.grid(alpha=0.3)
    figure.suptitle("ragdoll_pile, 100 figures")
    figure.tight_layout()
    figure.savefig(path, dpi=120)


def main() -> None:
    """Measure everything."""
    rows = []

    def note(what: str, who: str, found: dict[str, float]) -> None:
        for quantity, value in found.items():
            rows.append({"what": what, "who": who, "quantity": quantity, "value": float(f"{value:.4g}")})
            print(*rows[-1].values(), sep="; ", flush=True)

    for scene in ("chains_50x20", "joint_grid"):
        for against in ("atlasphys", "rapier", "box3d"):
            note(scene, against, swinging(scene, against))
    for name, solver in SOLVERS.items():
        for kind in ("ball", "hinge", "distance"):
            note(f"floating chain, {kind}", name, floating(solver, kind))
        for ratio in (10, 100):
            note(f"heavy ball {ratio} : 1", name, hanging(solver, ratio))
    pile = ragdolls(100)
    fell = [row[1:] for row in pile]
    note(
        "100 ragdolls",
        "soft_step",
        {"greatest stretch [mm]": max(row[1] for row in fell), "greatest speed after 10 s [m/s]": fell[-1][2]},
    )
    draw(pile, HERE.parent / "docs" / "figures" / "ragdolls.png")
    with (HERE / "joints.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main()
