"""The parts of joints: Jacobians against finite differences, effective masses against J M⁻¹ Jᵀ, springs against the damped oscillator."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from atlasphys.engine.joints import frames
from atlasphys.engine.joints.elastic import coefficients, decay, versine
from atlasphys.engine.joints.ends import Ends, double_angle
from atlasphys.engine.joints.layout import colours
from atlasphys.engine.joints.parts import PARTS
from atlasphys.engine.joints.rows import masses, pushed, rate
from atlasphys.engine.joints.symmetric import solve_symmetric
from atlasphys.engine.state.joints import COUPLING, LOCK, PART_TYPES, POINT, WORLD

finite = st.floats(-2, 2, allow_nan=False)


def lanes(numbers):
    return tuple(np.array([float(x)]) for x in numbers)


class Scene:
    """Two bodies with random poses, anchors, frames and velocities."""

    def __init__(self, seed):
        random = np.random.default_rng(seed)
        self.center = random.normal(size=(2, 3))
        self.turned = [frames.unit(tuple(random.normal(size=4))) for _ in range(2)]
        self.arm = random.normal(size=(2, 3))
        self.frame = [frames.unit(tuple(random.normal(size=4))) for _ in range(2)]
        self.ground = random.normal(size=(2, 3)) + 5
        self.ratio = random.uniform(0.5, 2, size=2)
        self.turns = random.integers(0, 2, size=2)
        self.velocity, self.spin = random.normal(size=(2, 2, 3))

    def ends(self, time=0.0):
        """The ends after the bodies have moved with their velocities for a time."""
        center = self.center + time * self.velocity
        turned = []
        for q, w in zip(self.turned, self.spin, strict=True):
            speed = float(np.linalg.norm(w))
            turned.append(frames.multiply(frames.turn(tuple(w / speed), speed * time), q))
        arm = [np.array(frames.rotate(q, tuple(r))) for q, r in zip(turned, self.arm, strict=True)]
        point = center + arm
        return Ends(
            lanes(arm[0]),
            lanes(arm[1]),
            lanes(point[1] - point[0]),
            lanes(frames.multiply(turned[0], self.frame[0])),
            lanes(frames.multiply(turned[1], self.frame[1])),
            (lanes(point[0] - self.ground[0]), lanes(point[1] - self.ground[1])),
            lanes(self.ratio),
            lanes(self.turns),
            np.zeros(1),
        )

    def velocities(self):
        return lanes(self.velocity[0]), lanes(self.spin[0]), lanes(self.velocity[1]), lanes(self.spin[1])


@pytest.mark.parametrize("kind", [kind for kind in range(PART_TYPES) if kind != COUPLING])
@pytest.mark.parametrize("seed", range(8))
def test_the_rate_of_the_coordinate_is_what_the_jacobian_says(kind, seed):
    scene, part, h = Scene(seed), PARTS[kind], 1e-5
    speeds = [rate(row, *scene.velocities())[0] for row in part.rows(scene.ends())]
    after, before = part.measure(scene.ends(h)), part.measure(scene.ends(-h))
    for speed, later, earlier in zip(speeds, after, before, strict=True):
        change = (
            (later[0] - earlier[0] + math.pi) % (2 * math.pi) - math.pi
            if abs(later[0] - earlier[0]) > 3
            else later[0] - earlier[0]
        )
        assert speed == pytest.approx(change / (2 * h), rel=1e-5, abs=1e-7)


@pytest.mark.parametrize("turns", [(0, 0), (0, 1), (1, 0), (1, 1)])
def test_a_coupling_counts_rotation_or_translation_along_axes_of_the_bodies(turns):
    scene = Scene(3)
    scene.turns = np.array(turns)
    ends = scene.ends()
    expected = 0.0
    for side, frame in enumerate((ends.frame_a, ends.frame_b)):
        n = np.array(frames.rotate(tuple(float(x[0]) for x in frame), (1.0, 0.0, 0.0)))
        moving = scene.spin if turns[side] else scene.velocity
        expected += scene.ratio[side] * (n @ moving[side])
    assert rate(PARTS[COUPLING].rows(ends)[0], *scene.velocities())[0] == pytest.approx(expected)


def symmetric(six):
    xx, yy, zz, xy, xz, yz = six
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def full_jacobian(rows):
    """(rows, 12) over v_a, ω_a, v_b, ω_b."""

    def numbers(vector):
        return [float(np.asarray(x).reshape(-1)[0]) for x in vector]

    return np.array(
        [
            [-x for x in numbers(row.push_a)]
            + [-x for x in numbers(row.turn_a)]
            + numbers(row.push_b)
            + numbers(row.turn_b)
            for row in rows
        ]
    )


@given(st.integers(0, 10**6), st.integers(0, PART_TYPES - 1), st.sampled_from([(1, 1), (0, 1), (1, 0), (0, 0)]))
@settings(max_examples=60, deadline=None)
def test_effective_mass_and_impulses_are_those_of_the_jacobian(seed, kind, movable):
    """K = J M⁻¹ Jᵀ, degenerate masses included; and impulses change velocities by M⁻¹ Jᵀ λ."""
    scene, random = Scene(seed), np.random.default_rng(seed)
    inverse, blocks = [], []
    for moves in movable:
        m = moves * random.uniform(0.1, 3, size=3)
        root = random.normal(size=(3, 3))
        tensor = moves * (root @ root.T)
        inverse += [lanes(m), lanes(tensor[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]])]
        blocks += [np.diag(m), tensor]
    full_inverse = np.zeros((12, 12))
    for k, block in enumerate(blocks):
        full_inverse[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = block
    rows = PARTS[kind].rows(scene.ends())
    jacobian = full_jacobian(rows)
    expected = jacobian @ full_inverse @ jacobian.T
    found = masses(rows, *inverse)
    for i, line in enumerate(found):
        for j, entry in enumerate(line):
            assert np.asarray(entry).reshape(-1)[0] == pytest.approx(expected[i, i + j], rel=1e-9, abs=1e-9)

    wanted = random.normal(size=len(rows))
    if len(rows) > 1 and np.linalg.cond(expected) < 1e5:
        with np.errstate(all="ignore"):
            solved = solve_symmetric(found, list(lanes(wanted)))
        assert np.array([x[0] for x in solved]) == pytest.approx(np.linalg.solve(expected, wanted), rel=1e-6, abs=1e-9)


def test_impulses_along_a_row_conserve_both_momenta():
    scene = Scene(5)
    mass = (0.5, 2.0)
    inverse = [
        lanes([1 / mass[0]] * 3),
        lanes([1, 2, 3, 0.1, 0.2, 0.3]),
        lanes([1 / mass[1]] * 3),
        lanes([2, 1, 1, 0, 0.1, 0.2]),
    ]
    tensors = [np.linalg.inv(symmetric([x[0] for x in inverse[k]])) for k in (1, 3)]
    for kind in range(PART_TYPES):
        if PARTS[kind].__name__.endswith(("coupling", "pulley")):
            continue  # they push against the world
        ends = scene.ends()
        if kind == POINT:  # the forces are opposite, and so have no torque together where the anchors are at one place
            scene.center[1] -= np.array([x[0] for x in ends.apart])
            ends = scene.ends()
        for row in PARTS[kind].rows(ends):
            row = type(row)(*(tuple(0.7 * x for x in side) for side in row))
            before = scene.velocities()
            after = pushed(row, *before, *inverse)
            change = [
                np.array([float(np.asarray(y - x).reshape(-1)[0]) for x, y in zip(u, v, strict=True)])
                for u, v in zip(before, after, strict=True)
            ]
            linear = mass[0] * change[0] + mass[1] * change[2]
            angular = tensors[0] @ change[1] + tensors[1] @ change[3]
            for k, side in enumerate((0, 2)):
                angular = angular + mass[k] * np.cross(scene.center[k], change[side])
            assert np.abs(linear).max() < 1e-12, kind
            assert np.abs(angular).max() < 1e-12, kind


def test_degenerate_rows_give_no_impulse():
    zero = np.zeros(1)
    with np.errstate(all="ignore"):
        assert solve_symmetric([[zero, zero], [zero]], [zero + 1, zero + 2]) == [0, 0]
        assert solve_symmetric([[zero, zero, zero], [zero, zero], [zero]], [zero + 1] * 3) == [0, 0, 0]
        for kind in range(PART_TYPES):  # anchors together, axes opposite
            ends = Scene(1).ends()._replace(apart=lanes((0, 0, 0)), ropes=(lanes((0, 0, 0)),) * 2)
            w, x, y, z = ends.frame_a
            ends = ends._replace(frame_b=(y, -z, -w, x))
            for row in PARTS[kind].rows(ends):
                assert np.isfinite(full_jacobian([row])).all(), kind


@given(st.floats(-math.pi, math.pi), st.floats(1e-3, 1e3))
def test_double_angle_is_that_of_the_library(angle, size):
    c, s = np.array([size * math.cos(angle / 2)]), np.array([size * math.sin(angle / 2)])
    assert double_angle(c, s)[0] == pytest.approx(2 * math.atan2(s[0], c[0]), rel=1e-14, abs=1e-14)
    assert double_angle(-c, -s)[0] == pytest.approx(double_angle(c, s)[0], abs=1e-14)


@given(st.floats(1e-4, 1e3), st.floats(0, 50), st.floats(1e-5, 0.05))
def test_springs_take_the_step_of_the_damped_oscillator(frequency, damping, h):
    """The step's eigenvalues are e^{(−ζ ± √(ζ² − 1)) ω h}, and a load a stretches the spring by a / ω²."""
    soft = coefficients(np.array([frequency]), np.array([damping]), h)
    alpha, beta, p, q = (float(x[0]) for x in soft)
    omega = 2 * math.pi * min(frequency, 0.15 / h)
    step = np.array([[1 - h * beta, h * alpha], [-beta, alpha]])
    roots = np.exp(h * omega * np.roots([1, 2 * damping, 1]))
    assert np.linalg.det(step) == pytest.approx(np.prod(roots).real, rel=1e-9, abs=1e-12)
    assert (1 - alpha) - (np.trace(step) - 2 * alpha) == pytest.approx(
        ((1 - roots[0]) * (1 - roots[1])).real, rel=1e-6, abs=1e-13
    )
    load = 9.81  # at rest u = a h, v₀ = 0, and v₁ = u − q u − β C = 0
    assert (1 - q) * load * h / beta == pytest.approx(load / omega**2, rel=1e-6)
    assert p + q == pytest.approx(1 - alpha, abs=1e-12)
    assert q > -1e-9
    assert p > -(omega**2) * h**2 / 12 - 1e-9


