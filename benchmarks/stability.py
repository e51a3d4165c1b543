"""Why stacks lean, what keeps them up and what that costs: the tables and figures of docs/soft_step.md.

Run: ``python benchmarks/stability.py`` (needs matplotlib; a few minutes). It prints what it measures and writes ``benchmarks/stability.csv``,
``docs/figures/buckling.png`` and ``docs/figures/recycling.png``. Simulated quantities only, no times: they are the same on every machine.
"""

import csv
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import atlasphys as ap
from atlasphys.engine import run

HERE = Path(__file__).parent
FIGURES = HERE.parent / "docs" / "figures"
DT = 1 / 60
G = 9.81

FRESH = ap.SoftStep(contact_recycling=False)
STIFF = ap.SoftStep(contact_recycling=False, substeps=32, contact_frequency=240.0)
DEFAULT = ap.SoftStep()


def recycling(turn: float, twist: float, **settings: float) -> ap.SoftStep:
    """Settings with tolerances in degrees."""
    return ap.SoftStep(recycle_turn=math.radians(turn), recycle_twist=math.radians(twist), **settings)


def empty(settings: ap.SoftStep, g: float = G) -> ap.World:
    """A world with a ground, without sleep."""
    world = ap.World(preset="default", solver=settings, gravity=(0, -g, 0), sleeping=False)
    world.add(ap.Plane())
    return world


def tower(count: int, settings: ap.SoftStep, g: float = G, size: float = 1.0) -> ap.World:
    """Cubes on each other."""
    world = empty(settings, g)
    for k in range(count):
        world.add(ap.Box(size=(size, size, size)), position=(0, (k + 0.5) * size, 0))
    return world


def pyramid(base: int, settings: ap.SoftStep) -> ap.World:
    """Cubes, a tenth of their width apart side by side."""
    world = empty(settings)
    for row in range(base):
        for k in range(base - row):
            world.add(ap.Box(size=(1, 1, 1)), position=(1.1 * (k - 0.5 * (base - row - 1)), row + 0.5, 0))
    return world


def leans(world: ap.World, times: list[float]) -> list[float]:
    """Greatest sideways displacement of a body at each of the times [m]."""
    start, found, done = world.bodies.position.copy(), [], 0.0
    for time in times:
        world.run(seconds=time - done, dt=DT)
        done = time
        found.append(float(np.abs((world.bodies.position - start)[:, [0, 2]]).max()))
    return found


def bisect(happens: Callable[[float], bool], low: float, high: float, within: float) -> float:
    """The least value for which something happens."""
    while high - low > within:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if happens(middle) else (middle, high)
    return 0.5 * (low + high)


# The buckling law -----------------------------------------------------------------------------------------------------


def critical_height(frequency: float, g: float) -> float:
    """Cubes of 1 m that soft contacts carry: N³ = 7.837 / 8 · ω² a / g."""
    return float((7.837 / 8 * (2 * math.pi * frequency) ** 2 / g) ** (1 / 3))


def tallest(frequency: float, g: float) -> int:
    """The tallest tower that leans by less than 2 cm at 20 s, with fresh contacts."""
    settings = ap.SoftStep(
        contact_recycling=False, contact_frequency=frequency, substeps=max(4, round(frequency / 7.5))
    )
    count = max(2, int(0.7 * critical_height(frequency, g)))
    while leans(tower(count + 1, settings, g), [20.0])[0] < 0.02:
        count += 1
    return count


# The price of recycling -----------------------------------------------------------------------------------------------


def turning(world: ap.World, rate: float) -> None:
    """Turn all bodies but the ground rigidly about the lower edge of the first, clockwise [rad/s]."""
    arms = world.bodies.position[1:] - np.array([0.5, 0.0, 0.0])
    world.bodies.velocity[1:] = np.cross((0.0, 0.0, -rate), arms)
    world.bodies.angular_velocity[1:] = (0.0, 0.0, -rate)


