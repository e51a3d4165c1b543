"""What the bodies over lanes say of pairs that are apart: they give no points before the shapes have moved so far."""

from __future__ import annotations

import numpy as np
import pytest

from atlasphys.engine.narrowphase.apart import INEXACT, ROUND_OFF
from atlasphys.engine.narrowphase.lanes.common import ROOM
from tests.engine.narrowphase.lane_blocks import DRIVERS, blocks_of, both_readings, planes_of
from tests.engine.narrowphase.poses import Pose, random_poses, random_shape, scale_of, turned
from tests.reference.narrowphase import rotation

PAIRS = [kinds for kinds in DRIVERS if kinds[1] != "plane"]
PLANES = [kinds[0] for kinds in DRIVERS if kinds[1] == "plane"]
MARGIN = 0.02


def extent(shape) -> float:
    """Greatest distance of a point of the shape from its centre."""
    kind, sizes = type(shape).__name__, shape.sizes
    return {"Sphere": sizes[0], "Capsule": sum(sizes[:2]), "Box": float(np.linalg.norm(sizes[:3]))}[kind]


def moved(position, turn, shape, travel, direction, rng):
    """A pose that is the given travel away, part of it along a direction, part of it a turn."""
    spin = rng.choice([0.0, 1.0, rng.uniform()])
    angle = 4 * np.arcsin(min(spin * travel / (4 * extent(shape)), 0.9))
    axis = rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    by = rotation((np.cos(angle / 2), *(np.sin(angle / 2) * axis)))
    return position + (1 - spin) * travel * direction, by @ turn


def collided(kinds, blocks):
    DRIVERS[kinds](*blocks)
    return blocks


def rooms_of(blocks, number):
    return np.array([blocks.contact[k // 8, ROOM, k % 8] for k in range(number)], float)


def counts_of(blocks, number):
    return np.array([blocks.tags[k // 8, 4, k % 8] for k in range(number)])


@pytest.mark.parametrize("real", [np.float32, np.float64])
@pytest.mark.parametrize("case", ["apart", "near", "thin", "tiny", "huge", "parallel"])
@pytest.mark.parametrize("kinds", PAIRS, ids="-".join)
def test_shapes_that_move_less_than_the_room_do_not_touch(kinds, case, real):
    rng = np.random.default_rng(2)
    size = scale_of(case)
    poses = []
    for pose in random_poses(*kinds, rng, case, 160):
        away = pose.position_b - pose.position_a
        away = away / (np.linalg.norm(away) or 1)
        apart = pose.position_b + rng.choice([0.0, 0.03, 0.2, 1.0]) * size * away
        poses.append(pose._replace(position_b=apart))
    margin = MARGIN * size
    first = both_readings(kinds, blocks_of(poses, real, margin))
    found, points = rooms_of(first, len(poses)), counts_of(first, len(poses))
    assert (found[points > 0] <= 0).all()
    extents = np.array([extent(pose.a) + extent(pose.b) for pose in poses])
    rooms = found * (1 - ROUND_OFF) - INEXACT * extents
    clear = [k for k in range(len(poses)) if rooms[k] > 0]
    assert len(clear) > 20
    for _ in range(4):
        after = []
        for k in clear:
            pose, share = poses[k], rng.choice([0.0, 1.0, rng.uniform()])
            towards = pose.position_b - pose.position_a
            towards = towards / (np.linalg.norm(towards) or 1)
            if rng.integers(2):
                towards = first.contact[k // 8, :3, k % 8].astype(float) if points[k] else towards
            a = moved(pose.position_a, pose.rotation_a, pose.a, share * rooms[k], towards, rng)
            b = moved(pose.position_b, pose.rotation_b, pose.b, (1 - share) * rooms[k], -towards, rng)
            after.append(Pose(pose.a, pose.b, a[0], b[0], a[1], b[1]))
        then = counts_of(collided(kinds, blocks_of(after, real, margin)), len(after))
        assert not then.any()


@pytest.mark.parametrize("real", [np.float32, np.float64])
@pytest.mark.parametrize("kind", PLANES)
def test_shapes_above_planes_too(kind, real):
    rng = np.random.default_rng(3)
    shapes = [random_shape(kind, rng, thin=k % 5 == 0) for k in range(160)]
    turns = [turned(rng) for _ in shapes]
    normals = rng.normal(size=(160, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    heights = [extent(shape) * rng.uniform(0, 1.5) for shape in shapes]
    first = both_readings((kind, "plane"), planes_of(shapes, turns, normals, heights, real, MARGIN))
    found, points = rooms_of(first, 160), counts_of(first, 160)
    assert (found[points > 0] <= 0).all()
    rooms = found * (1 - ROUND_OFF) - INEXACT * np.array([extent(shape) for shape in shapes])
    clear = np.flatnonzero(rooms > 0)
    assert len(clear) > 20
    for _ in range(4):
        poses = [moved(np.zeros(3), turns[k], shapes[k], rooms[k], -normals[k], rng) for k in clear]
        lower = [heights[k] + pose[0] @ normals[k] for k, pose in zip(clear, poses, strict=True)]
        then = planes_of([shapes[k] for k in clear], [pose[1] for pose in poses], normals[clear], lower, real, MARGIN)
        assert not counts_of(collided((kind, "plane"), then), len(clear)).any()
