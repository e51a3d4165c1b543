"""Greedy colouring of the contact graph, and its layout in blocks of eight.

Contacts of one colour share no body that impulses move, so eight of them at a time, and all of them on several threads, can be solved
without one seeing another's impulse half applied. Each contact takes the lowest colour that neither of its bodies has used yet: a bit mask of
64 colours per body. Bodies that impulses do not move (static, kinematic) never conflict. Where there is none left, the contact
goes to the last colour, one contact a block: so do those that bodies keep whole that have many contacts and are split (``split.py``).
"""

import numpy as np

from atlasphys.engine.jit import routine
from atlasphys.engine.math import vec
from atlasphys.engine.simd import LANES
from atlasphys.engine.simd.bits import trailing_ones
from atlasphys.engine.state.blocks import BODY_A, BODY_B, COUNT, MANIFOLD, MOVES_A, MOVES_B
from atlasphys.engine.state.manifolds import NORMAL

COLOURS = 64
"""Colours that several contacts share; one more, numbered COLOURS, takes those for which there is none, block by block."""


@routine
def colour_contacts(ends, row, count, live, number, moves, used, colours, sizes):
    """Give the first ``number`` of the pairs ``live`` their colours, and count them.

    ``ends`` (blocks, 2, 8) are the rows between which each is solved, ``row`` the row of its manifold, which has ``count`` points; ``moves`` says
    which rows impulses move; ``used`` (rows,) uint64 are the colours that each row has in use, and may not get any more. ``sizes`` (2, COLOURS + 1)
    receives the number of contacts per class (0: one point; 1: more) and colour.
    """
    one = np.uint64(1)
    full = ~np.uint64(0)
    sizes[:] = 0
    for s in range(number):
        i = live[s]
        row_a, row_b = ends[i // LANES, 0, i % LANES], ends[i // LANES, 1, i % LANES]
        taken = np.uint64(0)
        if moves[row_a]:
            taken |= used[row_a]
        if moves[row_b]:
            taken |= used[row_b]
        colour = COLOURS
        if taken != full:
            colour = trailing_ones(taken)
            bit = one << np.uint64(colour)
            used[row_a] |= bit
            used[row_b] |= bit
        colours[i] = colour
        sizes[1 if count[row[i]] > 1 else 0, colour] += 1


@routine
def weight_first(contact, row, gravity, live, number, scratch):
    """Move the contacts that carry weight, whose normal is within 45° of gravity's line, to the front of a list of pairs; the order is kept
    otherwise. Pair i has row ``row[i]`` of ``contact``. ``scratch`` has as many entries as the list.

    For solvers that begin each substep without impulses: the first of several contacts that could carry a body is the one that does. If the colours
    of contacts side by side fall between those of contacts one above the other, all rows of a wall come to rest on the same side, and lean.
    """
    g = vec.length_squared(gravity)
    first, rest = 0, 0
    for s in range(number):
        i = live[s]
        along = vec.dot(vec.load_columns(contact, row[i], NORMAL), gravity)
        if along * along >= type(g)(0.5) * g:
            live[first] = i
            first += 1
        else:
            scratch[rest] = i
            rest += 1
    for s in range(rest):
        live[first + s] = scratch[s]


@routine
def block_ranges(sizes, starts):
    """From numbers of contacts to ``starts`` (2, COLOURS + 2): the first block of each class and colour, and past the last one. Returns the number
    of colours up to the last that is in use."""
    for points in range(2):
        block = 0
        for colour in range(COLOURS):
            starts[points, colour] = block
            block += (sizes[points, colour] + LANES - 1) // LANES
        starts[points, COLOURS] = block
        starts[points, COLOURS + 1] = block + sizes[points, COLOURS]
    used = 0
    for colour in range(COLOURS + 1):
        if sizes[0, colour] > 0 or sizes[1, colour] > 0:
            used = colour + 1
    return used


@routine
def fill_blocks(ends, row, count, live, number, moves, colours, starts, cursor, integers_one, integers_many):
    """Write which manifold, and which rows, each lane of each block holds. ``cursor`` (2, COLOURS + 1) is scratch."""
    for points in range(2):
        for colour in range(COLOURS + 1):
            cursor[points, colour] = LANES * starts[points, colour]
    integers_one[: starts[0, COLOURS + 1]] = 0
    integers_many[: starts[1, COLOURS + 1]] = 0
    for s in range(number):
        i = live[s]
        colour = colours[i]
        manifold = row[i]
        points = 1 if count[manifold] > 1 else 0
        place = cursor[points, colour]
        cursor[points, colour] += LANES if colour == COLOURS else 1
        block, lane = place // LANES, place % LANES
        integers = integers_many if points else integers_one
        row_a, row_b = ends[i // LANES, 0, i % LANES], ends[i // LANES, 1, i % LANES]
        integers[block, BODY_A, lane], integers[block, BODY_B, lane] = row_a, row_b
        integers[block, MOVES_A, lane], integers[block, MOVES_B, lane] = moves[row_a], moves[row_b]
        integers[block, MANIFOLD, lane], integers[block, COUNT, lane] = manifold, count[manifold]


@routine
def beside(block, colour, stop):
    """The block that is worked on together with ``block``: the next, or itself if there is none, or the two may have bodies in common."""
    return block + 1 if colour < COLOURS and block + 1 < stop else block
