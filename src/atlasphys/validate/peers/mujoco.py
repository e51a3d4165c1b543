"""MuJoCo (double precision): Euler integration, Newton's method, pyramidal cones, soft contacts. It has no coefficient of restitution."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from atlasphys.engine.joints.frames import difference, rotate, scaled
from atlasphys.engine.joints.kinds.ball import Ball
from atlasphys.engine.joints.kinds.hinge import Hinge
from atlasphys.engine.joints.kinds.kind import JointKind
from atlasphys.engine.shapes.box import Box
from atlasphys.engine.shapes.capsule import Capsule
from atlasphys.engine.shapes.cylinder import Cylinder
from atlasphys.engine.shapes.plane import Plane
from atlasphys.engine.shapes.sphere import Sphere
from atlasphys.validate.case import NotOfferedError
from atlasphys.validate.peers import Item, PeerWorld, refuse_joint

TO_Y = (0.5**0.5, -(0.5**0.5), 0.0, 0.0)
"""The rotation that takes z, along which its capsules and cylinders lie, to y."""


class MuJoCoWorld(PeerWorld):
    """A model whose bodies have free joints; it is compiled when the first step is taken, and has its default memory otherwise."""

    def _start(self) -> None:
        self._spec = mujoco.MjSpec()
        self._spec.option.gravity = self.gravity
        self._spec.memory = 1 << 28
        self._data: Any = None

    def _add(self, item: Item) -> None:
        if item.restitution:
            raise NotOfferedError("it has no coefficient of restitution")
        if any(other.friction != item.friction for other in self._items):
            raise NotOfferedError("of two coefficients of friction the larger counts")
        geom: dict[str, Any] = {"friction": (item.friction, 0.0, 0.0), "condim": 3}
        if item.torsional_friction or item.rolling_friction:
            patch = (
                item.friction * item.torsional_friction
            )  # torsion is bounded by a length times N, here by μ times it
            geom = {"friction": (item.friction, patch, item.rolling_friction), "condim": 6}
        kinds = mujoco.mjtGeom
        match item.shape:
            case Plane(normal=normal, offset=offset):
                half = np.array([1 + normal[2], -normal[1], normal[0], 0.0])  # from z to the normal
                place = {"pos": np.array(normal) * offset, "quat": half / np.sqrt(half @ half)}
                self._spec.worldbody.add_geom(type=kinds.mjGEOM_PLANE, size=(0, 0, 1), **place, **geom)
                return
            case Box(size=size):
                geom |= {"type": kinds.mjGEOM_BOX, "size": [0.5 * side for side in size]}
            case Sphere(radius=radius):
                geom |= {"type": kinds.mjGEOM_SPHERE, "size": (radius, 0, 0)}
            case Capsule(radius=radius, length=length) | Cylinder(radius=radius, length=length):
                kind = kinds.mjGEOM_CAPSULE if isinstance(item.shape, Capsule) else kinds.mjGEOM_CYLINDER
                geom |= {"type": kind, "size": (radius, 0.5 * length, 0), "quat": TO_Y}
            case _:
                raise NotOfferedError(f"no {type(item.shape).__name__.lower()}")
        body = self._spec.worldbody.add_body(name=f"body {len(self._items)}", pos=item.position, quat=item.orientation)
        if not item.static:
            body.add_freejoint()
            body.explicitinertial = True
            body.mass, body.inertia, body.ipos = item.mass, item.moments, (0, 0, 0)
        body.add_geom(**geom)

    def _compiled(self) -> Any:
        if self._data is None:
            self._model = self._spec.compile()
            self._data = mujoco.MjData(self._model)
            moving = [(row, item) for row, item in enumerate(self._items) if not item.static]
            self._place = {row: i for i, (row, _) in enumerate(moving)}
            for i, (_, item) in enumerate(moving):
                turned = self._data.qpos[7 * i + 3 : 7 * i + 7]
                self._data.qvel[6 * i : 6 * i + 3] = item.velocity
                self._data.qvel[6 * i + 3 : 6 * i + 6] = _turn(_inverse(turned), item.angular_velocity)
            # Geoms are numbered by their bodies, those of the world (planes) first.
            planes = [row for row, item in enumerate(self._items) if isinstance(item.shape, Plane)]
            self._geom_rows = planes + [row for row in range(len(self._items)) if row not in planes]
            mujoco.mj_forward(self._model, self._data)
        return self._data

    def _join(self, a: int | None, b: int, joint: JointKind) -> Any:
        points = [joint.anchors()[1]]
        match joint:
            case Ball(cone=None, twist=None, spring=None, friction=0):
                pass
            case Hinge(limits=None, spring=None, friction=0, motor=None, frame_b=frame):
                along = rotate(frame, (0.5, 0.0, 0.0))  # two points on the axis make a hinge
                points = [difference(points[0], scaled(along, sign)) for sign in (-1, 1)]
            case _:
                refuse_joint(joint)
        first = len(self._spec.equalities)
        for point in points:
            self._spec.add_equality(
                type=mujoco.mjtEq.mjEQ_CONNECT,
                objtype=mujoco.mjtObj.mjOBJ_BODY,
                name1=f"body {b}",
                name2="world" if a is None else f"body {a}",
                data=[*point, *[0.0] * 9],
            )
        return range(first, first + len(points))

    def _force(self, joint: Any) -> Any:
        data = self._compiled()
        of_equality = data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        rows = [np.flatnonzero(of_equality & (data.efc_id == number)) for number in joint]
        return np.sum([data.efc_force[row] for row in rows], axis=0)

    def _step(self, dt: float) -> None:
        data = self._compiled()
        self._model.opt.timestep = dt
        mujoco.mj_step(self._model, data)

    def _read(self, row: int) -> tuple[Any, Any, Any, Any]:
        data = self._compiled()
        i = self._place[row]
        place, speed = data.qpos[7 * i : 7 * i + 7], data.qvel[6 * i : 6 * i + 6]
        return place[0:3], place[3:7], speed[0:3], _turn(place[3:7], speed[3:6])

    def _contacts(self) -> list[tuple[int, int, float, float]]:
        data, found = self._compiled(), []
        force = np.zeros(6)
        for i in range(data.ncon):
            contact = data.contact[i]
            mujoco.mj_contactForce(self._model, data, i, force)
            a, b = (self._geom_rows[geom] for geom in contact.geom)
            found.append((a, b, -contact.dist, force[0] * self._model.opt.timestep))
        return found


def _inverse(q: Any) -> Any:
    return q * np.array([1, -1, -1, -1])


def _turn(q: Any, v: Any) -> Any:
    turned = np.zeros(3)
    mujoco.mju_rotVecQuat(turned, np.array(v, float), np.array(q, float))
    return turned


WORLD = MuJoCoWorld
