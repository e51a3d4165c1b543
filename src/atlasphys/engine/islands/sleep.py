"""Islands and sleep: bodies that have been at rest for a while, together with all that they touch, are left out until something disturbs them.

An island is a set of dynamic bodies connected by contacts and joints; static and kinematic bodies do not connect. It falls asleep once each of its
bodies has been slower than a threshold for ``TIME_TO_SLEEP``, and wakes as a whole. A sleeping body's entry in ``Bodies.island`` is the lowest row
of its island, an awake one's is AWAKE.

Islands are found by union–find over the contacts and joints of the step, and only in steps in which some body has rested for long enough.
"""

from atlasphys.engine.jit import routine
from atlasphys.engine.math.union_find import find_root, unite
from atlasphys.engine.state.bodies import AWAKE, DYNAMIC, KINEMATIC

TIME_TO_SLEEP = 0.5
"""How long a body must have been at rest before it may sleep [s]. Smaller: what only pauses at the top of its path falls asleep there."""

NEVER_SLEEPS = 3
"""Column of ``Bodies.response``: 1 if the body, and with it its island, never sleeps."""


@routine
def is_active(kind, island, rest, motion, i):
    """Whether body i may disturb others: a dynamic one that is awake, a kinematic one that moves, or one of the rest that was changed by hand."""
    if kind[i] == DYNAMIC:
        return island[i] == AWAKE
    if rest[i] < 0:
        return True
    if kind[i] == KINEMATIC:
        for k in range(6):
            if motion[i, k] != 0:
                return True
    return False


@routine
def list_active(kind, island, rest, motion, count, active):
    """Note for each body whether it is active."""
    for i in range(count):
        active[i] = is_active(kind, island, rest, motion, i)


@routine
def list_awake(kind, island, frame, count, plain, tumbling):
    """List the bodies to be moved, in blocks of eight filled up with the last. Returns the number of blocks of either list."""
    lanes = plain.shape[1]
    filled_plain = filled_tumbling = 0
    for i in range(count):
        if kind[i] == KINEMATIC or (kind[i] == DYNAMIC and island[i] == AWAKE):
            if frame[i, 3] > 0:
                tumbling[filled_tumbling // lanes, filled_tumbling % lanes] = i
                filled_tumbling += 1
            else:
                plain[filled_plain // lanes, filled_plain % lanes] = i
                filled_plain += 1
    fill_up(plain, filled_plain)
    fill_up(tumbling, filled_tumbling)
    return (filled_plain + lanes - 1) // lanes, (filled_tumbling + lanes - 1) // lanes


@routine
def fill_up(blocks, filled):
    """Repeat the last row number to the end of its block."""
    lanes = blocks.shape[1]
    while filled % lanes:
        blocks[filled // lanes, filled % lanes] = blocks[(filled - 1) // lanes, (filled - 1) % lanes]
        filled += 1


@routine
def wake_touched(
    pairs, live, number, body, linked, kind, island, rest, active, count, marked, island_before, rest_before
):  # fmt: skip
    """Wake each island that has a contact with an active body, or a joint. Returns how many bodies woke.

    ``live`` lists those of the ``pairs`` that have contact points, ``linked`` (n, 2) joined bodies. ``marked`` (n,) is scratch, zero before and
    after. ``island_before`` and ``rest_before`` (n,) receive what the two were of those that wake.
    """
    found = False
    for s in range(number + len(linked)):
        if s < number:
            row_a, row_b = body[pairs[live[s], 0]], body[pairs[live[s], 1]]
        else:
            row_a, row_b = linked[s - number, 0], linked[s - number, 1]
        for sleeper, other in ((row_a, row_b), (row_b, row_a)):
            if kind[sleeper] == DYNAMIC and island[sleeper] != AWAKE and active[other]:
                marked[island[sleeper]] = 1
                found = True
    if not found:
        return 0
    woken = 0
    for i in range(count):
        if kind[i] == DYNAMIC and island[i] != AWAKE and marked[island[i]]:
            island_before[i], rest_before[i] = island[i], rest[i]
            rest[i] = 0
            active[i] = 1
            woken += 1
    for i in range(count):
        if kind[i] == DYNAMIC and active[i] and island[i] != AWAKE:
            marked[island[i]] = 0
            island[i] = AWAKE
    return woken


@routine
def note_rest(rows, blocks, kind, motion, response, radius, slow, h, rest):
    """Add a step of length h to the time at rest of the bodies that are slower than ``slow`` [m/s], counting rotation at their bounding radius."""
    limit = slow * slow
    for block in range(blocks):
        for lane in range(rows.shape[1]):
            i = rows[block, lane]
            if lane > 0 and i == rows[block, lane - 1]:
                break
            if kind[i] == DYNAMIC:
                speed = motion[i, 0] * motion[i, 0] + motion[i, 1] * motion[i, 1] + motion[i, 2] * motion[i, 2]
                spin = motion[i, 3] * motion[i, 3] + motion[i, 4] * motion[i, 4] + motion[i, 5] * motion[i, 5]
                at_rest = speed + spin * radius[i] * radius[i] < limit and response[i, NEVER_SLEEPS] == 0
                rest[i] = rest[i] + h if at_rest else 0


@routine
def put_to_sleep(pairs, live, number, body, linked, kind, island, rest, motion, active, count, parent, ready):
    """Let the islands sleep whose bodies have all rested for long enough. Returns how many bodies fell asleep.

    ``parent`` (n,) int32 and ``ready`` (n,) uint8 are scratch, the latter zero before and after.
    """
    candidates = False
    for i in range(count):
        parent[i] = i
        long_enough = kind[i] == DYNAMIC and island[i] == AWAKE and rest[i] >= TIME_TO_SLEEP
        ready[i] = long_enough
        candidates = candidates or long_enough
    if not candidates:
        return 0
    for s in range(number + len(linked)):
        if s < number:
            row_a, row_b = body[pairs[live[s], 0]], body[pairs[live[s], 1]]
        else:
            row_a, row_b = linked[s - number, 0], linked[s - number, 1]
        if kind[row_a] == DYNAMIC and kind[row_b] == DYNAMIC:
            unite(parent, row_a, row_b)
        elif kind[row_a] == KINEMATIC and active[row_a]:
            ready[row_b] = 0
        elif kind[row_b] == KINEMATIC and active[row_b]:
            ready[row_a] = 0
    for i in range(count):  # the root is the lowest row, so that it has been seen when its members come
        if kind[i] == DYNAMIC and island[i] == AWAKE and not ready[i]:
            ready[find_root(parent, i)] = 0
    asleep = 0
    for i in range(count):
        if kind[i] == DYNAMIC and island[i] == AWAKE:
            root = find_root(parent, i)
            if ready[root]:
                island[i] = root
                asleep += 1
                active[i] = 0
                for k in range(6):
                    motion[i, k] = 0
    for i in range(count):
        ready[i] = 0
    return asleep
