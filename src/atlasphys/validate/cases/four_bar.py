"""Case 24: a four-bar linkage whose crank turns at a constant rate.

With lengths a of the crank, b of the coupler, c of the rocker and d of the ground, crank angle θ2 and rocker angle θ4 satisfy Freudenstein's equation
K1 cos θ4 − K2 cos θ2 + K3 = cos(θ2 − θ4), K1 = d/a, K2 = d/c, K3 = (a² − b² + c² + d²)/(2 a c). With t = tan(θ4/2) it is A t² + B t + C = 0,
A = cos θ2 − K1 − K2 cos θ2 + K3, B = −2 sin θ2, C = K1 − (K2 + 1) cos θ2 + K3. The rocker's speed is ω4 = ω2 (a/c) sin(θ2 − θ3)/sin(θ4 − θ3), θ3 the
coupler's angle (Norton, Design of Machinery, §4.5 and §6.7).

A speed belongs to a time. Solvers that end a step by making velocities fit the joints where the bodies now are (relaxing, as ``soft_step``,
``sequential_impulse`` and ``xpbd`` do) report it at the step's end. A leapfrog scheme (``avbd``) reports the velocity with which the bodies
moved, the mean over the step; the exact mean is the change of the exact angle over dt. At 1/240 s the two differ by 1.1 % of the greatest speed.
Which of them a solver reports is seen from what it does: if its speeds are the changes of its own angles over dt, up to a tenth of what they
change by in a step, they are means.
"""

from __future__ import annotations

import math

import numpy as np

import atlasphys as ap
from atlasphys.validate.case import Case, Curve, Doubles, G, MakeWorld, turned_about_z

CRANK, COUPLER, ROCKER, GROUND = 0.5, 2.0, 1.5, 2.0
"""a, b, c, d [m]. The shortest and longest together are shorter than the other two: the crank turns round and round (Grashof)."""

RATE, TURNS = 4.0, 2
"""ω2 [rad/s], and turns of the crank that are followed."""

SETTLED = 0.05
"""Time in which the joints, which begin without impulses, take up the loads; the speed is judged from then on [s]."""

START = 0.5
"""θ2 at the start [rad]."""


def solution(crank: Doubles) -> tuple[Doubles, Doubles, Doubles]:
    """θ4 and θ3 [rad] of the open linkage, and ω4 [rad/s], for crank angles (n,)."""
    a, b, c, d = CRANK, COUPLER, ROCKER, GROUND
    k1, k2, k3 = d / a, d / c, (a * a - b * b + c * c + d * d) / (2 * a * c)
    cosine = np.cos(crank)
    first, second, third = cosine - k1 - k2 * cosine + k3, -2 * np.sin(crank), k1 - (k2 + 1) * cosine + k3
    rocker = 2 * np.arctan2(-second - np.sqrt(second * second - 4 * first * third), 2 * first)
    coupler = np.arctan2(c * np.sin(rocker) - a * np.sin(crank), d + c * np.cos(rocker) - a * cosine)
    speed = RATE * a / c * np.sin(crank - coupler) / np.sin(rocker - coupler)
    return np.mod(rocker, 2 * math.pi), coupler, speed


def drive(make_world: MakeWorld, dt: float) -> tuple[Doubles, Doubles, Doubles]:
    """Times, θ4 and ω4 of the simulated rocker."""
    world = make_world(gravity=(0, -G, 0))
    (rocker,), (coupler,), (speed,) = solution(np.array([START]))
    pin = CRANK * math.cos(START), CRANK * math.sin(START)
    # ω3 from the same loop: its end moves as the crank's and the rocker's do.
    turning = RATE * CRANK / COUPLER * math.sin(rocker - START) / math.sin(coupler - rocker)
    bars = []
    for x, y, length, angle, spin, moves in (
        (0.0, 0.0, CRANK, START, RATE, (0.0, 0.0)),
        (*pin, COUPLER, coupler, turning, (-RATE * pin[1], RATE * pin[0])),
        (GROUND, 0.0, ROCKER, rocker, speed, (0.0, 0.0)),
    ):
        half = 0.5 * length * math.cos(angle), 0.5 * length * math.sin(angle)
        bars.append(
            world.add(
                ap.Box(size=(length, 0.1, 0.1)),
                position=(x + half[0], y + half[1], 0),
                orientation=turned_about_z(float(angle)),
                velocity=(moves[0] - spin * half[1], moves[1] + spin * half[0], 0),
                angular_velocity=(0, 0, spin),
                mass=1,
            )
        )
    top = GROUND + ROCKER * math.cos(rocker), ROCKER * math.sin(rocker), 0.0
    axis, motor = (0, 0, 1), ap.Motor(speed=RATE)
    world.join(ap.Hinge(None, bars[0], anchor=(0, 0, 0), axis=axis, motor=motor))
    world.join(ap.Hinge(bars[0], bars[1], anchor=(*pin, 0), axis=axis))
    world.join(ap.Hinge(bars[1], bars[2], anchor=top, axis=axis))
    world.join(ap.Hinge(None, bars[2], anchor=(GROUND, 0, 0), axis=axis))
    rows = []
    for _ in range(round(TURNS * 2 * math.pi / RATE / dt)):
        world.step(dt)
        w, _, _, z = bars[2].orientation
        rows.append((world.time, 2 * math.atan2(z, w), bars[2].angular_velocity[2]))
    times, angles, speeds = np.array(rows).T
    return times, np.mod(angles, 2 * math.pi), speeds


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Follow the rocker for two turns of the crank. Errors are shares of the range of the angle and of the greatest speed."""
    times, angles, speeds = drive(make_world, dt)
    expected, _, rates = solution(START + RATE * times)
    moved = np.diff(np.unwrap(angles)) / dt
    if np.abs(speeds[1:] - moved).max() < 0.1 * np.abs(np.diff(rates)).max():
        before = solution(START + RATE * (times - dt))[0]
        rates = np.diff(np.unwrap(np.stack([before, expected]), axis=0), axis=0)[0] / dt
    off = np.abs(speeds - rates) / np.abs(rates).max()
    loaded = times > SETTLED
    return {
        "rocker's angle": float(np.abs(angles - expected).max() / np.ptp(expected)),
        "rocker's speed": float(off[loaded].max()),
        "rocker's speed at first": float(off[~loaded].max()),
    }


def curve(make_world: MakeWorld, dt: float) -> Curve:
    """The rocker's angle."""
    times, angles, _ = drive(make_world, dt)
    return Curve("θ4 [rad]", times, angles, solution(START + RATE * times)[0])


CASE = Case(
    number=24,
    name="four-bar linkage",
    law="Freudenstein: K1 cos θ4 − K2 cos θ2 + K3 = cos(θ2 − θ4)",
    measure=measure,
    tolerances={"rocker's angle": 0.005, "rocker's speed": 0.005},
    curve=curve,
)