@given(st.floats(1e-9, 500))
def test_decay_and_versine(x):
    assert decay(np.array([x]))[0] == pytest.approx(-math.expm1(-x), rel=1e-12, abs=0)
    y = min(x, 1.5)
    assert versine(np.array([y]))[0] == pytest.approx(2 * math.sin(y / 2) ** 2, rel=1e-14, abs=1e-300)


@given(st.lists(st.tuples(st.integers(-1, 9), st.integers(-1, 9)), max_size=120))
def test_joints_of_one_colour_share_no_moving_body(pairs):
    body = np.array(pairs, np.int32).reshape(-1, 2)
    moves = np.arange(10) % 4 != 0
    colour = colours(body, moves)
    for c in set(colour.tolist()):
        ends = [end for pair in body[colour == c].tolist() for end in set(pair) if end != WORLD and moves[end]]
        assert len(ends) == len(set(ends))


@pytest.mark.parametrize("kind", [POINT, LOCK])
def test_frames_that_agree_have_no_error(kind):
    ends = Scene(2).ends()._replace(apart=lanes((0, 0, 0)))
    ends = ends._replace(frame_b=tuple(-x for x in ends.frame_a))
    assert np.abs(PARTS[kind].measure(ends)).max() < 1e-15


@given(st.tuples(finite, finite, finite), st.tuples(finite, finite, finite))
def test_frames_of_axes(u, v):
    if np.linalg.norm(u) < 1e-3 or np.linalg.norm(np.cross(u, v)) < 1e-3:
        return
    x = frames.normalised(u)
    y = frames.normalised(frames.cross(frames.normalised(frames.cross(x, v)), x))
    for frame in (frames.shortest_turn(x), frames.of_axes(x, y)):
        assert frames.rotate(frame, (1.0, 0.0, 0.0)) == pytest.approx(x, abs=1e-9)
    assert frames.rotate(frames.of_axes(x, y), (0.0, 1.0, 0.0)) == pytest.approx(y, abs=1e-9)
    for turn, axis in ((frames.TO_Y, (0, 1, 0)), (frames.TO_Z, (0, 0, 1))):
        assert frames.rotate(turn, (1.0, 0.0, 0.0)) == axis


@given(st.floats(-math.pi, math.pi))
def test_turns_are_those_of_the_library(angle):
    assert frames.turn((0.0, 1.0, 0.0), angle) == pytest.approx(
        (math.cos(angle / 2), 0, math.sin(angle / 2), 0), abs=1e-15
    )
