"""Whether a scene came out right, from poses alone: the same yardstick for every engine.

A tower that fell is fast to simulate, and so are bodies that went through the ground; such results are shown as fallen and count for nothing.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from atlasphys.bench.scenes import GRAVITY, Box, Capsule, Hull, Scene, Shape, Sphere
from atlasphys.bench.swing import energy_error, stretch

Array = npt.NDArray[np.float64]

ASIDE = 0.5
"""A body of a stack that moved sideways by this share of its size has fallen: half a cube is beyond the edge of the one below."""

SUNK = 0.1
"""A body of a stack that lost this share of its height above the ground has fallen, or what is below it is crushed. One that
rose by ASIDE has been thrown up."""

DEEP = 0.25
"""Bodies that overlap by this share of the scene's smallest size are inside each other. In dropped piles every engine leaves single pairs
with a tenth."""

OFF_COURSE = 0.1
"""Share of ½ g t² by which a falling body may be off. Engines damp falls and take their first step differently."""

APART = 3.0
"""Anchors of a link at this distance have come apart [m]. Large nets in motion stretch by a metre in every engine, and come back."""

GAINED = 0.05
"""Share of weight times length by which what swings may rise."""

MOST_JUDGED = 20_000
"""Penetration is looked for in scenes of up to this many bodies."""


class Quality(NamedTuple):
    """What came of a scene."""

    stands: bool
    fault: str
    """What is wrong; empty if the scene stands."""
    worst_drift: float | None
    """Greatest distance of a body from where it began [m]; sideways only, if it falls; None for piles."""
    deepest: float | None
    """Deepest penetration [m]; None if nothing can touch, if numbers are not finite or if there are more than MOST_JUDGED bodies."""
    lost: int
    """Number of bodies that are below the ground or beyond the walls."""
    stretch: float | None = None
    """Greatest distance of the two anchors of a link [m]; None without links."""
    energy: float | None = None
    """Energy gained since the start, as a share of weight times length; None without links."""


def judge(
    scene: Scene, seconds: float, positions: Array, orientations: Array, before: tuple[Array, Array] | None = None
) -> Quality:
    """Judge the poses of a scene's bodies after a simulated time; for what swings, with those of the step before."""
    if not (np.isfinite(positions).all() and np.isfinite(orientations).all()):
        return Quality(False, "numbers are not finite", None, None, len(positions))
    start = np.array([item.position for item in scene.bodies])
    shift = positions - start
    sideways = np.sqrt(shift[:, 0] ** 2 + shift[:, 2] ** 2)
    if scene.expect == "falls":
        way = 0.5 * GRAVITY * seconds**2
        astray = np.abs(shift[:, 1] + way) > OFF_COURSE * way + 0.01
        fault = f"{astray.sum()} bodies do not fall as they should" if astray.any() else ""
        drift = float(sideways.max())
        return Quality(not fault and drift < 0.01, fault or "drifted sideways" * (drift >= 0.01), drift, None, 0)
    if scene.expect == "swings":
        assert before is not None
        apart = float(stretch(scene, positions, orientations).max())
        energy = energy_error(scene, before, (positions, orientations))
        faults = ["links came apart"] * (apart > APART) + ["it gained energy"] * (energy > GAINED)
        return Quality(not faults, "; ".join(faults), None, None, 0, apart, energy)
    lost = positions[:, 1] < 0.0
    if scene.expect == "piles":
        lost |= np.abs(positions[:, [0, 2]]).max(axis=1) > scene.inside
    faults = [f"{lost.sum()} of {len(lost)} bodies are out of the scene"] if lost.any() else []
    stack_drift: float | None = None
    if scene.expect == "stands":
        stack_drift = float(np.sqrt((shift**2).sum(axis=1)).max())
        size = np.array([_size(item.shape) for item in scene.bodies])
        fallen = (sideways > ASIDE * size) | (shift[:, 1] < -SUNK * start[:, 1]) | (shift[:, 1] > ASIDE * size)
        if fallen.any():
            faults.append(f"{fallen.sum()} of {len(fallen)} bodies fell")
    deepest = None
    if len(positions) <= MOST_JUDGED:
        deepest = penetration(scene, positions, orientations, ~lost)
        limit = DEEP * min(_size(item.shape) for item in scene.bodies)
        if deepest > limit:
            faults.append(f"bodies overlap by {1e3 * deepest:.0f} mm")
    return Quality(not faults, "; ".join(faults), stack_drift, deepest, int(lost.sum()))


def penetration(scene: Scene, positions: Array, orientations: Array, among: npt.NDArray[np.bool_]) -> float:
    """The deepest penetration [m] among the bodies of a mask, the ground and the walls, as our classic narrow phase sees it.

    A world with these poses and without gravity takes one step that is too short to move anything; its contacts are those of the poses.
    """
    import atlasphys as ap
    from atlasphys.bench.peers.atlasphys import add_items

    world = ap.World(preset="classic", narrowphase="auto", gravity=(0, 0, 0), precision="double")
    items: list[Any] = [
        item._replace(position=position, orientation=orientation)
        for item, position, orientation, judged in zip(
            scene.bodies, positions.tolist(), orientations.tolist(), among, strict=True
        )
        if judged
    ]
    if not items:
        return 0.0
    add_items(world, items)
    add_items(world, scene.walls, kind="static")
    if scene.ground:
        world.add(ap.Plane())
    world.step(1e-6)
    depth = world.contacts.depth
    return max(0.0, float(depth.max())) if len(depth) else 0.0


def _size(shape: Shape) -> float:
    """The smallest width of a shape, or for a hull about that [m]."""
    match shape:
        case Box(half):
            return 2 * min(half)
        case Sphere(radius) | Capsule(radius, _):
            return 2 * radius
        case Hull():
            return float(shape.volume ** (1 / 3))
