"""Bodies with many contacts are split: their contacts are dealt out to parts, which do not conflict.

Contacts of one body cannot be solved at a time, so a body with n of them takes n colours, each of a contact or two: a plate under 5000 boxes would
leave all other threads and lanes idle. Such a body, a *hub*, is instead split for the step into k parts. Each has the body's centre of mass and
velocity, a k-th of its mass and inertia, and at most MOST_CONTACTS of its contacts. The parts are rows of their own in what the blocks read
and write; after every pass over the contacts they are joined (solvers/parts.py).

A part knows a k-th of the mass only: a contact that bears much more than the others would take k times as many passes, and sink k times as deep
as a soft contact of the whole body. So the contacts with the heaviest neighbours, above all with the ground, are kept *whole*: they go to the last
colour, which is solved one contact a block once the parts are joined.

R. Tonge, F. Benevolenski, A. Voroshilov, "Mass Splitting for Jitter-Free Parallel Rigid Body Simulation", ACM Transactions on Graphics 31 (2012).
"""

import numpy as np

from atlasphys.engine.jit import routine
from atlasphys.engine.simd import LANES

MOST_CONTACTS = 32
"""Most contacts of a part, and of a body that is not split. Two bodies in contact so have 62 others at most, and one of 64 colours is free."""

MOST_WHOLE = 16
"""Most contacts of a hub that are kept whole."""

# Columns of a table of hubs
ROW, FIRST, NUMBER, DEALT = range(4)  # the body's row, its first part's row, number of parts, contacts dealt out so far

HUB_COLUMNS = 4
"""Number of columns."""

INVERSE_MASS = 6
"""Column of ``Bodies.inverse_mass``."""


@routine
def find_hubs(pair_bodies, live, number, moves, count, hub_of, hubs):
    """List the bodies of more than MOST_CONTACTS contacts. Returns how many they are, and how many parts they have.

    ``live`` lists the contacts, ``pair_bodies`` (blocks, 2, 8) has their bodies, ``moves`` says which bodies impulses move; ``count`` is the
    number of bodies. The parts' rows follow the bodies'. ``hub_of`` (bodies,) receives the number of the body's hub, or −1; ``hubs`` (room, 4) as
    many hubs as it has room for.
    """
    hub_of[:count] = 0
    for s in range(number):
        block, lane = live[s] // LANES, live[s] % LANES
        for side in range(2):
            row = pair_bodies[block, side, lane]
            if moves[row]:
                hub_of[row] += 1
    found = parts = 0
    for row in range(count):
        contacts = hub_of[row]
        hub_of[row] = -1
        if contacts > MOST_CONTACTS:
            needed = (contacts + MOST_CONTACTS - 1) // MOST_CONTACTS
            if found < len(hubs):
                hub_of[row] = found
                hubs[found, ROW], hubs[found, FIRST], hubs[found, NUMBER] = row, count + parts, needed
                hubs[found, DEALT] = 0
            found += 1
            parts += needed
    return found, parts


@routine
def insert_least(values, x):
    """Put x into an ascending list, from which the greatest goes."""
    if x < values[-1]:
        k = len(values) - 1
        while k > 0 and values[k - 1] > x:
            values[k] = values[k - 1]
            k -= 1
        values[k] = x


@routine
def deal_contacts(pair_bodies, live, number, inverse_mass, hub_of, hubs, found, heaviest, ends):
    """Write to ``ends`` (blocks, 2, 8) the rows between which each contact is solved: of a hub, that of a part, or its own if the contact is whole.

    Parts get contacts in turn, so that each has a sample of all that the body touches. Whole are those with the MOST_WHOLE heaviest neighbours, or
    fewer: neighbours of equal mass are treated alike. ``heaviest`` (hubs, MOST_WHOLE + 1) is scratch for inverse masses.
    """
    heaviest[:found] = np.inf
    for s in range(number):
        block, lane = live[s] // LANES, live[s] % LANES
        for side in range(2):
            hub = hub_of[pair_bodies[block, side, lane]]
            if hub >= 0:
                insert_least(heaviest[hub], inverse_mass[pair_bodies[block, 1 - side, lane], INVERSE_MASS])
    for s in range(number):
        block, lane = live[s] // LANES, live[s] % LANES
        whole = False
        for side in range(2):
            hub = hub_of[pair_bodies[block, side, lane]]
            if hub >= 0:
                other = inverse_mass[pair_bodies[block, 1 - side, lane], INVERSE_MASS]
                whole = whole or other < heaviest[hub, MOST_WHOLE]
        for side in range(2):
            row = pair_bodies[block, side, lane]
            hub = hub_of[row]
            if hub >= 0 and not whole:
                row = hubs[hub, FIRST] + hubs[hub, DEALT] % hubs[hub, NUMBER]
                hubs[hub, DEALT] += 1
            ends[block, side, lane] = row
