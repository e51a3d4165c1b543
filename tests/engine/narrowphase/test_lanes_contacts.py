"""Known answers of the bodies over lanes, what they keep of the scalar routines' points, and how steady they are."""

from __future__ import annotations

import itertools

import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial import ConvexHull as Qhull
from scipy.spatial import QhullError

from atlasphys.engine.shapes.box import Box
from atlasphys.engine.shapes.capsule import Capsule
from atlasphys.engine.shapes.plane import Plane
from atlasphys.engine.shapes.shape import Shape
from atlasphys.engine.shapes.sphere import Sphere
from tests.engine.narrowphase.lane_blocks import blocks_of, both_readings, lane_contact, planes_of
from tests.engine.narrowphase.poses import (
    CUBE_TURNS,
    Contact,
    Pose,
    contact,
    contacts_of,
    random_poses,
    random_shape,
    scale_of,
    turned,
)
from tests.reference.narrowphase import rotation

STILL = np.eye(3)
CUBE = Box((1.0, 1.0, 1.0))
REALS = [np.float32, np.float64]
BOXES = ("box", "box")


def kinds_of(pose: Pose) -> tuple[str, str]:
    return type(pose.a).__name__.lower(), type(pose.b).__name__.lower()


def found_of(poses: list[Pose], real: npt.DTypeLike = np.float64, margin: float = 0.02) -> list[Contact]:
    blocks = both_readings(kinds_of(poses[0]), blocks_of(poses, real, margin))
    return [lane_contact(blocks, k) for k in range(len(poses))]


def placed(a: Shape, b: Shape, offset: npt.ArrayLike, turn_b: npt.NDArray[np.float64] = STILL) -> Pose:
    return Pose(a, b, np.zeros(3), np.array(offset, float), STILL, turn_b)


def one(pose: Pose, real: npt.DTypeLike = np.float64, margin: float = 0.02) -> Contact:
    return found_of([pose], real, margin)[0]


def same_points(found: npt.NDArray[np.float64], wanted: npt.ArrayLike, tolerance: float) -> bool:
    """Whether each point has one of the others near it, and there are as many."""
    distance = np.linalg.norm(found[:, None] - np.asarray(wanted)[None], axis=2)
    near = distance <= tolerance
    return len(found) == near.shape[1] and bool(near.any(axis=0).all() and near.any(axis=1).all())


def area(points: npt.NDArray[np.float64], normal: npt.NDArray[np.float64]) -> float:
    """Area of the hull of points as seen along a normal."""
    u = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    u /= np.linalg.norm(u)
    try:
        return float(Qhull(points @ np.stack([u, np.cross(normal, u)], axis=1)).volume)
    except (QhullError, ValueError):  # fewer than three, or on a line
        return 0.0


# Boxes ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("real", REALS)
@pytest.mark.parametrize("turn", CUBE_TURNS)
def test_a_box_on_a_box_touches_at_the_corners_of_what_they_share(turn, real) -> None:
    for offset, xs, zs in (
        ((0.25, 0.998, 0.5), (-0.25, 0.75), (0.0, 1.0)),
        ((1.75, 0.998, -1.8), (1.25, 2.0), (-2.0, -1.3)),
        ((0.0, 0.998, 0.0), (-0.5, 0.5), (-0.5, 0.5)),
    ):
        pose = placed(Box((4.0, 1.0, 4.0)), CUBE, offset, turn)
        found = one(pose, real)
        assert found.normal == pytest.approx([0, 1, 0], abs=1e-6)
        assert found.depth == pytest.approx([0.002] * 4, abs=1e-6)
        wanted = [(x, 0.499, z) for x in xs for z in zs]
        # The face counts as wider by the bias of 0.5 mm.
        assert same_points(found.points, wanted, 8e-4)
        assert len(set(found.feature.tolist())) == 4
        back = one(Pose(pose.b, pose.a, np.zeros(3), -pose.position_b, pose.rotation_b, pose.rotation_a), real)
        assert back.normal == pytest.approx([0, -1, 0], abs=1e-6)
        assert same_points(back.points + pose.position_b, wanted, 8e-4)


