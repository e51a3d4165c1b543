"""Poses as blocks of eight lanes, drivers that call the bodies, and what they say of each pose."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from atlasphys.engine.jit import kernel
from atlasphys.engine.narrowphase.lanes.box_box import box_box
from atlasphys.engine.narrowphase.lanes.capsule_box import capsule_box
from atlasphys.engine.narrowphase.lanes.capsule_capsule import capsule_capsule
from atlasphys.engine.narrowphase.lanes.plane import box_plane, capsule_plane, sphere_plane
from atlasphys.engine.narrowphase.lanes.sphere_box import sphere_box
from atlasphys.engine.narrowphase.lanes.sphere_capsule import sphere_capsule
from atlasphys.engine.narrowphase.lanes.sphere_sphere import sphere_sphere
from atlasphys.engine.shapes.shape import Shape
from tests.engine.narrowphase.poses import Contact, Pose


def driver(body: Callable[..., Any]) -> Callable[..., None]:
    """A kernel that calls a body on each block, as a step does."""

    @kernel
    def run(pairs, geometry, place, margin, contact, tags, found):
        for block in range(len(pairs)):
            found[block] = body(pairs[block], geometry, place[block], margin, contact[block], tags[block])

    return run


DRIVERS: dict[tuple[str, str], Callable[..., None]] = {
    ("sphere", "sphere"): driver(sphere_sphere),
    ("sphere", "capsule"): driver(sphere_capsule),
    ("sphere", "box"): driver(sphere_box),
    ("capsule", "capsule"): driver(capsule_capsule),
    ("capsule", "box"): driver(capsule_box),
    ("box", "box"): driver(box_box),
    ("sphere", "plane"): driver(sphere_plane),
    ("capsule", "plane"): driver(capsule_plane),
    ("box", "plane"): driver(box_plane),
}


class Blocks(NamedTuple):
    """Arguments of a driver. Bodies 2 k and 2 k + 1 are pair k, which is lane k mod 8 of block k div 8."""

    pairs: npt.NDArray[np.int32]
    geometry: npt.NDArray[Any]
    place: npt.NDArray[Any]
    margin: float
    contact: npt.NDArray[Any]
    tags: npt.NDArray[np.int32]
    found: npt.NDArray[np.bool_]


def _sizes(shape: Shape) -> list[float]:
    return [*shape.sizes, 0.0, 0.0, 0.0, 0.0][:4]


def blocks_of(poses: list[Pose], real: npt.DTypeLike, margin: float) -> Blocks:
    number = len(poses)
    blocks = -(-number // 8)
    lanes = np.minimum(np.arange(8 * blocks), number - 1)  # idle lanes repeat the last pair
    geometry = np.zeros((2 * number, 16), real)
    place = np.zeros((number, 16), real)
    for k, pose in enumerate(poses):
        geometry[2 * k, :9], geometry[2 * k + 1, :9] = pose.rotation_a.ravel(), pose.rotation_b.ravel()
        place[k, 4:8], place[k, 8:12] = _sizes(pose.a), _sizes(pose.b)
        place[k, :3] = pose.position_b - pose.position_a
    return Blocks(
        np.ascontiguousarray(np.stack([2 * lanes, 2 * lanes + 1]).reshape(2, blocks, 8).swapaxes(0, 1), dtype=np.int32),
        geometry,
        np.ascontiguousarray(place[lanes].reshape(blocks, 8, 16).swapaxes(1, 2)),
        margin,
        np.full((blocks, 24, 8), np.nan, real),
        np.full((blocks, 8, 8), -1, np.int32),
        np.zeros(blocks, np.bool_),
    )


def planes_of(
    shapes: list[Shape], turns: Any, normals: Any, heights: Any, real: npt.DTypeLike, margin: float
) -> Blocks:
    """The same for shapes above or in planes."""
    still, here = np.eye(3), np.zeros(3)
    blocks = blocks_of(
        [Pose(shape, shape, here, here, turn, still) for shape, turn in zip(shapes, turns, strict=True)], real, margin
    )
    lanes = np.minimum(np.arange(8 * len(blocks.pairs)), len(shapes) - 1)
    blocks.place[:, :3] = np.asarray(normals)[lanes].reshape(-1, 8, 3).swapaxes(1, 2)
    blocks.place[:, 3] = np.asarray(heights)[lanes].reshape(-1, 8)
    blocks.place[:, 8:] = 0
    return blocks


def both_readings(kinds: tuple[str, str], blocks: Blocks) -> Blocks:
    """The compiled answer, after asserting that the NumPy reading gives the same bits."""
    other = blocks._replace(contact=blocks.contact.copy(), tags=blocks.tags.copy(), found=blocks.found.copy())
    driver: Any = DRIVERS[kinds]
    driver(*blocks)
    driver.py_func(*other)
    np.testing.assert_array_equal(blocks.contact, other.contact)
    np.testing.assert_array_equal(blocks.tags, other.tags)
    np.testing.assert_array_equal(blocks.found, other.found)
    check_form(blocks)
    return blocks


def check_form(blocks: Blocks) -> None:
    """Unused points are zero, used ones finite; the answer tells whether there are any."""
    count = blocks.tags[:, 4]
    assert ((count >= 0) & (count <= 4)).all()
    np.testing.assert_array_equal(blocks.found, (count > 0).any(axis=1))
    assert np.isfinite(blocks.contact[:, :20]).all()
    for k in range(4):
        unused = count <= k
        assert (blocks.contact[:, 4 + 4 * k : 8 + 4 * k].swapaxes(1, 2)[unused] == 0).all()
        assert (blocks.tags[:, k][unused] == 0).all()
    assert (blocks.contact[:, 7:20:4].swapaxes(1, 2)[count == 0] == 0).all()


def lane_contact(blocks: Blocks, k: int, origin: Any = 0.0) -> Contact:
    """The contact of pair k, in double precision; the points as seen from the first's centre, moved by ``origin``."""
    block, lane = divmod(k, 8)
    values = blocks.contact[block, :, lane].astype(float)
    count = blocks.tags[block, 4, lane]
    points = values[4:20].reshape(4, 4)[:count]
    return Contact(values[:3], points[:, :3] + origin, points[:, 3], blocks.tags[block, :count, lane].copy())
