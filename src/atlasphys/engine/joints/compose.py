"""From a kind of joint to the rows of its parts."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from atlasphys.engine.joints.frames import Vector, difference
from atlasphys.engine.joints.kinds.kind import JointKind
from atlasphys.engine.joints.part import Part
from atlasphys.engine.state.joints import (
    ARM_A,
    ARM_B,
    DAMPING,
    FIRST_BLOCK_TYPE,
    FRAME_A,
    FRAME_B,
    FREQUENCY,
    FRICTION_FORCE,
    LOWER,
    MOTOR_FORCE,
    RATIO_A,
    REST,
    SPEED,
    SPRING_FORCE,
    TURNS_A,
    UNBOUNDED,
    UPPER,
    WORLD,
    JointTable,
    Parts,
)
from atlasphys.engine.state.state import State


def bounded(value: float) -> float:
    """A number, UNBOUNDED for infinity."""
    return math.copysign(UNBOUNDED, value) if math.isinf(value) else value


def add_joint(state: State, kind: JointKind, identity: int, body: tuple[int, int]) -> int:
    """Add a placed joint between two rows of bodies; returns its row."""
    table, parts = state.joints, kind.parts()
    row = table.append(len(parts))
    table.rows.id[row], table.rows.body[row], table.rows.enabled[row] = identity, body, True
    write_joint(state, row, kind, parts)
    return row


def change_joint(state: State, row: int, kind: JointKind) -> None:
    """Write a joint anew whose kind has been given other settings. Parts of the same types keep their impulses."""
    table, parts = state.joints, kind.parts()
    first, number = int(table.rows.first[row]), int(table.rows.parts[row])
    types = table.parts.type[first : first + number].tolist()
    if types != [part.type for part in parts]:
        before = {kind: table.parts.impulse[first + k].copy() for k, kind in enumerate(types)}
        table.resize(row, len(parts))
        for k, part in enumerate(parts):
            table.parts.impulse[first + k] = before.get(part.type, 0.0)
    write_joint(state, row, kind, parts)


def write_joint(state: State, row: int, kind: JointKind, parts: list[Part]) -> None:
    """Write what a kind of joint says into the joint's row and those of its parts, and wake its bodies."""
    table = state.joints
    table.rows.collide[row] = kind.collide
    table.rows.strength[row] = kind.breaking_force, kind.breaking_torque
    anchors, centers = kind.anchors(), []
    for body, anchor in zip(table.rows.body[row].tolist(), anchors, strict=True):
        center = (0.0, 0.0, 0.0) if body == WORLD else tuple(state.bodies.local_center[body].tolist())
        centers.append(difference(anchor, center))
    first = int(table.rows.first[row])
    for k, part in enumerate(parts):
        write_part(table.parts, first + k, part, centers, table.rows.body[row])
    state.joints_changed(row)


def write_part(parts: Parts, p: int, part: Part, arms: list[Vector], body: npt.NDArray[np.int32]) -> None:
    """Write one part. ``arms`` are its anchors from the centres of mass; of the world, they are where they are."""
    numbers = parts.settings[p]
    parts.type[p] = part.type
    parts.base[p] = 0
    for side, (column, base) in enumerate(((ARM_A, 0), (ARM_B, 4))):
        tied = body[side] != WORLD
        numbers[column : column + 3] = arms[side] if tied else 0.0
        if part.hung is not None:
            parts.base[p, base : base + 3] = part.hung[side]
        elif not tied:
            parts.base[p, base : base + 3] = arms[side]
    numbers[FRAME_A : FRAME_A + 4], numbers[FRAME_B : FRAME_B + 4] = part.frame_a, part.frame_b
    numbers[LOWER], numbers[UPPER] = bounded(part.lower), bounded(part.upper)
    elastic = part.elastic
    numbers[REST] = 0.0 if elastic is None else elastic.rest
    numbers[SPRING_FORCE] = 0.0 if elastic is None else bounded(elastic.max_force)
    parts.elastic[p, FREQUENCY] = -1.0 if elastic is None else elastic.frequency
    parts.elastic[p, DAMPING] = 0.0 if elastic is None else elastic.damping
    motor = part.motor
    numbers[SPEED] = 0.0 if motor is None or motor.speed is None else motor.speed
    numbers[MOTOR_FORCE] = 0.0 if motor is None else bounded(motor.max_force)
    numbers[FRICTION_FORCE] = bounded(part.friction)
    if part.type >= FIRST_BLOCK_TYPE and part.friction > 0:
        numbers[SPRING_FORCE] = bounded(part.friction)
    numbers[RATIO_A : RATIO_A + 2] = part.ratio
    numbers[TURNS_A : TURNS_A + 2] = part.turns


def reactions(table: JointTable) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Impulse [N s] and angular impulse about the anchor [N m s] of each joint on its body b over the last step, (joints, 3) each."""
    force, torque = np.zeros((2, table.count, 3))
    n = table.part_count
    joint = table.parts.joint[:n]
    np.add.at(force, joint, table.parts.total[:n, 0:3].astype(np.float64))
    np.add.at(torque, joint, table.parts.total[:n, 3:6].astype(np.float64))
    return force, torque


def break_joints(table: JointTable) -> None:
    """Break the joints whose reaction in the last step was greater than they bear."""
    n = table.count
    force, torque = reactions(table)
    bears = table.rows.strength[:n] * table.elapsed
    too_much = (np.sqrt((force**2).sum(axis=1)) > bears[:, 0]) | (np.sqrt((torque**2).sum(axis=1)) > bears[:, 1])
    table.broke = np.flatnonzero(too_much & table.active).astype(np.int32)
    table.rows.broken[table.broke] = True