def toppling_spin(count: int, settings: ap.SoftStep) -> float:
    """The least rigid spin about its lower edge [rad/s] that topples a tower."""

    def topples(rate: float) -> bool:
        world = tower(count, settings)
        turning(world, rate)
        world.run(seconds=10, dt=DT)
        return bool(world.bodies.position[-1, 1] < count - 1.5 or world.bodies.position[-1, 0] > 0.7)

    rigid = rigid_toppling_spin(count)
    return bisect(topples, 0.7 * rigid, 2 * rigid, 0.005 * rigid)


def rigid_toppling_spin(count: int) -> float:
    """½ I ω² = m g (r − N/2) about the edge."""
    r = math.sqrt(0.25 + 0.25 * count**2)
    return math.sqrt(2 * G * (r - 0.5 * count) / ((1 + count**2) / 12 + r * r))


def on_platform(height: float, friction: float, settings: ap.SoftStep, start: float, gives_way: str) -> float:
    """The slope [degrees] at which a block slips by 1 mm, or tips by 1°, on a slab that lies on a platform which turns by 0.2 degrees a second.

    (Contacts with a kinematic body that turns are never recycled, hence the slab.)
    """
    world = ap.World(preset="default", solver=settings, sleeping=False, friction_combine="min")
    angle = math.radians(start)
    turned, up = (math.cos(angle / 2), 0, 0, math.sin(angle / 2)), np.array([-math.sin(angle), math.cos(angle), 0])
    platform = world.add(ap.Box(size=(20, 1, 4)), orientation=turned, kind="kinematic", friction=2)
    world.add(ap.Box(size=(4, 0.5, 4)), position=0.75 * up, orientation=turned, friction=2)
    block = world.add(
        ap.Box(size=(1, height, 1)), position=(1 + 0.5 * height) * up, orientation=turned, friction=friction
    )
    platform.angular_velocity = (0, 0, math.radians(0.2))

    def state() -> tuple[float, float, float]:
        slope, own = (2 * math.atan2(body.orientation[3], body.orientation[0]) for body in (platform, block))
        apart = block.position - platform.position
        along = apart[0] * math.cos(slope) + apart[1] * math.sin(slope)
        return math.degrees(slope), float(along), math.degrees(own - slope)

    world.run(seconds=0.25, dt=DT)
    began = state()[1]
    for _ in range(1000):
        world.run(seconds=0.05, dt=DT)
        slope, along, tipped = state()
        if (abs(along - began) > 1e-3) if gives_way == "slips" else (abs(tipped) > 1):
            return slope
    return math.nan


def fall_from_edge(settings: ap.SoftStep) -> float:
    """Time [s] for a cube to fall from its edge: from 45.5° to 60°."""
    world = empty(settings)
    angle = math.radians(45.5)
    height = 0.5 * (math.sin(angle) + math.cos(angle))
    turned = (math.cos(angle / 2), 0, 0, math.sin(angle / 2))
    cube = world.add(ap.Box(size=(1, 1, 1)), position=(0, height, 0), orientation=turned, friction=1)
    for k in range(1, 600):
        world.step(DT)
        if 2 * math.atan2(cube.orientation[3], cube.orientation[0]) > math.radians(60):
            return k * DT
    return math.nan


def kept_speed(settings: ap.SoftStep) -> float:
    """Share of its speed that a ball which rolls at 0.3 m/s keeps for 10 s."""
    world = empty(settings)
    ball = world.add(ap.Sphere(radius=0.5), position=(0, 0.5, 0), velocity=(0.3, 0, 0), angular_velocity=(0, 0, -0.6))
    world.run(seconds=10, dt=DT)
    return float(ball.velocity[0]) / 0.3


# The use of recycling -------------------------------------------------------------------------------------------------


def hardest(stands: Callable[[float], bool], values: list[float]) -> float:
    """The last of rising values at which it stands, those before it included."""
    last = 0.0
    for value in values:
        if not stands(value):
            break
        last = value
    return last