def test_features_are_steady_while_a_stack_trembles() -> None:
    rng = np.random.default_rng(3)
    still = placed(CUBE, CUBE, (0.0, 0.999, 0.0))
    poses = [still] + [
        still._replace(
            position_b=still.position_b + 1e-4 * rng.uniform(-1, 1, 3),
            rotation_b=rotation((1, *(1e-4 * rng.uniform(-1, 1, 3)))),
        )
        for _ in range(80)
    ]
    first, *others = found_of(poses, np.float32)
    assert len(first.feature) == 4
    for found in others:
        assert sorted(found.feature) == sorted(first.feature)
        assert found.normal == pytest.approx([0, 1, 0], abs=3e-4)


def test_a_face_is_preferred_to_an_edge_axis_that_is_hardly_better() -> None:
    for tilt in itertools.product((-2e-4, 2e-4), repeat=2):
        found = one(placed(CUBE, CUBE, (0.3, 0.999, 0.2), rotation((1, tilt[0], 0.3, tilt[1]))))
        assert found.normal.tolist() == [0.0, 1.0, 0.0]
        assert len(found.depth) >= 3


@pytest.mark.parametrize("real", REALS)
def test_four_points_keep_most_of_the_support_area(real) -> None:
    """Against all corners of the polygon, by the scalar routine: two thirds of the area, the deepest, and the centre."""
    rng = np.random.default_rng(8)
    poses = []
    for _ in range(160):
        a, b = (Box(tuple(rng.uniform(0.3, 2.0, 3))) for _ in range(2))
        turn = rotation((1, 0, rng.normal(), 0)) @ rotation((1, *(1e-3 * rng.normal(size=3))))
        height = 0.5 * (a.size[1] + b.size[1]) - 0.001
        aside = [0.45 * (a.size[k] + b.size[k]) * rng.uniform(-0.8, 0.8) for k in (0, 2)]
        whole = turned(rng)
        offset = whole @ np.array([aside[0], height, aside[1]])
        poses.append(Pose(a, b, np.zeros(3), offset, whole, whole @ turn))
    scalar = contacts_of(poses, real, margin=0.02)
    many, fewest = 0, 1.0
    for k, found in enumerate(found_of(poses, real)):
        every = contact(scalar, k, poses[k])
        if len(every.depth) < 3 or every.normal @ found.normal < 0.999999:
            continue
        many += len(every.depth) > 4
        whole_area = area(every.points, every.normal)
        if whole_area > 0.01:
            fewest = min(fewest, area(found.points, found.normal) / whole_area)
        assert found.depth.max() == pytest.approx(every.depth.max(), abs=6e-4)
    assert many > 40
    assert fewest > 0.66


def test_edges_that_cross_touch_where_they_cross() -> None:
    # Two square beams, each with an edge up against the other, at right angles.
    on_edge = rotation((np.cos(np.pi / 8), 0, 0, np.sin(np.pi / 8)))
    across = rotation((1, 0, 1, 0)) @ on_edge
    beam = Box((1.0, 1.0, 5.0))
    for real in REALS:
        found = one(Pose(beam, beam, np.zeros(3), np.array([0.3, np.sqrt(2) - 0.01, 0.7]), on_edge, across), real)
        assert found.normal == pytest.approx([0, 1, 0], abs=1e-5)
        assert found.depth == pytest.approx([0.01], abs=1e-5)
        # The first's edge runs along z at x = 0, the second's along x at z = 0.7.
        assert found.points == pytest.approx(np.array([[0.0, np.sqrt(0.5) - 0.005, 0.7]]), abs=1e-5)


def test_boxes_apart_give_points_within_the_margin_only() -> None:
    for gap, wanted in ((0.01, 4), (0.03, 0)):
        found = one(placed(CUBE, CUBE, (0.0, 1.0 + gap, 0.0)))
        assert len(found.depth) == wanted
        assert found.depth == pytest.approx([-gap] * wanted)
    assert len(one(placed(CUBE, CUBE, (1.015, 1.015, 0.0))).depth) == 0  # corner to corner: nothing to rest on


