"""Joints as a frame holds them, and the lines that are drawn of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from atlasphys.engine.joints.frames import Quaternion, Vector
from atlasphys.engine.joints.frames import rotate as turned
from atlasphys.engine.joints.kinds.couplings import Pulley
from atlasphys.engine.joints.kinds.hinge import Hinge
from atlasphys.engine.joints.kinds.kind import JointKind
from atlasphys.engine.joints.kinds.slider import Slider, Wheel
from atlasphys.engine.joints.kinds.universal import Universal
from atlasphys.engine.state.joints import WORLD
from atlasphys.world.rotation import rotate

if TYPE_CHECKING:
    from atlasphys.viewer.frame import Frame
    from atlasphys.world.joint import Joint
    from atlasphys.world.world import World

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.int64]

MOST_JOINTS = 4000
"""Most joints that are drawn: the first ones."""

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


class JointEntry(NamedTuple):
    """What is known of a joint until it is edited."""

    id: int
    label: str
    kind: str
    """Name of its class: ``"Hinge"``."""


class JointTable:
    """The joints of a frame, a row each. Frames share one until something is edited by hand."""

    def __init__(self, world: World) -> None:
        joints = list(world.joints)
        kinds = [joint.settings for joint in joints]
        self.entries = tuple(_entry(row, joint) for row, joint in enumerate(joints))
        self.anchors: Floats = np.array([kind.anchors() for kind in kinds], np.float64).reshape(-1, 2, 3)
        """(j, 2, 3) anchors in the axes of a and of b; in the world, if that is the side [m]."""
        axes = [(row, side, axis) for row, kind in enumerate(kinds) for side, axis in axes_of(kind)]
        self.axis_joint: Rows = np.array([row for row, _, _ in axes], np.int64)
        self.axis_side: Rows = np.array([side for _, side, _ in axes], np.int64)
        self.axis: Floats = np.array([axis for _, _, axis in axes], np.float64).reshape(-1, 3)
        """(k, 3) axes that joints turn about or slide along, each in the axes of a side of its joint."""
        self.hung: Rows = np.array([row for row, kind in enumerate(kinds) if isinstance(kind, Pulley)], np.int64)
        """Joints whose two anchors hang from points of the world rather than on each other."""
        grounds = [(kind.ground_a, kind.ground_b) for kind in kinds if isinstance(kind, Pulley)]
        self.grounds: Floats = np.array(grounds, np.float64).reshape(-1, 2, 3)
        self._rows = {entry.id: row for row, entry in enumerate(self.entries)}

    def __len__(self) -> int:
        return len(self.entries)

    def row(self, identity: int | None) -> int | None:
        """The row of a joint, or None if it is not there."""
        return None if identity is None else self._rows.get(identity)


@dataclass(frozen=True)
class JointState:
    """A joint at one moment."""

    id: int
    enabled: bool
    broken: bool
    ends: tuple[str, str]
    coordinates: dict[str, tuple[float, float]]
    """Value and rate of each coordinate by name [rad, m; a second]."""
    apart: float
    """Distance from anchor to anchor [m]."""
    force: Floats
    """(3,) mean force on b in the last step [N]."""
    torque: Floats
    """(3,) mean torque on b about its anchor [N m]."""
    motor_force: float
    """[N, N m]"""


@dataclass(frozen=True)
class JointsNow:
    """The joints at one moment."""

    table: JointTable
    bodies: npt.NDArray[np.int32]
    """(j, 2) rows of the bodies; −1: the world."""
    acts: npt.NDArray[np.bool_]
    """(j,) which are enabled and not broken."""
    selected: JointState | None
    """The joint that was asked for."""


def _entry(row: int, joint: Joint) -> JointEntry:
    kind = type(joint.settings).__name__
    called = f"{kind} {joint.name!r}" if joint.name else kind
    return JointEntry(joint.id, f"{row}: {called}, {' to '.join(ends_of(joint))}", kind)


def ends_of(joint: Joint) -> tuple[str, str]:
    """What a joint joins, in words."""
    a, b = ("the world" if end is None else end.name or f"body {end.row}" for end in (joint.a, joint.b))
    return a, b


def state_of(joint: Joint) -> JointState:
    """The present state of a joint."""
    a, b = joint.anchors
    return JointState(
        id=joint.id,
        enabled=joint.enabled,
        broken=joint.broken,
        ends=ends_of(joint),
        coordinates={name: (joint.coordinate(name), joint.rate(name)) for name in joint.settings.coordinates()},
        apart=float(np.sqrt(((b - a) ** 2).sum())),
        force=joint.reaction_force,
        torque=joint.reaction_torque,
        motor_force=joint.motor_force,
    )


def axes_of(kind: JointKind) -> list[tuple[int, Vector]]:
    """Side and direction, in the axes of that side, of each axis that a placed joint turns about or slides along."""
    a, b = kind.frames()
    match kind:
        case Wheel():
            axle: Quaternion = kind.axle_b
            return [(0, turned(a, X)), (1, turned(axle, X))]
        case Hinge() | Slider():
            return [(0, turned(a, X))]
        case Universal():
            return [(0, turned(a, Y)), (1, turned(b, Z))]
    return []


class JointLines(NamedTuple):
    """Lines to draw, (k, 2, 3) each [m]."""

    arms: Floats
    """From the centres of bodies to their anchors, of joints that act."""
    links: Floats
    """From anchor to anchor: rods, ropes, and how far other joints are from where they should be."""
    axes: Floats
    """What joints turn about or slide along."""
    idle: Floats
    """Arms of joints that are disabled or broken."""
    selected: Floats
    """Arms and link of one joint."""


NO_LINES = JointLines(*(np.empty((0, 2, 3)) for _ in JointLines._fields))


def joint_lines(frame: Frame, centers: Floats, width: float, selected: int | None = None) -> JointLines:
    """The lines of a frame's joints.

    Args:
        frame: a moment; one of a recording has no joints.
        centers: (n, 3) centres of mass of its bodies [m].
        width: length of the mark of an axis [m].
        selected: id of the joint to be marked.
    """
    joints = frame.joints
    if joints is None or len(joints.table) == 0:
        return NO_LINES
    table, drawn = joints.table, min(len(joints.table), MOST_JOINTS)
    bodies, acts = joints.bodies[:drawn], joints.acts[:drawn]
    tied = bodies != WORLD
    position, orientation = frame.position[bodies], frame.orientation[bodies].astype(np.float64)
    local = table.anchors[:drawn]
    moved = position + rotate(orientation.reshape(-1, 4), local.reshape(-1, 3)).reshape(-1, 2, 3)
    anchors = np.where(tied[:, :, None], moved, local)
    arms = np.stack([centers[bodies], anchors], axis=2)  # joint, side, end
    links = anchors[:, None].copy()
    hung = table.hung[table.hung < drawn]
    grounds = table.grounds[: len(hung)]
    ropes = np.stack([anchors[hung], grounds], axis=2).reshape(-1, 2, 3)
    plain = np.ones(drawn, np.bool_)
    plain[hung] = False
    over = np.concatenate([ropes[np.repeat(acts[hung], 2)], grounds[acts[hung]]])
    chosen = table.row(selected)
    marked = NO_LINES.selected
    if chosen is not None and chosen < drawn:
        marked = np.concatenate([arms[chosen][tied[chosen]], links[chosen] if plain[chosen] else NO_LINES.links])
    return JointLines(
        arms=arms[tied & acts[:, None]],
        links=np.concatenate([links[plain & acts, 0], over]),
        axes=_axis_marks(frame, joints, anchors, width),
        idle=arms[tied & ~acts[:, None]],
        selected=marked,
    )


def _axis_marks(frame: Frame, joints: JointsNow, anchors: Floats, width: float) -> Floats:
    table = joints.table
    kept = table.axis_joint < len(anchors)
    kept[kept] &= joints.acts[table.axis_joint[kept]]
    joint, side, axis = table.axis_joint[kept], table.axis_side[kept], table.axis[kept]
    body = joints.bodies[joint, side]
    axis = np.where((body != WORLD)[:, None], rotate(frame.orientation[body].astype(np.float64), axis), axis)
    middle = anchors[joint, side]
    return np.stack([middle - 0.5 * width * axis, middle + 0.5 * width * axis], axis=1)
