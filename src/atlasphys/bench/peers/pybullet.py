"""PyBullet, without a display (double precision).

Its defaults: bodies of the multibody kind, 50 iterations, damping of 0.04, which for a body that falls is air that it cannot pass at more than
16 m/s; so there, and only there, damping is 0. Fixed here: the time step; bodies do not sleep, by default. It multiplies coefficients of
friction: each is √0.5, so that contacts have 0.5. It takes masses, not densities, and moments of inertia from a shape's bounds. The package
has no threads in this mode and no call for many steps: the loop is Python's.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from atlasphys.bench.scenes import DT, FRICTION, GRAVITY, Box, Capsule, Hull, Item, Scene, Shape, Sphere, volume

if TYPE_CHECKING:
    from atlasphys.bench.peers import Poses


class PyBullet:
    """A scene on a PyBullet server in this process."""

    def __init__(self, scene: Scene, threads: int, preset: str | None) -> None:
        if scene.links:
            raise NotImplementedError("links are compared with Rapier and Box3D alone")
        import pybullet

        self.threads = 1
        self._client = pybullet.connect(pybullet.DIRECT)
        pybullet.setGravity(0, -GRAVITY, 0)
        pybullet.setTimeStep(DT)
        self._shapes: dict[Shape, int] = {}
        self._damped = scene.expect != "falls"
        if scene.ground:
            plane = pybullet.createCollisionShape(pybullet.GEOM_PLANE, planeNormal=[0, 1, 0])
            self._rub(pybullet.createMultiBody(0, plane))
        for wall in scene.walls:
            self._add(wall, 0.0)
        self._bodies = [self._add(item, item.density * volume(item.shape)) for item in scene.bodies]

    def _add(self, item: Item, mass: float) -> int:
        import pybullet

        shape = self._shapes.get(item.shape)
        if shape is None:
            shape = self._shapes[item.shape] = _shape(item.shape)
        w, x, y, z = item.orientation
        body = pybullet.createMultiBody(mass, shape, basePosition=item.position, baseOrientation=(x, y, z, w))
        self._rub(body)
        return int(body)

    def _rub(self, body: int) -> None:
        import pybullet

        pybullet.changeDynamics(body, -1, lateralFriction=math.sqrt(FRICTION))
        if not self._damped:
            pybullet.changeDynamics(body, -1, linearDamping=0.0, angularDamping=0.0)

    def run(self, steps: int) -> None:
        """Take steps."""
        import pybullet

        step = pybullet.stepSimulation
        for _ in range(steps):
            step()

    def poses(self) -> Poses:
        """Positions and orientations."""
        import numpy as np
        import pybullet

        found = [pybullet.getBasePositionAndOrientation(body) for body in self._bodies]
        positions, orientations = np.array([place for place, _ in found]), np.array([turn for _, turn in found])
        return positions, orientations[:, [3, 0, 1, 2]]


def _shape(shape: Shape) -> int:
    import pybullet

    # A capsule of PyBullet lies along z.
    match shape:
        case Box(half):
            return int(pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=half))
        case Sphere(radius):
            return int(pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=radius))
        case Capsule(radius, half_length):
            turn = pybullet.getQuaternionFromEuler((-math.pi / 2, 0, 0))
            return int(
                pybullet.createCollisionShape(
                    pybullet.GEOM_CAPSULE, radius=radius, height=2 * half_length, collisionFrameOrientation=turn
                )
            )
        case Hull():
            return int(pybullet.createCollisionShape(pybullet.GEOM_MESH, vertices=shape.points))


ENGINE = PyBullet
