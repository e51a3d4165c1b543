"""Box3D, by the Python package ``robox3d`` (single precision).

Its defaults: 4 substeps, contacts of 30 Hz, contact recycling. Fixed here: the world cannot sleep; as many workers as are asked for. It has
no half-space: the ground is a box of 2 m thickness that reaches 50 m beyond the scene. Friction coefficients make their geometric mean. A
turn is one native call for all of its steps. Links are spherical joints as by default, 60 Hz with damping ratio 2.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from atlasphys.bench.scenes import DT, FRICTION, GRAVITY, Box, Capsule, Hull, Item, Link, Scene, Sphere

if TYPE_CHECKING:
    from atlasphys.bench.peers import Poses

DEPTH = 2.0
"""Thickness of the box that is the ground [m]."""


class Box3D:
    """A scene in a robox3d world."""

    def __init__(self, scene: Scene, threads: int, preset: str | None) -> None:
        import robox3d

        self.threads = threads
        self._world = robox3d.World(gravity=(0.0, -GRAVITY, 0.0), worker_count=threads, enable_sleep=False)
        items = list(scene.walls)
        if scene.ground:
            items.append(Item(Box((scene.extent, 0.5 * DEPTH, scene.extent)), (0.0, -0.5 * DEPTH, 0.0)))
        for item in items:
            self._add(item, "static")
        bodies = [self._add(item, "dynamic", collides=not scene.links) for item in scene.bodies]
        self._group = robox3d.BodyGroup(bodies)
        if scene.links:
            ground = self._world.create_body(kind="static")
            for link in scene.links:
                self._link(ground if link.a is None else bodies[link.a], bodies[link.b], link)

    def _link(self, a: Any, b: Any, link: Link) -> None:
        from robox3d._ffi import ffi, lib

        joint = lib.b3DefaultSphericalJointDef()  # the package itself makes no ball joints
        joint.base.bodyIdA, joint.base.bodyIdB = a.id, b.id
        for frame, anchor in ((joint.base.localFrameA, link.anchor_a), (joint.base.localFrameB, link.anchor_b)):
            frame.p.x, frame.p.y, frame.p.z = anchor
        lib.b3CreateSphericalJoint(self._world.id, ffi.addressof(joint))

    def _add(self, item: Item, kind: str, collides: bool = True) -> Any:
        w, x, y, z = item.orientation
        body = self._world.create_body(position=item.position, rotation=(x, y, z, w), kind=kind)
        material: dict[str, Any] = {"density": item.density, "friction": FRICTION}
        match item.shape:
            case Box(half):
                shape = body.add_box(half, **material)
            case Sphere(radius):
                shape = body.add_sphere(radius, **material)
            case Capsule(radius, half_length):
                shape = body.add_capsule((0, -half_length, 0), (0, half_length, 0), radius, **material)
            case Hull():
                shape = body.add_hull(item.shape.points, **material)
        if not collides:
            from robox3d._ffi import lib

            filter = lib.b3Shape_GetFilter(shape)
            filter.maskBits = 0
            lib.b3Shape_SetFilter(shape, filter, True)
        return body

    def run(self, steps: int) -> None:
        """Take steps, in one call."""
        self._world.step_n(steps, DT)

    def poses(self) -> Poses:
        """Positions and orientations."""
        poses = self._group.poses().astype("f8")
        return poses[:, 0:3], poses[:, [6, 3, 4, 5]]


ENGINE = Box3D
