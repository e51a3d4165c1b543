"""What contacts must be besides deep enough: symmetric, steady, on both surfaces, the same anywhere in the world."""

from __future__ import annotations

import itertools

import numpy as np
import numpy.typing as npt
import pytest

from atlasphys.engine.narrowphase.dispatch import METHODS, collide
from atlasphys.engine.shapes.box import Box
from atlasphys.engine.shapes.capsule import Capsule
from atlasphys.engine.shapes.cone import Cone
from atlasphys.engine.shapes.cylinder import Cylinder
from atlasphys.engine.shapes.hull import ConvexHull, octahedron
from atlasphys.engine.shapes.plane import Plane
from atlasphys.engine.shapes.shape import Shape
from atlasphys.engine.shapes.sphere import Sphere
from atlasphys.engine.state.contacts import empty_contacts
from tests.engine.narrowphase.poses import (
    KINDS,
    Contact,
    Pose,
    contact,
    contacts_of,
    random_poses,
    random_shape,
    state_of,
    turned,
)
from tests.reference.narrowphase import corners, overlap, reach, rotation

STILL = np.eye(3)
CUBE = Box((1.0, 1.0, 1.0))
CUBE_HULL = ConvexHull(corners(CUBE))


def placed(a: Shape, b: Shape, offset: tuple[float, float, float], turn_b: npt.NDArray[np.float64] = STILL) -> Pose:
    return Pose(a, b, np.zeros(3), np.array(offset), STILL, turn_b)


def one(pose: Pose, method: str = "auto", margin: float = 0.02, real: npt.DTypeLike = np.float64) -> Contact:
    return contact(contacts_of([pose], real, method, margin), 0, pose)


# Known answers -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("real", [np.float32, np.float64])
@pytest.mark.parametrize("top", [CUBE, CUBE_HULL])
def test_a_box_on_a_box_touches_at_its_four_corners(method: str, real: npt.DTypeLike, top: Shape) -> None:
    found = one(placed(Box((4.0, 1.0, 4.0)), top, (0.25, 0.998, 0.5)), method, real=real)
    assert found.normal.tolist() == [0.0, 1.0, 0.0]
    assert found.depth == pytest.approx([0.002] * 4, abs=1e-6)
    wanted = sorted((x, 0.499, z) for x in (-0.25, 0.75) for z in (0.0, 1.0))
    assert np.array(sorted(found.points.round(5).tolist())) == pytest.approx(np.array(wanted), abs=1e-5)
    assert len(set(found.feature.tolist())) == 4


@pytest.mark.parametrize("method", METHODS)
def test_features_are_steady_while_a_stack_trembles(method: str) -> None:
    rng = np.random.default_rng(3)
    still = placed(CUBE, CUBE, (0.0, 0.999, 0.0))
    features = sorted(one(still, method, real=np.float32).feature.tolist())
    assert len(features) == 4
    for _ in range(50):
        trembling = still._replace(
            position_b=still.position_b + 1e-4 * rng.uniform(-1, 1, 3),
            rotation_b=rotation((1, *(1e-4 * rng.uniform(-1, 1, 3)))),
        )
        found = one(trembling, method, real=np.float32)
        assert sorted(found.feature.tolist()) == features
        assert found.normal == pytest.approx([0, 1, 0], abs=3e-4)


def test_a_face_is_preferred_to_an_edge_axis_that_is_hardly_better() -> None:
    # Tilted by 0.4 mm over its width, a cube keeps its face contact, though edge axes come near the normal.
    for tilt in itertools.product((-2e-4, 2e-4), repeat=2):
        found = one(placed(CUBE, CUBE, (0.3, 0.999, 0.2), rotation((1, tilt[0], 0.3, tilt[1]))))
        assert found.normal.tolist() == [0.0, 1.0, 0.0]
        assert len(found.depth) >= 3


