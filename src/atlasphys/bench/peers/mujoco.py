"""MuJoCo (double precision).

Its defaults: Euler integration, the Newton solver, pyramidal cones, soft contacts; sleeping is off. Fixed here: the time step, which is longer
than what it is made for (2 ms); the size of its arena, for what it reserves by itself grows with the square of the number of bodies. Of two
coefficients of friction the larger counts. The ground is a plane. Above one thread the simulation has a thread pool of that size. A turn
is one native call for all of its steps.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from atlasphys.bench.scenes import DT, FRICTION, GRAVITY, Box, Capsule, Hull, Scene, Shape, Sphere

if TYPE_CHECKING:
    from atlasphys.bench.peers import Poses

TO_Y = (0.5**0.5, -(0.5**0.5), 0.0, 0.0)
"""The rotation that takes z, along which MuJoCo's planes look and its capsules lie, to y."""


ARENA, LEAST_ARENA, MOST_ARENA = 4e5, 2.5e8, 8e9
"""Bytes of MuJoCo's arena per body, at least and at most; they are reserved, not used."""


class MuJoCo:
    """A scene in a model whose bodies all have free joints."""

    def __init__(self, scene: Scene, threads: int, preset: str | None) -> None:
        if scene.links:
            raise NotImplementedError("links are compared with Rapier and Box3D alone")
        import mujoco

        self.threads = threads
        spec = mujoco.MjSpec()
        spec.option.timestep = DT
        spec.option.gravity = (0, -GRAVITY, 0)
        spec.memory = round(min(max(ARENA * len(scene.bodies), LEAST_ARENA), MOST_ARENA))
        self._spec, self._meshes = spec, dict[Shape, str]()
        if scene.ground:
            spec.worldbody.add_geom(
                type=mujoco.mjtGeom.mjGEOM_PLANE, size=(0, 0, 1), quat=TO_Y, friction=(FRICTION, 0.005, 0.0001)
            )
        for wall in scene.walls:
            self._add(spec.worldbody.add_body(pos=wall.position), wall.shape)
        for item in scene.bodies:
            body = spec.worldbody.add_body(pos=item.position, quat=item.orientation)
            body.add_freejoint()
            self._add(body, item.shape, density=item.density)
        self._model = spec.compile()
        self._data = mujoco.MjData(self._model)
        if threads > 1:
            mujoco.mju_threadpool(self._data, threads)

    def _add(self, body: Any, shape: Shape, **settings: Any) -> None:
        import mujoco

        kinds = mujoco.mjtGeom
        settings["friction"] = (FRICTION, 0.005, 0.0001)  # sliding; spinning and rolling as by default
        match shape:
            case Box(half):
                body.add_geom(type=kinds.mjGEOM_BOX, size=half, **settings)
            case Sphere(radius):
                body.add_geom(type=kinds.mjGEOM_SPHERE, size=(radius, 0, 0), **settings)
            case Capsule(radius, half_length):
                body.add_geom(type=kinds.mjGEOM_CAPSULE, size=(radius, half_length, 0), quat=TO_Y, **settings)
            case Hull():
                if shape not in self._meshes:
                    name = self._meshes[shape] = f"hull {len(self._meshes)}"
                    self._spec.add_mesh(name=name, uservert=[value for point in shape.points for value in point])
                body.add_geom(type=kinds.mjGEOM_MESH, meshname=self._meshes[shape], **settings)

    def run(self, steps: int) -> None:
        """Take steps, in one call."""
        import mujoco

        mujoco.mj_step(self._model, self._data, nstep=steps)

    def poses(self) -> Poses:
        """Positions and orientations."""
        state = self._data.qpos.reshape(-1, 7)
        return state[:, 0:3].copy(), state[:, 3:7].copy()


ENGINE = MuJoCo
