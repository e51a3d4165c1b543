"""Case 16: the corner of one free box strikes the face of another, without friction.

With the unit normal n from a to b, arms r to the contact point and approach speed v_n = n · (v_b + ω_b × r_b − v_a − ω_a × r_a) < 0, the impulse is
j = −(1 + e) v_n / k, k = 1/m_a + 1/m_b + (r_a × n) · I_a⁻¹ (r_a × n) + (r_b × n) · I_b⁻¹ (r_b × n), and the energy changes by
ΔE = j v_n + ½ k j² = −½ (1 − e²) v_n²/k. P and L are conserved. (Derived in docs/solver.md.)

That is the law of an instant. With e = 0 the bodies stay in contact and spin on, and in substeps the contact goes on pressing for the rest of the
step: j grows by a share of about ω dt. So the step is short.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

import atlasphys as ap
from atlasphys.validate.case import Case, MakeWorld, relative

SIZE_A, SIZE_B, MASS_A, MASS_B = (2.0, 1.0, 1.5), (0.8, 0.5, 0.6), 3.0, 2.0
OVERLAP = 1e-4
"""Depth at which the corner is placed [m]: touching, and less than what position correction acts on. k does not depend on it."""

RESTITUTIONS = (0.0, 0.5, 1.0)

VELOCITY_A, SPIN_A = (0.3, 0.5, -0.2), (0.4, -0.6, 0.5)
VELOCITY_B, SPIN_B = (-0.5, -2.0, 0.4), (1.5, 0.7, -1.1)


def rotation(q: tuple[float, float, float, float]) -> npt.NDArray[np.float64]:
    """The matrix of a unit quaternion."""
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def inverse_inertia(
    mass: float, size: tuple[float, float, float], turned: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """I⁻¹ of a box in world axes."""
    x, y, z = (side * side for side in size)
    moments = mass / 12 * np.array([y + z, x + z, x + y])
    inverse: npt.NDArray[np.float64] = turned / moments @ turned.T
    return inverse


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Let b, standing on a corner, strike the upper face of a, for three restitutions."""
    q = np.array([0.83, 0.31, 0.22, 0.41])
    w, x, y, z = (float(value) for value in q / math.sqrt(float(q @ q)))
    turned = rotation((w, x, y, z))
    signs = np.array([[sx, sy, sz] for sx in (-1, 1) for sy in (-1, 1) for sz in (-1, 1)])
    corners = (signs * np.array(SIZE_B) / 2) @ turned.T
    lowest = corners[np.argmin(corners[:, 1])]
    point = np.array([0.6, 0.5 * SIZE_A[1], -0.4])
    center_b = point - lowest - np.array([0, OVERLAP, 0])

    n, r_a, r_b = np.array([0.0, 1.0, 0.0]), point, lowest
    arm_a, arm_b = np.cross(r_a, n), np.cross(r_b, n)
    turn_a, turn_b = inverse_inertia(MASS_A, SIZE_A, np.eye(3)) @ arm_a, inverse_inertia(MASS_B, SIZE_B, turned) @ arm_b
    k = float(1 / MASS_A + 1 / MASS_B + arm_a @ turn_a + arm_b @ turn_b)
    approach = float(n @ (VELOCITY_B + np.cross(SPIN_B, r_b) - VELOCITY_A - np.cross(SPIN_A, r_a)))

    errors = dict.fromkeys(("impulse", "momentum", "angular momentum", "energy", "velocity"), 0.0)
    for e in RESTITUTIONS:
        world = make_world(gravity=(0, 0, 0))
        a = world.add(
            ap.Box(size=SIZE_A), mass=MASS_A, velocity=VELOCITY_A, angular_velocity=SPIN_A, friction=0, restitution=e
        )
        b = world.add(
            ap.Box(size=SIZE_B),
            mass=MASS_B,
            position=center_b,
            orientation=(w, x, y, z),
            velocity=VELOCITY_B,
            angular_velocity=SPIN_B,
            friction=0,
            restitution=e,
        )
        momentum, spin, energy = world.momentum(), world.angular_momentum(), world.energy().kinetic
        world.step(dt)
        j = -(1 + e) * approach / k
        left_a, left_b = VELOCITY_A - j / MASS_A * n, VELOCITY_B + j / MASS_B * n
        found: dict[str, float] = {
            "impulse": relative(float(world.contacts.normal_impulse.sum()), j),
            "momentum": float(np.abs(world.momentum() - momentum).max()) / j,
            "angular momentum": float(np.abs(world.angular_momentum() - spin).max()) / j,
            "energy": abs(world.energy().kinetic - energy + 0.5 * (1 - e * e) * approach**2 / k) / energy,
            "velocity": float(max(np.abs(a.velocity - left_a).max(), np.abs(b.velocity - left_b).max()))
            / abs(approach),
        }
        errors = {name: max(errors[name], value) for name, value in found.items()}
    return errors


CASE = Case(
    number=16,
    name="corner on face",
    law="j = −(1 + e) v_n/k; P and L conserved; ΔE = −½ (1 − e²) v_n²/k",
    measure=measure,
    tolerances={"impulse": 1e-6, "energy": 1e-6, "velocity": 1e-6, "momentum": 1e-12, "angular momentum": 1e-12},
    dt=1e-6,
    precision="double",
)
