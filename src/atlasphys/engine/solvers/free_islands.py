"""The momenta of free islands, for solvers that place bodies one by one.

Bodies that touch only each other keep their momentum P and angular momentum L, for contacts act on both alike. A solver that finds velocities body
by body keeps them only as far as it converges. What it lost is given back here as a rigid motion of the whole island, V + Ω × d for the bodies at d
from a common point. No contact of the island sees it: rigid motions leave all relative velocities as they are. It solves

    Σ m (V + Ω × d) = −ΔP,    Σ (m d × (V + Ω × d) + I Ω) = −ΔL.

Islands with a contact to a static or kinematic body, or with a body that is locked in some direction, are not free.
"""

from atlasphys.engine.jit import routine
from atlasphys.engine.math import mat, vec
from atlasphys.engine.math.ldlt import solve_6x6
from atlasphys.engine.math.union_find import find_root, unite
from atlasphys.engine.solvers.common import load_velocity, store_velocity
from atlasphys.engine.state.bodies import DYNAMIC

# Columns of ``sums``, one row for each island: the system above.
MASS, MOMENT, TENSOR, LOST, LOST_SPIN = 0, 1, 4, 10, 13  # Σ m; Σ m d; Σ I − m (d dᵀ − |d|²); ΔP; ΔL
RIGID = 16  # 16–18 V, 19–21 Ω
SUM_COLUMNS = 22


@routine
def list_free_islands(bodies, body_count, pairs, count, parent, free):
    """Write the representative of each body's island to ``parent``, and into its row of ``free`` whether the island is free and has contacts."""
    for i in range(body_count):
        parent[i] = i
        free[i] = False
    for c in range(count):
        a, b = pairs[c, 0], pairs[c, 1]
        if bodies.kind[a] == DYNAMIC and bodies.kind[b] == DYNAMIC:
            unite(parent, a, b)
    for c in range(count):
        free[find_root(parent, pairs[c, 0])] = True
    for c in range(count):
        a, b = pairs[c, 0], pairs[c, 1]
        if bodies.kind[a] != DYNAMIC or bodies.kind[b] != DYNAMIC:
            free[find_root(parent, a)] = free[find_root(parent, b)] = False
    for i in range(body_count):
        parent[i] = find_root(parent, i)
        if bodies.locks[i]:
            free[parent[i]] = False


@routine
def keep_momenta(bodies, body_count, before, inertia, parent, free, sums):
    """Give each free island the momenta back that it would have with the velocities ``before`` (bodies, 6).

    ``inertia`` (bodies, 6): the tensors in world axes. ``sums`` (bodies, SUM_COLUMNS) is scratch.
    """
    motion, center, mass = bodies.motion, bodies.center, bodies.mass
    real = type(motion[0, 0])
    for i in range(body_count):
        for c in range(SUM_COLUMNS):
            sums[i, c] = 0
    for i in range(body_count):
        island = parent[i]
        if free[island]:
            m, d = mass[i, 0], offset(center, i, island, real)
            v, w = load_velocity(motion, i)
            v_before, w_before = load_velocity(before, i)
            lost = vec.scale(vec.sub(v, v_before), m)
            tensor = load_tensor(inertia, i)
            lost_spin = vec.add(vec.cross(d, lost), mat.sym_mul_vec(tensor, vec.sub(w, w_before)))
            squared = vec.length_squared(d)
            sums[island, MASS] += m
            for k in range(3):
                sums[island, MOMENT + k] += m * d[k]
                sums[island, TENSOR + k] += tensor[k] + m * (squared - d[k] * d[k])
                sums[island, LOST + k] += lost[k]
                sums[island, LOST_SPIN + k] += lost_spin[k]
            sums[island, TENSOR + 3] += tensor[3] - m * d[0] * d[1]
            sums[island, TENSOR + 4] += tensor[4] - m * d[0] * d[2]
            sums[island, TENSOR + 5] += tensor[5] - m * d[1] * d[2]
    for i in range(body_count):
        if free[i]:
            m, zero = sums[i, MASS], real(0)
            x, y, z = vec.load_columns(sums, i, MOMENT)
            tensor = (
                sums[i, TENSOR], sums[i, TENSOR + 1], sums[i, TENSOR + 2],
                sums[i, TENSOR + 3], sums[i, TENSOR + 4], sums[i, TENSOR + 5],
            )  # fmt: skip
            lost, lost_spin = vec.load_columns(sums, i, LOST), vec.load_columns(sums, i, LOST_SPIN)
            shift, turn = solve_6x6(
                (m, m, m, zero, zero, zero), (zero, -z, y, z, zero, -x, -y, x, zero), tensor, vec.neg(lost), vec.neg(lost_spin)
            )  # fmt: skip
            vec.store_columns(sums, i, RIGID, shift)
            vec.store_columns(sums, i, RIGID + 3, turn)
    for i in range(body_count):
        island = parent[i]
        if free[island]:
            shift, turn = vec.load_columns(sums, island, RIGID), vec.load_columns(sums, island, RIGID + 3)
            v, w = load_velocity(motion, i)
            v = vec.add(v, vec.add(shift, vec.cross(turn, offset(center, i, island, real))))
            store_velocity(motion, i, v, vec.add(w, turn))


@routine
def load_tensor(inertia, i):
    """Row i of a table of symmetric tensors."""
    return inertia[i, 0], inertia[i, 1], inertia[i, 2], inertia[i, 3], inertia[i, 4], inertia[i, 5]


@routine
def offset(center, i, j, real):
    """Centre of mass of body i, seen from that of j, in single precision where the world has it."""
    return real(center[i, 0] - center[j, 0]), real(center[i, 1] - center[j, 1]), real(center[i, 2] - center[j, 2])
