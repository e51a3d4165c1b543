"""What a world keeps of its bodies beside the physics, and its state at one moment."""

from __future__ import annotations

from dataclasses import dataclass

from atlasphys.engine.state.state import State
from atlasphys.engine.step import Pipeline
from atlasphys.world.joint import JointInfo


@dataclass(frozen=True, slots=True)
class BodyInfo:
    """What is known of a body beside the physics."""

    name: str | None
    color: tuple[float, float, float] | None


class Snapshot:
    """A world's state at one moment, from :meth:`World.snapshot`. It can be restored any number of times, and pickled."""

    __slots__ = ("_infos", "_joint_infos", "_pipeline", "_state")

    def __init__(self, state: State, infos: list[BodyInfo], joint_infos: list[JointInfo], pipeline: Pipeline) -> None:
        self._state = state
        self._infos, self._joint_infos = infos, joint_infos
        self._pipeline = pipeline

    def __repr__(self) -> str:
        return f"<Snapshot: {self._state.count} bodies at {self._state.time:.6g} s>"