@pytest.mark.parametrize("real", [np.float32, np.float64])
@pytest.mark.parametrize("method", METHODS)
def test_concentric_and_identical_shapes_have_a_unit_normal_that_parts_them(method: str, real: npt.DTypeLike) -> None:
    rng = np.random.default_rng(11)
    for kind in KINDS:
        shape = random_shape(kind, rng)
        pose = placed(shape, shape, (0.0, 0.0, 0.0))
        found = one(pose, method, real=real)
        h = float(overlap(shape, shape, STILL, STILL, np.zeros(3), found.normal))
        assert np.linalg.norm(found.normal) == pytest.approx(1.0, abs=1e-6)
        assert found.depth.max() == pytest.approx(h, abs=1e-3)


def test_round_off_does_not_span_a_plane() -> None:
    # Of two capsules in the same place, GJK's simplex is the origin alone: no measure of round-off.
    shape = Capsule(0.25, 0.9777094579516271)
    turn = rotation((1, 0, 0, 1))
    assert turn[0, 0] == 2.0**-52
    found = one(Pose(shape, shape, np.zeros(3), np.zeros(3), turn, turn), "gjk_epa")
    assert found.depth.max() == pytest.approx(0.5)
    assert found.normal @ turn[:, 1] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_a_sphere_leaves_the_middle_of_a_cylinder_sideways(real: npt.DTypeLike) -> None:
    # EPA meets many faces in one plane here. Where round-off chose which of them to replace, it lost its surface.
    rng = np.random.default_rng(5)
    poses = [Pose(Sphere(0.3), Cylinder(0.36, 0.77), np.zeros(3), np.zeros(3), STILL, turned(rng)) for _ in range(100)]
    contacts = contacts_of(poses, real, "gjk_epa")
    for k, pose in enumerate(poses):
        assert contact(contacts, k, pose).depth.max() == pytest.approx(0.66, abs=1e-3)


def test_sphere_against_box_corner_edge_face_and_inside() -> None:
    ball = Sphere(0.5)
    corner = one(placed(ball, CUBE, (-0.7, -0.7, -0.7)))
    assert corner.normal == pytest.approx(-np.ones(3) / np.sqrt(3))
    assert corner.depth == pytest.approx([0.5 - 0.2 * np.sqrt(3)])
    edge = one(placed(ball, CUBE, (0.0, -0.7, -0.7)))
    assert edge.normal == pytest.approx(-np.array([0, 1, 1]) / np.sqrt(2))
    inside = one(placed(ball, CUBE, (0.1, -0.3, 0.2)))
    assert inside.normal.tolist() == [0, -1, 0]
    assert inside.depth == pytest.approx([0.7])


def test_parallel_capsules_touch_at_both_ends_of_what_they_share() -> None:
    found = one(placed(Capsule(0.25, 2.0), Capsule(0.25, 1.0), (0.49, 0.2, 0.0)))
    assert found.normal.tolist() == [1.0, 0.0, 0.0]
    assert found.points == pytest.approx(np.array([[0.245, 0.7, 0], [0.245, -0.3, 0]]))
    assert found.depth == pytest.approx([0.01, 0.01])


@pytest.mark.parametrize("method", METHODS)
def test_capsules_on_one_line_part_sideways(method: str) -> None:
    # In single precision the nearest points of the two segments are 2e-8 m apart here, along the line.
    a, b = Capsule(0.32430662, 1.4470218), Capsule(0.27694546, 1.0250993)
    pose = placed(a, b, (0.0, 0.75, 0.0), rotation((0, 1, 0, 0)))._replace(
        position_a=np.array([0.65109291, 0.8272716, -0.56439045]),
        position_b=np.array([0.65109291, 1.5772716, -0.56439045]),
    )
    found = one(pose, method, real=np.float32)
    assert found.normal[1] == pytest.approx(0.0, abs=1e-6)
    assert found.depth.max() == pytest.approx(a.radius + b.radius, abs=1e-6)


@pytest.mark.parametrize("method", METHODS)
def test_a_capsule_lies_on_a_box_at_two_points(method: str) -> None:
    ground = Box((4.0, 1.0, 4.0))
    lying = Pose(Capsule(0.25, 1.0), ground, np.zeros(3), np.array([0, -0.74, 0]), rotation((1, 1, 0, 0)), STILL)
    found = one(lying, method)
    assert found.normal == pytest.approx([0, -1, 0])
    assert found.depth == pytest.approx([0.01, 0.01])
    assert sorted(found.points[:, 2].round(6)) == [-0.5, 0.5]


