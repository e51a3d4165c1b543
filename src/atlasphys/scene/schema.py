"""What a scene file may hold, as pydantic models: version 1 of the schema.

A setting that is left out has the default of :class:`atlasphys.World` or of ``World.add``; none is repeated here.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal, Self, Union, get_args

from pydantic import (
    Field,
    Strict,
    StringConstraints,
    ValidationError,
    ValidatorFunctionWrapHandler,
    WrapValidator,
    model_validator,
)
from pydantic_core import PydanticCustomError

from atlasphys.engine.shapes.shape import Shape
from atlasphys.scene.joints import JOINTS, JointModel
from atlasphys.scene.model import Flag, Model, Name, NotNegative, Positive, Quaternion, Real, Text, Vector, Whole

VERSION = 1
"""Version of the schema that is written, and the newest that is read."""


def _either(wanted: str) -> WrapValidator:
    """One message for a value of several forms, in place of one for each form."""

    def validate(value: object, validate_forms: ValidatorFunctionWrapHandler) -> object:
        try:
            return validate_forms(value)
        except ValidationError:
            raise PydanticCustomError("either", "Input should {wanted}", {"wanted": wanted}) from None

    return WrapValidator(validate)


Inertia = Annotated[
    Vector | Annotated[tuple[Vector, ...], Field(min_length=3, max_length=3)],
    _either("be three moments, or three rows of three numbers"),
]
Color = Annotated[
    Annotated[str, Strict(), StringConstraints(pattern="^#[0-9a-fA-F]{6}$")]
    | Annotated[tuple[Annotated[Real, Field(ge=0, le=1)], ...], Field(min_length=3, max_length=3)],
    _either("be '#rrggbb', or three numbers from 0 to 1"),
]


class ShapeModel(Model):
    """The arguments of one of the public shapes, checked by making it."""

    maker: ClassVar[str]
    """Module in :mod:`atlasphys.engine.shapes` and name of the class or factory."""

    def make(self) -> Shape:
        """The shape.

        Raises:
            InvalidArgumentError: the arguments make none.
        """
        module, name = self.maker.split(".")
        maker = getattr(import_module(f"atlasphys.engine.shapes.{module}"), name)
        return maker(**{name: value for name, value in self.given().items() if name != "type"})  # type: ignore[no-any-return]

    @model_validator(mode="after")
    def _can_be_made(self) -> Self:
        self.make()
        return self


class PlaneModel(ShapeModel):
    """A half-space: all points x with normal · x ≤ offset are solid. Its body is static."""

    maker: ClassVar[str] = "plane.Plane"
    type: Literal["plane"]
    normal: Vector | None = None
    """Direction out of the solid, of any length but zero. Default: (0, 1, 0)."""
    offset: Real | None = None
    """Distance of the surface from the origin along the normal [m]. Default: 0."""


class SphereModel(ShapeModel):
    """A ball about the origin."""

    maker: ClassVar[str] = "sphere.Sphere"
    type: Literal["sphere"]
    radius: Positive
    """Radius [m]."""


class BoxModel(ShapeModel):
    """A rectangular box (a rectangular prism, or a cube) about the origin."""

    maker: ClassVar[str] = "box.Box"
    type: Literal["box"]
    size: Annotated[tuple[Positive, ...], Field(min_length=3, max_length=3)]
    """Full edge lengths along x, y and z [m]."""


class CapsuleModel(ShapeModel):
    """All points within the radius of a segment of the y axis about the origin."""

    maker: ClassVar[str] = "capsule.Capsule"
    type: Literal["capsule"]
    radius: Positive
    """Radius [m]."""
    length: Positive
    """Distance between the centres of the two caps [m]."""


class CylinderModel(ShapeModel):
    """A round cylinder along y about the origin."""

    maker: ClassVar[str] = "cylinder.Cylinder"
    type: Literal["cylinder"]
    radius: Positive
    """Radius [m]."""
    length: Positive
    """Full length [m]."""


class ConeModel(ShapeModel):
    """A round cone along y: base at −height/2, apex at +height/2."""

    maker: ClassVar[str] = "cone.Cone"
    type: Literal["cone"]
    radius: Positive
    """Radius of the base [m]."""
    height: Positive
    """Height from base to apex [m]."""


class ConvexHullModel(ShapeModel):
    """The smallest convex solid that holds all given points."""

    maker: ClassVar[str] = "hull.ConvexHull"
    type: Literal["convex_hull"]
    points: tuple[Vector, ...]
    """At least four points, not all in one plane [m]."""


class TetrahedronModel(ShapeModel):
    """A regular tetrahedron: base level, apex up, centroid at the origin."""

    maker: ClassVar[str] = "hull.tetrahedron"
    type: Literal["tetrahedron"]
    radius: Positive
    """Distance of the corners from the centroid [m]."""


class PyramidModel(ShapeModel):
    """A right pyramid along y on a regular polygon: base at −height/2, apex at +height/2."""

    maker: ClassVar[str] = "hull.pyramid"
    type: Literal["pyramid"]
    sides: Annotated[Whole, Field(ge=3, le=1000)]
    """Number of sides of the base."""
    radius: Positive
    """Distance of the base's corners from the axis [m]."""
    height: Positive
    """Height from base to apex [m]."""


class OctahedronModel(ShapeModel):
    """A regular octahedron about the origin, its corners on the axes."""

    maker: ClassVar[str] = "hull.octahedron"
    type: Literal["octahedron"]
    radius: Positive
    """Distance of the corners from the centre [m]."""


