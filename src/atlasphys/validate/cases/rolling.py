"""Case 7: rolling down an incline.

For a round body with I = c m R² that rolls without slip, m a = m g sin θ − F and c m R² (a/R) = F R give a = g sin θ / (1 + c), and the grip
F ≤ μ m g cos θ needs μ ≥ c/(1 + c) tan θ: c is ⅖ for a solid sphere, ½ for a solid cylinder, 1 for a hoop. With less friction it slides with
a = g (sin θ − μ cos θ).
"""

from __future__ import annotations

import math

import numpy as np

import atlasphys as ap
from atlasphys.validate.case import Case, G, MakeWorld, relative

RADIUS, LENGTH, SLOPE, SECONDS = 0.5, 0.4, 0.5, 2.0

_ALONG_Z = (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)
_HOOP = (0.5 * RADIUS**2 + LENGTH**2 / 12, RADIUS**2, 0.5 * RADIUS**2 + LENGTH**2 / 12)

BODIES = {
    # shape, moments of inertia for a mass of 1 kg, orientation, c
    "sphere": (ap.Sphere(radius=RADIUS), None, (1.0, 0.0, 0.0, 0.0), 0.4),
    "cylinder": (ap.Cylinder(radius=RADIUS, length=LENGTH), None, _ALONG_Z, 0.5),
    "hoop": (ap.Cylinder(radius=RADIUS, length=LENGTH), _HOOP, _ALONG_Z, 1.0),
}


def measure(make_world: MakeWorld, dt: float) -> dict[str, float]:
    """Let each body go from rest, with 1.2 and with 0.8 of the friction that rolling needs."""
    angle = math.atan(SLOPE)
    sine, cosine = round(math.sin(angle), 15), round(math.cos(angle), 15)
    errors = {}
    for name, (shape, inertia, orientation, c) in BODIES.items():
        least = c / (1 + c) * SLOPE
        for word, friction, expected in (
            ("rolls", 1.2 * least, G * sine / (1 + c)),
            ("slides", 0.8 * least, G * (sine - 0.8 * least * cosine)),
        ):
            world = make_world(gravity=(0, -G, 0))
            world.add(ap.Plane(normal=(sine, cosine, 0)), friction=friction)
            body = world.add(
                shape,
                position=(RADIUS * sine, RADIUS * cosine, 0),
                orientation=orientation,
                mass=1,
                inertia=inertia,
                friction=friction,
            )
            world.run(seconds=SECONDS, dt=dt)
            errors[f"{name} {word}"] = relative(float(np.linalg.norm(body.velocity)) / SECONDS, expected)
            if word == "rolls":
                errors[f"{name} slip"] = relative(
                    -RADIUS * body.angular_velocity[2], float(np.linalg.norm(body.velocity))
                )
    return errors


CASE = Case(
    number=7,
    name="rolling down an incline",
    law="a = g sin θ × 5/7 (sphere), 2/3 (cylinder), 1/2 (hoop) if μ exceeds 2/7, 1/3, 1/2 of tan θ",
    measure=measure,
    tolerances={f"{name} {word}": 0.01 for name in BODIES for word in ("rolls", "slip", "slides")},
)