# Planes --------------------------------------------------------------------------------------------------------------


def lowest(shape: Shape, turn: npt.NDArray[np.float64], n: npt.NDArray[np.float64]) -> float:
    return -float(reach(shape, -n @ turn))


@pytest.mark.parametrize("real", [np.float32, np.float64])
@pytest.mark.parametrize("kind", KINDS)
def test_planes_are_exact(kind: str, real: npt.DTypeLike) -> None:
    rng = np.random.default_rng(5)
    for k in range(60):
        n = np.array([0.0, 1.0, 0.0]) if k % 3 else rng.normal(size=3)
        plane = Plane(normal=tuple(n), offset=float(rng.uniform(-2, 2)))
        n = np.array(plane.normal)
        shape = random_shape(kind, rng)
        turn = (STILL if k % 2 else turned(rng)).astype(real).astype(float)
        height = -lowest(shape, turn, n) - rng.uniform(-0.01, 0.2)
        center = n * (plane.offset + height) + np.cross(n, rng.normal(size=3))
        pose = Pose(plane, shape, np.zeros(3), center, STILL, turn)
        found = one(pose, real=real)
        depth = -(height + lowest(shape, turn, n))
        assert found.depth.max() == pytest.approx(depth, abs=2e-6 if real is np.float32 else 1e-12)
        assert found.normal == pytest.approx(n, abs=1e-6)
        surface = found.points @ n - plane.offset
        assert surface == pytest.approx(-0.5 * found.depth, abs=4e-6)


def test_a_plane_far_away_is_as_exact_as_one_at_hand() -> None:
    far = np.array([3e6, 0.0, -2e6])
    pose = Pose(Plane(), CUBE, far * 0, far + np.array([0.0, 0.499, 0.0]), STILL, STILL)
    found = one(pose, real=np.float32)
    assert found.depth == pytest.approx([0.001] * 4, abs=1e-7)


STANDING = [(Cylinder(0.5, 1.0), 8), (Cone(0.5, 1.0), 8), (CUBE, 4), (Capsule(0.5, 1.0), 1)]


@pytest.mark.parametrize(("shape", "number"), STANDING)
def test_shapes_stand_on_planes(shape: Shape, number: int) -> None:
    height = float(reach(shape, np.array([0.0, -1.0, 0.0])))
    assert len(one(placed(Plane(), shape, (0.0, height - 0.001, 0.0))).depth) == number


# Properties ----------------------------------------------------------------------------------------------------------

PAIRS = list(itertools.combinations_with_replacement(KINDS, 2))


@pytest.mark.parametrize(("kind_a", "kind_b"), PAIRS)
def test_swapping_a_and_b_flips_the_normal(kind_a: str, kind_b: str) -> None:
    rng = np.random.default_rng(7)
    poses = random_poses(kind_a, kind_b, rng, "random", 10)
    swapped = [Pose(p.b, p.a, p.position_b, p.position_a, p.rotation_b, p.rotation_a) for p in poses]
    for method in ("auto", "gjk_epa"):
        there, back = contacts_of(poses, np.float64, method), contacts_of(swapped, np.float64, method)
        for k, pose in enumerate(poses):
            one_way, other_way = contact(there, k, pose), contact(back, k, swapped[k])
            assert len(one_way.depth) == len(other_way.depth)
            assert one_way.normal == pytest.approx(-other_way.normal, abs=1e-4)
            assert sorted(one_way.depth) == pytest.approx(sorted(other_way.depth), abs=1e-5)


