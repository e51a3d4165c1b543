"""GJK and EPA, the separating axis test and the exact routines against a dense sweep over directions.

An answer (n, depth) is right exactly if the overlap along n is the depth, and no direction's overlap is less. Both are
asked of the deepest contact point that :func:`collide` gives, so clipping is tested with them. Where the least depth is
not unique this still holds, whatever normal was taken; where it is, the normals are compared too. Distances of pairs
apart are negative depths.
"""

from __future__ import annotations

import math
import zlib
from itertools import combinations_with_replacement
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import pytest

from atlasphys.engine.narrowphase.clip import FACE_PREFERENCE
from atlasphys.engine.state.contacts import Contacts
from tests.engine.narrowphase.poses import CASES, KINDS, Pose, contacts_of, random_poses, scale_of
from tests.reference.narrowphase import reach, sweep
from tests.reference.sweep import Placed, lowest_elsewhere, minima, overlaps, placed, separating_axes

Array = npt.NDArray[np.float64]
PAIRS = list(combinations_with_replacement(KINDS, 2))
POLYHEDRA = ("box", "hull")
ROUND = ("cylinder", "cone")
ANGLE = 0.05


class Report(NamedTuple):
    """What a block of pairs showed, lengths as parts of the pair's size."""

    pairs: int
    miss: float
    """The most that a depth differs from the overlap along its normal."""
    excess: float
    """The most by which a depth exceeds the least."""
    unique: int
    """Pairs whose least depth is unique, so that normals were compared."""


def margin_of(case: str, real: npt.DTypeLike) -> float:
    """The speculative margin. The bias in favour of faces is a part of it: a small one makes the answers exact."""
    small = 1e-8 if real is np.float64 else 1e-4
    return {"near": 1e-3, "apart": 0.15}.get(case, small * scale_of(case))


def allowed_miss(case: str, real: npt.DTypeLike) -> float:
    """How far the overlap along the normal may be from the depth, as a part of the pair's size.

    In single precision, cores (and needles) about 1e-4 of their size apart have a normal that is wrong by as much.
    """
    if real is np.float64:
        return 1e-8
    return 2e-4 if case in ("touching", "near", "thin") else 5e-5


def allowed_excess(kind_a: str, kind_b: str, case: str, real: npt.DTypeLike) -> float:
    """How much deeper than the least an answer may be, as a part of the pair's size."""
    if case in ("concentric", "identical", "aligned", "deep") and (kind_a in ROUND or kind_b in ROUND):
        return 2e-3  # coaxial round cores: a whole circle of normals is nearly as good (docs/narrowphase.md)
    return 1e-6 if real is np.float64 else allowed_miss(case, real)


def methods(kind_a: str, kind_b: str) -> tuple[str, ...]:
    return ("gjk_epa", "auto", "sat") if kind_a in POLYHEDRA and kind_b in POLYHEDRA else ("gjk_epa", "auto")


def deepest(contacts: Contacts, number: int) -> Array:
    """Depth of each pair's deepest point; minus infinity where there is none."""
    result = np.full(number, -np.inf)
    owner = np.repeat(np.arange(number), contacts.count[:number])
    slot = np.arange(len(owner)) - np.repeat(
        np.cumsum(contacts.count[:number]) - contacts.count[:number], contacts.count[:number]
    )
    np.maximum.at(result, owner, contacts.depth[contacts.first[owner] + slot].astype(float))
    return result


def rounded(turn: Array, real: npt.DTypeLike) -> Array:
    return turn.astype(real).astype(float)


def as_pairs(poses: list[Pose]) -> Placed:
    return placed(
        [shape for p in poses for shape in (p.a, p.b)],
        [turn for p in poses for turn in (p.rotation_a, p.rotation_b)],
        [p.position_b - p.position_a for p in poses],
    )


def size_of(pose: Pose) -> float:
    axes = np.eye(3)
    return float(reach(pose.a, axes).max() + reach(pose.b, axes).max())


