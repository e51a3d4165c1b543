"""Rolling friction, and the torsional friction of single points, of eight manifolds side by side. Bodies over lanes.

Rolling friction [m] is a lever arm: an angular impulse across the normal, at most that times the normal impulse, that opposes the bodies' rolling
on each other (principle of maximum dissipation, as for sliding). Torsional friction [m] is the radius of the contact patch: about the normal, at
most μ times that times the normal impulse; where a manifold has several points ``soft_contact.solve`` has that already.

Few bodies have either, so these impulses have blocks of their own, beside the blocks of the contacts that they belong to.
"""

from atlasphys.engine.simd import gather, load, maximum, minimum, scatter, select, simd_kernel, store, vec
from atlasphys.engine.solvers.contact_block import (
    COEFFICIENT,
    NORMAL,
    TWIST,
    TWIST_MASS,
    TWIST_RADIUS,
    TWIST_TOTAL,
    Fields,
    invert_2x2,
    load_vec,
    solve_disk,
)
from atlasphys.engine.state.blocks import BODY_A, BODY_B, COUNT, MANIFOLD, MOVES_A, MOVES_B
from atlasphys.engine.state.manifolds import PATCH_ROLLING, ROLLING

# Fields of a block
ROLLING_MATRIX = 0  # 0–2 inverse of the 2×2 matrix of the tangents, 3 inverse of its greatest eigenvalue
LEVER = 4  # rolling friction [m]
ROLL = 5  # 5–6 angular impulse along the two tangents
ROLLING_FIELDS = 8


@simd_kernel
def prepare_rolling(block, integers, blocks, rolls, manifolds, inverse_mass, ratio):
    """Write a block. ``ratio`` scales last step's impulses."""
    head = gather(manifolds.contact, load(integers, block, MANIFOLD), 16)
    used = load(integers, block, COUNT) > 0
    t1, t2 = vec.tangents(load_vec(blocks, block, NORMAL))
    inertia_a, inertia_b = (gather(inverse_mass, load(integers, block, body)) for body in (BODY_A, BODY_B))
    inertia = tuple(x + y for x, y in zip(inertia_a[0:6], inertia_b[0:6], strict=True))
    turn1, turn2 = vec.sym_mul_vec(inertia, t1), vec.sym_mul_vec(inertia, t2)
    for i, entry in enumerate(invert_2x2(vec.dot(t1, turn1), vec.dot(t1, turn2), vec.dot(t2, turn2))):
        store(rolls, block, ROLLING_MATRIX + i, entry)
    store(rolls, block, LEVER, select(used, head[ROLLING], 0))
    rolling = head[PATCH_ROLLING : PATCH_ROLLING + 3]
    for i, t in enumerate((t1, t2)):
        store(rolls, block, ROLL + i, select(used, vec.dot(rolling, t) * ratio, 0))


class Spins:
    """The angular velocities of the two bodies of a block's manifolds."""

    def __init__(self, block, integers, motion, inverse_mass):
        self.rows = [load(integers, block, body) for body in (BODY_A, BODY_B)]
        self.moves = [load(integers, block, moves) != 0 for moves in (MOVES_A, MOVES_B)]
        self.motion = [gather(motion, row) for row in self.rows]
        self.inertia = [gather(inverse_mass, row)[0:6] for row in self.rows]
        self.spins = [m[3:6] for m in self.motion]

    def between(self):
        """ω_b − ω_a."""
        return vec.sub(self.spins[1], self.spins[0])

    def turn(self, impulse):
        """Apply an angular impulse to b, and its opposite to a."""
        for i, sign in ((0, -1.0), (1, 1.0)):
            self.spins[i] = vec.add_scaled(self.spins[i], vec.sym_mul_vec(self.inertia[i], impulse), sign)

    def store(self, motion):
        """Write the angular velocities of the bodies that are moved by impulses."""
        for row, moves, m, spin in zip(self.rows, self.moves, self.motion, self.spins, strict=True):
            scatter(motion, row, (*m[0:3], *spin, *m[6:8]), where=moves)


@simd_kernel
def start_rolling(points, block, integers, blocks, rolls, motion, inverse_mass):
    """Apply the impulses that the last substep ended with."""
    spins = Spins(block, integers, motion, inverse_mass)
    n = load_vec(blocks, block, NORMAL)
    t1, t2 = vec.tangents(n)
    impulse = vec.add_scaled(vec.scale(t1, load(rolls, block, ROLL)), t2, load(rolls, block, ROLL + 1))
    if points == 1:
        impulse = vec.add_scaled(impulse, n, load(blocks, block, TWIST))
    spins.turn(impulse)
    spins.store(motion)


@simd_kernel
def solve_rolling(points, block, integers, blocks, rolls, motion, inverse_mass, counts):
    """One visit, within what the present normal impulses allow. ``counts`` is 1 where the impulse is added to the total, else 0."""
    spins, fields = Spins(block, integers, motion, inverse_mass), Fields(points)
    impulses = [load(blocks, block, fields.impulse + k) for k in range(points)]
    pressed = sum(impulses[1:], impulses[0])
    n = load_vec(blocks, block, NORMAL)
    t1, t2 = vec.tangents(n)
    spin = spins.between()
    was = load(rolls, block, ROLL), load(rolls, block, ROLL + 1)
    inverse = [load(rolls, block, ROLLING_MATRIX + i) for i in range(4)]
    now = solve_disk(was, (vec.dot(t1, spin), vec.dot(t2, spin)), inverse, load(rolls, block, LEVER) * pressed)
    impulse = vec.add_scaled(vec.scale(t1, now[0] - was[0]), t2, now[1] - was[1])
    store(rolls, block, ROLL, now[0])
    store(rolls, block, ROLL + 1, now[1])
    if points == 1:
        old = load(blocks, block, TWIST)
        limit = load(blocks, block, COEFFICIENT) * load(blocks, block, TWIST_RADIUS) * pressed
        twist = maximum(minimum(old - load(blocks, block, TWIST_MASS) * vec.dot(n, spin), limit), -limit)
        impulse = vec.add_scaled(impulse, n, twist - old)
        store(blocks, block, TWIST, twist)
        store(blocks, block, TWIST_TOTAL, load(blocks, block, TWIST_TOTAL) + counts * twist)
    spins.turn(impulse)
    spins.store(motion)


@simd_kernel
def store_rolling(block, integers, blocks, rolls, manifolds):
    """Write the rolling impulses of the last substep to the manifolds, for warm starting."""
    row, used = load(integers, block, MANIFOLD), load(integers, block, COUNT) > 0
    head = gather(manifolds.contact, row, 16)
    t1, t2 = vec.tangents(load_vec(blocks, block, NORMAL))
    rolling = vec.add_scaled(vec.scale(t1, load(rolls, block, ROLL)), t2, load(rolls, block, ROLL + 1))
    scatter(manifolds.contact, row, (*head[:PATCH_ROLLING], *rolling, *head[PATCH_ROLLING + 3 :]), where=used)
