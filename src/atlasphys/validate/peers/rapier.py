"""Rapier, by ``rapier3d`` (single precision): 4 solver iterations, each a substep; friction and restitution combined as here."""

from __future__ import annotations

from typing import Any

import rapier3d

from atlasphys.engine.shapes.box import Box
from atlasphys.engine.shapes.capsule import Capsule
from atlasphys.engine.shapes.cylinder import Cylinder
from atlasphys.engine.shapes.plane import Plane
from atlasphys.engine.shapes.sphere import Sphere
from atlasphys.validate.case import NotOfferedError
from atlasphys.validate.peers import Item, PeerWorld, refuse_rolling


class RapierWorld(PeerWorld):
    """A ``PhysicsWorld``."""

    def _start(self) -> None:
        self._world = rapier3d.PhysicsWorld(gravity=self.gravity)
        self._parameters = self._world.integration_parameters
        self.substeps = self._parameters.num_solver_iterations
        self._bodies: list[Any] = []
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
