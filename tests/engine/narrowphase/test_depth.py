"""GJK and EPA, the separating axis test and the exact routines against a dense sweep over directions.

An answer (n, depth) is right exactly if the overlap along n is the depth, and no direction's overlap is less. Both are
asked of the deepest contact point that :func:`collide` gives, so clipping is tested with them. Where the least depth is
not unique this still holds, whatever normal was taken.
"""

from __future__ import annotations

import zlib
from itertools import combinations_with_replacement

import numpy as np
import numpy.typing as npt
import pytest

from tests.engine.narrowphase.poses import CASES, KINDS, Pose, contact, contacts_of, random_pose
from tests.reference.narrowphase import overlap, reach, sweep

PAIRS = list(combinations_with_replacement(KINDS, 2))
POLYHEDRA = ("box", "hull")
ROUND = ("cylinder", "cone")
OVERLAPPING = tuple(case for case in CASES if case != "apart")


def size_of(pose: Pose) -> float:
    axes = np.eye(3)
    return float(reach(pose.a, axes).max() + reach(pose.b, axes).max())


def methods_of(kind_a: str, kind_b: str) -> tuple[str, ...]:
    return ("gjk_epa", "auto")


def allowed_excess(kind_a: str, kind_b: str, case: str, real: npt.DTypeLike) -> float:
    """How much deeper than the least an answer may be, as a part of the pair's size."""
    if case in ("concentric", "identical", "aligned", "deep") and (kind_a in ROUND or kind_b in ROUND):
        return 2e-2  # coaxial round cores: a whole circle of normals is nearly as good (docs/narrowphase.md)
    return 5e-5 if real is np.float32 else 1e-6


def allowed_miss(case: str, real: npt.DTypeLike) -> float:
    """How far the overlap along the normal may be from the depth, as a part of the pair's size.

    In single precision, cores about 1e-4 of their size apart have a normal that is wrong by as much.
    """
    if real is np.float64:
        return 1e-8
    return 2e-4 if case in ("touching", "thin") else 5e-5


def check(kind_a: str, kind_b: str, case: str, number: int, real: npt.DTypeLike, seed: int) -> None:
    rng = np.random.default_rng([seed, zlib.crc32(f"{kind_a} {kind_b} {case}".encode())])
    poses = [random_pose(kind_a, kind_b, rng, case) for _ in range(number)]
    as_seen = [
        p._replace(
            rotation_a=p.rotation_a.astype(real).astype(float), rotation_b=p.rotation_b.astype(real).astype(float)
        )
        for p in poses
    ]
    truths = [sweep(p.a, p.b, p.rotation_a, p.rotation_b, p.position_b - p.position_a) for p in as_seen]
    # The bias in favour of faces is a part of the margin, so a small margin makes the answers exact.
    scale = {"tiny": 1e-3, "huge": 1e3}.get(case, 1.0)
    margin = 1e-4 * scale
    for method in methods_of(kind_a, kind_b):
        contacts = contacts_of(poses, real, method, margin)
        for k, pose in enumerate(as_seen):
            found, truth = contact(contacts, k, pose), truths[k][0]
            where = f"{kind_a} {kind_b} {case} {k} {method}: {pose}"
            size = size_of(pose)
            if len(found.depth) == 0:
                assert truth < 1e-5 * size, f"no contact found, but they overlap by {truth}: {where}"
                continue
            assert np.isfinite(found.depth).all(), where
            assert abs(np.linalg.norm(found.normal) - 1.0) < 1e-5, where
            h = float(
                overlap(
                    pose.a, pose.b, pose.rotation_a, pose.rotation_b, pose.position_b - pose.position_a, found.normal
                )
            )
            deepest = float(found.depth.max())
            attained = allowed_miss(case, real) * size + 2.5 * margin * 0.025
            assert abs(h - deepest) < attained, f"depth {deepest}, but overlap {h} along the normal: {where}"
            excess = allowed_excess(kind_a, kind_b, case, real) * size + 1.5 * margin * 0.025
            assert deepest < truth + excess, (
                f"depth {deepest} along {found.normal}, but {truth} along {truths[k][1]}: {where}"
            )


@pytest.mark.parametrize(("kind_a", "kind_b"), PAIRS)
def test_depth_is_attained_and_least_in_single_precision(kind_a: str, kind_b: str) -> None:
    for case in OVERLAPPING:
        check(kind_a, kind_b, case, 3, np.float32, 1)


@pytest.mark.parametrize(("kind_a", "kind_b"), [("box", "box"), ("hull", "cylinder"), ("capsule", "cone")])
def test_depth_is_attained_and_least_in_double_precision(kind_a: str, kind_b: str) -> None:
    for case in OVERLAPPING:
        check(*sorted((kind_a, kind_b), key=KINDS.index), case, 3, np.float64, 2)


@pytest.mark.full
@pytest.mark.parametrize("real", [np.float32, np.float64])
@pytest.mark.parametrize(("kind_a", "kind_b"), PAIRS)
def test_depth_is_attained_and_least_over_20000_pairs(kind_a: str, kind_b: str, real: npt.DTypeLike) -> None:
    for case in OVERLAPPING:
        for block in range(10):
            check(kind_a, kind_b, case, -(-20000 // (10 * len(OVERLAPPING))), real, 100 + block)
