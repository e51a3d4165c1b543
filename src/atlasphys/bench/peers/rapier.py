"""Rapier, by its own Python package ``rapier3d`` (single precision).

Its defaults: 4 solver iterations, contacts of 30 Hz, simplified friction, contact recycling and clustering. Fixed here: bodies cannot sleep;
the world has a pool of as many threads as are asked for. The ground is a half-space. Friction coefficients are averaged: 0.5 and 0.5
make 0.5. Links are impulse joints, as by default. Its package has no call for many steps: the loop is Python's.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from atlasphys.bench.scenes import DT, FRICTION, GRAVITY, Box, Capsule, Hull, Item, Scene, Shape, Sphere

if TYPE_CHECKING:
    from atlasphys.bench.peers import Poses


class Rapier:
    """A scene in a PhysicsWorld."""

    def __init__(self, scene: Scene, threads: int, preset: str | None) -> None:
        import rapier3d

        self.threads = threads
        world = self._world = rapier3d.PhysicsWorld(gravity=(0.0, -GRAVITY, 0.0))
        world.set_num_threads(threads)
        world.integration_parameters.dt = DT
        if scene.ground:
            world.add_collider(rapier3d.Collider.halfspace((0.0, 1.0, 0.0)).friction(FRICTION))
        for wall in scene.walls:
            self._add(rapier3d.RigidBody.fixed(), wall)
        collides = rapier3d.InteractionGroups.none() if scene.links else rapier3d.InteractionGroups.all()
        free = rapier3d.RigidBody.dynamic().can_sleep(False)
        self._handles = [self._add(free, item, collides) for item in scene.bodies]
        if scene.links:
            ground = world.add_body(rapier3d.RigidBody.fixed(), [])
            for link in scene.links:
                joint = rapier3d.SphericalJoint.builder().local_anchor1(link.anchor_a).local_anchor2(link.anchor_b)
                ends = ground if link.a is None else self._handles[link.a], self._handles[link.b]
                world.impulse_joints.insert(*ends, joint.contacts_enabled(False).build())

    def _add(self, body: Any, item: Item, collides: Any = None) -> Any:
        collider = _collider(item.shape).density(item.density).friction(FRICTION)
        if collides is not None:
            collider = collider.collision_groups(collides)
        return self._world.add_body(body.position((item.position, _rotation(item.orientation))), [collider])

    def run(self, steps: int) -> None:
        """Take steps."""
        step = self._world.step
        for _ in range(steps):
            step()

    def poses(self) -> Poses:
        """Positions and orientations."""
        import numpy as np

        bodies = [self._world.rigid_bodies[handle] for handle in self._handles]
        positions = [(body.translation.x, body.translation.y, body.translation.z) for body in bodies]
        rotations = [body.rotation for body in bodies]
        return np.array(positions, float), np.array([(q.w, q.i, q.j, q.k) for q in rotations], float)


def _rotation(orientation: Any) -> Any:
    import rapier3d

    return rapier3d.Rotation3.from_quaternion(*orientation)


def _collider(shape: Shape) -> Any:
    import numpy as np
    from rapier3d import Collider

    match shape:
        case Box(half):
            return Collider.cuboid(*half)
        case Sphere(radius):
            return Collider.ball(radius)
        case Capsule(radius, half_length):
            return Collider.capsule_y(half_length, radius)
        case Hull():
            return Collider.convex_hull(np.array(shape.points))


ENGINE = Rapier