def survives_shot(count: int, settings: ap.SoftStep) -> float:
    """Greatest speed [m/s] of a ball of 65 kg that hits a tower in its middle and leaves it standing for 15 s."""

    def stands(speed: float) -> bool:
        world = tower(count, settings)
        world.add(ap.Sphere(radius=0.25), position=(-1, count // 2 + 0.5, 0.05), velocity=(speed, 0, 0))
        world.run(seconds=15, dt=DT)
        return bool(world.bodies.position[count, 1] > count - 1)

    return hardest(stands, [1, 2, 3, 5, 8, 12, 20, 30, 50])


def survives_rocking(count: int, settings: ap.SoftStep) -> float:
    """Greatest share of the toppling spin with which a tower rocks and still stands after 20 s."""

    def stands(share: float) -> bool:
        world = tower(count, settings)
        turning(world, share * rigid_toppling_spin(count))
        world.run(seconds=20, dt=DT)
        return bool(world.bodies.position[-1, 1] > count - 1)

    return hardest(stands, [0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9])


CHOICES: list[tuple[str, ap.SoftStep]] = [
    ("fresh, 240 Hz, 32 substeps", STIFF),
    ("fresh", FRESH),
    ("0.5°, 0.5°", recycling(0.5, 0.5)),
    ("1°, 0.3°", recycling(1, 0.3)),
    ("1°, 1°", recycling(1, 1)),
    ("1.5°, 1° (default)", DEFAULT),
    ("2°, 1°", recycling(2, 1)),
    ("2°, 2°", recycling(2, 2)),
    ("5°, 1°", recycling(5, 1)),
    ("5°, 5°", recycling(5, 5)),
    ("10°, 10°", recycling(10, 10)),
]


def price(settings: ap.SoftStep) -> dict[str, float]:
    """What frozen arms cost, and what they hold up."""
    tips = [on_platform(2.0, 1.0, settings, start, "tips") for start in (24.0, 24.3, 24.6, 25.0)]
    return {
        "toppling spin of 8 cubes [rad/s]": toppling_spin(8, settings),
        "toppling spin of a cube [rad/s]": toppling_spin(1, settings),
        "block on platform slips at [°]": on_platform(1.0, 0.5, settings, 24.0, "slips"),
        "block on platform tips at, latest of four [°]": max(tips),
        "cube falls from its edge in [s]": fall_from_edge(settings),
        "speed kept by a rolling ball": kept_speed(settings),
        "tower of 20 rocks at [share of toppling spin]": survives_rocking(20, settings),
        "tower of 20 survives shot at [m/s]": survives_shot(20, settings),
        "tower of 50 survives shot at [m/s]": survives_shot(50, settings),
    }


def ledge(settings: ap.SoftStep) -> float:
    """How far beyond the ledge [m] the centre of a cube is that glides over it at 0.2 m/s, when it has tipped by 1°."""
    world = ap.World(preset="default", solver=settings, sleeping=False)
    world.add(ap.Box(size=(4, 1, 4)), position=(-2, -0.5, 0), kind="static", friction=0)
    cube = world.add(ap.Box(size=(1, 1, 1)), position=(-0.1, 0.5, 0), velocity=(0.2, 0, 0), friction=0)
    for _ in range(600):
        world.step(DT)
        if abs(2 * cube.orientation[3]) > math.radians(1):
            return float(cube.position[0])
    return math.nan


def pile_energy(settings: ap.SoftStep, seed: int) -> float:
    """Kinetic energy [J] that 1000 cubes of 512 kg still have 20 s after they were dropped."""
    from atlasphys.bench.peers.atlasphys import add_items
    from atlasphys.bench.scenes import Box, _pile

    scene = _pile("pile", [Box((0.4, 0.4, 0.4))] * 1000, 1.45, seed=seed)
    world = empty(settings)
    add_items(world, scene.walls, kind="static")
    add_items(world, scene.bodies)
    world.run(seconds=20, dt=DT)
    return world.energy().kinetic


def jitter(share: float, stiffening: float) -> float:
    """Greatest kinetic energy [J] of pyramids of base 5, 7 and 15 after 20 s, with contacts of a frequency of ``share`` of the substeps a second.

    ``stiffening``: factor on it where a body is static. The engine's own limits are lifted.
    """
    kept = run.MOST_FREQUENCY, run.STATIC_STIFFENING
    run.MOST_FREQUENCY, run.STATIC_STIFFENING = 1.0, stiffening
    try:
        worlds = [pyramid(base, ap.SoftStep(contact_frequency=240 * share)) for base in (5, 7, 15)]
        for world in worlds:
            world.run(seconds=20, dt=DT)
    finally:
        run.MOST_FREQUENCY, run.STATIC_STIFFENING = kept
    return max(world.energy().kinetic for world in worlds)


def main() -> None:
    """Measure, print, write, draw."""
    rows: list[tuple[str, str, str, float]] = []

    def note(table: str, case: str, quantity: str, value: float) -> None:
        rows.append((table, case, quantity, value))
        print(f"{table:10} {case:32} {quantity:50} {value:.4g}", flush=True)

    for frequency, g in ((15, G), (30, 10 * G), (30, G), (30, G / 4), (30, G / 8), (45, G), (60, G)):
        case = f"{frequency} Hz, {g / G:g} g"
        note("buckling", case, "predicted", critical_height(frequency, g))
        note("buckling", case, "tallest that stands 20 s", tallest(frequency, g))
    scenes: list[tuple[str, Callable[[ap.SoftStep], ap.World]]] = [
        ("tower of 20", lambda s: tower(20, s)),
        ("tower of 50", lambda s: tower(50, s)),
        ("tower of 100", lambda s: tower(100, s)),
        ("pyramid of base 40", lambda s: pyramid(40, s)),
    ]
    kinds = {
        "fresh": FRESH,
        "fresh, 240 Hz, 32 substeps": STIFF,
        "default": DEFAULT,
        "60 Hz, 8 substeps": ap.SoftStep(contact_frequency=60.0, substeps=8),
    }
    for scene, build in scenes:
        for kind, settings in kinds.items():
            if settings is STIFF and scene.startswith("pyramid"):
                continue
            for time, lean in zip((10, 20, 60), leans(build(settings), [10.0, 20.0, 60.0]), strict=True):
                note("lean", f"{scene}, {kind}", f"lean at {time} s [m]", lean)
    for size in (10.0, 1.0, 0.1, 0.02):
        for count in (5, 10, 20):
            note(
                "size",
                f"{count} cubes of {size:g} m",
                "lean at 20 s / size",
                leans(tower(count, DEFAULT, size=size), [20.0])[0] / size,
            )
    for turn in (0.5, 1.0, 1.5, 2.0):
        settings = [recycling(turn, min(turn, 1.0), contact_frequency=30 + 0.5 * k) for k in range(13)]
        fell = sum(leans(tower(100, one), [10.0])[0] > 0.5 for one in settings)
        note("turn", f"{turn:g}°", "of 13 towers of 100, 30 to 36 Hz, fell in 10 s", fell)
    for twist in (0.3, 1.0, 2.0):
        for seed in (1, 2, 3):
            note(
                "twist",
                f"1.5°, {twist:g}°",
                f"energy of pile {seed} at 20 s [J]",
                pile_energy(recycling(1.5, twist), seed),
            )
    for slip in (0.001, 0.005, 0.02, 0.05, 0.2):
        note("slip", f"{slip:g} m", "cube tips beyond the ledge by [m]", ledge(recycling(1.5, 1, recycle_slip=slip)))
    note("slip", "fresh", "cube tips beyond the ledge by [m]", ledge(FRESH))
    for stiffening in (1.0, 2.0):
        for hertz in (28, 30, 32, 34, 36, 40, 45, 60):
            note(
                "jitter", f"static × {stiffening:g}, {hertz} Hz", "energy at 20 s [J]", jitter(hertz / 240, stiffening)
            )
    note("price", "rigid theory", "toppling spin of 8 cubes [rad/s]", rigid_toppling_spin(8))
    note("price", "rigid theory", "toppling spin of a cube [rad/s]", rigid_toppling_spin(1))
    for name, settings in CHOICES:
        for quantity, value in price(settings).items():
            note("price", name, quantity, value)
    times = [0.5 * k for k in range(1, 121)]
    curves = {
        f"{count} cubes, {kind}": leans(tower(count, settings), times)
        for count, kind, settings in (
            (20, "fresh", FRESH),
            (20, "recycled", DEFAULT),
            (50, "fresh", FRESH),
            (50, "recycled", DEFAULT),
            (20, "fresh, 240 Hz", STIFF),
        )
    }
    for name, curve in curves.items():
        for time, lean in zip(times, curve, strict=True):
            rows.append(("curve", name, f"lean at {time:g} s [m]", lean))
    with (HERE / "stability.csv").open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("table", "case", "quantity", "value"))
        writer.writerows((*row[:3], f"{row[3]:.5g}") for row in rows)
    draw(rows, times, curves)


def draw(rows: list[tuple[str, str, str, float]], times: list[float], curves: dict[str, list[float]]) -> None:
    """The two figures."""
    from matplotlib import pyplot

    values: dict[tuple[str, str], float] = {(case, quantity): value for _, case, quantity, value in rows}
    FIGURES.mkdir(exist_ok=True)
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(11, 4), layout="constrained")
    predicted = [value for table, _, quantity, value in rows if table == "buckling" and quantity == "predicted"]
    stood = [value for table, _, quantity, value in rows if table == "buckling" and quantity != "predicted"]
    line = np.array([0.0, 1.1 * max(predicted)])
    left.plot(line, line, color="0.6", label="N³ = 0.98 ω² a / g")
    left.plot(predicted, stood, "o", label="tallest tower that stood 20 s")
    left.set(xlabel="predicted number of cubes", ylabel="measured", title="Fresh contacts buckle")
    left.legend()
    styles: list[dict[str, Any]] = [
        {"color": "C3"},
        {"color": "C0"},
        {"color": "C3", "linestyle": "--"},
        {"color": "C0", "linestyle": "--"},
        {"color": "C2"},
    ]
    for (name, curve), style in zip(curves.items(), styles, strict=True):
        right.semilogy(times, curve, label=name, **style)
    right.set(xlabel="time [s]", ylabel="greatest lean [m]", title="Towers at 34 Hz")
    right.legend(fontsize="small", loc="upper left", bbox_to_anchor=(1, 1))
    figure.savefig(FIGURES / "buckling.png", dpi=110)

    figure, (left, right) = pyplot.subplots(1, 2, figsize=(11, 4), layout="constrained")
    shown = [name for name, _ in CHOICES if name != "fresh, 240 Hz, 32 substeps"]
    place = np.arange(len(shown))
    spin = [values[name, "toppling spin of 8 cubes [rad/s]"] for name in shown]
    rigid = values["rigid theory", "toppling spin of 8 cubes [rad/s]"]
    tip = [values[name, "block on platform tips at, latest of four [°]"] for name in shown]
    left.bar(place - 0.2, [100 * (s / rigid - 1) for s in spin], 0.4, label="8 cubes topple late: spin [% above rigid]")
    left.bar(
        place + 0.2,
        [10 * (t - math.degrees(math.atan(0.5))) for t in tip],
        0.4,
        label="block on platform tips late [0.1°]",
    )
    left.set(title="The price: turn, twist", xticks=place)
    left.set_xticklabels(shown, rotation=60, ha="right")
    left.legend(fontsize="small")
    right.bar(
        place - 0.2,
        [values[name, "tower of 20 survives shot at [m/s]"] for name in shown],
        0.4,
        label="shot survived by 20 cubes [m/s], tried up to 50",
    )
    right.bar(
        place + 0.2,
        [100 * values[name, "tower of 20 rocks at [share of toppling spin]"] for name in shown],
        0.4,
        label="rocking survived by 20 cubes [% of toppling spin]",
    )
    right.set(title="The use: turn, twist", xticks=place)
    right.set_xticklabels(shown, rotation=60, ha="right")
    right.legend(fontsize="small")
    figure.savefig(FIGURES / "recycling.png", dpi=110)


if __name__ == "__main__":
    main()
