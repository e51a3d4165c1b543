"""A scene: a world's settings and bodies as plain values, before there is a world."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from atlasphys.errors import SceneError
from atlasphys.scene.faults import Source, faults_of
from atlasphys.scene.schema import VERSION, BodyModel, SceneModel

if TYPE_CHECKING:
    from atlasphys.world.world import World


class Scene:
    """A world's settings and bodies as plain values, checked, and not changed afterwards.

    Args:
        bodies: the bodies in the order in which they are added, as mappings of the arguments of ``World.add``; the
            shape is a mapping too, its ``type`` beside its sizes.
        joints: the joints, as mappings: ``type`` names the kind, ``a`` and ``b`` are names or places of bodies, the rest are its arguments.
        world: arguments of :class:`atlasphys.World`.
        name: name of the scene.
        description: what it shows, in a line.
        seconds: time to simulate where nothing else is asked for [s].
        dt: time step where nothing else is asked for [s].

    Raises:
        SceneError: listing everything that is wrong, a line each.

    >>> scene = Scene([{"shape": {"type": "sphere", "radius": 0.5}, "position": (0, 3, 0)}], name="ball")
    >>> len(scene.bodies), scene.seconds
    (1, 10.0)
    """

    def __init__(
        self,
        bodies: Iterable[Mapping[str, Any] | BodyModel] = (),
        *,
        joints: Iterable[Mapping[str, Any]] = (),
        world: Mapping[str, Any] | None = None,
        name: str | None = None,
        description: str | None = None,
        seconds: float | None = None,
        dt: float | None = None,
    ) -> None:
        given = {"name": name, "description": description, "seconds": seconds, "dt": dt, "world": world and dict(world)}
        data = {key: value for key, value in given.items() if value is not None}
        self._source = Source(name if isinstance(name, str) and name else "scene")
        self.model = check({"version": VERSION, **data, "bodies": tuple(bodies), "joints": tuple(joints)}, self._source)

    @classmethod
    def from_data(cls, data: Any, source: Source) -> Scene:
        """The scene that parsed data of the schema describe.

        Raises:
            SceneError: listing everything that is wrong.
        """
        scene = cls.__new__(cls)
        scene._source = source
        scene.model = check(data, source)
        return scene

    @classmethod
    def from_world(cls, world: World, *, name: str | None = None, description: str | None = None) -> Scene:
        """The scene of a world as it is now: its settings, bodies and joints that act, without the impulses kept for warm starting."""
        from atlasphys.scene.build import describe_body, describe_world
        from atlasphys.scene.joints import describe_joint

        joints = [describe_joint(joint) for joint in world.joints if joint.enabled and not joint.broken]
        return cls(
            map(describe_body, world.bodies),
            joints=joints,
            world=describe_world(world),
            name=name,
            description=description,
        )

    @property
    def name(self) -> str:
        """Name, or that of its file."""
        return self.model.name or self._source.name

    @property
    def description(self) -> str:
        """What it shows, in a line; empty if not said."""
        return self.model.description or ""

    @property
    def seconds(self) -> float:
        """Time to simulate where nothing else is asked for [s]."""
        return self.model.seconds or 10.0

    @property
    def dt(self) -> float:
        """Time step where nothing else is asked for [s]."""
        return self.model.dt or 1.0 / 60.0

    @property
    def bodies(self) -> tuple[BodyModel, ...]:
        """The bodies, in the order in which they are added."""
        return self.model.bodies

    def build(self, **settings: Any) -> World:
        """A world with the scene's bodies.

        Args:
            settings: arguments of :class:`atlasphys.World` that replace the scene's.

        Raises:
            SceneError: the world refuses some settings or bodies; all of them are listed.
        """
        from atlasphys.scene.build import build_world

        return build_world(self.model, self._source, settings)

    def data(self) -> dict[str, Any]:
        """The scene in the form of the schema: what was given, in the order of the schema."""
        data = self.model.model_dump(mode="json", exclude_unset=True, exclude_none=True)
        return {key: value for key, value in data.items() if value not in ({}, [])}

    def save(self, path: str | Path) -> None:
        """Write the scene to a file, which appears whole: JSON if its name ends so, else TOML. Reading it gives an equal scene, to the bit.

        Raises:
            SceneError: the file cannot be written.
        """
        path = Path(path)
        if path.suffix.lower() == ".json":
            text = json.dumps(self.data(), indent=2, ensure_ascii=False) + "\n"
        else:
            from atlasphys.scene.toml import to_toml

            text = to_toml(self.data())
        try:
            special = path.exists() and not path.is_file()  # a pipe, say
            part = path if special else path.with_name(f".{path.name}.{os.getpid()}.part")
            try:
                part.write_text(text, encoding="utf-8", newline="\n")
                if not special:
                    os.replace(part, path.resolve())
            finally:
                if not special:
                    part.unlink(missing_ok=True)
        except (OSError, ValueError) as error:  # ValueError: a null character in the name
            raise SceneError(f"{path}: cannot be written: {getattr(error, 'strerror', None) or error}") from None

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Scene) and self.data() == other.data()

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"Scene({self.name!r}, {len(self.bodies)} bodies, {self.seconds:g} s at dt {self.dt:.4g} s)"


def check(data: Any, source: Source) -> SceneModel:
    """The model of the data.

    Raises:
        SceneError: listing everything that is wrong.
    """
    try:
        return SceneModel.model_validate(data)
    except ValidationError as error:
        raise source.error(faults_of(error)) from None
