"""Rapier, by ``rapier3d`` (single precision): 4 solver iterations, each a substep; friction and restitution combined as here."""

from __future__ import annotations

import math
from typing import Any

import rapier3d

from atlasphys.engine.joints.frames import rotate
from atlasphys.engine.joints.kinds.ball import Ball
from atlasphys.engine.joints.kinds.distance import Distance, Spring
from atlasphys.engine.joints.kinds.hinge import Hinge
from atlasphys.engine.joints.kinds.kind import JointKind
from atlasphys.engine.shapes.box import Box
from atlasphys.engine.shapes.capsule import Capsule
from atlasphys.engine.shapes.cylinder import Cylinder
from atlasphys.engine.shapes.plane import Plane
from atlasphys.engine.shapes.sphere import Sphere
from atlasphys.validate.case import NotOfferedError
from atlasphys.validate.peers import Item, PeerWorld, refuse_joint, refuse_rolling


class RapierWorld(PeerWorld):
    """A ``PhysicsWorld``."""

    def _start(self) -> None:
        self._world = rapier3d.PhysicsWorld(gravity=self.gravity)
        self._parameters = self._world.integration_parameters
        self.substeps = self._parameters.num_solver_iterations
        self._bodies: list[Any] = []
        self._ground: Any = None
        self._row_of: dict[Any, int] = {}

    def _add(self, item: Item) -> None:
        refuse_rolling(item)
        collider = _collider(item.shape).friction(item.friction).restitution(item.restitution)
        collider = collider.friction_combine_rule(rapier3d.CoefficientCombineRule.GEOMETRIC_MEAN)
        collider = collider.restitution_combine_rule(rapier3d.CoefficientCombineRule.MAX)
        rotation = rapier3d.Rotation3.from_quaternion(*item.orientation)
        if item.static:
            body = rapier3d.RigidBody.fixed()
        else:
            properties = rapier3d.MassProperties(mass=item.mass, principal_inertia=item.moments)
            collider = collider.density(0.0)
            body = rapier3d.RigidBody.dynamic().can_sleep(False).additional_mass_properties(properties)
            body = body.linvel(item.velocity).angvel(item.angular_velocity)
        handle = self._world.add_body(body.position((item.position, rotation)), [collider])
        if not item.static:
            self._world.rigid_bodies[handle].gyroscopic_forces_enabled = True
        self._bodies.append(handle)
        self._row_of[self._world.rigid_bodies[handle].colliders[0]] = len(self._bodies) - 1

    def _join(self, a: int | None, b: int, joint: JointKind) -> Any:
        made: Any
        match joint:
            case Ball(cone=None, twist=None, spring=None, friction=0):
                made = rapier3d.SphericalJoint.builder()
            case Hinge(limits=None, spring=None, friction=0, motor=None, frame_a=frame_a, frame_b=frame_b):
                axis_a, axis_b = (rotate(frame, (1.0, 0.0, 0.0)) for frame in (frame_a, frame_b))
                made = rapier3d.RevoluteJoint.builder(axis_a).local_axis1(axis_a).local_axis2(axis_b)
            case Distance(limits=None, length=float(length)):
                made = rapier3d.RopeJoint.builder(length)  # it has no rods; in our case the rope is taut
            case Spring(limits=None, rest_length=float(length), frequency=frequency, damping=zeta):
                masses = [self._items[row].mass for row in (a, b) if row is not None]
                mass, omega = 1 / sum(1 / mass for mass in masses), 2 * math.pi * frequency
                made = rapier3d.SpringJoint.builder(length, mass * omega**2, 2 * zeta * mass * omega)
                made = made.spring_model(rapier3d.MotorModel.FORCE_BASED)
            case _:
                refuse_joint(joint)
        if self._ground is None:
            self._ground = self._world.add_body(rapier3d.RigidBody.fixed(), [])
        anchor_a, anchor_b = joint.anchors()
        made = made.local_anchor1(anchor_a).local_anchor2(anchor_b).contacts_enabled(False).build()
        end = self._ground if a is None else self._bodies[a]
        return self._world.impulse_joints.insert(end, self._bodies[b], made)

    def _step(self, dt: float) -> None:
        self._parameters.dt = dt
        self._world.step()

    def _read(self, row: int) -> tuple[Any, Any, Any, Any]:
        body = self._world.rigid_bodies[self._bodies[row]]
        x, q, v, w = body.translation, body.rotation, body.linvel, body.angvel
        return (x.x, x.y, x.z), (q.w, q.i, q.j, q.k), (v.x, v.y, v.z), (w.x, w.y, w.z)

    def _contacts(self) -> list[tuple[int, int, float, float]]:
        return [
            (self._row_of[pair.collider1], self._row_of[pair.collider2], -point.dist, point.impulse)
            for pair in self._world.narrow_phase.contact_pairs()
            for manifold in pair.manifolds
            for point in manifold.points
        ]


def _collider(shape: Any) -> Any:
    make = rapier3d.Collider
    match shape:
        case Plane(normal=normal):
            return make.halfspace(normal)
        case Box(size=size):
            return make.cuboid(*(0.5 * side for side in size))
        case Sphere(radius=radius):
            return make.ball(radius)
        case Capsule(radius=radius, length=length):
            return make.capsule_y(0.5 * length, radius)
        case Cylinder(radius=radius, length=length):
            return make.cylinder(0.5 * length, radius)
    raise NotOfferedError(f"no {type(shape).__name__}")


WORLD = RapierWorld
