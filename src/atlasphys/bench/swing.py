"""What joints leave undone: how far apart their anchors are, and how much energy was gained or lost. From poses alone, as everything is judged."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from atlasphys.bench.peers.atlasphys import shape_of
from atlasphys.bench.scenes import DT, GRAVITY, Scene
from atlasphys.world.rotation import rotate

Array = npt.NDArray[np.float64]
Poses = tuple[Array, Array]


def stretch(scene: Scene, positions: Array, orientations: Array) -> Array:
    """Distance of the two anchors of each link [m]."""
    ends = []
    for side in ("a", "b"):
        anchors = np.array([getattr(link, f"anchor_{side}") for link in scene.links])
        rows = np.array([-1 if (row := getattr(link, side)) is None else row for link in scene.links])
        held = rows >= 0
        anchors[held] = positions[rows[held]] + rotate(orientations[rows[held]], anchors[held])
        ends.append(anchors)
    distances: Array = np.sqrt(((ends[1] - ends[0]) ** 2).sum(axis=1))
    return distances


def energy_error(scene: Scene, before: Poses, after: Poses) -> float:
    """Energy that a scene that began at rest has gained, from its poses before and after a step, as a share of weight times length.

    Speeds are the mean ones of the step, heights those halfway. All is relative to the start, where the energy is 0.
    """
    start = np.array([item.position for item in scene.bodies])
    shapes = {item.shape: shape_of(item.shape) for item in scene.bodies}
    mass = np.array([item.density * shapes[item.shape].volume for item in scene.bodies])
    inertia = np.array([shapes[item.shape].inertia(item.density) for item in scene.bodies])
    velocity = (after[0] - before[0]) / DT
    w, v = before[1][:, :1], before[1][:, 1:]
    s, u = after[1][:, :1], after[1][:, 1:]
    sine = (
        w * u - s * v - np.cross(v, u)
    )  # vector part of q_before⁻¹ q_after: the turn in the body's axes, times the sine of half its angle
    length = np.sqrt((sine**2).sum(axis=1))
    angle = 2 * np.arctan2(length, np.abs((before[1] * after[1]).sum(axis=1)))
    spin = sine * (angle / np.maximum(length, 1e-300) / DT)[:, None]
    kinetic = 0.5 * (mass * (velocity**2).sum(axis=1)).sum() + 0.5 * np.einsum("ni,nij,nj", spin, inertia, spin)
    height = 0.5 * (before[0] + after[0])[:, 1] - start[:, 1]
    return float((kinetic + GRAVITY * (mass * height).sum()) / (GRAVITY * mass.sum() * scene.length))
