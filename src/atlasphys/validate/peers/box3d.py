"""Box3D, by ``robox3d`` (single precision): 4 substeps. The half-space is a wide box; it has no cylinders."""

from __future__ import annotations

import weakref
from typing import Any

import numpy as np
import robox3d
from robox3d._ffi import ffi, lib

from atlasphys.engine.joints.frames import IDENTITY, TO_Y, multiply
from atlasphys.engine.joints.kinds.ball import Ball
from atlasphys.engine.joints.kinds.distance import Distance, Spring
from atlasphys.engine.joints.kinds.hinge import Hinge
from atlasphys.engine.joints.kinds.kind import JointKind
from atlasphys.engine.shapes.box import Box
from atlasphys.engine.shapes.capsule import Capsule
from atlasphys.engine.shapes.plane import Plane
from atlasphys.engine.shapes.sphere import Sphere
from atlasphys.validate.case import NotOfferedError
from atlasphys.validate.peers import Item, PeerWorld, refuse_joint, refuse_rolling

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
        self._ground: Any = None
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

    def _join(self, a: int | None, b: int, joint: JointKind) -> Any:
        match joint:
            case Ball(cone=None, twist=None, spring=None, friction=0):
                made, make = lib.b3DefaultSphericalJointDef(), lib.b3CreateSphericalJoint
            case Hinge(limits=None, spring=None, friction=0, motor=motor):
                made, make = lib.b3DefaultRevoluteJointDef(), lib.b3CreateRevoluteJoint
                if motor is not None:
                    made.enableMotor, made.motorSpeed, made.maxMotorTorque = True, motor.speed, 1e6
            case Distance(limits=None, length=length):
                made, make = lib.b3DefaultDistanceJointDef(), lib.b3CreateDistanceJoint
                made.length = length
            case Spring(limits=None, rest_length=length, frequency=frequency, damping=damping):
                made, make = lib.b3DefaultDistanceJointDef(), lib.b3CreateDistanceJoint
                made.length, made.enableSpring, made.hertz, made.dampingRatio = length, True, frequency, damping
            case _:
                refuse_joint(joint)
        to_z = TO_Y  # it takes z to x: its hinges turn about z
        ground = self._ground = self._ground or self._world.create_body(kind="static")
        made.base.bodyIdA, made.base.bodyIdB = (ground if a is None else self._bodies[a]).id, self._bodies[b].id
        for frame, anchor, turned in zip(
            (made.base.localFrameA, made.base.localFrameB), joint.anchors(), joint.frames(), strict=True
        ):
            frame.p.x, frame.p.y, frame.p.z = anchor
            frame.q.s, frame.q.v.x, frame.q.v.y, frame.q.v.z = multiply(turned or IDENTITY, to_z)
        return make(self._world.id, ffi.addressof(made))

    def _force(self, joint: Any) -> Any:
        force = lib.b3Joint_GetConstraintForce(joint)
        return force.x, force.y, force.z

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
