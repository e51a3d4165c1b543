"""Box3D, by ``robox3d`` (single precision): 4 substeps. The half-space is a wide box; it has no cylinders."""

from __future__ import annotations

import weakref
from typing import Any

import numpy as np
import robox3d
from robox3d._ffi import ffi, lib

from atlasphys.engine.shapes.box import Box
from atlasphys.engine.shapes.capsule import Capsule
from atlasphys.engine.shapes.plane import Plane
from atlasphys.engine.shapes.sphere import Sphere
from atlasphys.validate.case import NotOfferedError
from atlasphys.validate.peers import Item, PeerWorld, refuse_rolling

EXTENT, DEPTH = 100.0, 2.0
"""Half the width and the thickness of the box that stands for a half-space [m]."""


class Box3DWorld(PeerWorld):
    """A robox3d world. Its restitution threshold, which the package does not show, is set through the library underneath."""

    def _start(self) -> None:
        self._world = robox3d.World(gravity=self.gravity)
        lib.b3World_SetRestitutionThreshold(self._world.id, 0.0)
        lib.b3World_SetMaximumLinearSpeed(self._world.id, 1e4)
        self.substeps = self._world.substeps
        self._bodies: list[Any] = []
        weakref.finalize(self, self._world.destroy)

    def _add(self, item: Item) -> None:
        refuse_rolling(item)
        material = {"friction": item.friction, "restitution": item.restitution}
        position: Any = item.position
        orientation: Any = item.orientation
        if isinstance(item.shape, Plane):
            normal = np.array(item.shape.normal)
            position = normal * (item.shape.offset - 0.5 * DEPTH)
            half = np.array([1 + normal[1], normal[2], 0.0, -normal[0]])  # from y to the normal: (1 + y · n, y × n)
            orientation = half / np.sqrt(half @ half)
        w, x, y, z = orientation
        kind = "static" if item.static else "dynamic"
        body = self._world.create_body(position=position, rotation=(x, y, z, w), kind=kind)
        match item.shape:
            case Plane():
                body.add_box((EXTENT, 0.5 * DEPTH, EXTENT), **material)
            case Box(size=size):
                body.add_box([0.5 * side for side in size], **material)
            case Sphere(radius=radius):
                body.add_sphere(radius, **material)
            case Capsule(radius=radius, length=length):
                body.add_capsule((0, -0.5 * length, 0), (0, 0.5 * length, 0), radius, **material)
            case _:
                raise NotOfferedError(f"no {type(item.shape).__name__.lower()}")
        if not item.static:
            body.set_mass_data(item.mass, (0, 0, 0), np.diag(item.moments))
            body.linear_velocity, body.angular_velocity = item.velocity, item.angular_velocity
        self._bodies.append(body)

    def _step(self, dt: float) -> None:
        self._world.step(dt)

    def _read(self, row: int) -> tuple[Any, Any, Any, Any]:
        body = self._bodies[row]
        return body.position, body.rotation[[3, 0, 1, 2]], body.linear_velocity, body.angular_velocity

    def _contacts(self) -> list[tuple[int, int, float, float]]:
        rows = {_key(body.id): row for row, body in enumerate(self._bodies)}
        found: list[tuple[int, int, float, float]] = []
        for row, body in enumerate(self._bodies):
            capacity = lib.b3Body_GetContactCapacity(body.id)
            buffer = ffi.new("b3ContactData[]", max(capacity, 1))
            for contact in buffer[0 : lib.b3Body_GetContactData(body.id, buffer, capacity)]:
                a, b = (rows[_key(lib.b3Shape_GetBody(shape))] for shape in (contact.shapeIdA, contact.shapeIdB))
                if row != max(a, b):  # each contact is listed with both of its bodies
                    continue
                found += [
                    (a, b, -point.separation, self.substeps * point.normalImpulse)
                    for manifold in contact.manifolds[0 : contact.manifoldCount]
                    for point in manifold.points[0 : manifold.pointCount]
                ]
        return found


def _key(body: Any) -> tuple[int, int]:
    return body.index1, body.generation


WORLD = Box3DWorld
