"""AtlasPhys: a 3D rigid-body physics engine that can be read stage by stage.

>>> import atlasphys as ap
>>> world = ap.World()
>>> ball = world.add(ap.Sphere(radius=0.5), position=(0, 3, 0))
>>> world.step(1 / 60)
>>> print(f"{ball.velocity[1]:.4f} m/s")
-0.1635 m/s

Names are imported when first used, so that ``import atlasphys`` takes milliseconds.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from atlasphys.engine.joints.kinds.ball import Ball as Ball
    from atlasphys.engine.joints.kinds.ball import Target as Target
    from atlasphys.engine.joints.kinds.couplings import Gear as Gear
    from atlasphys.engine.joints.kinds.couplings import Pulley as Pulley
    from atlasphys.engine.joints.kinds.couplings import RackPinion as RackPinion
    from atlasphys.engine.joints.kinds.distance import Distance as Distance
    from atlasphys.engine.joints.kinds.distance import Spring as Spring
    from atlasphys.engine.joints.kinds.hinge import Fixed as Fixed
    from atlasphys.engine.joints.kinds.hinge import Hinge as Hinge
    from atlasphys.engine.joints.kinds.six_dof import SixDof as SixDof
    from atlasphys.engine.joints.kinds.slider import Slider as Slider
    from atlasphys.engine.joints.kinds.slider import Wheel as Wheel
    from atlasphys.engine.joints.kinds.universal import Universal as Universal
    from atlasphys.engine.joints.part import Elastic as Elastic
    from atlasphys.engine.joints.part import Motor as Motor
    from atlasphys.engine.shapes.box import Box as Box
    from atlasphys.engine.shapes.capsule import Capsule as Capsule
    from atlasphys.engine.shapes.cone import Cone as Cone
    from atlasphys.engine.shapes.cylinder import Cylinder as Cylinder
    from atlasphys.engine.shapes.hull import ConvexHull as ConvexHull
    from atlasphys.engine.shapes.hull import octahedron as octahedron
    from atlasphys.engine.shapes.hull import pyramid as pyramid
    from atlasphys.engine.shapes.hull import tetrahedron as tetrahedron
    from atlasphys.engine.shapes.plane import Plane as Plane
    from atlasphys.engine.shapes.sphere import Sphere as Sphere
    from atlasphys.engine.solvers.avbd import AVBD as AVBD
    from atlasphys.engine.solvers.sequential_impulse import SequentialImpulse as SequentialImpulse
    from atlasphys.engine.solvers.soft_step import SoftStep as SoftStep
    from atlasphys.engine.solvers.xpbd import XPBD as XPBD
    from atlasphys.errors import AtlasPhysError as AtlasPhysError
    from atlasphys.errors import DivergenceError as DivergenceError
    from atlasphys.errors import InvalidArgumentError as InvalidArgumentError
    from atlasphys.errors import MissingExtraError as MissingExtraError
    from atlasphys.errors import RecordingError as RecordingError
    from atlasphys.errors import RemovedBodyError as RemovedBodyError
    from atlasphys.errors import RemovedJointError as RemovedJointError
    from atlasphys.errors import SceneError as SceneError
    from atlasphys.explainer.story import Story as Story
    from atlasphys.explainer.story import explain as explain
    from atlasphys.record.read import Poses as Poses
    from atlasphys.record.read import Recording as Recording
    from atlasphys.record.read import Trajectory as Trajectory
    from atlasphys.record.write import Recorder as Recorder
    from atlasphys.scene.load import load_scene as load_scene
    from atlasphys.scene.scene import Scene as Scene
    from atlasphys.world.body import Body as Body
    from atlasphys.world.joint import Joint as Joint
    from atlasphys.world.snapshot import Snapshot as Snapshot
    from atlasphys.world.views import Energy as Energy
    from atlasphys.world.views import Event as Event
    from atlasphys.world.world import World as World

_HOMES = {
    "AVBD": "engine.solvers.avbd",
    "AtlasPhysError": "errors",
    "Ball": "engine.joints.kinds.ball",
    "Body": "world.body",
    "Box": "engine.shapes.box",
    "Capsule": "engine.shapes.capsule",
    "Cone": "engine.shapes.cone",
    "ConvexHull": "engine.shapes.hull",
    "Cylinder": "engine.shapes.cylinder",
    "Distance": "engine.joints.kinds.distance",
    "DivergenceError": "errors",
    "Elastic": "engine.joints.part",
    "Energy": "world.views",
    "Event": "world.views",
    "Fixed": "engine.joints.kinds.hinge",
    "Gear": "engine.joints.kinds.couplings",
    "Hinge": "engine.joints.kinds.hinge",
    "InvalidArgumentError": "errors",
    "Joint": "world.joint",
    "MissingExtraError": "errors",
    "Motor": "engine.joints.part",
    "Plane": "engine.shapes.plane",
    "Poses": "record.read",
    "Pulley": "engine.joints.kinds.couplings",
    "RackPinion": "engine.joints.kinds.couplings",
    "Recorder": "record.write",
    "Recording": "record.read",
    "RecordingError": "errors",
    "RemovedBodyError": "errors",
    "RemovedJointError": "errors",
    "Scene": "scene.scene",
    "SceneError": "errors",
    "SequentialImpulse": "engine.solvers.sequential_impulse",
    "SixDof": "engine.joints.kinds.six_dof",
    "Slider": "engine.joints.kinds.slider",
    "Snapshot": "world.snapshot",
    "SoftStep": "engine.solvers.soft_step",
    "Sphere": "engine.shapes.sphere",
    "Spring": "engine.joints.kinds.distance",
    "Story": "explainer.story",
    "Target": "engine.joints.kinds.ball",
    "Trajectory": "record.read",
    "Universal": "engine.joints.kinds.universal",
    "Wheel": "engine.joints.kinds.slider",
    "World": "world.world",
    "XPBD": "engine.solvers.xpbd",
    "explain": "explainer.story",
    "load_scene": "scene.load",
    "octahedron": "engine.shapes.hull",
    "pyramid": "engine.shapes.hull",
    "tetrahedron": "engine.shapes.hull",
}

__version__ = "0.1.0"
__all__ = ["__version__", *sorted(_HOMES)]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'atlasphys' has no attribute {name!r}")
    value = globals()[name] = getattr(import_module(f"atlasphys.{_HOMES[name]}"), name)
    return value


def __dir__() -> list[str]:
    return __all__