def test_a_lane_does_not_depend_on_its_neighbours() -> None:
    rng = np.random.default_rng(4)
    poses = [
        pose
        for case in ("random", "apart", "aligned", "identical")
        for pose in random_poses("box", "box", rng, case, 10)
    ]
    together = found_of(poses, np.float32)
    for pose, found in zip(poses, together, strict=True):
        alone = one(pose, np.float32)
        np.testing.assert_array_equal(alone.points, found.points)
        np.testing.assert_array_equal(alone.feature, found.feature)


# Round shapes --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("real", REALS)
@pytest.mark.parametrize("case", ["random", "deep", "near", "apart", "thin", "tiny", "huge"])
@pytest.mark.parametrize("kinds", [("sphere", "sphere"), ("sphere", "capsule"), ("sphere", "box")], ids=" ".join)
def test_spheres_answer_as_the_scalar_routines(kinds, case, real) -> None:
    rng = np.random.default_rng(12)
    poses = [
        p._replace(position_a=np.zeros(3), position_b=p.position_b - p.position_a)
        for p in random_poses(*kinds, rng, case, 24)
    ]
    margin = 0.02 * scale_of(case)
    scalar = contacts_of(poses, real, margin=margin)
    tolerance = scale_of(case) * (1e-5 if real is np.float32 else 1e-12)
    for k, found in enumerate(found_of(poses, real, margin)):
        wanted = contact(scalar, k, poses[k])
        assert len(found.depth) == len(wanted.depth)
        if len(wanted.depth):
            assert found.normal == pytest.approx(wanted.normal, abs=2e-3 if real is np.float32 else 1e-9)
            assert found.depth == pytest.approx(wanted.depth, abs=tolerance)
            assert found.points == pytest.approx(wanted.points, abs=100 * tolerance)


@pytest.mark.parametrize("real", REALS)
def test_concentric_shapes_have_a_unit_normal(real) -> None:
    ball, rod = Sphere(0.5), Capsule(0.2, 1.0)
    assert one(placed(ball, ball, (0, 0, 0)), real).normal.tolist() == [1, 0, 0]
    for other in (rod, Box((1.0, 0.7, 2.0))):
        found = one(placed(ball, other, (0, 0, 0)), real)
        assert np.linalg.norm(found.normal) == pytest.approx(1)
        assert found.depth == pytest.approx([0.7 if other is rod else 0.85])


@pytest.mark.parametrize("real", REALS)
def test_sphere_against_box_corner_edge_face_and_inside(real) -> None:
    ball = Sphere(0.5)
    corner, edge, face, inside = found_of(
        [placed(ball, CUBE, d) for d in ((-0.7, -0.7, -0.7), (0.0, -0.7, -0.7), (0.2, 0.95, 0.3), (0.1, -0.3, 0.2))],
        real,
    )
    assert corner.normal == pytest.approx(-np.ones(3) / np.sqrt(3))
    assert corner.depth == pytest.approx([0.5 - 0.2 * np.sqrt(3)])
    assert edge.normal == pytest.approx(-np.array([0, 1, 1]) / np.sqrt(2))
    assert face.normal.tolist() == [0, 1, 0]
    assert face.points == pytest.approx(np.array([[0, 0.475, 0]]))
    assert inside.normal.tolist() == [0, -1, 0]
    assert inside.depth == pytest.approx([0.7])


@pytest.mark.parametrize("real", REALS)
def test_parallel_capsules_touch_at_both_ends_of_what_they_share(real) -> None:
    found = one(placed(Capsule(0.25, 2.0), Capsule(0.25, 1.0), (0.49, 0.2, 0.0)), real)
    assert found.normal == pytest.approx([1, 0, 0], abs=1e-6)
    assert found.points == pytest.approx(np.array([[0.245, -0.3, 0], [0.245, 0.7, 0]]), abs=1e-6)
    assert found.depth == pytest.approx([0.01, 0.01], abs=1e-6)
    assert found.feature.tolist() == [1, 2]
    end_to_end = one(placed(Capsule(0.25, 2.0), Capsule(0.25, 1.0), (0.0, 1.99, 0.0)), real)
    assert end_to_end.normal == pytest.approx([0, 1, 0])
    assert end_to_end.points == pytest.approx(np.array([[0, 1.245, 0]]))


