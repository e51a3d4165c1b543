"""PyBullet, without a display (double precision): 50 iterations. It multiplies coefficients, so each body gets the root of its friction."""

from __future__ import annotations

import math
import weakref
from typing import Any

import pybullet

from atlasphys.engine.joints.kinds.ball import Ball
from atlasphys.engine.joints.kinds.kind import JointKind
from atlasphys.engine.shapes.box import Box
from atlasphys.engine.shapes.capsule import Capsule
from atlasphys.engine.shapes.cylinder import Cylinder
from atlasphys.engine.shapes.plane import Plane
from atlasphys.engine.shapes.sphere import Sphere
from atlasphys.validate.case import NotOfferedError
from atlasphys.validate.peers import Item, PeerWorld, refuse_joint

ALONG_Y = (math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
"""The rotation (x, y, z, w) that takes z, along which its cylinders and capsules lie, to an axis of which only the line matters, y."""


class PyBulletWorld(PeerWorld):
    """A PyBullet server in this process. Damping, 0.04 by default, is 0, and so is the threshold of restitution."""

    def _start(self) -> None:
        self._client = pybullet.connect(pybullet.DIRECT)
        pybullet.setGravity(*self.gravity, physicsClientId=self._client)
        pybullet.setPhysicsEngineParameter(restitutionVelocityThreshold=0.0, physicsClientId=self._client)
        self._bodies: list[int] = []
        self._dt = 0.0
        weakref.finalize(self, _disconnect, self._client)

    def _add(self, item: Item) -> None:
        client = {"physicsClientId": self._client}
        w, x, y, z = item.orientation
        body = pybullet.createMultiBody(
            item.mass, _shape(item.shape, client), basePosition=item.position, baseOrientation=(x, y, z, w), **client
        )
        root = math.sqrt(item.friction)
        pybullet.changeDynamics(
            body, -1, lateralFriction=root, restitution=1.0 if item.static else item.restitution,
            # It adds up each body's spinning and rolling friction times the other's coefficient. In our cases one body of a pair has
            # torsional friction, and its limit is μ times it; both have the same rolling friction, which is a length by itself.
            spinningFriction=root * item.torsional_friction,
            rollingFriction=0.5 * item.rolling_friction / root if root else 0.0,
            linearDamping=0.0, angularDamping=0.0, **client,
        )  # fmt: skip
        if not item.static:
            pybullet.changeDynamics(body, -1, localInertiaDiagonal=item.moments, **client)
            pybullet.resetBaseVelocity(body, item.velocity, item.angular_velocity, **client)
            between = [other.restitution for other in self._items if not other.static]
            if any(other != item.restitution for other in between):
                raise NotOfferedError("it multiplies coefficients of restitution")
            if item.restitution not in (0.0, 1.0) and between:
                pybullet.changeDynamics(body, -1, restitution=math.sqrt(item.restitution), **client)
                for row in range(len(self._items)):
                    pybullet.changeDynamics(self._bodies[row], -1, restitution=math.sqrt(item.restitution), **client)
        self._bodies.append(body)

    def _join(self, a: int | None, b: int, joint: JointKind) -> Any:
        match joint:
            case Ball(cone=None, twist=None, spring=None, friction=0):
                pass
            case _:
                refuse_joint(joint)
        anchor_a, anchor_b = joint.anchors()
        other = -1 if a is None else self._bodies[a]
        return pybullet.createConstraint(
            self._bodies[b], -1, other, -1, pybullet.JOINT_POINT2POINT, (0, 0, 0), anchor_b, anchor_a,
            physicsClientId=self._client,
        )  # fmt: skip

    def _force(self, joint: Any) -> Any:
        return pybullet.getConstraintState(joint, physicsClientId=self._client)[:3]

    def _step(self, dt: float) -> None:
        if dt != self._dt:
            pybullet.setTimeStep(dt, physicsClientId=self._client)
            self._dt = dt
        pybullet.stepSimulation(physicsClientId=self._client)

    def _read(self, row: int) -> tuple[Any, Any, Any, Any]:
        body = self._bodies[row]
        position, (x, y, z, w) = pybullet.getBasePositionAndOrientation(body, physicsClientId=self._client)
        velocity, spin = pybullet.getBaseVelocity(body, physicsClientId=self._client)
        return position, (w, x, y, z), velocity, spin

    def _contacts(self) -> list[tuple[int, int, float, float]]:
        rows = {body: row for row, body in enumerate(self._bodies)}
        points = pybullet.getContactPoints(physicsClientId=self._client)
        return [(rows[point[1]], rows[point[2]], -point[8], point[9] * self._dt) for point in points]


def _disconnect(client: int) -> None:
    if pybullet.isConnected(client):
        pybullet.disconnect(client)


def _shape(shape: Any, client: dict[str, int]) -> int:
    make = pybullet.createCollisionShape
    match shape:
        case Plane(normal=normal):
            return int(make(pybullet.GEOM_PLANE, planeNormal=normal, **client))
        case Box(size=size):
            return int(make(pybullet.GEOM_BOX, halfExtents=[0.5 * side for side in size], **client))
        case Sphere(radius=radius):
            return int(make(pybullet.GEOM_SPHERE, radius=radius, **client))
        case Capsule(radius=radius, length=length) | Cylinder(radius=radius, length=length):
            kind = pybullet.GEOM_CAPSULE if isinstance(shape, Capsule) else pybullet.GEOM_CYLINDER
            turned = {"collisionFrameOrientation": ALONG_Y}
            return int(make(kind, radius=radius, height=length, **turned, **client))
    raise NotOfferedError(f"no {type(shape).__name__.lower()}")


WORLD = PyBulletWorld
