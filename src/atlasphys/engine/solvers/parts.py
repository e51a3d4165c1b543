"""The parts of hubs (islands/split.py) in a step: what they are given before a pass over the contacts, and how they are joined after it.

While there are hubs, the solver works on copies of three of the bodies' columns, in which the parts' rows follow the bodies'. All parts of a body
have the same mass, so the mean of their velocities keeps its linear and angular momentum; and it loses energy, as every inelastic impact does, if
they differ. Where the impulses have converged they do not.
"""

from atlasphys.engine.islands.split import FIRST, NUMBER, ROW
from atlasphys.engine.jit import routine
from atlasphys.engine.state.work import HUBS
from atlasphys.engine.team import meet, share


@routine
def copy_rows(source, target, first, stop):
    """Copy a range of rows."""
    for i in range(first, stop):
        for k in range(source.shape[1]):
            target[i, k] = source[i, k]


@routine
def take_bodies(bodies, work, member):
    """Copy the bodies' rows to those that the solver works on while there are hubs, and give parts theirs."""
    if work.status[HUBS] > 0:
        first, stop = share(0, work.hubs[0, FIRST], member)
        copy_rows(bodies.motion, work.motion, first, stop)
        copy_rows(bodies.inverse_mass, work.inverse_mass, first, stop)
        meet(member)
        hand_out(work.motion, work.inverse_mass, work.drives, work, member)


@routine
def give_back(bodies, work, member):
    """Copy the bodies' rows back."""
    if work.status[HUBS] > 0:
        first, stop = share(0, work.hubs[0, FIRST], member)
        copy_rows(work.motion, bodies.motion, first, stop)
        copy_rows(work.inverse_mass, bodies.inverse_mass, first, stop)
        meet(member)


@routine
def hand_out(motion, inverse_mass, drives, work, member):
    """Let all parts go on from where their bodies are."""
    hubs, real = work.hubs, motion.dtype.type
    for hub in range(work.status[HUBS]):
        row, parts = hubs[hub, ROW], hubs[hub, NUMBER]
        first, stop = share(hubs[hub, FIRST], hubs[hub, FIRST] + parts, member)
        for part in range(first, stop):
            for k in range(motion.shape[1]):
                motion[part, k] = motion[row, k]
                inverse_mass[part, k] = real(parts) * inverse_mass[row, k]
            for k in range(drives.shape[1]):
                drives[part, k] = drives[row, k]
    if work.status[HUBS] > 0:
        meet(member)


@routine
def join_parts(hubs, found, motion):
    """Give the first ``found`` hubs the mean velocity of their parts. Parts that nothing has changed add nothing, not even round-off."""
    real = motion.dtype.type
    for hub in range(found):
        row, first, parts = hubs[hub, ROW], hubs[hub, FIRST], hubs[hub, NUMBER]
        for k in range(6):
            before = motion[row, k]
            change = before - before
            for part in range(first, first + parts):
                change += motion[part, k] - before
            motion[row, k] = before + change / real(parts)