@pytest.mark.parametrize("real", REALS)
def test_thin_capsules_that_cross_at_a_small_angle_touch_where_they_cross(real) -> None:
    needle = Capsule(0.001, 2.0)
    found = one(placed(needle, needle, (0.0019, 0.0, 0.0), rotation((1, 0.01, 0, 0))), real, 1e-4)
    assert found.points == pytest.approx(np.array([[0.00095, 0, 0]]), abs=1e-4)
    assert found.depth == pytest.approx([1e-4], abs=1e-6)


@pytest.mark.parametrize("real", REALS)
def test_a_thin_capsule_that_crosses_an_edge_at_a_small_angle_touches_where_it_crosses(real) -> None:
    edge_up = rotation((1, np.sqrt(2) - 1, 0, 0)) @ rotation((1, 0, 0, 1))  # the box's y and z axes are at 45°
    pose = Pose(Capsule(0.001, 2.0), CUBE, np.zeros(3), np.array([0.0, -0.0009 - np.sqrt(0.5), 0.0]), STILL, STILL)
    rod = rotation((1, 0, 0.01, 0)) @ rotation((1, 0, 0, 1))  # along x, turned by 0.02 about y
    found = one(pose._replace(rotation_a=rod, rotation_b=edge_up), real, 1e-4)
    assert found.normal == pytest.approx([0, -1, 0], abs=1e-4)
    assert found.points == pytest.approx(np.array([[0, -0.00095, 0]]), abs=1e-4)
    assert found.depth == pytest.approx([1e-4], abs=2e-6)


@pytest.mark.parametrize("real", REALS)
def test_a_capsule_on_one_line_with_another_parts_sideways(real) -> None:
    a, b = Capsule(0.32430662, 1.4470218), Capsule(0.27694546, 1.0250993)
    found = one(placed(a, b, (0.0, 0.75, 0.0), rotation((0, 1, 0, 0))), real)
    assert found.normal[1] == pytest.approx(0, abs=1e-4)
    assert found.depth.max() == pytest.approx(a.radius + b.radius, abs=1e-5)


@pytest.mark.parametrize("real", REALS)
def test_a_capsule_rests_on_a_box_by_two_points(real) -> None:
    rod, turn = Capsule(0.1, 1.0), rotation((1, 1, 0, 0))
    lies, overhangs, along_edge, stands, inside = found_of(
        [
            Pose(rod, Box((2.0, 0.4, 2.0)), np.zeros(3), np.array([0.1, -0.299, 0.2]), turn, STILL),
            Pose(rod, Box((2.0, 0.4, 2.0)), np.zeros(3), np.array([0.1, -0.299, 0.9]), turn, STILL),
            # The box's edge is uppermost, and the capsule lies along it.
            Pose(rod, CUBE, np.zeros(3), np.array([0, -0.099 - np.sqrt(0.5), 0.2]), turn, rotation((np.cos(np.pi / 8), 0, 0, np.sin(np.pi / 8)))),
            Pose(rod, CUBE, np.zeros(3), np.array([0.2, -1.099, 0.2]), STILL, STILL),
            Pose(rod, Box((2.0, 2.0, 2.0)), np.zeros(3), np.array([0.1, -0.9, 0.2]), turn, STILL),
        ],
        real,
    )  # fmt: skip
    for found, ends in ((lies, (-0.5, 0.5)), (overhangs, (-0.1, 0.5)), (along_edge, (-0.3, 0.5))):
        assert found.normal == pytest.approx([0, -1, 0], abs=1e-6)
        assert sorted(found.points[:, 2]) == pytest.approx(ends, abs=1.1e-3)
        assert found.points[:, 1] == pytest.approx([-0.0995] * 2, abs=1e-5)
        assert found.depth == pytest.approx([0.001] * 2, abs=1e-5)
    assert stands.points == pytest.approx(np.array([[0, -0.5995, 0]]), abs=1e-5)
    assert inside.depth == pytest.approx([0.2, 0.2], abs=1e-5)


