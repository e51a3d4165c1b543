"""The bodies over lanes against the dense sweep over directions, as ``test_depth.py`` does for the scalar routines, and
their points against the shapes. Every answer is compared, bit for bit, with the body's NumPy reading."""

from __future__ import annotations

import math
import zlib

import numpy as np
import numpy.typing as npt
import pytest

from atlasphys.engine.narrowphase.clip import FACE_PREFERENCE, PARALLEL
from atlasphys.engine.narrowphase.lanes.box_box import RELATIVE_PREFERENCE
from atlasphys.engine.narrowphase.lanes.common import ASIDE
from atlasphys.engine.shapes.capsule import Capsule
from tests.engine.narrowphase.lane_blocks import DRIVERS, blocks_of, both_readings, lane_contact
from tests.engine.narrowphase.poses import CASES, Pose, random_poses
from tests.engine.narrowphase.test_depth import ANGLE, allowed_miss, as_pairs, margin_of, rounded, size_of
from tests.reference.narrowphase import reach
from tests.reference.sweep import lowest_elsewhere, minima, overlaps, separating_axes

PAIRS = [kinds for kinds in DRIVERS if kinds[1] != "plane"]


def check(kinds: tuple[str, str], case: str, number: int, real: npt.DTypeLike, seed: int) -> None:
    rng = np.random.default_rng([seed, zlib.crc32(f"{kinds} {case}".encode())])
    poses = [
        p._replace(
            rotation_a=rounded(p.rotation_a, real),
            rotation_b=rounded(p.rotation_b, real),
            position_a=np.zeros(3),
            position_b=p.position_b - p.position_a,
        )
        for p in random_poses(*kinds, rng, case, number)
    ]
    pairs = as_pairs(poses)
    depths, normals = minima(pairs)
    least, along = depths[:, 0], normals[:, 0]
    axes = np.full(number, -np.inf)
    if kinds == ("box", "box"):
        axes = separating_axes(pairs, [shape for pose in poses for shape in (pose.a, pose.b)])
        least = np.where(axes > 0, np.minimum(least, axes), least)
    size = np.array([size_of(pose) for pose in poses])
    margin = margin_of(case, real)
    bias = FACE_PREFERENCE * margin
    off = allowed_miss(case, real) * size
    # A second box's face yields to the first's, and edges to that.
    preferred = 2.1 * (bias + (RELATIVE_PREFERENCE * np.abs(least) if "box" in kinds and "sphere" not in kinds else 0))
    allowed = off + preferred
    alone = lowest_elsewhere(pairs, depths, normals, ANGLE) > depths[:, 0] + 2 * allowed
    blocks = both_readings(kinds, blocks_of(poses, real, margin))
    contacts = [lane_contact(blocks, k) for k in range(number)]
    found = np.array([len(contact.depth) > 0 for contact in contacts])
    depth = np.array([contact.depth.max(initial=-np.inf) for contact in contacts])
    normal = np.array([contact.normal if len(contact.depth) else along[k] for k, contact in enumerate(contacts)])
    h = overlaps(pairs, normal)
    # Of boxes apart corner to corner the best axis shows less than the distance; they may give no point.
    bound = np.maximum(least, axes)
    cosine = np.einsum("ij,ij->i", normal, along)
    known = (bound <= depths[:, 0]) & (depth > depths[:, 0] - off)
    near = least > (allowed if kinds == ("box", "box") else allowed - margin)
    # A capsule may slant by so much against the edge or segment that it lies along.
    slant = np.array([_slant(pose) for pose in poses]) if kinds[0] == "capsule" else np.zeros(number)
    faults = {
        "no contact found": ~found & near,
        "a contact beyond the margin": found & (depth < -margin - off),
        "no unit normal": found & ~(np.abs(np.linalg.norm(normal, axis=1) - 1) < 1e-5),
        "the overlap along the normal is not the depth": found & ~(np.abs(h - depth) < off + 2.5 * bias + preferred),
        "a depth greater than the overlap": found & ~(depth < h + off + 2.5 * bias),
        "not the least depth": found & ~(depth < bound + allowed),
        "another normal, though one is best": found & alone & known & ~(cosine > math.cos(ANGLE)),
        "a point is not between the surfaces": np.array(
            [
                _astray(pose, contact, 2 * bias + off[k] + slant[k])
                for k, (pose, contact) in enumerate(zip(poses, contacts, strict=True))
            ]
        ),
    }
    for fault, at_fault in faults.items():
        for k in np.flatnonzero(at_fault):
            raise AssertionError(
                f"{fault}: {int(at_fault.sum())} of {number} pairs {kinds} {case}, the first: {k}: depth {depth[k]} along "
                f"{normal[k]}, overlap there {h[k]}, least {least[k]} along {along[k]}: {contacts[k]} {poses[k]}"
            )


def _slant(pose: Pose) -> float:
    """How far a point may be from where the surfaces are because two segments that are not quite parallel count so."""
    radii = pose.a.radius + (pose.b.radius if isinstance(pose.b, Capsule) else 0.0)
    return (PARALLEL + 0.5 * ASIDE) * radii


def _astray(pose: Pose, contact, tolerance: float) -> bool:
    """Whether some point is farther than the tolerance from where the surfaces are: half the depth out of either along
    the normal it is within both shapes, and no face of either is far from it."""
    n = contact.normal
    for point, depth in zip(contact.points, contact.depth, strict=True):
        for shape, turn, at, side in (
            (pose.a, pose.rotation_a, point, 1),
            (pose.b, pose.rotation_b, point - pose.position_b, -1),
        ):
            surface = (at + 0.5 * side * depth * n) @ turn
            # Within the shape: below its support planes along its own axes and the normal.
            directions = np.concatenate([np.eye(3), -np.eye(3), [side * n @ turn]])
            if (directions @ surface > reach(shape, directions) + tolerance).any():
                return True
    return False


@pytest.mark.parametrize("real", [np.float32, np.float64])
@pytest.mark.parametrize("kinds", PAIRS, ids=" ".join)
def test_depth_is_attained_and_least(kinds: tuple[str, str], real: npt.DTypeLike) -> None:
    for case in CASES:
        check(kinds, case, 24, real, 1)


@pytest.mark.full
@pytest.mark.parametrize("real", [np.float32, np.float64])
@pytest.mark.parametrize("kinds", PAIRS, ids=" ".join)
def test_depth_is_attained_and_least_over_many_pairs(kinds: tuple[str, str], real: npt.DTypeLike) -> None:
    for case in CASES:
        for seed in range(100, 104):
            check(kinds, case, 208, real, seed)
