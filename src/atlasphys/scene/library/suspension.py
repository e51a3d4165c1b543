"""A car."""

from __future__ import annotations

import math
from typing import Annotated, Any

from pydantic import Field

from atlasphys.scene.library.parts import ALONG_Z, Body, Joint, Layout, body, box, ground, joint

RADIUS, WIDTH = 0.35, 0.25
"""Of a wheel [m]."""

BASE, TRACK = 2.6, 1.5
"""Distance of the axles, and of the wheels on one [m]."""

SAG = 0.1
"""By which the springs give under the car [m]."""


def suspension(
    speed: Annotated[float, Field(ge=-30, le=30)] = 8.0,
    steering: Annotated[float, Field(ge=-35, le=35)] = 0.0,
    bumps: Annotated[int, Field(ge=0, le=50)] = 6,
) -> Layout:
    """A car with sprung wheels and rear drive runs over bumps."""
    bodies: list[Body] = [ground(friction=1.0)]
    joints: list[Joint] = []
    bodies.append(box((4.0, 0.5, 1.2), (0, 0.8, 0), mass=1000, name="chassis"))
    # A wheel of 20 kg and the part of the chassis that goes with it: the spring's frequency is that of the wheel between the two.
    springs = {"frequency": 6.0, "damping": 0.8, "rest": -SAG}
    for axle, x in (("front", 0.5 * BASE), ("rear", -0.5 * BASE)):
        for side, z in (("left", -0.5 * TRACK), ("right", 0.5 * TRACK)):
            name, place = f"{axle} {side} wheel", (x, RADIUS, z)
            wheel = {"radius": RADIUS, "length": WIDTH}
            bodies.append(body("cylinder", place, wheel, orientation=ALONG_Z, mass=20, friction=1.0, name=name))
            settings: dict[str, Any] = {"anchor": place, "axis": (0, 1, 0), "axle": (0, 0, 1)}
            settings |= {"limits": (-0.2, 0.2), "spring": springs}
            if axle == "rear":  # rolling forwards, along x, is a negative turn about z
                settings["motor"] = {"speed": -speed / RADIUS, "max_force": 600.0}
            else:
                settings["steering"] = math.radians(steering)
            joints.append(joint("wheel", "chassis", name, **settings, name=f"{axle} {side}"))
    for k in range(bumps):
        lying = {"radius": 1.0, "length": 1.6}
        place = (8.0 + 4.0 * k, -0.92, 1.0 if k % 2 else -1.0)
        bodies.append(
            body("cylinder", place, lying, orientation=ALONG_Z, kind="static", friction=1.0, name=f"bump {k}")
        )
    return Layout(bodies, joints=joints)
