"""Matching of a pair's new contact points with last step's, so that impulses carry over (warm starting).

A point is last step's point if the same features of the two shapes meet there; failing that, if it lies close to it as seen
from either body. Position is needed because feature ids flicker where faces align, as they do in every stack of boxes.
"""

from atlasphys.engine.jit import routine
from atlasphys.engine.math import vec


@routine
def separation_squared(new, i, k, old, j, q):
    """Squared distance between new point k and old point q as seen from the body on which it is less."""
    on_a = vec.length_squared(vec.sub(vec.load(new.local_a[i], k), vec.load(old.local_a[j], q)))
    on_b = vec.length_squared(vec.sub(vec.load(new.local_b[i], k), vec.load(old.local_b[j], q)))
    return min(on_a, on_b)


@routine
def carry(new, i, k, old, j, q):
    """Let new point k go on from the impulses of old point q."""
    new.normal_impulse[i, k] = old.normal_impulse[j, q]
    vec.store(new.friction_impulse[i], k, vec.load(old.friction_impulse[j], q))


@routine
def match_points(new, i, old, j, distance):
    """Carry impulses from manifold j of ``old`` to manifold i of ``new``. Each old point serves at most one new one."""
    used = 0
    matched = 0
    limit = distance * distance
    for k in range(new.count[i]):
        for q in range(old.count[j]):
            if not used & (1 << q) and new.feature[i, k] == old.feature[j, q]:
                # The same features at quite another place are another contact.
                if separation_squared(new, i, k, old, j, q) <= 100 * limit:
                    carry(new, i, k, old, j, q)
                    used |= 1 << q
                    matched |= 1 << k
                break
    for k in range(new.count[i]):
        if not matched & (1 << k):
            nearest, best = -1, limit
            for q in range(old.count[j]):
                if not used & (1 << q):
                    squared = separation_squared(new, i, k, old, j, q)
                    if squared <= best:
                        nearest, best = q, squared
            if nearest >= 0:
                carry(new, i, k, old, j, nearest)
                used |= 1 << nearest
    vec.store(new.rolling_impulse, i, vec.load(old.rolling_impulse, j))
    new.torsional_impulse[i] = old.torsional_impulse[j]
    new.touching[i] = old.touching[j]