def check(kind_a: str, kind_b: str, case: str, number: int, real: npt.DTypeLike, seed: int) -> dict[str, Report]:
    rng = np.random.default_rng([seed, zlib.crc32(f"{kind_a} {kind_b} {case}".encode())])
    poses = [
        p._replace(rotation_a=rounded(p.rotation_a, real), rotation_b=rounded(p.rotation_b, real))
        for p in random_poses(kind_a, kind_b, rng, case, number)
    ]
    pairs = as_pairs(poses)
    depths, normals = minima(pairs)
    least, along = depths[:, 0], normals[:, 0]
    axes = np.full(number, -np.inf)
    if "sat" in methods(kind_a, kind_b):
        axes = separating_axes(pairs, [shape for pose in poses for shape in (pose.a, pose.b)])
        least = np.where(axes > 0, np.minimum(least, axes), least)
    size = np.array([size_of(pose) for pose in poses])
    margin = margin_of(case, real)
    bias = FACE_PREFERENCE * margin
    off = allowed_miss(case, real) * size
    allowed = allowed_excess(kind_a, kind_b, case, real) * size + 2.0 * bias
    alone = lowest_elsewhere(pairs, depths, normals, ANGLE) > depths[:, 0] + 2.0 * allowed
    reports = {}
    for method in methods(kind_a, kind_b):
        contacts = contacts_of(poses, real, method, margin)
        depth, normal = deepest(contacts, number), contacts.normal[:number].astype(float)
        found = depth > -np.inf
        normal[~found] = along[~found]
        h = overlaps(pairs, normal)
        # Of polyhedra apart corner to corner the best axis shows less than the distance.
        bound = np.maximum(least, axes) if method != "gjk_epa" else least
        cosine = np.einsum("ij,ij->i", normal, along)
        known = (bound <= depths[:, 0]) & (depth > depths[:, 0] - off)  # else the sweep has missed the best itself
        faults = {
            "no contact found": ~found & (least > -margin + allowed),
            "a contact beyond the margin": found & (depth < -margin),
            "no unit normal": found & ~(np.abs(np.linalg.norm(normal, axis=1) - 1.0) < 1e-5),
            "the overlap along the normal is not the depth": found & ~(np.abs(h - depth) < off + 2.5 * bias),
            "not the least depth": found & ~(depth < bound + allowed),
            "another normal, though one is best": found & alone & known & ~(cosine > math.cos(ANGLE)),
        }
        for fault, pairs_at_fault in faults.items():
            for k in np.flatnonzero(pairs_at_fault):
                raise AssertionError(
                    f"{fault}: {int(pairs_at_fault.sum())} of {number} pairs {kind_a} {kind_b} {case} by {method}, the "
                    f"first: {k}: depth {depth[k]} along {normal[k]}, overlap there {h[k]}, least {least[k]} along "
                    f"{along[k]}: {poses[k]}"
                )
        part = np.where(found, np.abs(h - depth), 0.0) / size
        over = np.where(found, depth - bound, 0.0) / size
        reports[method] = Report(number, float(max(part.max(), 0.0)), float(max(over.max(), 0.0)), int(alone.sum()))
    return reports


@pytest.mark.parametrize("case", ["random", "deep", "thin", "concentric", "near", "apart"])
def test_the_compiled_sweep_agrees_with_the_slow_one(case: str) -> None:
    rng = np.random.default_rng(17)
    for kind_a, kind_b in [("sphere", "box"), ("capsule", "cone"), ("cylinder", "hull")]:
        poses = random_poses(kind_a, kind_b, rng, case, 2)
        pairs = as_pairs(poses)
        depth, normal = (found[:, 0] for found in minima(pairs))
        assert overlaps(pairs, normal) == pytest.approx(depth, abs=1e-12)
        for k, pose in enumerate(poses):
            where = pose.a, pose.b, pose.rotation_a, pose.rotation_b, pose.position_b - pose.position_a
            slow, direction = sweep(*where, starts=2, rounds=40)
            assert overlaps(pairs, np.tile(direction, (2, 1)))[k] == pytest.approx(slow, abs=1e-12)
            # The slow one stops on ridges.
            assert slow - 5e-3 < depth[k] < slow + 1e-9


@pytest.mark.parametrize("case", [case for case in CASES if case not in ("near", "apart")])
def test_the_compiled_sweep_finds_the_depth_of_polyhedra(case: str) -> None:
    rng = np.random.default_rng(19)
    poses = random_poses("box", "hull", rng, case, 40)
    pairs = as_pairs(poses)
    exact = separating_axes(pairs, [shape for p in poses for shape in (p.a, p.b)])
    inside = exact > 0
    assert minima(pairs)[0][inside, 0] == pytest.approx(exact[inside], abs=1e-9 * scale_of(case))


@pytest.mark.parametrize(("kind_a", "kind_b"), PAIRS)
def test_depth_is_attained_and_least_in_single_precision(kind_a: str, kind_b: str) -> None:
    for case in CASES:
        check(kind_a, kind_b, case, 10, np.float32, 1)


@pytest.mark.parametrize(("kind_a", "kind_b"), [("box", "box"), ("hull", "cylinder"), ("capsule", "cone")])
def test_depth_is_attained_and_least_in_double_precision(kind_a: str, kind_b: str) -> None:
    for case in CASES:
        check(*sorted((kind_a, kind_b), key=KINDS.index), case, 10, np.float64, 2)


@pytest.mark.full
@pytest.mark.parametrize("real", [np.float32, np.float64])
@pytest.mark.parametrize(("kind_a", "kind_b"), PAIRS)
def test_depth_is_attained_and_least_over_10000_pairs_in_each_precision(
    kind_a: str, kind_b: str, real: npt.DTypeLike
) -> None:
    reports: dict[str, list[Report]] = {}
    for case in CASES:
        gap = " (gaps)" if case in ("near", "apart") else ""
        for block in range(4):
            for method, report in check(kind_a, kind_b, case, 209, real, 100 + block).items():
                reports.setdefault(method + gap, []).append(report)
    for name, blocks in reports.items():
        pairs, unique = (sum(getattr(block, field) for block in blocks) for field in ("pairs", "unique"))
        miss, excess = (max(getattr(block, field) for block in blocks) for field in ("miss", "excess"))
        print(f"{kind_a} {kind_b} {np.dtype(real).name} {name}: {pairs} pairs, {unique} with a unique normal, ", end="")
        print(f"miss {miss:.1e}, excess {excess:.1e} of the size")