AnyShape = Annotated[
    PlaneModel
    | SphereModel
    | BoxModel
    | CapsuleModel
    | CylinderModel
    | ConeModel
    | ConvexHullModel
    | TetrahedronModel
    | PyramidModel
    | OctahedronModel,
    Field(discriminator="type"),
]

SHAPES: dict[str, type[ShapeModel]] = {
    get_args(model.model_fields["type"].annotation)[0]: model for model in get_args(get_args(AnyShape)[0])
}
"""The model of each shape by its type."""


if TYPE_CHECKING:
    AnyJoint = JointModel
else:
    AnyJoint = Annotated[Union[tuple(JOINTS.values())], Field(discriminator="type")]  # noqa: UP007


class BodyModel(Model):
    """A body: the arguments of ``World.add``."""

    shape: AnyShape
    """What the body looks like; ``type`` names the shape, its other keys are its sizes."""
    name: Name | None = None
    """Name, not given to two bodies of a scene."""
    kind: Literal["dynamic", "static", "kinematic"] | None = None
    """Moved by forces and contacts; immovable; or moved only by its own velocity. Default: dynamic, a plane static."""
    position: Vector | None = None
    """Origin of the shape's own frame [m]. Default: (0, 0, 0)."""
    orientation: Quaternion | None = None
    """Quaternion (w, x, y, z) from the shape's own frame to the world's; it is normalised. Default: (1, 0, 0, 0)."""
    velocity: Vector | None = None
    """Velocity of the centre of mass [m/s]. Default: 0."""
    angular_velocity: Vector | None = None
    """Angular velocity [rad/s]. Default: 0."""
    mass: Positive | None = None
    """Mass [kg], instead of a density."""
    density: Positive | None = None
    """Density [kg/m³]. Default, where no mass is given: 1000."""
    inertia: Inertia | None = None
    """Three moments about the shape's axes, or the tensor, about the centre of mass [kg m²]. Default: the shape's."""
    friction: NotNegative | None = None
    """Coefficient of Coulomb friction. Default: 0.5."""
    restitution: Annotated[Real, Field(ge=0, le=1)] | None = None
    """Coefficient of restitution. Default: 0."""
    rolling_friction: NotNegative | None = None
    """Lever arm of rolling friction [m]. Default: 0."""
    torsional_friction: NotNegative | None = None
    """Lever arm of torsional friction [m]. Default: 0."""
    linear_damping: NotNegative | None = None
    """Rate at which velocity decays [1/s]. Default: 0."""
    angular_damping: NotNegative | None = None
    """Rate at which angular velocity decays [1/s]. Default: 0."""
    gravity_scale: Real | None = None
    """Factor on the world's gravity. Default: 1."""
    locks: tuple[Literal["x", "y", "z", "rx", "ry", "rz"], ...] | None = None
    """Axes of the world along which (x, y, z) or about which (rx, ry, rz) the body cannot move. Default: none."""
    group: Whole | None = None
    """Collision groups of the body, as bits. Default: 1."""
    mask: Whole | None = None
    """Groups that the body collides with, as bits. Default: all."""
    color: Color | None = None
    """For pictures: ``"#rrggbb"``, or red, green and blue from 0 to 1."""


class WorldModel(Model):
    """Settings of the world: the arguments of :class:`atlasphys.World`."""

    gravity: Vector | None = None
    """Acceleration of free fall [m/s²]. Default: (0, −9.81, 0)."""
    preset: Text | None = None
    """Named choice of stages, such as ``classic``."""
    solver: Text | None = None
    """Name of the solver."""
    solver_settings: dict[Text, Flag | Whole | Real | Text] | None = None
    """Settings of the solver that is named, such as ``iterations``."""
    narrowphase: Text | None = None
    """Method for pairs of convex shapes."""
    broadphase: Text | None = None
    """Method that finds candidate pairs."""
    position_correction: Text | None = None
    """How overlap is removed: ``projection`` or ``baumgarte``."""
    substeps: Whole | None = None
    """Solver steps per step."""
    threads: Whole | None = None
    """Number of threads."""
    sleeping: Flag | None = None
    """Whether resting bodies are left out of the computation until something disturbs them."""
    precision: Literal["single", "double"] | None = None
    """Precision of everything but positions, which are always double. Default: single."""
    length_unit: Positive | None = None
    """Typical size of a body [m], by which tolerances scale. Default: 1."""
    restitution_threshold: NotNegative | None = None
    """Speed of approach below which nothing bounces [m/s]. Default: 1 × ``length_unit``."""
    friction_combine: Text | None = None
    """How the friction of two bodies makes that of their contact. Default: geometric_mean."""
    restitution_combine: Text | None = None
    """How the restitution of two bodies makes that of their contact. Default: max."""


class SceneModel(Model):
    """The contents of a scene file."""

    version: Annotated[Whole, Field(ge=VERSION, le=VERSION)]
    """Version of the schema: 1."""
    name: Name | None = None
    """Name of the scene."""
    description: Text | None = None
    """What the scene shows, in a line."""
    seconds: Positive | None = None
    """Time to simulate where nothing else is asked for [s]. Default: 10."""
    dt: Positive | None = None
    """Time step where nothing else is asked for [s]. Default: 1/60."""
    world: WorldModel = WorldModel()
    """Settings of the world."""
    bodies: tuple[BodyModel, ...] = ()
    """The bodies, in the order in which they are added."""
    joints: tuple[AnyJoint, ...] = ()
    """The joints, in the order in which they are made; ``type`` names the kind, ``a`` and ``b`` the bodies."""
