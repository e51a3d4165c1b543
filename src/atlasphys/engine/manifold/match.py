"""Matching of a pair's new contact points with last step's, so that impulses carry over (warm starting).

A point is last step's point if the same features of the two shapes meet there; failing that, if it lies close to it as seen
from either body. Position is needed because feature ids flicker where faces align, as they do in every stack of boxes.
"""

from atlasphys.engine.jit import routine
from atlasphys.engine.math import vec
from atlasphys.engine.state.manifolds import LOCAL_A, LOCAL_B, POINT_COLUMNS
from atlasphys.engine.trace import TRACED, note

FEATURE_REACH = 100
"""Square of the multiple of the matching distance within which equal features count as the same contact."""


@routine
def load_local(local, i, k):
    """Point k of manifold i in the axes of a and of b."""
    first = POINT_COLUMNS * k
    return vec.load_columns(local, i, first + LOCAL_A), vec.load_columns(local, i, first + LOCAL_B)


@routine
def match_points(i, count, feature, local, j, old_count, old_feature, old_local, distance, origin):
    """For each of the ``count`` points of new manifold i, find the point of old manifold j that it goes on from.

    ``origin[k]`` becomes that point's number, or −1. Each old point serves at most one new one.
    """
    used = 0
    limit = distance * distance
    for pass_number in range(2):
        for k in range(count):
            if pass_number == 0:
                origin[k] = -1
            elif origin[k] >= 0:
                continue
            best = type(distance)(FEATURE_REACH) * limit if pass_number == 0 else limit
            a, b = load_local(local, i, k)
            for q in range(old_count):
                if used & (1 << q) or (pass_number == 0 and feature[i, k] != old_feature[j, q]):
                    continue
                old_a, old_b = load_local(old_local, j, q)
                squared = min(vec.length_squared(vec.sub(a, old_a)), vec.length_squared(vec.sub(b, old_b)))
                if squared <= best:
                    origin[k], best = q, squared
            if TRACED:
                note("match.point", point=k, by="feature" if pass_number == 0 else "place", old=origin[k], squared=best)
            if origin[k] >= 0:
                used |= 1 << origin[k]