# Planes --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("real", REALS)
@pytest.mark.parametrize("kind", ["sphere", "capsule", "box"])
def test_planes_answer_as_the_scalar_routine(kind, real) -> None:
    """The lowest points among those of the scalar routine, that of a box keeping the face's."""
    rng = np.random.default_rng(14)
    shapes, turns, normals, heights = [], [], [], []
    for k in range(120):
        shapes.append(random_shape(kind, rng, thin=k % 5 == 0))
        turns.append(CUBE_TURNS[k % 7] @ rotation((1, *(1e-3 * rng.normal(size=3)))) if k % 2 else turned(rng))
        n = rng.normal(size=3) if k % 3 else np.eye(3)[k // 3 % 3]
        normals.append(n / np.linalg.norm(n))
        low = -np.min(_lowest(shapes[-1], turns[-1], normals[-1]))
        heights.append(low + rng.choice([-0.3, 0.3, 0.01, -1e-3, 0.0, 0.021], p=[0.1, 0.1, 0.3, 0.3, 0.1, 0.1]))
    blocks = both_readings((kind, "plane"), planes_of(shapes, turns, normals, heights, real, 0.02))
    poses = [
        Pose(shape, Plane(tuple(n), 0.0), h * n, np.zeros(3), turn, STILL)
        for shape, n, h, turn in zip(shapes, normals, heights, turns, strict=True)
    ]
    scalar = contacts_of(poses, real, margin=0.02)
    tolerance = 2e-6 if real is np.float32 else 1e-12
    resting = 0
    for k, pose in enumerate(poses):
        found, wanted = lane_contact(blocks, k, pose.position_a), contact(scalar, k, pose)
        assert found.normal == pytest.approx(-normals[k], abs=1e-6)
        assert (len(found.depth) > 0) == (len(wanted.depth) > 0) or heights[k] == pytest.approx(0.02, abs=1e-6)
        if kind != "box":
            assert len(found.depth) == len(wanted.depth)
        for point, depth, feature in zip(found.points, found.depth, found.feature, strict=True):
            same = int(np.flatnonzero(wanted.feature == feature)[0])
            assert point == pytest.approx(wanted.points[same], abs=5 * tolerance)
            assert depth == pytest.approx(wanted.depth[same], abs=5 * tolerance)
        if len(found.depth):
            resting += len(found.depth) > 1
            assert found.depth.max() == pytest.approx(wanted.depth.max(), abs=5 * tolerance)
            assert (np.diff(found.depth) <= 2 * tolerance).all()
            if len(wanted.depth) <= 4 and kind == "box" and min(pose.a.size) > 0.1:
                assert len(found.depth) == len(wanted.depth)
    assert resting > 20 or kind == "sphere"


def _lowest(shape: Shape, turn: npt.NDArray[np.float64], n: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    if isinstance(shape, Box):
        return np.array(list(itertools.product((-0.5, 0.5), repeat=3))) * shape.size @ turn.T @ n
    half = 0.5 * shape.length if isinstance(shape, Capsule) else 0.0
    return np.array([half, -half]) * (turn[:, 1] @ n) - shape.radius


@pytest.mark.parametrize("real", REALS)
def test_a_box_flat_on_a_plane_touches_at_four_corners(real) -> None:
    for turn in CUBE_TURNS:
        blocks = both_readings(("box", "plane"), planes_of([CUBE], [turn], [[0, 1, 0]], [0.499], real, 0.02))
        found = lane_contact(blocks, 0)
        wanted = [(x, -0.4995, z) for x in (-0.5, 0.5) for z in (-0.5, 0.5)]
        assert same_points(found.points, wanted, 1e-6)
        assert found.depth == pytest.approx([0.001] * 4, abs=1e-6)
        assert len(set(found.feature.tolist())) == 4
