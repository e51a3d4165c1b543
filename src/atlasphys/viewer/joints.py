"""Joints as a frame holds them, and the lines that are drawn of them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

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
    """The joints of a frame, a row each. Frames share one until something is edited by hand.

    Args:
        entries: what is known of them.
        kinds: the joints, placed.
    """

    def __init__(self, entries: Iterable[JointEntry], kinds: list[JointKind]) -> None:
        self.entries = tuple(entries)
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

    @classmethod
    def of_world(cls, world: World) -> JointTable:
        """The joints of a world."""
        joints = list(world.joints)
        entries = [entry_of(row, j.id, j.settings, j.name, ends_of(j)) for row, j in enumerate(joints)]
        return cls(entries, [joint.settings for joint in joints])

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
    selected: JointState | None = None
    """The joint that was asked for; None in a recording, which knows no forces."""
    there: npt.NDArray[np.bool_] | None = None
    """(j,) which are in the world at this time; None: all."""


def entry_of(row: int, identity: int, kind: JointKind, name: str | None, ends: tuple[str, str]) -> JointEntry:
    """What lists say of a joint."""
    title = type(kind).__name__
    called = f"{title} {name!r}" if name else title
    return JointEntry(identity, f"{row}: {called}, {' to '.join(ends)}", title)


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


class _Placed(NamedTuple):
    """Where joints are at one moment [m]."""

    anchors: Floats
    """(j, 2, 3) on a and on b."""
    arms: Floats
    """(j, 2, 2, 3) from the centre of either body to its anchor."""
    tied: npt.NDArray[np.bool_]
    """(j, 2) whether a side is a body, rather than the world."""
    acts: npt.NDArray[np.bool_]
    idle: npt.NDArray[np.bool_]
    hung: Rows
    """Rows of the pulleys."""
    grounds: Floats
    """(p, 2, 3) what they hang from."""


def _placed(frame: Frame, centers: Floats) -> _Placed | None:
    joints = frame.joints
    if joints is None or len(joints.table) == 0:
        return None
    table, drawn = joints.table, min(len(joints.table), MOST_JOINTS)
    bodies, acts = joints.bodies[:drawn], joints.acts[:drawn]
    idle = ~acts if joints.there is None else ~acts & joints.there[:drawn]
    tied = bodies != WORLD
    position, orientation = frame.position[bodies], frame.orientation[bodies].astype(np.float64)
    local = table.anchors[:drawn]
    moved = position + rotate(orientation.reshape(-1, 4), local.reshape(-1, 3)).reshape(-1, 2, 3)
    anchors = np.where(tied[:, :, None], moved, local)
    hung = table.hung[table.hung < drawn]
    arms = np.stack([centers[bodies], anchors], axis=2)
    return _Placed(anchors, arms, tied, acts, idle, hung, table.grounds[: len(hung)])


def joint_lines(frame: Frame, centers: Floats, width: float, selected: int | None = None) -> JointLines:
    """The lines of a frame's joints.

    Args:
        frame: a moment; one of a recording of an earlier version has no joints.
        centers: (n, 3) centres of mass of its bodies [m].
        width: length of the mark of an axis [m].
        selected: id of the joint to be marked.
    """
    placed = _placed(frame, centers)
    if placed is None:
        return NO_LINES
    assert frame.joints is not None
    anchors, arms, tied, acts, idle, hung, grounds = placed
    links = anchors[:, None]
    ropes = np.stack([anchors[hung], grounds], axis=2).reshape(-1, 2, 3)
    plain = np.ones(len(anchors), np.bool_)
    plain[hung] = False
    over = np.concatenate([ropes[np.repeat(acts[hung], 2)], grounds[acts[hung]]])
    chosen = frame.joints.table.row(selected)
    marked = NO_LINES.selected
    if chosen is not None and chosen < len(anchors) and (acts | idle)[chosen]:
        marked = np.concatenate([arms[chosen][tied[chosen]], links[chosen] if plain[chosen] else NO_LINES.links])
    return JointLines(
        arms=arms[tied & acts[:, None]],
        links=np.concatenate([links[plain & acts, 0], over]),
        axes=_axis_marks(frame, frame.joints, anchors, width),
        idle=arms[tied & idle[:, None]],
        selected=marked,
    )


def joint_at(
    frame: Frame, centers: Floats, width: float, origin: Any, direction: Any, tolerance: float, *, arms: bool = True
) -> int | None:
    """Id of the joint whose lines a ray comes nearest to, None if none is within an angle of ``tolerance`` [rad].

    Args:
        frame, centers, width: as for :func:`joint_lines`.
        origin: (3,) where the ray begins: the camera [m].
        direction: (3,) unit vector.
        tolerance: greatest angle between the ray and a point of a line, as seen from its origin [rad].
        arms: whether lines from the centres of bodies to anchors count.
    """
    placed = _placed(frame, centers)
    if placed is None:
        return None
    assert frame.joints is not None
    sides = placed.tied & (placed.acts | placed.idle)[:, None] & arms
    plain = placed.acts.copy()
    plain[placed.hung] = False
    hung = placed.hung[placed.acts[placed.hung]]
    ropes = np.stack([placed.anchors[hung], placed.grounds[placed.acts[placed.hung]]], axis=2).reshape(-1, 2, 3)
    axis_rows = frame.joints.table.axis_joint
    axis_rows = axis_rows[(axis_rows < len(placed.anchors))]
    segments = np.concatenate(
        [placed.arms[sides], placed.anchors[plain], ropes, _axis_marks(frame, frame.joints, placed.anchors, width)]
    )
    rows = np.concatenate(
        [np.nonzero(sides)[0], np.flatnonzero(plain), np.repeat(hung, 2), axis_rows[placed.acts[axis_rows]]]
    )
    if len(rows) == 0:
        return None
    angles = _angles_to(segments - np.asarray(origin, np.float64), np.asarray(direction, np.float64))
    best = int(angles.argmin())
    return frame.joints.table.entries[int(rows[best])].id if angles[best] <= tolerance else None


def _angles_to(segments: Floats, direction: Floats) -> Floats:
    """(k,) least angle, about, between a ray from the origin and points of segments (k, 2, 3); π for those behind it."""
    share = np.linspace(0.0, 1.0, 33)[:, None]
    points = segments[:, None, 0] + share * (segments[:, None, 1] - segments[:, None, 0])
    along = points @ direction
    across = np.sqrt(np.maximum(0.0, (points**2).sum(axis=-1) - along**2))
    angles: Floats = np.where(along > 0, np.arctan2(across, along), np.pi).min(axis=1)
    return angles


def _axis_marks(frame: Frame, joints: JointsNow, anchors: Floats, width: float) -> Floats:
    table = joints.table
    kept = table.axis_joint < len(anchors)
    kept[kept] &= joints.acts[table.axis_joint[kept]]
    joint, side, axis = table.axis_joint[kept], table.axis_side[kept], table.axis[kept]
    body = joints.bodies[joint, side]
    axis = np.where((body != WORLD)[:, None], rotate(frame.orientation[body].astype(np.float64), axis), axis)
    middle = anchors[joint, side]
    return np.stack([middle - 0.5 * width * axis, middle + 0.5 * width * axis], axis=1)