@pytest.mark.parametrize(("kind_a", "kind_b"), PAIRS)
def test_contact_points_are_midway_and_both_anchors_are_one_point(kind_a: str, kind_b: str) -> None:
    rng = np.random.default_rng(9)
    poses = random_poses(kind_a, kind_b, rng, "random", 10)
    state = state_of(poses, np.float64)
    offsets = rng.uniform(-0.3, 0.3, (20, 3))
    state.bodies.geometry[:, 9:12] = offsets
    contacts = collide(*state, "auto", 0.01, empty_contacts(1, 1, np.float64))
    for k, pose in enumerate(poses):
        rows = slice(contacts.first[k], contacts.first[k] + contacts.count[k])
        if contacts.count[k] == 0:
            continue
        points = contacts.anchor_a[rows] + pose.position_a + offsets[2 * k]
        others = contacts.anchor_b[rows] + pose.position_b + offsets[2 * k + 1]
        assert np.abs(points - others).max() < 1e-14
        # Half the depth out of either surface along the normal: no farther than that from being on both.
        n = contacts.normal[k]
        for point, depth in zip(points, contacts.depth[rows], strict=True):
            above_a = n @ (point - pose.position_a) + 0.5 * depth - reach(pose.a, n @ pose.rotation_a)
            below_b = -n @ (point - pose.position_b) + 0.5 * depth - reach(pose.b, -n @ pose.rotation_b)
            assert above_a < 1e-3
            assert below_b < 1e-3
        deepest = int(np.argmax(contacts.depth[rows]))
        above_a = n @ (points[deepest] - pose.position_a) + 0.5 * contacts.depth[rows][deepest]
        assert above_a == pytest.approx(float(reach(pose.a, n @ pose.rotation_a)), abs=1e-3)


@pytest.mark.parametrize(("kind_a", "kind_b"), PAIRS)
def test_contacts_do_not_depend_on_where_in_the_world_they_are(kind_a: str, kind_b: str) -> None:
    rng = np.random.default_rng(13)
    far = np.array([2.0**20, -(2.0**21), 2.0**19])  # adding it loses no bits that single precision keeps
    poses = random_poses(kind_a, kind_b, rng, "random", 4)
    poses = [
        p._replace(
            position_a=p.position_a.round(4) * 0 + 0.25, position_b=np.round(64 * (p.position_b - p.position_a)) / 64
        )
        for p in poses
    ]
    moved = [p._replace(position_a=p.position_a + far, position_b=p.position_b + far) for p in poses]
    here, there = contacts_of(poses, np.float32), contacts_of(moved, np.float32)
    for name in ("count", "normal", "anchor_a", "anchor_b", "depth", "feature"):
        used = len(poses) if name in ("count", "normal") else int(here.first[len(poses)])
        assert np.array_equal(getattr(here, name)[:used], getattr(there, name)[:used]), name


def test_pairs_apart_give_points_within_the_margin_only() -> None:
    for gap, wanted in ((0.01, 4), (0.03, 0)):
        for method in METHODS:
            found = one(placed(CUBE, CUBE, (0.0, 1.0 + gap, 0.0)), method)
            assert len(found.depth) == wanted
            assert found.depth == pytest.approx([-gap] * wanted)


def test_buffers_grow_and_are_used_again() -> None:
    rng = np.random.default_rng(1)
    state = state_of(random_poses("box", "box", rng, "random", 9), np.float32)
    small = empty_contacts(1, 1, np.float32)
    grown = collide(*state, "auto", 0.02, small)
    assert len(grown.a) >= 9
    assert len(grown.depth) >= grown.first[9] == 9 * (4 + 4 + 1)
    assert collide(*state, "auto", 0.02, grown) is grown
    nothing = collide(*state[:3], np.empty((0, 2), np.int32), "auto", 0.02, grown)
    assert nothing.first[0] == 0


def test_octahedra_agree_between_sat_and_epa() -> None:
    rng = np.random.default_rng(21)
    poses = [
        Pose(octahedron(1.0), CUBE, np.zeros(3), rng.uniform(-0.6, 0.6, 3), turned(rng), turned(rng)) for _ in range(50)
    ]
    sat, epa = contacts_of(poses, np.float64, "sat"), contacts_of(poses, np.float64, "gjk_epa")
    for k, pose in enumerate(poses):
        assert contact(sat, k, pose).depth.max() == pytest.approx(contact(epa, k, pose).depth.max(), abs=1e-6)
