"""Case 6: an oblique bounce of a solid sphere.

The normal impulse is m (1 + e) v_n and bounds the friction impulse by μ m (1 + e) v_n. A tangential impulse p changes the slip (the velocity of the
sphere's lowest point) by p/m + p R²/I = (7/2) p/m, for I = ⅖ m R². So friction ends the slip with Δv_t = −(2/7) slip if that is within the
bound, and else slides throughout with Δv_t = −μ (1 + e) v_n against the slip. The spin changes by I Δω = −R n × p.
"""

from __future__ import annotations

import numpy as np

import atlasphys as ap
from atlasphys.validate.case import Case, MakeWorld

RADIUS, FRICTION, RESTITUTION, APPROACH = 0.5, 0.3, 0.7, 3.0
LIMIT = 3.5 * FRICTION * (1 + RESTITUTION) * APPROACH
"""Greatest slip [m/s] that the bounce ends."""

THROWS = (
    # velocity along the ground (x, z), angular velocity
    ((0.9 * LIMIT, 0.0), (0.0, 0.0, 0.0)),
    ((1.1 * LIMIT, 0.0), (0.0, 0.0, 0.0)),
    ((3.0, -4.0), (0.0, 0.0, 0.0)),
    ((3.0, -4.0), (5.0, 2.0, 6.0)),
    ((0.0, 0.0), (3.0, 0.0, -8.0)),
    ((0.0, 0.0), (0.0, 0.0, 40.0)),
    ((4.0, 0.0), (0.0, 0.0, -8.0)),  # rolls already: no friction at all
)


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Throw spheres at the ground, without gravity, and compare what each leaves with."""
    errors = {"normal": 0.0, "tangential": 0.0, "spin": 0.0}
    for (x, z), spin in THROWS:
        world = make_world(gravity=(0, 0, 0))
        world.add(ap.Plane(normal=(0, 1, 0)), friction=FRICTION)
        ball = world.add(
            ap.Sphere(radius=RADIUS),
            position=(0, RADIUS + 0.25 * APPROACH * dt, 0),
            velocity=(x, -APPROACH, z),
            angular_velocity=spin,
            friction=FRICTION,
            restitution=RESTITUTION,
        )
        slip = np.array([x + RADIUS * spin[2], 0.0, z - RADIUS * spin[0]])
        size = float(np.linalg.norm(slip))
        change = -min(2 / 7, FRICTION * (1 + RESTITUTION) * APPROACH / size if size > 0 else 1.0) * slip
        # Δω = (r × m Δv_t) / I with r = (0, −R, 0) and I = ⅖ m R²
        turned = np.array(spin) + np.cross((0, -1, 0), change) / (0.4 * RADIUS)
        for _ in range(5):
            world.step(dt)
        found = ball.velocity
        scale = max(size, APPROACH)
        errors["normal"] = max(errors["normal"], abs(found[1] / (RESTITUTION * APPROACH) - 1))
        off = np.array([found[0] - x - change[0], found[2] - z - change[2]])
        errors["tangential"] = max(errors["tangential"], float(np.linalg.norm(off)) / scale)
        off = RADIUS * (ball.angular_velocity - turned)
        errors["spin"] = max(errors["spin"], float(np.linalg.norm(off)) / scale)
    return errors


CASE = Case(
    number=6,
    name="oblique bounce of a sphere",
    law="Δv_t = −μ (1 + e) v_n against the slip if |slip| > (7/2) μ (1 + e) v_n, else −(2/7) slip",
    measure=measure,
    tolerances={"normal": 0.01, "tangential": 0.01, "spin": 0.01},
)
