"""Which row of the tables of manifolds a pair has: one from when it gets contact points until it has none.

Most candidate pairs of a heap do not touch, so rows are given only to those that do, and given back. A pair's row is the same in both tables: what a
recycled pair keeps need not be copied from step to step. Row 0 is never given: it stays without points, and stands for "none".

Last step's table is left as it is until the step is complete, for a step that fails to return to. So a row is given back at the end of the step in
which its pair lost its points; it has none in either table then. Threads take rows as they find contacts, so who gets which depends on chance:
nothing may depend on the numbers of rows, and what is read out is put in the order of the pairs.
"""

import math

from atlasphys.engine.jit import routine
from atlasphys.engine.simd.atomic import atomic_add
from atlasphys.engine.state.manifolds import DEPTH, POINT_COLUMNS
from atlasphys.engine.state.work import BEGAN, ENDED, FREE, LIVE, PAIRS, PAIRS_BEFORE, ROWS, TAKEN


@routine
def carry_over(new, work):
    """Take over to a new list of candidate pairs what is known of those that were on the last one; both are ordered. What is no longer a candidate
    has no points in the next table."""
    pairs, before, known, j = work.pairs, work.pairs_before, work.status[PAIRS_BEFORE], 0
    for p in range(work.status[PAIRS]):
        a, b = pairs[p, 0], pairs[p, 1]
        while j < known and (before[j, 0] < a or (before[j, 0] == a and before[j, 1] < b)):
            new.count[work.row_before[j]] = 0
            j += 1
        work.row[p], work.expiry[p] = 0, -math.inf
        if j < known and before[j, 0] == a and before[j, 1] == b:
            work.row[p], work.expiry[p] = work.row_before[j], work.expiry_before[j]
            j += 1
    while j < known:
        new.count[work.row_before[j]] = 0
        j += 1


@routine
def take_row(work):
    """A row for a pair that has got points. Several threads may ask at a time."""
    number, free = atomic_add(work.status, TAKEN, 1), work.status[FREE]
    return work.free[free - 1 - number] if number < free else work.status[ROWS] + number - free


@routine
def give_back_rows(old, new, work):
    """At the end of a step, give back the rows of the pairs that have lost their points, and list those of them that touched."""
    status = work.status
    taken, free, ended = status[TAKEN], status[FREE], 0
    status[ROWS] += max(taken - free, 0)
    free = max(free - taken, 0)
    for i in range(1, status[ROWS]):
        lost = (old.count[i] > 0) & (new.count[i] == 0)
        work.free[free] = i  # no branch: a processor would guess wrong too often
        free += 1 if lost else 0
        work.ended[ended, 0], work.ended[ended, 1] = old.a[i], old.b[i]
        ended += 1 if lost & (old.touching[i] != 0) else 0
        old.count[i] = 0 if lost else old.count[i]
    status[TAKEN], status[FREE], status[ENDED] = 0, free, ended


@routine
def note_touching(new, work):
    """Which pairs touch now, and which of them began to in this step."""
    status, began = work.status, 0
    for s in range(status[LIVE]):
        p = work.live[s]
        i = work.row[p]
        if not new.touching[i]:
            for k in range(new.count[i]):
                if new.total[i, k] > 0 or new.points[i, POINT_COLUMNS * k + DEPTH] >= 0:
                    new.touching[i] = True
            if new.touching[i]:
                work.began[began, 0], work.began[began, 1] = work.pairs[p, 0], work.pairs[p, 1]
                began += 1
    status[BEGAN] = began
