"""AtlasPhys: a default world, or the preset that was asked for, that does not sleep. A turn is one call of ``World.run``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from atlasphys.bench.scenes import DT, FRICTION, GRAVITY, Box, Capsule, Hull, Item, Scene, Shape, Sphere

if TYPE_CHECKING:
    from atlasphys.bench.peers import Poses


def shape_of(shape: Shape) -> Any:
    """Our shape."""
    import atlasphys as ap

    match shape:
        case Box((x, y, z)):
            return ap.Box(size=(2 * x, 2 * y, 2 * z))
        case Sphere(radius):
            return ap.Sphere(radius=radius)
        case Capsule(radius, half_length):
            return ap.Capsule(radius=radius, length=2 * half_length)
        case Hull():
            return ap.ConvexHull(points=shape.points)


def add_items(world: Any, items: list[Item], **settings: Any) -> None:
    """Add bodies; equal shapes are made once."""
    shapes: dict[Shape, Any] = {}
    for item in items:
        shape = shapes.get(item.shape) or shapes.setdefault(item.shape, shape_of(item.shape))
        world.add(
            shape,
            position=item.position,
            orientation=item.orientation,
            density=item.density,
            friction=FRICTION,
            **settings,
        )


class AtlasPhys:
    """A scene in a world."""

    def __init__(self, scene: Scene, threads: int, preset: str | None) -> None:
        import atlasphys as ap

        self.threads = threads
        # The sparse call, so that an engine's defaults decide whatever is not asked for.
        given: dict[str, Any] = {} if preset is None else {"preset": preset}
        if threads != 1:
            given["threads"] = threads
        self._world = ap.World(gravity=(0, -GRAVITY, 0), sleeping=False, **given)
        add_items(self._world, scene.bodies, mask=0 if scene.links else 2**32 - 1)
        for link in scene.links:
            a, b = (None if row is None else self._world.bodies[row] for row in (link.a, link.b))
            self._world.join(ap.Ball(a, b, anchor_a=link.anchor_a, anchor_b=link.anchor_b))
        add_items(self._world, scene.walls, kind="static")
        if scene.ground:
            self._world.add(ap.Plane(), friction=FRICTION)
        self._count = len(scene.bodies)

    def run(self, steps: int) -> None:
        """Take steps, in one call."""
        self._world.run(seconds=steps * DT, dt=DT)

    def poses(self) -> Poses:
        """Positions and orientations."""
        bodies = self._world.bodies
        return bodies.position[: self._count].astype("f8"), bodies.orientation[: self._count].astype("f8")


ENGINE = AtlasPhys
